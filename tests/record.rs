//! `pldi record` through the binary: what is kept is what came.

mod common;

use std::path::Path;
use std::process::Stdio;

use common::{command, copy, folder, listed, names, pldi, recording};
use serde_json::Value;

/// The lines of `pldi run` without what a recording of another kind calls otherwise.
fn run(input: &Path) -> Vec<Value> {
    pldi(arguments!["run", input]).ok().lines()
}

#[test]
fn a_folder_of_a_folder_gives_the_same_lines() {
    let place = folder();
    let out = place.path().join("kept");
    let outcome = pldi(arguments!["record", recording(), "-o", out]).ok();
    assert!(outcome.stdout.is_empty() && outcome.stderr.contains("3 frames in"), "{}", outcome.stderr);
    assert_eq!(run(&out), run(recording()));
    assert_eq!(names(place.path()), ["kept"]);
    // A part, without a calibration; then the whole with the user's.
    let info = copy();
    std::fs::remove_file(info.path().join("camera_info.yaml")).unwrap();
    let part = place.path().join("part");
    pldi(arguments!["record", info.path(), "--frames", "2", "-o", part]).ok();
    assert_eq!(names(&part), ["associations.txt", "depth", "rgb"]);
    assert_eq!(names(&part.join("depth")), ["000000.png", "000001.png"]);
    let yaml = recording().join("camera_info.yaml");
    let whole = place.path().join("whole");
    pldi(arguments!["record", info.path(), "--camera-info", yaml, "-o", whole]).ok();
    assert_eq!(run(&whole), run(recording()));
}

#[test]
fn what_is_there_is_not_touched() {
    let place = folder();
    let outcome = pldi(arguments!["record", recording(), "-o", place.path()]);
    assert!(outcome.code == Some(1) && outcome.stderr.contains("there already"), "{}", outcome.stderr);
    assert!(names(place.path()).is_empty());
    let partial = place.path().join("kept.partial");
    std::fs::create_dir(&partial).unwrap();
    let outcome = pldi(arguments!["record", recording(), "-o", place.path().join("kept")]);
    assert!(outcome.code == Some(1) && outcome.stderr.contains("kept.partial"), "{}", outcome.stderr);
}

#[test]
fn a_frame_that_cannot_be_read_is_left_out_and_told() {
    let (input, place) = (copy(), folder());
    std::fs::write(input.path().join("depth/0001.png"), b"").unwrap();
    let out = place.path().join("kept");
    let outcome = pldi(arguments!["record", input.path(), "-o", out]);
    assert_eq!(outcome.code, Some(1));
    for part in ["frame 1 is left out", "0001.png is empty", "2 frames in", "1 of 3 frames failed"] {
        assert!(outcome.stderr.contains(part), "{part}: {}", outcome.stderr);
    }
    let lines = run(&out);
    let original = run(recording());
    assert_eq!([&lines[0]["stamp"], &lines[1]["stamp"]], [&original[0]["stamp"], &original[2]["stamp"]]);
}

#[test]
fn options_that_make_no_sense_are_refused() {
    let place = folder();
    for options in [&["--mode", "vga"][..], &["--once"], &["--depth", "/d"], &["--color", "/c"], &["--frames", "0"]] {
        let mut arguments = arguments!["record", recording(), "-o", place.path().join("x")].to_vec();
        arguments.extend(options.iter().map(Into::into));
        let outcome = pldi(arguments);
        assert!(outcome.code == Some(2) && outcome.stderr.contains(options[0]), "{options:?}: {}", outcome.stderr);
    }
    assert!(names(place.path()).is_empty());
}

#[cfg(unix)]
#[test]
fn an_interrupt_leaves_a_recording_of_what_came() {
    let (input, place) = (listed(50_000), folder());
    let out = place.path().join("kept");
    let mut child = command();
    let child = child.args(arguments!["record", input.path(), "-o", out]).stderr(Stdio::piped()).spawn().unwrap();
    let start = std::time::Instant::now();
    while !place.path().join("kept.partial/depth/000002.png").exists() {
        assert!(start.elapsed().as_secs() < 30, "no frame after 30 s");
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{stderr}");
    let kept = names(&out.join("depth")).len();
    assert!(kept >= 3 && stderr.contains(&format!("{kept} frames in")), "{kept}: {stderr}");
    assert_eq!(names(place.path()), ["kept"]);
    let listed = pldi(arguments!["inspect", out, "--json"]).ok().json();
    assert_eq!(listed["frames"], kept);
}
