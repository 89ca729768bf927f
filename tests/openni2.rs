//! The virtual sensor through the real libOpenNI2: what it sees comes out bit for bit, live and from an `.oni` file.

mod common;
#[path = "openni2/mod.rs"]
mod openni2;

use openni2::{VirtualSensor, film};
use pldi_fixtures::Recording;

/// Frames of the film.
const FRAMES: usize = 3;

/// Three frames of the demo, at 640x480.
fn seen() -> Vec<u8> {
    let mut recording = Recording::demo();
    recording.path.truncate(FRAMES);
    film(&recording)
}

/// The lines of a reader: stream, number, time stamp.
fn taken(stdout: &[u8], stream: &str) -> Vec<(u32, u64)> {
    let text = String::from_utf8_lossy(stdout);
    let lines = text.lines().filter_map(|line| line.strip_prefix(stream)?.trim().split_once(' '));
    lines.map(|(index, stamp)| (index.parse().unwrap(), stamp.parse().unwrap())).collect()
}

#[test]
fn frames_come_out_bit_for_bit_live_and_from_a_file() {
    let film = seen();
    let Some(sensor) = VirtualSensor::new(&film, "pace: asked") else { return };
    assert_eq!(sensor.oni(["list"]).ok().stdout, b"virtual/0601@1/5\n");
    for (width, expected) in [(640, &film)] {
        let (out, count) = (sensor.path("taken"), FRAMES.to_string());
        let take = |from: &std::path::Path| {
            let run = sensor.oni(arguments!["take", from, out, width.to_string(), count]).ok();
            assert!(std::fs::read(&out).unwrap() == *expected, "{} at {width} columns", from.display());
            run.stdout
        };
        let live = take("first".as_ref());
        assert_eq!(taken(&live, "depth"), [(1, 1_000_000), (2, 1_033_333), (3, 1_066_666)]);
        assert_eq!(taken(&live, "color"), [(1, 1_004_000), (2, 1_037_333), (3, 1_070_666)]);
        // OpenNI2's recorder lets the time stamps of each stream begin at 0.
        let played = take(&sensor.record("recorded.oni", width, FRAMES));
        assert_eq!(taken(&played, "depth"), [(1, 0), (2, 33_333), (3, 66_666)]);
        assert_eq!(taken(&played, "color"), [(1, 0), (2, 33_333), (3, 66_666)]);
    }
}

#[test]
fn a_sensor_that_is_unplugged_comes_back() {
    let controls = "pace: asked\nunplug-after: 2\nreplug-after-ms: 200";
    let Some(sensor) = VirtualSensor::new(&seen(), controls) else { return };
    let run = sensor.oni(["survive", "5"]).ok();
    let text = String::from_utf8(run.stdout).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let first = ["opened", "depth 1 1000000", "depth 2 1033333", "gone"];
    assert_eq!(lines, [&first[..], &first[..3], &["depth 3 1066666"]].concat());
    let device = ["opened", "started Depth", "stopped Depth", "closed"].map(String::from);
    assert_eq!(sensor.events().iter().filter(|event| device.contains(event)).count(), 8);
    assert!(sensor.events().windows(2).any(|pair| pair == ["unplugged", "plugged"] || pair[0] == "unplugged"));
}

#[test]
fn frames_are_dropped_and_a_sensor_can_be_away() {
    let Some(sensor) = VirtualSensor::new(&seen(), "pace: asked\ndrop-depth: 1\ndrop-color: 0") else { return };
    let out = sensor.path("taken");
    let run = sensor.oni(arguments!["take", "first", out, "640", "3"]).ok();
    assert_eq!(taken(&run.stdout, "depth").iter().map(|frame| frame.0).collect::<Vec<_>>(), [1, 3, 4]);
    assert_eq!(taken(&run.stdout, "color").iter().map(|frame| frame.0).collect::<Vec<_>>()[..2], [2, 3]);
    sensor.unplug();
    assert_eq!(sensor.oni(["list"]).ok().stdout, b"");
    assert_eq!(sensor.oni(arguments!["take", "first", out, "640", "3"]).code, Some(1));
    sensor.plug();
    assert_eq!(sensor.oni(["list"]).ok().stdout, b"virtual/0601@1/5\n");
}
