//! The virtual sensor through the real libOpenNI2: what it sees comes out bit for bit, live and from an `.oni` file.

mod common;
#[path = "openni2/mod.rs"]
mod openni2;

use std::path::Path;
use std::sync::OnceLock;

use common::frames;
use openni2::{VirtualSensor, film};

/// Bytes of a film before the frames.
const HEADER: usize = 32;
/// Readings at the end of a depth image that an `.oni` file may spoil: OpenNI2's compression writes the last run of equal
/// readings, at most 15 pairs, behind the odd last reading instead of before it.
const SPOILT: usize = 31;

/// Three frames at 640x480, as a film.
fn seen() -> &'static [u8] {
    static FILM: OnceLock<Vec<u8>> = OnceLock::new();
    FILM.get_or_init(|| film(&frames()))
}

/// The images of a film, each with the size of its pixels.
fn images(film: &[u8], width: usize) -> impl Iterator<Item = (&[u8], usize)> {
    let pixels = width * width * 3 / 4;
    film[HEADER..]
        .chunks_exact(pixels * 5)
        .flat_map(move |frame| [(&frame[..pixels * 2], 2), (&frame[pixels * 2..], 3)])
}

/// Every second pixel of every second row.
fn halved(film: &[u8]) -> Vec<u8> {
    let mut half = film[..HEADER].to_vec();
    half[8..12].copy_from_slice(&320u32.to_le_bytes());
    half[12..16].copy_from_slice(&240u32.to_le_bytes());
    for (image, size) in images(film, 640) {
        for row in image.chunks_exact(640 * size).step_by(2) {
            half.extend(row.chunks_exact(size).step_by(2).flatten());
        }
    }
    half
}

/// The lines of a reader: number and time stamp of each image of a stream.
fn taken(stdout: &[u8], stream: &str) -> Vec<(u32, u64)> {
    let text = String::from_utf8_lossy(stdout);
    let lines = text.lines().filter_map(|line| line.strip_prefix(stream)?.trim().split_once(' '));
    lines.map(|(index, stamp)| (index.parse().unwrap(), stamp.parse().unwrap())).collect()
}

#[test]
fn frames_come_out_bit_for_bit_live_and_from_a_file() {
    let Some(sensor) = VirtualSensor::new(seen(), "pace: asked") else { return };
    assert_eq!(sensor.oni(["list"]).ok().stdout, b"virtual/0601@1/5\n");
    for (width, expected) in [(640, seen()), (320, &halved(seen()))] {
        let out = sensor.path("taken");
        let take = |from: &Path| {
            let run = sensor.oni(arguments!["take", from, out, width.to_string(), "3"]).ok();
            (run.stdout, std::fs::read(&out).unwrap())
        };
        let (live, got) = take("first".as_ref());
        assert!(got == *expected, "live at {width} columns");
        assert_eq!(taken(&live, "depth"), [(1, 1_000_000), (2, 1_033_333), (3, 1_066_666)]);
        assert_eq!(taken(&live, "color"), [(1, 1_004_000), (2, 1_037_333), (3, 1_070_666)]);

        let (played, got) = take(&sensor.record("recorded.oni", width, 3));
        assert_eq!((got.len(), &got[..HEADER]), (expected.len(), &expected[..HEADER]));
        for (i, ((got, size), (expected, _))) in images(&got, width).zip(images(expected, width)).enumerate() {
            let sure = expected.len() - if size == 2 { size * SPOILT } else { 0 };
            assert!(got[..sure] == expected[..sure], "image {i} played at {width} columns");
        }
        // OpenNI2's recorder lets the time stamps of each stream begin at 0.
        assert_eq!(taken(&played, "depth"), [(1, 0), (2, 33_333), (3, 66_666)]);
        assert_eq!(taken(&played, "color"), [(1, 0), (2, 33_333), (3, 66_666)]);
    }
}

#[test]
fn a_sensor_that_is_told_nothing_is_small_mirrored_and_unregistered() {
    let Some(sensor) = VirtualSensor::new(seen(), "speed: 2") else { return };
    let out = sensor.path("taken");
    // By the clock a reader may miss frames, and then they are not known: this film has but one.
    let mut still = seen()[..HEADER + 640 * 480 * 5].to_vec();
    still[20..24].copy_from_slice(&1u32.to_le_bytes());
    std::fs::write(sensor.path("film"), &still).unwrap();
    let run = sensor.oni(arguments!["take-raw", out, "2"]).ok();
    let stamps = taken(&run.stdout, "depth");
    assert!(
        stamps.iter().all(|&(index, stamp)| stamp == 1_000_000 + u64::from(index - 1) * 1_000_000 / 30),
        "{stamps:?}"
    );
    let (got, half) = (std::fs::read(&out).unwrap(), halved(&still));
    for ((got, size), (expected, _)) in images(&got, 320).zip(images(&half, 320)) {
        // The two cameras are 10 columns apart at full width.
        let shift = if size == 2 { 5 } else { 0 };
        for (got, expected) in got.chunks_exact(320 * size).zip(expected.chunks_exact(320 * size)) {
            for x in 0..320 - shift {
                let at = (319 - x) * size;
                assert_eq!(got[at..at + size], expected[(x + shift) * size..(x + shift + 1) * size]);
            }
        }
    }
}

#[test]
fn a_sensor_that_is_unplugged_comes_back() {
    let Some(sensor) = VirtualSensor::new(seen(), "pace: asked\nunplug-after: 2\nreplug-after-ms: 200") else { return };
    let run = sensor.oni(["survive", "5"]).ok();
    let text = String::from_utf8(run.stdout).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let first = ["opened", "depth 1 1000000", "depth 2 1033333", "gone"];
    assert_eq!(lines, [&first[..], &first[..3], &["depth 3 1066666"]].concat());
    let mut events = sensor.events();
    events.sort();
    let device = ["closed", "opened", "started Depth", "stopped Depth"];
    let mut expected = [&device[..], &device[..], &["plugged", "unplugged"]].concat();
    expected.sort_unstable();
    assert_eq!(events, expected);
}

#[test]
fn frames_are_dropped_and_a_sensor_can_be_away() {
    let Some(sensor) = VirtualSensor::new(seen(), "pace: asked\ndrop-depth: 1\ndrop-color: 0") else { return };
    let out = sensor.path("taken");
    let run = sensor.oni(arguments!["take", "first", out, "640", "3"]).ok();
    let numbers = |stream| taken(&run.stdout, stream).iter().map(|frame| frame.0).collect::<Vec<_>>();
    assert_eq!((numbers("depth"), numbers("color")), (vec![1, 3, 4], vec![2, 3, 4]));
    sensor.unplug();
    assert_eq!(sensor.oni(["list"]).ok().stdout, b"");
    assert_eq!(sensor.oni(arguments!["take", "first", out, "640", "3"]).code, Some(1));
    sensor.plug();
    assert_eq!(sensor.oni(["list"]).ok().stdout, b"virtual/0601@1/5\n");
}
