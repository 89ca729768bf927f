//! The other commands: stages, describe, match, inspect, bench.

mod common;

use std::path::Path;

use common::{copy, folder, names, pldi, real_recordings, recording};
use pldi_core::matching::canberra;
use serde_json::Value;

fn read_json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

fn descriptor(values: &Value) -> [f32; 58] {
    let values: Vec<f32> = values.as_array().unwrap().iter().map(|v| v.as_f64().unwrap() as f32).collect();
    values.try_into().unwrap()
}

#[test]
fn stages_of_both_arithmetics_look_alike() {
    let out = folder();
    let stages = |arithmetic: &str| {
        let to = out.path().join(arithmetic);
        pldi(arguments!["stages", *recording(), "--frame", "1", "--arithmetic", arithmetic, "--out", to]).ok();
        let pixels = |name: &str| image::open(to.join(name)).unwrap().into_luma16().into_raw();
        (names(&to), ["filtered.png", "n.png", "map.png", "clusters.png"].map(pixels))
    };
    let (float, fixed) = (stages("float"), stages("fixed"));
    assert_eq!(float.0, fixed.0);
    // 2 mm; a hundredth of N; of white; the same cluster. N of ragged neighbourhoods depends on every point's last bit.
    let limits = [("depth", 16, 5), ("N", 655, 15), ("density", 655, 5), ("clusters", 0, 1)];
    for ((a, b), (name, step, per_mille)) in float.1.iter().zip(&fixed.1).zip(limits) {
        let far = a.iter().zip(b).filter(|(a, b)| a.abs_diff(**b) > step).count();
        assert!(1000 * far <= per_mille * a.len() && a.iter().any(|v| *v > 0), "{name}: {far} of {}", a.len());
    }
}

#[test]
fn stages_writes_all_files_and_its_descriptors_are_those_of_the_views() {
    for arithmetic in ["float", "fixed"] {
        check_stages(arithmetic);
    }
}

fn check_stages(arithmetic: &str) {
    let out = folder();
    let written = out.path().join("stages");
    pldi(arguments!["stages", *recording(), "--frame", "1", "--arithmetic", arithmetic, "--out", written]).ok();
    let candidates = read_json(&written.join("candidates.json"));
    let mut expected: Vec<String> =
        ["candidates.json", "clusters.png", "filtered.png", "map.png", "n.png"].map(str::to_owned).to_vec();
    let mut seen = 0;
    for cluster in candidates["clusters"].as_array().unwrap().iter().filter(|c| c["candidate"] == true) {
        let id = &cluster["cluster"];
        expected.extend([format!("view_{id}.png"), format!("dwt_{id}.f32"), format!("descriptor_{id}.json")]);
        let dwt = std::fs::metadata(written.join(format!("dwt_{id}.f32"))).unwrap();
        assert_eq!(dwt.len(), 4 * 128 * 128);
        let descriptors = read_json(&written.join(format!("descriptor_{id}.json")));
        for kind in ["paper", "halves"] {
            let view = written.join(format!("view_{id}.png"));
            let described = pldi(arguments!["describe", view, "--descriptor", kind]).ok().json();
            assert_eq!(described["descriptor"], kind);
            if arithmetic == "float" {
                assert_eq!(described["values"], descriptors[kind], "{kind} {id}");
            } else {
                // Codes, of a view without its bits below a unit: small numbers' ratios are what differs.
                let [a, b] = [&described["values"], &descriptors[kind]].map(descriptor);
                assert!(canberra(&a, &b) < 0.5, "{kind} {id}: {}", canberra(&a, &b));
            }
        }
        seen += 1;
    }
    expected.sort();
    assert_eq!(names(&written), expected);
    assert!(seen > 0);
    let size = |name: &str| image::image_dimensions(written.join(name)).unwrap();
    assert_eq!([size("filtered.png"), size("n.png"), size("clusters.png")], [(320, 240); 3]);
    assert_eq!(size("map.png"), (256, 208));
}

#[test]
fn match_measures_descriptors() {
    let out = folder();
    let stages = |frame: &str| {
        let to = out.path().join(frame);
        pldi(arguments!["stages", *recording(), "--frame", frame, "--out", to]).ok();
        let view = names(&to).into_iter().find(|n| n.starts_with("view_")).expect("a candidate");
        to.join(view)
    };
    let describe = |view: &Path, kind: &str, to: &str| {
        let file = out.path().join(to);
        std::fs::write(&file, pldi(arguments!["describe", view, "--descriptor", kind]).ok().stdout).unwrap();
        file
    };
    let (first, second) = (stages("0"), stages("2"));
    let a = describe(&first, "halves", "a.json");
    let b = describe(&second, "halves", "b.json");
    let paper = describe(&second, "paper", "paper.json");
    assert_eq!(pldi(arguments!["match", a, a]).ok().json()["distance"].as_f64(), Some(0.0));
    let distance = pldi(arguments!["match", a, b]).ok().json()["distance"].as_f64().unwrap();
    assert!(distance > 0.0 && distance <= 58.0);
    assert_eq!(pldi(arguments!["match", b, a]).ok().json()["distance"].as_f64(), Some(distance));
    let outcome = pldi(arguments!["match", a, paper]);
    assert!(outcome.code == Some(1) && outcome.stderr.contains("cannot be compared"), "{}", outcome.stderr);
    let outcome = pldi(arguments!["match", a, first]);
    assert!(outcome.code == Some(1) && outcome.stderr.contains("view_"), "{}", outcome.stderr);
    let outcome = pldi(arguments!["describe", a]);
    assert!(outcome.code == Some(1) && outcome.stderr.contains("a.json"), "{}", outcome.stderr);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_and_no_panic() {
    let descriptor = folder();
    let file = descriptor.path().join("a.json");
    let values = vec!["0.5"; 58].join(",");
    std::fs::write(&file, format!("{{\"descriptor\":\"halves\",\"values\":[{values}]}}")).unwrap();
    for line in [
        arguments!["templates", "info"].to_vec(),
        arguments!["match", file, file].to_vec(),
        arguments!["inspect", *recording()].to_vec(),
        arguments!["run", *recording()].to_vec(),
    ] {
        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let output = common::command().args(&line).stdout(full).stderr(std::process::Stdio::piped()).output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{line:?}: {stderr}");
        assert!(stderr.contains("cannot write to stdout") && !stderr.contains("panicked"), "{line:?}: {stderr}");
    }
}

#[test]
fn the_exact_filter_is_not_to_be_had_in_integers() {
    let out = folder();
    for line in [
        arguments!["run", *recording()].to_vec(),
        arguments!["stages", *recording(), "--out", out.path()].to_vec(),
        arguments!["trial", "--rooms", "1", "--frames", "1"].to_vec(),
        arguments!["demo", "--out", out.path().join("demo")].to_vec(),
    ] {
        let more = ["--arithmetic", "fixed", "--filter", "exact"].map(Into::into);
        let outcome = pldi(line.iter().chain(&more));
        assert!(outcome.code == Some(2) && outcome.stdout.is_empty(), "{line:?}: {}", outcome.stderr);
        assert!(outcome.stderr.contains("--filter exact"), "{line:?}: {}", outcome.stderr);
    }
    assert!(names(out.path()).is_empty());
}

#[test]
fn bench_compares_the_arithmetics() {
    let table = String::from_utf8(pldi(arguments!["bench", *recording(), "--budget", "0.01"]).ok().stdout).unwrap();
    let row = table.lines().find(|line| line.starts_with("whole frame")).expect("a row for the whole frame");
    let numbers: Vec<f64> = row["whole frame".len()..].split_whitespace().map(|n| n.parse().unwrap()).collect();
    let [a, _, b, _, ratio] = numbers[..] else { panic!("{row}") };
    assert!(a > 0.0 && b > 0.0 && (ratio - b / a).abs() < 0.02, "{row}");
    assert!(table.contains("reconstruct") && table.contains("nearest templates"), "{table}");
}

#[test]
fn inspect_tells_what_a_recording_is_like() {
    let summary = pldi(arguments!["inspect", *recording(), "--json"]).ok().json();
    assert_eq!((&summary["frames"], &summary["looked_at"], &summary["floors"]), (&3.into(), &3.into(), &3.into()));
    assert_eq!(summary["sizes"], serde_json::json!([{ "width": 640, "height": 480, "factor": 2 }]));
    assert!((summary["timing"]["rate"].as_f64().unwrap() - 5.0).abs() < 1e-6);
    assert!((summary["height"][1].as_f64().unwrap() - 1.2).abs() < 0.05);
    assert!((summary["pitch"][1].as_f64().unwrap() - 17.2).abs() < 2.0);
    assert_eq!(summary["registration"]["verdict"], "registered", "{summary}");
    let table = String::from_utf8(pldi(arguments!["inspect", *recording(), "--frames", "2"]).ok().stdout).unwrap();
    for part in ["3, looked at 2", "640x480", "camera_info.yaml", "fx 571.26", "registered", "found in 2 of 2"] {
        assert!(table.contains(part), "{part}: {table}");
    }
    let copy = copy();
    std::fs::write(copy.path().join("depth/0001.png"), b"").unwrap();
    let outcome = pldi(arguments!["inspect", copy.path(), "--json"]);
    assert_eq!((outcome.code, outcome.json()["unreadable"][0]["frame"].as_u64()), (Some(1), Some(1)));
}

/// Moves the depth images of a copy by some columns: they then lie `columns` to the left of the colour.
#[test]
fn inspect_notices_depth_that_is_not_registered() {
    let copy = copy();
    for i in 0..3 {
        let path = copy.path().join(format!("depth/{i:04}.png"));
        let ((width, height), mut depth) = pldi_host::output::png::read_grey16(&path).unwrap();
        for line in depth.chunks_exact_mut(usize::from(width)) {
            line.rotate_left(9);
        }
        pldi_host::output::png::write_grey16(&path, (width.into(), height.into()), &depth).unwrap();
    }
    let registration = pldi(arguments!["inspect", copy.path(), "--json"]).ok().json()["registration"].clone();
    assert_eq!(registration["verdict"], "off", "{registration}");
    let [dx, dy] = [0, 1].map(|k| registration["shift"][k].as_i64().unwrap());
    assert!((dx - 9).abs() <= 2 && dy.abs() <= 2, "{registration}");
}

#[test]
fn real_recordings_fit_what_is_known_about_them() {
    let Some(recordings) = real_recordings() else { return };
    let verdict = |name: &str| {
        let outcome = pldi(arguments!["inspect", recordings.join(name), "--json"]).ok();
        outcome.json()["registration"]["verdict"].clone()
    };
    for name in ["armchair", "classroom", "office_boxes", "lounge", "tabletop"] {
        assert_eq!(verdict(name), "registered", "{name}");
    }
    assert_ne!(verdict("kitchen"), "registered");
    assert!(verdict("depth_only").is_null());
}

#[test]
fn labelled_objects_of_real_recordings_are_in_clusters() {
    let Some(recordings) = real_recordings() else { return };
    let truth = read_json(&recordings.join("truth.json"));
    for (frame, objects) in truth.as_object().unwrap().iter().filter(|(key, _)| key.contains('/')) {
        let (name, number) = frame.split_once('/').unwrap();
        let out = folder();
        let number = number.trim_start_matches('0');
        let number = if number.is_empty() { "0" } else { number };
        pldi(arguments!["stages", recordings.join(name), "--frame", number, "--out", out.path()]).ok();
        let clusters = image::open(out.path().join("clusters.png")).unwrap().into_luma8();
        let mut found = Vec::new();
        for object in objects.as_array().unwrap() {
            let [u, v] = ["u", "v"].map(|k| object[k].as_u64().unwrap() as u32 / 2);
            let cluster = clusters.get_pixel(u, v).0[0];
            assert_ne!(cluster, 0, "{frame}: {object} is in no cluster");
            found.push(cluster);
        }
        if name == "office_boxes" {
            // Box, chair, book and, in frame 1, a bottle: each on its own.
            found.sort_unstable();
            found.dedup();
            assert_eq!(found.len(), objects.as_array().unwrap().len(), "{frame}");
        }
    }
}
