//! What a test asks of the sensor.

use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::PathBuf;
use std::time::Duration;

/// What becomes of a registration that is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Registration {
    /// It is done if the streams run, else lost.
    Works,
    /// It is lost.
    Ignored,
    /// There is no such property.
    Unsupported,
}

/// The lines of the file `controls`, each `name: value`; all may be left out.
#[derive(Debug, Clone)]
pub struct Controls {
    /// `speed: 10`: so many times as fast; the time stamps stay those of the film's rate.
    pub speed: f64,
    /// `pace: asked`: a frame comes when a reader waits for one and has none, so that nothing is lost and nothing waited
    /// for; `pace: clock` (as a sensor).
    pub asked: bool,
    /// `start-after-ms: 100`: from the start of the last stream to the first frame.
    pub start_after: Duration,
    /// `color-after-us: 4000`: how much later than the depth a colour image is taken.
    pub color_after_us: u64,
    /// `drop: 5,9`: frames that do not come, counted from 0; `drop-depth:` and `drop-color:` of one stream alone.
    pub dropped: [Vec<u64>; 2],
    /// `unplug-after: 7`: the device is unplugged once, after so many frames.
    pub unplug_after: Option<u64>,
    /// `replug-after-ms: 200`: it is back so much later, and goes on with the next frame; without it, it stays away.
    pub replug_after: Option<Duration>,
    /// `at-end: loop`, or `silent`: what comes after the last frame.
    pub loops: bool,
    /// `registration: works`, `ignored` or `unsupported`.
    pub registration: Registration,
    /// `open: denied`: the device is listed but cannot be opened, as without permissions.
    pub denied: bool,
}

impl Default for Controls {
    fn default() -> Self {
        Self {
            speed: 1.0,
            asked: false,
            start_after: Duration::from_millis(100),
            color_after_us: 4000,
            dropped: [Vec::new(), Vec::new()],
            unplug_after: None,
            replug_after: None,
            loops: true,
            registration: Registration::Works,
            denied: false,
        }
    }
}

impl Controls {
    /// Parses the file's text; says which line is wrong.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut controls = Self::default();
        for line in text.lines().filter(|line| !line.trim().is_empty()) {
            let (name, value) = line.split_once(':').unwrap_or((line, ""));
            controls
                .set(name.trim(), value.trim())
                .ok_or_else(|| format!("a control that is not understood: {line}"))?;
        }
        Ok(controls)
    }

    fn set(&mut self, name: &str, value: &str) -> Option<()> {
        let number = || value.parse::<u64>().ok();
        let numbers = || value.split(',').map(|n| n.trim().parse().ok()).collect::<Option<Vec<u64>>>();
        match name {
            "speed" => self.speed = value.parse().ok().filter(|&speed| speed > 0.0)?,
            "pace" => self.asked = choice(value, ["clock", "asked"])? == 1,
            "start-after-ms" => self.start_after = Duration::from_millis(number()?),
            "color-after-us" => self.color_after_us = number()?,
            "drop" => self.dropped = [numbers()?, numbers()?],
            "drop-depth" => self.dropped[0] = numbers()?,
            "drop-color" => self.dropped[1] = numbers()?,
            "unplug-after" => self.unplug_after = Some(number()?),
            "replug-after-ms" => self.replug_after = Some(Duration::from_millis(number()?)),
            "at-end" => self.loops = choice(value, ["silent", "loop"])? == 1,
            "registration" => {
                let all = [Registration::Works, Registration::Ignored, Registration::Unsupported];
                self.registration = all[choice(value, ["works", "ignored", "unsupported"])?];
            }
            "open" => self.denied = choice(value, ["allowed", "denied"])? == 1,
            _ => return None,
        }
        Some(())
    }
}

/// Which of the words it is.
fn choice<const N: usize>(value: &str, words: [&str; N]) -> Option<usize> {
    words.iter().position(|&word| word == value)
}

/// The folder through which a test and the driver speak; without one, the defaults.
#[derive(Debug, Clone, Default)]
pub struct Folder(pub Option<PathBuf>);

impl Folder {
    /// The controls as they stand now.
    pub fn controls(&self) -> Result<Controls, String> {
        let Some(folder) = &self.0 else { return Ok(Controls::default()) };
        match fs::read_to_string(folder.join("controls")) {
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(Controls::default()),
            Err(error) => Err(error.to_string()),
            Ok(text) => Controls::parse(&text),
        }
    }

    /// Whether the test holds the plug in its hand.
    pub fn unplugged(&self) -> bool {
        self.0.as_ref().is_some_and(|folder| folder.join("unplugged").exists())
    }

    /// Adds a line to `events`. A test that looks for it fails without it, so an error need not be reported.
    pub fn event(&self, what: &str) {
        let Some(folder) = &self.0 else { return };
        if let Ok(mut file) = OpenOptions::new().create(true).append(true).open(folder.join("events")) {
            let _ = file.write_all(format!("{what}\n").as_bytes());
        }
    }
}
