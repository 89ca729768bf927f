//! `pldi devices`: the sensors that are there.

use std::fmt::Write as _;
use std::io::Write as _;

use pldi_host::input::openni2::{self, Device};

/// Options of `pldi devices`.
#[derive(Debug, clap::Args)]
pub struct Devices {
    /// One JSON object a line
    #[arg(long)]
    json: bool,
}

impl Devices {
    /// Runs the command.
    pub fn run(&self) -> anyhow::Result<()> {
        let devices = openni2::devices()?;
        if devices.is_empty() {
            eprintln!("pldi: {}", openni2::why_none());
        }
        let mut text = String::new();
        for device in &devices {
            if self.json {
                text += &serde_json::to_string(device)?;
                text.push('\n');
            } else {
                describe(&mut text, device)?;
            }
        }
        std::io::stdout().write_all(text.as_bytes())?;
        Ok(())
    }
}

fn describe(text: &mut String, device: &Device) -> std::fmt::Result {
    let known = [&device.vendor, &device.name, &device.usb];
    let known: Vec<&str> = known.into_iter().map(String::as_str).filter(|word| !word.is_empty()).collect();
    writeln!(text, "{}  {}", device.uri, known.join(", "))?;
    if let Some(error) = &device.error {
        writeln!(text, "  {error}")?;
    }
    for sensor in &device.sensors {
        for modes in &sensor.modes {
            writeln!(text, "  {:<9}{:<16}{}", sensor.kind, modes.format, modes.sizes.join(", "))?;
        }
    }
    Ok(())
}
