//! A long recording: that memory stays constant and the time below the recording's own. Not part of ci: minutes of work
//! and gigabytes of disk.

use std::fmt::Write as _;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Instant;

use crate::process::{cargo, program, run as run_command, target_dir};
use crate::report::{Outcome, Report};

/// Frames a second, as a sensor takes them.
const RATE: u32 = 30;
/// Frames of the generated recording, which come again and again.
const FRAMES: u32 = 12;
/// Memory in use may grow by so much from the first tenth of the frames to the end, in KiB.
const GROWTH: u64 = 4096;

/// Records so many minutes as MCAP and takes them through the pipeline on one thread.
pub(crate) fn run(report: &mut Report, minutes: u32) {
    let name = format!("{minutes} minutes at {RATE} Hz");
    report.step(&name, || {
        if !Path::new("/proc/self/status").exists() {
            return Outcome::missing_tool("memory and time are read from /proc, which only Linux has".into());
        }
        run_command(&mut cargo("build --release --locked")).and_then(|| measure(minutes).into())
    });
}

fn measure(minutes: u32) -> Result<(), String> {
    let (folder, pldi) = (target_dir().join("endurance"), target_dir().join("release/pldi"));
    let _ = fs::remove_dir_all(&folder);
    let demo = program(&pldi).arg("demo").arg("--out").arg(folder.join("demo")).stdout(Stdio::null()).status();
    if !demo.as_ref().is_ok_and(std::process::ExitStatus::success) {
        return Err(format!("pldi demo: {demo:?}"));
    }
    let frames = minutes * 60 * RATE;
    let long = folder.join("long");
    fs::create_dir_all(&long).map_err(failed(&long))?;
    let mut list = String::new();
    for i in 0..frames {
        let (t, k) = (f64::from(i) / f64::from(RATE), i % FRAMES);
        // Writing to a string cannot fail.
        let _ = writeln!(list, "{t:.6} ../demo/recording/rgb/{k:04}.png {t:.6} ../demo/recording/depth/{k:04}.png");
    }
    fs::write(long.join("associations.txt"), list).map_err(failed(&long))?;
    let info = folder.join("demo/recording/camera_info.yaml");
    fs::copy(&info, long.join("camera_info.yaml")).map_err(failed(&info))?;
    let bag = folder.join("long.mcap");
    let recording =
        watch(&pldi, &["record".into(), long.clone(), "--threads".into(), "1".into(), "-o".into(), bag.clone()], 0)?;
    recording.print("recorded as MCAP", frames);
    let size = fs::metadata(&bag).map_err(failed(&bag))?.len();
    println!(
        "{}: {:.2} GiB, {} KiB a frame",
        bag.display(),
        size as f64 / (1u64 << 30) as f64,
        size / 1024 / u64::from(frames)
    );
    let running = watch(&pldi, &["run".into(), bag.clone(), "--threads".into(), "1".into()], frames)?;
    running.print("recognised from MCAP", frames);
    fs::remove_file(&bag).map_err(failed(&bag))?;
    match running.peaks {
        _ if running.lines != frames => Err(format!("{} lines for {frames} frames", running.lines)),
        (Some(early), Some(late)) if late > early + GROWTH => {
            Err(format!("memory grew from {early} KiB after a tenth of the frames to {late} KiB"))
        }
        _ => Ok(()),
    }
}

/// Says which file an error is about.
fn failed(path: &Path) -> impl FnOnce(std::io::Error) -> String {
    move |error| format!("{}: {error}", path.display())
}

/// What a command took.
struct Taken {
    lines: u32,
    seconds: f64,
    /// Processor time in seconds.
    cpu: f64,
    /// Most memory in use, in KiB: after a tenth of the lines, and at the end.
    peaks: (Option<u64>, Option<u64>),
}

impl Taken {
    fn print(&self, what: &str, frames: u32) {
        let length = f64::from(frames) / f64::from(RATE);
        let kib = |peak: Option<u64>| peak.map_or("-".to_owned(), |p| format!("{p} KiB"));
        println!(
            "{what}: {frames} frames of {length:.0} s in {:.0} s ({:.1} times real time), {:.0} s of processor time; peak memory {} \
             after a tenth, {} at the end",
            self.seconds,
            length / self.seconds,
            self.cpu,
            kib(self.peaks.0),
            kib(self.peaks.1)
        );
    }
}

/// Runs a command, counts its lines and reads its memory and time while it runs.
fn watch(pldi: &Path, arguments: &[PathBuf], expected: u32) -> Result<Taken, String> {
    let start = Instant::now();
    let child = program(pldi).args(arguments).stdout(Stdio::piped()).spawn();
    let mut child = child.map_err(|error| format!("{}: {error}", pldi.display()))?;
    let id = child.id();
    let (mut lines, mut peaks, mut cpu) = (0, (None, None), 0.0);
    let mut look = |peaks: &mut (_, Option<u64>)| {
        peaks.1 = peak(id).or(peaks.1);
        cpu = processor_time(id).unwrap_or(cpu);
    };
    if let Some(out) = child.stdout.take().filter(|_| expected > 0) {
        for line in BufReader::new(out).lines() {
            line.map_err(|error| format!("its output: {error}"))?;
            lines += 1;
            if lines == expected / 10 {
                peaks.0 = peak(id);
            }
            if lines % 50 == 0 || lines == expected {
                look(&mut peaks);
            }
        }
    }
    let status = loop {
        match child.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) => look(&mut peaks),
            Err(error) => return Err(format!("pldi: {error}")),
        }
        std::thread::sleep(std::time::Duration::from_millis(20));
    };
    if !status.success() {
        return Err(format!("pldi {}: {status}", arguments[0].display()));
    }
    Ok(Taken { lines, seconds: start.elapsed().as_secs_f64(), cpu, peaks })
}

/// Most memory that a process had in use, in KiB.
fn peak(process: u32) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?.split_whitespace().next()?.parse().ok()
}

/// Processor time of all threads of a process in seconds; Linux counts it in hundredths.
fn processor_time(process: u32) -> Option<f64> {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name in brackets may hold blanks; behind it the state is field 3, utime field 14 and stime field 15.
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<u64>().ok();
    Some((ticks()? + ticks()?) as f64 / 100.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn a_process_has_memory_and_time() {
        let own = std::process::id();
        assert!(peak(own).unwrap() > 100 && processor_time(own).unwrap() < 1e6);
        assert_eq!((peak(u32::MAX), processor_time(u32::MAX)), (None, None));
    }
}
