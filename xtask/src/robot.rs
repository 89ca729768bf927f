//! A robot's co-processor in an emulator, fed over a bad line: the image `robot` of `tests/firmware` in QEMU, and its host,
//! an example of `pldi-host`.

use std::path::Path;
use std::process::Child;
use std::time::{Duration, Instant};

use crate::firmware::{self, Board};
use crate::process::{cargo, program, run as run_command, succeeds, target_dir};
use crate::report::{Outcome, Report};

const BOARD: Board = Board::CORTEX_M7;

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
    report.step(format!("robot loop, {frames} frames on a bad line, {}", BOARD.title), || {
        let image = match firmware::build(BOARD, "", "robot") {
            Ok(image) => image,
            Err(outcome) => return outcome,
        };
        run_command(&mut cargo("build --release --locked -p pldi-host --example robot_feeder"))
            .and_then(|| talk(&image, frames))
    });
}

/// Lets host and device talk until all frames are answered.
fn talk(image: &Path, frames: u32) -> Outcome {
    let folder = target_dir().join("robot");
    if let Err(error) = std::fs::create_dir_all(&folder) {
        return Outcome::Failed(format!("{}: {error}", folder.display()));
    }
    let [to, from] = ["to-device", "from-device"].map(|name| folder.join(name));
    for fifo in [&to, &from] {
        let _ = std::fs::remove_file(fifo);
        if !succeeds(program("mkfifo").arg(fifo)) {
            return Outcome::Failed(format!("mkfifo {} failed", fifo.display()));
        }
    }
    let mut device = match firmware::command(BOARD, image, &[&to.to_string_lossy(), &from.to_string_lossy()]) {
        Ok(device) => device,
        Err(outcome) => return outcome,
    };
    let mut host = program(target_dir().join("release/examples/robot_feeder"));
    host.args([frames.to_string(), CORRUPTED.to_string()]).args([&to, &from]);
    let mut device = match device.spawn() {
        Ok(device) => device,
        Err(error) => return Outcome::Failed(format!("{}: {error}", BOARD.qemu)),
    };
    let said = run_command(&mut host);
    // It ends by itself when the line is closed; where the host failed before it opened the line, it never does.
    let ended = wait(&mut device, Duration::from_secs(20));
    let _ = device.kill();
    said.and_then(|| ended.into())
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
