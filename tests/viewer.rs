//! `pldi run --rerun`: frames for the viewer, in a file.

mod common;

use std::process::Stdio;
use std::time::{Duration, Instant};

use common::{command, folder, lines, listed, names, pldi, recording};

#[test]
fn the_frames_are_kept_for_the_viewer_beside_the_lines() {
    let place = folder();
    let file = place.path().join("out.rrd");
    let plain = pldi(arguments!["run", recording()]).ok();
    for threads in ["1", "3"] {
        let shown = pldi(arguments!["run", recording(), "--rerun", file, "--threads", threads]).ok();
        assert_eq!(shown.stdout, plain.stdout);
        let bytes = std::fs::read(&file).expect("the file is there");
        assert_eq!(&bytes[..4], b"RRF2");
        // Three frames: of depth alone there are 900 kB, packed.
        assert!((500_000..3_000_000).contains(&bytes.len()), "{}", bytes.len());
        assert_eq!(names(place.path()), ["out.rrd"]);
    }
}

#[test]
fn what_is_no_target_is_wrong_usage() {
    let outcome = pldi(arguments!["run", recording(), "--rerun", "somewhere"]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("neither spawn, nor a viewer's address"), "{}", outcome.stderr);
    let outcome = pldi(arguments!["run", "--from-serial", "-", "--rerun", "spawn"]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
}

#[test]
fn frames_before_one_that_fails_are_kept() {
    let (place, damaged) = (folder(), common::copy());
    let file = place.path().join("out.rrd");
    std::fs::write(damaged.path().join("depth/0001.png"), b"no image").expect("written");
    let outcome = pldi(arguments!["run", damaged.path(), "--rerun", file]);
    assert_eq!((outcome.code, outcome.lines().len()), (Some(1), 1), "{}", outcome.stderr);
    let one = std::fs::metadata(&file).expect("the file is there").len();
    assert!((100_000..1_000_000).contains(&one), "{one}");
}

#[cfg(unix)]
#[test]
fn an_interrupt_leaves_the_frames_that_are_done() {
    let (input, place) = (listed(50_000), folder());
    let (text, file) = (place.path().join("lines.jsonl"), place.path().join("out.rrd"));
    let mut child = command();
    child.args(arguments!["run", input.path(), "--rerun", file]).stderr(Stdio::piped());
    let child = child.stdout(std::fs::File::create(&text).expect("made")).spawn().expect("started");
    let start = Instant::now();
    while lines_in(&text) < 3 {
        assert!(start.elapsed().as_secs() < 60, "no lines after 60 s");
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(!file.exists());
    let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("sent");
    assert!(kill.success());
    let output = child.wait_with_output().expect("ended");
    assert_eq!(output.status.code(), Some(130), "{}", String::from_utf8_lossy(&output.stderr));
    let frames = lines(&std::fs::read(&text).expect("read")).len() as u64;
    let bytes = std::fs::metadata(&file).expect("the file is there").len();
    assert!((400_000 * frames..800_000 * frames).contains(&bytes), "{bytes} bytes of {frames} frames");
    assert_eq!(names(place.path()), ["lines.jsonl", "out.rrd"]);
}

#[cfg(unix)]
fn lines_in(file: &std::path::Path) -> usize {
    std::fs::read(file).expect("read").iter().filter(|byte| **byte == b'\n').count()
}
