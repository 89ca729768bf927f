//! `pldi` with a sensor through the real libOpenNI2: what it sees is recognised as from a folder, and it may go away.

mod common;
#[path = "openni2/mod.rs"]
mod openni2;

use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use common::{Outcome, folder, frames, pldi, recording};
use openni2::{VirtualSensor, film};
use pldi_host::input::read_camera_info;
use serde_json::Value;

/// The virtual sensor's URI.
const URI: &str = "openni2:virtual/0601@1/5";
/// Frames come when they are asked for.
const ASKED: &str = "pace: asked\n";

/// Three frames at 640x480, as a film.
fn seen() -> &'static [u8] {
    static FILM: OnceLock<Vec<u8>> = OnceLock::new();
    FILM.get_or_init(|| film(&frames()))
}

fn sensor(controls: &str) -> Option<VirtualSensor> {
    VirtualSensor::new(seen(), &format!("{ASKED}{controls}"))
}

/// The lines of a run without their times.
fn untimed(run: &Outcome) -> Vec<Value> {
    let mut lines = run.lines();
    for line in &mut lines {
        line.as_object_mut().unwrap().remove("stamp").unwrap();
    }
    lines
}

fn stamps(lines: &[Value]) -> Vec<f64> {
    lines.iter().map(|line| line["stamp"].as_f64().unwrap()).collect()
}

#[test]
fn a_sensor_and_its_recording_show_what_the_folder_shows() {
    let Some(sensor) = sensor("") else { return };
    let k = frames().sensor.intrinsics;
    // Angles of view give the last digit otherwise.
    let k = format!("--intrinsics={},{},{},{}@{}x{}", k.fx, k.fy, k.cx, k.cy, k.width, k.height);
    let from_folder = untimed(&pldi(arguments!["run", *recording(), k]).ok());
    assert!(from_folder.iter().any(|line| !line["detections"].as_array().unwrap().is_empty()));
    let live = sensor.pldi(arguments!["run", "openni2:", "--mode", "vga", "--frames", "3", k]).ok();
    assert_eq!(untimed(&live), from_folder);
    assert_eq!(stamps(&live.lines()), [1.0, 1.033333, 1.066666]);
    assert_eq!(live.stderr, "");
    assert!(sensor.events().contains(&"registration on kept".to_owned()), "{:?}", sensor.events());
    let file = sensor.record("recorded.oni", 640, 3);
    let played = sensor.pldi(arguments!["run", file, k]).ok();
    assert_eq!(untimed(&played), from_folder);
    assert_eq!(stamps(&played.lines()), [0.0, 0.033333, 0.066666]);
    // Without --mode the small mode, which takes half the time.
    let small = sensor.pldi(["run", URI, "--frames", "2"]).ok();
    assert_eq!(small.lines().len(), 2);
    assert_eq!(small.stderr, "");
}

#[test]
fn the_camera_is_the_one_of_the_angles_of_view() {
    let Some(sensor) = sensor("") else { return };
    let out = folder();
    let out = out.path().join("out");
    sensor.pldi(arguments!["record", URI, "--mode", "640x480@30", "--frames", "1", "-o", out]).ok();
    let (read, expected) = (read_camera_info(&out.join("camera_info.yaml")).unwrap(), frames().sensor.intrinsics);
    assert_eq!((read.width, read.height, read.cx, read.cy), (640, 480, 319.5, 239.5));
    assert!((read.fx - expected.fx).abs() < 1e-3 && (read.fy - expected.fy).abs() < 1e-3, "{read:?}");
}

#[test]
fn devices_are_listed() {
    let Some(sensor) = sensor("") else { return };
    let text = String::from_utf8(sensor.pldi(["devices"]).ok().stdout).unwrap();
    for part in [URI, "virtual sensor", "1d27:0601", "320x240@30, 640x480@30", "depth in mm", "RGB"] {
        assert!(text.contains(part), "{text}");
    }
    let lines = sensor.pldi(["devices", "--json"]).ok().lines();
    assert_eq!((lines.len(), lines[0]["uri"].as_str()), (1, Some(URI)));
    assert_eq!(lines[0]["sensors"][0]["modes"][0]["sizes"][1], "640x480@30");
    sensor.unplug();
    let none = sensor.pldi(["devices"]).ok();
    assert!(none.stdout.is_empty() && none.stderr.contains("libOniFile.so.0"), "{}", none.stderr);
    let run = sensor.pldi(["run", "openni2:"]);
    assert_eq!(run.code, Some(1));
    assert!(run.stderr.contains("finds no device") && run.stderr.contains("drivers"), "{}", run.stderr);
    let run = sensor.pldi(["run", "openni2:other"]);
    assert!(run.code == Some(1) && run.stderr.contains("no device other is listed"), "{}", run.stderr);
}

#[test]
fn a_mode_or_device_that_cannot_be_had_is_told_with_those_that_can() {
    let Some(free) = sensor("") else { return };
    let run = free.pldi(["run", URI, "--mode", "1280x960@15"]);
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("1280x960@15") && run.stderr.contains("320x240@30, 640x480@30"), "{}", run.stderr);
    let denied = sensor("open: denied").unwrap();
    let run = denied.pldi(["run", URI]);
    assert!(run.code == Some(1) && run.stderr.contains("cannot be opened"), "{}", run.stderr);
    let listed = String::from_utf8(denied.pldi(["devices"]).ok().stdout).unwrap();
    assert!(listed.contains(URI) && listed.contains("cannot be opened"), "{listed}");
}

#[test]
fn registration_that_is_not_done_is_never_silent() {
    for (controls, says) in [("registration: ignored", "read back"), ("registration: unsupported", "does not register")]
    {
        let Some(sensor) = sensor(controls) else { return };
        let run = sensor.pldi(["run", URI, "--frames", "1"]).ok();
        assert_eq!(run.stderr.matches(says).count(), 1, "{}", run.stderr);
    }
}

#[test]
fn lost_frames_are_counted() {
    // Of frame 1 nothing comes; of frame 3 depth alone.
    let Some(sensor) = sensor("drop: 1\ndrop-color: 1,3") else { return };
    let out = folder();
    let out = out.path().join("out");
    let run = sensor.pldi(arguments!["record", URI, "--frames", "3", "-o", out]).ok();
    assert!(run.stderr.contains("3 frames in") && run.stderr.contains("2 lost"), "{}", run.stderr);
}

#[test]
fn a_run_goes_on_when_the_sensor_is_back() {
    let Some(sensor) = sensor("unplug-after: 2\nreplug-after-ms: 200") else { return };
    let run = sensor.pldi(["run", URI, "--frames", "5"]).ok();
    let (lost, back) = (run.stderr.find("was lost").unwrap(), run.stderr.find("is back").unwrap());
    assert!(lost < back && run.stderr.lines().count() == 2, "{}", run.stderr);
    let stamps = stamps(&run.lines());
    assert!(stamps.len() == 5 && stamps.is_sorted_by(|a, b| a < b), "{stamps:?}");
    assert_eq!(sensor.events().iter().filter(|event| *event == "registration on kept").count(), 2);
}

#[test]
fn once_ends_with_the_sensor() {
    let Some(sensor) = sensor("unplug-after: 2") else { return };
    let run = sensor.pldi(["run", URI, "--once"]);
    assert_eq!((run.code, run.lines().len()), (Some(1), 2), "{}", run.stderr);
    assert!(run.stderr.contains("was lost"), "{}", run.stderr);
}

#[test]
fn an_interrupt_ends_the_wait_for_a_sensor() {
    let Some(sensor) = sensor("unplug-after: 2") else { return };
    let mut command = sensor.command(env!("CARGO_BIN_EXE_pldi"));
    let mut child = command.args(["run", URI]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    stderr.read_line(&mut line).unwrap();
    assert!(line.contains("waiting for it to come back"), "{line}");
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let mut rest = String::new();
    stderr.read_to_string(&mut rest).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{rest}");
    let mut stdout = Vec::new();
    child.stdout.unwrap().read_to_end(&mut stdout).unwrap();
    assert_eq!(common::lines(&stdout).len(), 2);
}

#[test]
fn a_file_that_cannot_be_played_is_an_error() {
    let Some(sensor) = sensor("") else { return };
    let file = sensor.record("recorded.oni", 320, 3);
    let bytes = std::fs::read(&file).unwrap();
    for (name, bytes) in [("cut.oni", &bytes[..bytes.len() / 3]), ("text.oni", b"no recording"), ("empty.oni", b"")] {
        let file = sensor.path(name);
        std::fs::write(&file, bytes).unwrap();
        let run = sensor.pldi(arguments!["run", file]);
        assert!(run.code == Some(1) && run.stderr.contains(name), "{name}: {}", run.stderr);
    }
    let run = sensor.pldi(arguments!["run", sensor.path("missing.oni")]);
    assert!(run.code == Some(1) && run.stderr.contains("cannot read"), "{}", run.stderr);
}

#[test]
fn a_damaged_file_gives_what_it_has() {
    let Some(sensor) = sensor("") else { return };
    let file = sensor.record("recorded.oni", 320, 3);
    let mut bytes = std::fs::read(&file).unwrap();
    // The second colour image: the fourth record of data, and what is around its head.
    let mut data = (0..bytes.len()).filter(|&at| bytes[at..].starts_with(b"NIR\0\x0a\0\0\0"));
    let at = data.nth(3).unwrap();
    bytes[at - 100..at + 20_000].fill(0xa5);
    std::fs::write(&file, bytes).unwrap();
    let run = sensor.pldi(arguments!["run", file]).ok();
    assert_eq!(run.lines().len(), 2, "{}", run.stderr);
    assert!(run.stderr.contains("3 of 3 depth and 2 of 3 colour"), "{}", run.stderr);
    assert!(run.stderr.contains("1 depth images have no colour image"), "{}", run.stderr);
}

#[test]
fn a_library_or_driver_that_is_missing_is_named() {
    let folder = folder();
    for name in ["libOpenNI2.so.0", "libOpenNI2.so"] {
        std::fs::write(folder.path().join(name), "no library").unwrap();
    }
    let mut command = common::command();
    command.env("LD_LIBRARY_PATH", folder.path()).env("OPENNI2_REDIST", folder.path()).arg("devices");
    let output = command.output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    let own = folder.path().join("libOpenNI2.so.0");
    for part in [own.to_str().unwrap(), " libOpenNI2.so.0 (", " libOpenNI2.so (", "libopenni2-0", "OPENNI2_REDIST"] {
        assert!(stderr.contains(part), "{part}: {stderr}");
    }
    let Some(sensor) = sensor("") else { return };
    for driver in ["drivers/libPldiVirtual.so.0", "drivers/libOniFile.so.0"] {
        std::fs::remove_file(sensor.path(driver)).unwrap();
    }
    let run = sensor.pldi(["devices"]);
    assert_eq!(run.code, Some(1));
    assert!(run.stderr.contains(sensor.path("drivers").to_str().unwrap()), "{}", run.stderr);
    assert!(run.stderr.contains("has none"), "{}", run.stderr);
}
