//! A robot's co-processor in an emulator, fed over a bad line: the image `robot` of `tests/firmware` in QEMU, and its host,
//! an example of `pldi-host`.

use std::path::Path;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use crate::nostd;
use crate::process::{cargo, program, run as run_command, succeeds, target_dir};
use crate::report::{Outcome, Report};
use crate::symbols::rust_lld;

/// Cortex-M7.
const TARGET: &str = "thumbv7em-none-eabihf";
const EMULATOR: &str = "qemu-system-arm";
const MACHINE: &str = "-machine mps2-an500 -cpu cortex-m7 -display none -monitor none -serial none";

/// Corrupted packets of each frame: with 200 frames, ten thousand.
const CORRUPTED: u32 = 50;

/// How many frames are sent.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Extent {
    /// Enough to see that it works.
    Short,
    /// 200 frames, 10,000 corrupted packets.
    All,
}

/// One step.
pub(crate) fn run(report: &mut Report, extent: Extent) {
    let frames = match extent {
        Extent::Short => 20,
        Extent::All => 200,
    };
    report.step(format!("robot loop, {frames} frames on a bad line, {TARGET}"), || {
        if !succeeds(program(EMULATOR).arg("--version")) {
            return Outcome::missing_tool(format!("install {EMULATOR} (Debian: qemu-system-arm)"));
        }
        let Some(toolchain) = nostd::toolchain(TARGET) else { return nostd::missing(TARGET) };
        let folder = target_dir().join("robot");
        if let Err(error) = std::fs::create_dir_all(&folder) {
            return Outcome::Failed(format!("{}: {error}", folder.display()));
        }
        let mut templates = cargo("run --release --locked -p pldi-host --bin pldi -- templates convert");
        templates.arg("pldi-host/assets/furniture.pldt").arg("-o").arg(folder.join("fixed.pldt"));
        let line = format!(
            "build --release --locked --manifest-path tests/firmware/Cargo.toml --target {TARGET} --bin robot --features an500"
        );
        let mut image = nostd::cargo_for(toolchain, &line, &target_dir().join("firmware/an500"));
        image.env("PLDI_FIRMWARE_DATA", &folder);
        if let Some(linker) = rust_lld() {
            image.env(format!("CARGO_TARGET_{}_LINKER", TARGET.to_uppercase().replace('-', "_")), linker);
        }
        run_command(&mut templates)
            .and_then(|| run_command(&mut cargo("build --release --locked -p pldi-host --example robot_feeder")))
            .and_then(|| run_command(&mut image))
            .and_then(|| talk(&folder, frames).into())
    });
}

/// Lets host and device talk until all frames are answered.
fn talk(folder: &Path, frames: u32) -> Result<(), String> {
    let [to, from] = ["to-device", "from-device"].map(|name| folder.join(name));
    for fifo in [&to, &from] {
        let _ = std::fs::remove_file(fifo);
        if !succeeds(program("mkfifo").arg(fifo)) {
            return Err(format!("mkfifo {} failed", fifo.display()));
        }
    }
    let image = target_dir().join("firmware/an500").join(TARGET).join("release/robot");
    let mut config = String::from("enable=on,target=native,arg=robot");
    for fifo in [&to, &from] {
        config += &format!(",arg={}", fifo.display());
    }
    let mut device = program(EMULATOR);
    device.args(MACHINE.split_whitespace()).arg("-semihosting-config").arg(config).arg("-kernel").arg(image);
    let mut host = program(target_dir().join("release/examples/robot_feeder"));
    host.args([frames.to_string(), CORRUPTED.to_string()]).args([&to, &from]);
    let mut device = spawn(&mut device)?;
    let said = run_command(&mut host);
    // It ends by itself when the line is closed; where the host failed before it opened the line, it never does.
    let ended = wait(&mut device, Duration::from_secs(20));
    let _ = device.kill();
    match said {
        Outcome::Passed => ended,
        Outcome::Failed(why) | Outcome::Skipped(why) => Err(why),
    }
}

fn spawn(command: &mut Command) -> Result<Child, String> {
    command.spawn().map_err(|error| format!("{}: {error}", command.get_program().to_string_lossy()))
}

/// Waits for a process to end well.
fn wait(process: &mut Child, patience: Duration) -> Result<(), String> {
    let start = Instant::now();
    while start.elapsed() < patience {
        match process.try_wait() {
            Ok(Some(status)) if status.success() => return Ok(()),
            Ok(Some(status)) => return Err(format!("the device: {status}")),
            Ok(None) => std::thread::sleep(Duration::from_millis(50)),
            Err(error) => return Err(format!("the device: {error}")),
        }
    }
    Err("the device does not end when the line is closed".into())
}
