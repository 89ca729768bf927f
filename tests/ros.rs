//! Bags and MCAP files that the formats' own Python libraries write: the same frames give the same results.
//!
//! Needs a Python with `tests/ros/requirements.txt`, which `.ci/run` prepares; without one the tests say so and do
//! nothing, and fail where `CI` is set.

mod common;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use common::{Outcome, folder, pldi, recording};
use serde_json::Value;

/// Seconds that `write.py` adds to the stamps.
const EPOCH: f64 = 1.7e9;

/// A Python that has what the scripts import.
fn python() -> Option<PathBuf> {
    let venv = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/judge-venv/bin/python");
    let candidates = match std::env::var_os("PLDI_PYTHON") {
        Some(python) => vec![python.into()],
        None => vec![venv, "python3".into()],
    };
    let has_modules = |python: &PathBuf| {
        let imports = Command::new(python).args(["-c", "import numpy, cv2, mcap, mcap_ros2, rosbags"]).output();
        imports.is_ok_and(|output| output.status.success())
    };
    candidates.into_iter().find(has_modules)
}

fn script(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/ros").join(name)
}

/// The folder of what `write.py` wrote, once per test binary.
fn written() -> Option<&'static Path> {
    static FOLDER: OnceLock<Option<PathBuf>> = OnceLock::new();
    let write = || {
        let Some(python) = python() else {
            // Written directly: the test harness keeps what print macros say of tests that pass.
            let _ = writeln!(std::io::stderr(), "SKIPPED: no Python with tests/ros/requirements.txt (set PLDI_PYTHON)");
            assert!(std::env::var_os("CI").is_none(), "CI needs that Python");
            return None;
        };
        let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("ros-written");
        let _ = std::fs::remove_dir_all(&out);
        let output =
            Command::new(python).arg(script("write.py")).arg(recording()).arg(&out).output().expect("it starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        Some(out)
    };
    FOLDER.get_or_init(write).as_deref()
}

/// The lines without their stamps, and the stamps.
fn split(mut lines: Vec<Value>) -> (Vec<Value>, Vec<f64>) {
    let stamps = lines.iter_mut().map(|line| line["stamp"].take().as_f64().expect("a stamp")).collect();
    (lines, stamps)
}

/// Runs a file and compares all its lines with the folder's first ones; gives their number.
#[track_caller]
fn same_as_the_folder(file: &Path, more: &[&str]) -> (usize, Outcome) {
    static FOLDER: OnceLock<(Vec<Value>, Vec<f64>)> = OnceLock::new();
    let (expected, times) = FOLDER.get_or_init(|| split(pldi(arguments!["run", *recording()]).ok().lines()));
    let mut line = vec!["run".into(), file.as_os_str().to_owned()];
    line.extend(more.iter().map(Into::into));
    let outcome = pldi(line).ok();
    let (lines, stamps) = split(outcome.lines());
    let n = lines.len();
    assert!(lines[..] == expected[..n], "{}: {lines:#?}\n{}", file.display(), outcome.stderr);
    for (stamp, time) in stamps.iter().zip(times) {
        assert!((stamp - EPOCH - time).abs() < 1e-6, "{}: {stamp}", file.display());
    }
    (n, outcome)
}

#[test]
fn whatever_the_container_and_the_encoding_the_results_are_the_folders() {
    let Some(written) = written() else { return };
    let files = [
        "ros2-support.mcap",
        "lz4.mcap",
        "none.mcap",
        "unchunked.mcap",
        "unindexed.mcap",
        "small.mcap",
        "ros1.mcap",
        "rosbag2/rosbag2.mcap",
        "none.bag",
        "lz4.bag",
        "bz2.bag",
    ];
    for file in files {
        let (frames, outcome) = same_as_the_folder(&written.join(file), &[]);
        assert_eq!((frames, outcome.stderr.as_str()), (3, ""), "{file}");
    }
}

#[test]
fn cut_and_damaged_files_are_read_as_far_as_they_go_with_one_warning() {
    let Some(written) = written() else { return };
    for (file, frames, message) in [
        ("truncated.mcap", 2, "in the midst"),
        ("damaged.mcap", 2, "the chunk at byte"),
        ("active.bag", 2, "in the midst"),
    ] {
        // A damaged chunk takes a frame out of the middle: only what is before it has the folder's numbers.
        let outcome = pldi(arguments!["run", written.join(file)]).ok();
        assert_eq!(outcome.lines().len(), frames, "{file}: {}", outcome.stderr);
        assert_eq!(outcome.stderr.matches(message).count(), 1, "{file}: {}", outcome.stderr);
    }
    same_as_the_folder(&written.join("truncated.mcap"), &[]);
    same_as_the_folder(&written.join("active.bag"), &[]);
}

#[test]
fn topics_can_be_chosen() {
    let Some(written) = written() else { return };
    let (depth, colour) = ("/camera/depth_registered/image_raw", "/camera/rgb/image_raw");
    let info = "/camera/depth_registered/camera_info";
    let file = written.join("bz2.bag");
    let (frames, _) = same_as_the_folder(&file, &["--depth", depth, "--color", colour, "--info", info]);
    assert_eq!(frames, 3);
    for (option, topic, message) in [
        ("--depth", "/nowhere", "/camera/rgb/image_raw (sensor_msgs/Image in ros1, 3 messages)"),
        ("--depth", colour, "depth in encoding \"bgr8\" is not read"),
        ("--info", depth, "CameraInfo are needed"),
    ] {
        let outcome = pldi(arguments!["run", file, option, topic]);
        assert!(outcome.code != Some(0) && outcome.stderr.contains(message), "{}", outcome.stderr);
    }
}

/// The images in two folders, name by name.
fn images(a: &Path, b: &Path) -> Vec<[image::RgbImage; 2]> {
    let names = common::names(b);
    assert!(names.len() == 3 && common::names(a) == names, "{}", a.display());
    let open = |folder: &Path, name: &str| image::open(folder.join(name)).expect("an image").into_rgb8();
    names.iter().map(|name| [open(a, name), open(b, name)]).collect()
}

#[test]
fn encodings_that_lose_colour_are_read_as_opencv_reads_them() {
    let Some(written) = written() else { return };
    let place = folder();
    // How far from the rim on, and how far apart: OpenCV copies the rim of a mosaic, decoders of JPEG round as they like.
    let bayer = ["rggb", "bggr", "gbrg", "grbg"].map(|name| (name, "mcap", 1, 0));
    let others = [("uyvy", "mcap", 0, 0), ("yuyv", "mcap", 0, 0), ("mono8", "mcap", 0, 0), ("jpeg", "bag", 0, 6)];
    for (name, extension, rim, apart) in bayer.into_iter().chain(others) {
        let out = place.path().join(name);
        pldi(arguments!["record", written.join(format!("{name}.{extension}")), "-o", out]).ok();
        for [ours, theirs] in images(&out.join("rgb"), &written.join(format!("{name}.colour"))) {
            assert_eq!(ours.dimensions(), theirs.dimensions());
            for (x, y, pixel) in ours.enumerate_pixels() {
                if x >= rim && y >= rim && x + rim < ours.width() && y + rim < ours.height() {
                    let other = theirs.get_pixel(x, y);
                    let close = pixel.0.iter().zip(other.0).all(|(a, b)| a.abs_diff(b) <= apart);
                    assert!(close, "{name} at {x}, {y}: {pixel:?}, OpenCV {other:?}");
                }
            }
        }
    }
    // Inverse depth in 16 bits has steps of z^2 / 10100 m.
    let depth =
        |folder: &Path, name: &str| image::open(folder.join("depth").join(name)).expect("an image").into_luma16();
    for i in 0..3 {
        let ours = depth(&place.path().join("jpeg"), &format!("{i:06}.png"));
        let theirs = depth(recording(), &format!("{i:04}.png"));
        for (a, b) in ours.iter().zip(theirs.iter()) {
            let step = (f32::from(*b) / 1000.0) * f32::from(*b) / 10_100.0;
            assert!((f32::from(*a) - f32::from(*b)).abs() <= step + 1.0, "{a} for {b} mm");
        }
    }
}

/// What the reference libraries read from a file, topic by topic.
fn read_by_others(python: &Path, file: &Path) -> Value {
    let output = Command::new(python).arg(script("read.py")).arg(file).output().expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut read: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    read["topics"].take()
}

/// A value's numbers as single precision, in which they were computed.
fn singles<'a>(values: impl IntoIterator<Item = &'a Value>) -> Vec<f32> {
    values.into_iter().map(|value| value.as_f64().expect("a number") as f32).collect()
}

#[test]
fn results_in_mcap_are_read_by_others_as_the_lines_say() {
    let Some(python) = python() else { return };
    let out = folder();
    let file = out.path().join("results.mcap");
    let lines = pldi(arguments!["run", *recording(), "--mcap", file]).ok().lines();
    let topics = read_by_others(&python, &file);
    let messages = |topic: &str| topics[topic]["messages"].as_array().expect("messages").clone();
    let mut candidates = 0;
    for (line, message) in lines.iter().zip(messages("/pldi/detections")) {
        let (said, read) = (line["detections"].as_array().unwrap(), message["detections"].as_array().unwrap());
        assert_eq!(said.len(), read.len());
        for (said, read) in said.iter().zip(read) {
            candidates += 1;
            let (position, size) = (&read["bbox"]["center"]["position"], &read["bbox"]["size"]);
            let xyz = |of: &Value| singles([&of["x"], &of["y"], &of["z"]]);
            assert_eq!(xyz(position), singles(said["center"].as_array().unwrap()));
            assert_eq!(xyz(size), singles(said["size"].as_array().unwrap()));
            let results = said["results"].as_array().unwrap();
            assert_eq!(results.len(), read["results"].as_array().unwrap().len());
            for (said, read) in results.iter().zip(read["results"].as_array().unwrap()) {
                assert_eq!(said["class_id"], read["hypothesis"]["class_id"]);
                assert_eq!(singles([&said["score"]]), singles([&read["hypothesis"]["score"]]));
                assert_eq!(read["pose"]["pose"]["position"], *position);
            }
        }
    }
    assert!(candidates >= 3);
    for (line, message) in lines.iter().zip(messages("/pldi/markers")) {
        let count = 1 + 2 * line["detections"].as_array().unwrap().len();
        assert_eq!(message["markers"].as_array().unwrap().len(), count);
    }
    let (n, camera) = (&messages("/pldi/n")[0], &messages("/pldi/camera_info")[0]);
    assert_eq!((&n["width"], &n["data"]["bytes"], &camera["width"]), (&320.into(), &76_800.into(), &320.into()));
}

#[test]
fn recordings_in_mcap_are_read_by_others_and_here() {
    let out = folder();
    let (kept, again) = (out.path().join("kept.mcap"), out.path().join("again.mcap"));
    pldi(arguments!["record", *recording(), "--out", kept]).ok();
    assert_eq!(pldi(arguments!["run", kept]).ok().stdout, pldi(arguments!["run", *recording()]).ok().stdout);
    // What is read and written once more says the same, also of its coordinate frame.
    pldi(arguments!["record", kept, "--out", again]).ok();
    let Some(python) = python() else { return };
    let topics = read_by_others(&python, &kept);
    assert_eq!(topics.as_object().unwrap().len(), 4);
    assert_eq!(topics, read_by_others(&python, &again));
    let depth = topics["/camera/depth/image_raw"]["messages"].as_array().unwrap();
    assert_eq!((depth.len(), &depth[2]["encoding"], &depth[2]["data"]["bytes"]), (3, &"16UC1".into(), &614_400.into()));
}

#[test]
fn results_have_the_coordinate_frame_of_the_recording() {
    let (Some(written), Some(python)) = (written(), python()) else { return };
    let (input, out) = (written.join("ros2-support.mcap"), folder());
    let file = out.path().join("results.mcap");
    pldi(arguments!["run", input, "--mcap", file, "--frames", "1"]).ok();
    let (theirs, ours) = (read_by_others(&python, &input), read_by_others(&python, &file));
    let images = theirs.as_object().unwrap().values().flat_map(|topic| topic["messages"].as_array().unwrap());
    let depth: Vec<&Value> = images.filter(|message| message["encoding"] == "16UC1").collect();
    let header = &ours["/pldi/detections"]["messages"][0]["header"];
    assert!(header["frame_id"] != "" && depth.iter().any(|message| message["header"] == *header), "{header}");
}
