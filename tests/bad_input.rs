//! Bad input: a message that names the culprit, exit code 1 or 2, never a panic, and what was done before stays.

mod common;

use std::path::Path;

use common::{copy, folder, pldi, recording};
use pldi_core::descriptor::{DescriptorKind, LENGTH};
use pldi_core::templates::Templates;
use pldi_core::view::ViewParams;
use pldi_host::output::png;
use pldi_host::templates::{EMBEDDED, TemplateSet, View, fixed_file};

/// Runs on a damaged copy: the exit code, what the message must contain, and how many frames are written before.
#[track_caller]
fn refused(input: &Path, more: &[&str], code: i32, message: &[&str], frames: usize) {
    let mut line = vec!["run".into(), input.as_os_str().to_owned()];
    line.extend(more.iter().map(Into::into));
    let outcome = pldi(line);
    assert_eq!(outcome.code, Some(code), "{}", outcome.stderr);
    for part in message {
        assert!(outcome.stderr.contains(part), "{part:?} is not in {:?}", outcome.stderr);
    }
    let last = outcome.stderr.lines().last().unwrap_or_default();
    assert!(last.starts_with("pldi: ") || code == 2, "{}", outcome.stderr);
    let lines = outcome.lines();
    assert_eq!(lines.len(), frames, "{}", outcome.stderr);
    assert!(lines.iter().enumerate().all(|(i, line)| line["frame"] == i));
}

/// Changes a file of a copy and expects frame 1 to fail.
#[track_caller]
fn damaged(file: &str, change: impl Fn(&mut Vec<u8>), message: &[&str]) {
    let copy = copy();
    let path = copy.path().join(file);
    let mut bytes = std::fs::read(&path).unwrap();
    change(&mut bytes);
    std::fs::write(&path, bytes).unwrap();
    refused(copy.path(), &["--threads", "2"], 1, &[&["frame 1", file], message].concat(), 1);
}

#[test]
fn images_cut_anywhere() {
    for file in ["depth/0001.png", "rgb/0001.png"] {
        let whole = std::fs::metadata(recording().join(file)).unwrap().len() as usize;
        damaged(file, Vec::clear, &["0 bytes"]);
        for length in [1, 7, 8, 20, 33, 57, 1000, whole / 3, whole / 2, whole - 13, whole - 1] {
            damaged(file, |bytes| bytes.truncate(length), &["cut"]);
        }
        damaged(file, |bytes| bytes[whole / 2] ^= 0x40, &["damaged"]);
        damaged(file, |bytes| bytes.splice(.., *b"no image").for_each(drop), &["neither a PNG nor a JPEG"]);
    }
}

#[test]
fn missing_files_are_named_with_the_line_that_lists_them() {
    for file in ["depth/0001.png", "rgb/0001.png"] {
        let copy = copy();
        std::fs::remove_file(copy.path().join(file)).unwrap();
        refused(copy.path(), &[], 1, &["frame 1", file, "associations.txt, line 2"], 1);
    }
    let copy = copy();
    std::fs::write(copy.path().join("associations.txt"), "0 rgb/0000.png 0 depth/0000.png\n1 rgb/0001.png\n").unwrap();
    refused(copy.path(), &[], 1, &["associations.txt, line 2", "fields"], 0);
}

#[test]
fn frames_that_fail_can_be_left_out() {
    let copy = copy();
    std::fs::write(copy.path().join("depth/0001.png"), b"").unwrap();
    let outcome = pldi(arguments!["run", copy.path(), "--keep-going"]);
    assert_eq!(outcome.code, Some(1));
    let frames: Vec<u64> = outcome.lines().iter().map(|l| l["frame"].as_u64().unwrap()).collect();
    assert_eq!(frames, [0, 2]);
    for part in ["frame 1", "depth/0001.png", "1 of 3 frames failed"] {
        assert!(outcome.stderr.contains(part), "{}", outcome.stderr);
    }
}

#[test]
fn sizes_that_do_not_fit() {
    let copy = copy();
    let colour = copy.path().join("rgb/0001.png");
    png::write_rgb8(&colour, (320, 240), &[7; 3 * 320 * 240]).unwrap();
    refused(copy.path(), &[], 1, &["frame 1", "rgb/0001.png is 320x240", "depth/0001.png is 640x480"], 1);
    png::write_rgb8(&colour, (500, 400), &[7; 3 * 500 * 400]).unwrap();
    png::write_grey16(&copy.path().join("depth/0001.png"), (500, 400), &[900; 500 * 400]).unwrap();
    refused(copy.path(), &[], 1, &["frame 1", "depth/0001.png is 500x400", "320x240"], 1);
    png::write_grey8(&copy.path().join("depth/0001.png"), (640, 480), &[9; 640 * 480]).unwrap();
    refused(copy.path(), &[], 1, &["frame 1", "depth/0001.png", "16-bit grey"], 1);
}

#[test]
fn absurd_intrinsics_by_option_are_wrong_usage() {
    for (text, message) in [
        ("0,525,319.5,239.5", "fx"),
        ("525,nan,319.5,239.5", "fy"),
        ("-525,525,319.5,239.5", "fx"),
        ("525,525,inf,239.5", "cx"),
        ("525,525,319.5,99999@640x480", "cy"),
        ("525,525,319.5", "fx,fy,cx,cy"),
        ("525,525,319.5,239.5@0x480", "fx,fy,cx,cy"),
        ("525,525,319.5,239.5@320x240", "640x480"),
        ("3,3,319.5,239.5", "fx"),
    ] {
        refused(recording(), &["--intrinsics", text], 2, &[message], 0);
    }
}

#[test]
fn absurd_calibration_files() {
    let good = std::fs::read_to_string(recording().join("camera_info.yaml")).unwrap();
    let matrix = "data: [571.26";
    assert!(good.contains(matrix));
    for (text, message) in [
        (good.replace(matrix, "data: [0.0"), "fx = 0"),
        (good.replace(matrix, "data: [-5.0"), "fx = -5"),
        (good.replace(matrix, "data: [.nan"), "fx"),
        (good.replace(matrix, "data: [1.0, 571.26"), "10 numbers"),
        (good.replace("image_width: 640", "image_width: 0"), "image_width"),
        (good.replace("image_width: 640\nimage_height: 480", "image_width: 320\nimage_height: 240"), "320x240"),
        (good.replace("camera_matrix", "matrix"), "camera_matrix"),
        ("\t: [{ not yaml".to_owned(), "camera_info"),
        (String::new(), "0 bytes"),
    ] {
        let copy = copy();
        std::fs::write(copy.path().join("camera_info.yaml"), text).unwrap();
        refused(copy.path(), &[], 1, &["camera_info.yaml", message], 0);
    }
}

#[test]
fn inputs_that_are_no_recordings() {
    let empty = folder();
    refused(empty.path(), &[], 1, &["no recording"], 0);
    refused(&empty.path().join("missing"), &[], 1, &["missing"], 0);
    std::fs::create_dir(empty.path().join("depth")).unwrap();
    refused(empty.path(), &[], 1, &["no frame"], 0);
    std::fs::write(empty.path().join("depth.txt"), "# nothing\n").unwrap();
    refused(empty.path(), &[], 1, &["no frame"], 0);
    refused(&recording().join("camera_info.yaml"), &[], 1, &["camera_info.yaml", "no known kind of input"], 0);
    refused(recording(), &["--floor", "steep"], 2, &["--floor"], 0);
    refused(recording(), &["--depth-scale", "0"], 2, &["depth scale"], 0);
    refused(recording(), &["--colour", "x.png"], 2, &["--color"], 0);
    let file = empty.path().join("file");
    std::fs::write(&file, b"").unwrap();
    refused(recording(), &["--overlay", file.to_str().unwrap()], 1, &["cannot write", "file"], 0);
}

/// A template file of a few views.
fn small_set(descriptor: DescriptorKind) -> Vec<u8> {
    let view =
        |view: u16| -> View { View { object: view % 2, view, descriptor: [0.01 * f32::from(view + 1); LENGTH] } };
    let set: TemplateSet = TemplateSet {
        view: ViewParams { descriptor, ..ViewParams::DEFAULT },
        distance: 2.0,
        height: 1.2,
        simulated: true,
        classes: vec!["chair".into(), "box".into()],
        objects: vec![(0, "a".into()), (1, "b".into())],
        views: (0..4).map(view).collect(),
    };
    set.to_bytes().unwrap()
}

#[test]
fn a_template_file_cut_anywhere_is_refused() {
    let paper = small_set(DescriptorKind::Paper);
    for whole in [EMBEDDED.to_vec(), fixed_file(&paper).unwrap(), paper] {
        for length in 0..whole.len() {
            let error = Templates::parse(&whole[..length]).expect_err("cut");
            assert!(!error.to_string().is_empty());
        }
        assert!(Templates::parse(&whole).is_ok());
    }
    let out = folder();
    let file = out.path().join("cut.pldt");
    for length in [0, 3, 47, 48, 100, EMBEDDED.len() / 2, EMBEDDED.len() - 1] {
        std::fs::write(&file, &EMBEDDED[..length]).unwrap();
        refused(recording(), &["--templates", file.to_str().unwrap()], 1, &["cut.pldt", "cut"], 0);
    }
}

#[test]
fn a_template_file_with_any_byte_changed_is_refused() {
    let halves = small_set(DescriptorKind::Halves);
    for whole in [fixed_file(&halves).unwrap(), halves] {
        for at in 0..whole.len() {
            for flip in [0xff, 0x01, 0x80] {
                let mut bytes = whole.clone();
                bytes[at] ^= flip;
                assert!(Templates::parse(&bytes).is_err(), "byte {at}");
            }
        }
    }
    let out = folder();
    let file = out.path().join("changed.pldt");
    for (at, message) in [(0, "not a template file"), (5, "version"), (60, "damaged"), (EMBEDDED.len() - 1, "damaged")]
    {
        let mut bytes = EMBEDDED.to_vec();
        bytes[at] ^= 0xff;
        std::fs::write(&file, &bytes).unwrap();
        refused(recording(), &["--templates", file.to_str().unwrap()], 1, &["changed.pldt", message], 0);
        let info = pldi(arguments!["templates", "info", file]);
        assert!(info.code == Some(1) && info.stderr.contains("changed.pldt"), "{}", info.stderr);
    }
    let missing = out.path().join("missing.pldt");
    refused(recording(), &["--templates", missing.to_str().unwrap()], 1, &["missing.pldt"], 0);
}

#[test]
fn templates_in_the_other_encoding() {
    let out = folder();
    let [file, again] = ["coded.pldt", "again.pldt"].map(|name| out.path().join(name));
    std::fs::write(&file, fixed_file(EMBEDDED).unwrap()).unwrap();
    let message = ["coded.pldt", "16-bit logarithms", "32-bit floats are needed"];
    refused(recording(), &["--templates", file.to_str().unwrap()], 2, &message, 0);
    let outcome = pldi(arguments!["templates", "convert", file, "-o", again]);
    assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
    assert!(message.iter().all(|part| outcome.stderr.contains(part)), "{}", outcome.stderr);
    std::fs::write(&file, &EMBEDDED[..1000]).unwrap();
    let outcome = pldi(arguments!["templates", "convert", file, "-o", again]);
    assert!(outcome.code == Some(1) && outcome.stderr.contains("coded.pldt: the template file is cut"));
    assert!(!again.exists());
}

#[test]
fn templates_of_the_other_descriptor() {
    let out = folder();
    for (kind, own, other) in [(DescriptorKind::Paper, "paper", "halves"), (DescriptorKind::Halves, "halves", "paper")]
    {
        let file = out.path().join(format!("{own}.pldt"));
        std::fs::write(&file, small_set(kind)).unwrap();
        let name = file.to_str().unwrap();
        refused(recording(), &["--templates", name, "--descriptor", other], 2, &[name, "view parameters"], 0);
        // Without a wish, the file's own are used.
        assert_eq!(pldi(arguments!["run", *recording(), "--templates", name]).ok().lines().len(), 3);
        assert_eq!(
            pldi(arguments!["run", *recording(), "--templates", name, "--descriptor", own]).ok().lines().len(),
            3
        );
    }
    refused(recording(), &["--framing", "metric"], 2, &["embedded templates", "view parameters"], 0);
}
