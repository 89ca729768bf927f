//! `pldi run` on good input: what it writes, and that nothing but the input decides it.

mod common;

use std::io::{BufRead, BufReader};
use std::process::Stdio;

use common::{command, folder, lines, listed, names, pldi, recording};
use serde_json::Value;

fn keys(value: &Value) -> Vec<&str> {
    let mut keys: Vec<&str> = value.as_object().expect("an object").keys().map(String::as_str).collect();
    keys.sort_unstable();
    keys
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    let values: Vec<f64> = value.as_array().expect("an array").iter().map(|v| v.as_f64().expect("a number")).collect();
    values.try_into().unwrap_or_else(|v| panic!("{v:?} are not {N} numbers"))
}

fn hexadecimal(value: &Value) -> bool {
    value.as_str().is_some_and(|s| s.len() == 8 && u32::from_str_radix(s, 16).is_ok())
}

#[test]
fn lines_have_the_promised_form() {
    let lines = pldi(arguments!["run", *recording()]).ok().lines();
    assert_eq!(lines.len(), 3);
    let mut detections = 0;
    for (i, line) in lines.iter().enumerate() {
        let expected =
            ["arithmetic", "detections", "floor", "frame", "params", "rejected", "stamp", "templates", "version"];
        assert_eq!(keys(line), expected);
        assert_eq!(line["arithmetic"], "float");
        assert_eq!((line["frame"].as_u64(), line["stamp"].as_f64()), (Some(i as u64), Some(i as f64 * 0.2)));
        assert!(hexadecimal(&line["params"]) && hexadecimal(&line["templates"]), "{line}");
        assert_eq!(line["version"], env!("CARGO_PKG_VERSION"));
        assert_eq!((&line["params"], &line["templates"]), (&lines[0]["params"], &lines[0]["templates"]));
        // The camera stands 1.2 m high and looks down by 0.3.
        let normal = numbers::<3>(&line["floor"]["normal"]);
        assert!((normal[2] + 0.2955).abs() < 0.03 && (normal[1] + 0.9553).abs() < 0.03, "{normal:?}");
        assert!((line["floor"]["height"].as_f64().unwrap() - 1.2).abs() < 0.05, "{line}");
        for detection in line["detections"].as_array().unwrap() {
            detections += 1;
            check_detection(detection);
        }
        for rejected in line["rejected"].as_array().unwrap() {
            assert_eq!(keys(rejected), ["bbox", "center", "id", "reason"]);
            check_box(&rejected["bbox"]);
            numbers::<3>(&rejected["center"]);
            let reasons = ["noise", "at border", "too small", "too large", "occluded"];
            assert!(reasons.contains(&rejected["reason"].as_str().unwrap()), "{rejected}");
        }
    }
    assert!(detections >= 3, "the frames show six objects that stand free");
}

/// The clusters, by the middle of their boxes in the image, and what they are.
fn found(line: &Value) -> Vec<([f64; 2], String)> {
    let middle = |cluster: &Value| {
        let [u0, v0, u1, v1] = numbers::<4>(&cluster["bbox"]);
        [0.5 * (u0 + u1), 0.5 * (v0 + v1)]
    };
    let class = |d: &Value| d["results"][0]["class_id"].as_str().unwrap().to_owned();
    line["detections"].as_array().unwrap().iter().map(|d| (middle(d), class(d))).collect()
}

#[test]
fn integers_find_what_floats_find() {
    let input = recording();
    let overlay = folder();
    let float = pldi(arguments!["run", *input]).ok().lines();
    let fixed = pldi(arguments!["run", *input, "--arithmetic", "fixed", "--overlay", overlay.path()]).ok();
    assert_eq!(names(overlay.path()).len(), 3);
    let one = pldi(arguments!["run", *input, "--arithmetic", "fixed", "--threads", "1"]).ok();
    assert!(fixed.stdout == one.stdout, "the number of threads changes nothing");
    for (a, b) in float.iter().zip(fixed.lines()) {
        assert_eq!((keys(a), &a["params"], &b["arithmetic"]), (keys(&b), &b["params"], &"fixed".into()));
        let height = |line: &Value| line["floor"]["height"].as_f64().unwrap();
        assert!((height(a) - height(&b)).abs() < 0.01, "{a} {b}");
        let (float, fixed) = (found(a), found(&b));
        assert_eq!(float.len(), fixed.len(), "{a} {b}");
        for ((at, class), (near, same)) in float.iter().zip(&fixed) {
            assert!((at[0] - near[0]).abs() <= 6.0 && (at[1] - near[1]).abs() <= 6.0, "{at:?} {near:?}");
            assert_eq!(class, same, "{a} {b}");
        }
        for detection in b["detections"].as_array().unwrap() {
            check_detection(detection);
        }
    }
}

fn check_detection(detection: &Value) {
    assert_eq!(keys(detection), ["bbox", "center", "id", "results", "size"]);
    check_box(&detection["bbox"]);
    let (center, size) = (numbers::<3>(&detection["center"]), numbers::<3>(&detection["size"]));
    assert!(center[2] > 0.5 && center[2] < 6.0 && size.iter().all(|s| *s > 0.0 && *s < 4.0), "{detection}");
    let results = detection["results"].as_array().unwrap();
    assert!((1..=5).contains(&results.len()));
    for (rank, result) in results.iter().enumerate() {
        assert_eq!(keys(result), ["class_id", "distance", "object", "score", "view"]);
        let (score, distance) = (result["score"].as_f64().unwrap(), result["distance"].as_f64().unwrap());
        assert!((0.0..=1.0).contains(&score) && (0.0..=58.0).contains(&distance), "{result}");
        assert!(if rank == 0 { score >= 0.5 } else { score <= 0.5 }, "{results:?}");
        assert!(result["class_id"].as_str().is_some_and(|c| !c.is_empty()) && result["view"].is_u64());
        assert!(rank == 0 || distance >= results[rank - 1]["distance"].as_f64().unwrap(), "best first: {results:?}");
    }
}

/// Boxes are in the images' own pixels and hold whole blocks of 2x2.
fn check_box(bbox: &Value) {
    let [u0, v0, u1, v1] = numbers::<4>(bbox).map(|v| v as u32);
    assert!(u0 < u1 && u1 < 640 && v0 < v1 && v1 < 480 && u0 % 2 == 0 && v0 % 2 == 0 && u1 % 2 == 1 && v1 % 2 == 1);
}

#[test]
fn numbers_of_clusters_are_those_of_the_stages() {
    for arithmetic in ["float", "fixed"] {
        compare_with_stages(arithmetic);
    }
}

fn compare_with_stages(arithmetic: &str) {
    let lines = pldi(arguments!["run", *recording(), "--arithmetic", arithmetic]).ok().lines();
    let out = folder();
    pldi(arguments!["stages", *recording(), "--frame", "1", "--arithmetic", arithmetic, "--out", out.path()]).ok();
    let stages: Value = serde_json::from_slice(&std::fs::read(out.path().join("candidates.json")).unwrap()).unwrap();
    let of = |candidate: bool, key: &str| -> Vec<Value> {
        let all = stages["clusters"].as_array().unwrap().iter();
        all.filter(|c| c["candidate"] == candidate).map(|c| c[key].clone()).collect()
    };
    let ids = |key: &str| -> Vec<Value> { lines[1][key].as_array().unwrap().iter().map(|c| c["id"].clone()).collect() };
    assert_eq!(ids("detections"), of(true, "cluster"));
    assert_eq!(ids("rejected"), of(false, "cluster"));
    for (detection, bbox) in lines[1]["detections"].as_array().unwrap().iter().zip(of(true, "bbox")) {
        let [u0, v0, u1, v1] = numbers::<4>(&bbox);
        assert_eq!(numbers::<4>(&detection["bbox"]), [2.0 * u0, 2.0 * v0, 2.0 * u1 + 1.0, 2.0 * v1 + 1.0]);
    }
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let input = listed(12);
    let run = |threads: &str| {
        let overlay = folder();
        let outcome = pldi(arguments!["run", input.path(), "--threads", threads, "--overlay", overlay.path()]).ok();
        let pictures: Vec<Vec<u8>> =
            names(overlay.path()).iter().map(|name| std::fs::read(overlay.path().join(name)).unwrap()).collect();
        (outcome.stdout, pictures)
    };
    let one = run("1");
    assert_eq!((lines(&one.0).len(), one.1.len()), (12, 12));
    for threads in ["2", "5"] {
        assert!(run(threads) == one, "{threads} threads");
    }
}

#[test]
fn each_frame_has_a_picture() {
    let out = folder();
    let overlay = out.path().join("made/where/missing");
    pldi(arguments!["run", *recording(), "--overlay", overlay]).ok();
    assert_eq!(names(&overlay), ["0000.png", "0001.png", "0002.png"]);
    for name in names(&overlay) {
        let picture = image::open(overlay.join(name)).unwrap().into_rgb8();
        assert_eq!(picture.dimensions(), pldi_host::overlay::SIZE);
        // Not empty on either side.
        let bright = |x: u32| (0..480).filter(|y| picture.get_pixel(x, *y).0.iter().any(|c| *c > 60)).count();
        assert!(bright(320) > 100 && (700..1100).map(bright).sum::<usize>() > 1000);
    }
}

#[test]
fn a_reader_that_has_seen_enough_ends_the_run_quietly() {
    let input = listed(300);
    let mut child = command();
    child.args(arguments!["run", input.path()]).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = child.spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    assert_eq!(lines(line.as_bytes())[0]["frame"], 0);
    // The reading end is closed by now.
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
}

#[cfg(unix)]
#[test]
fn an_interrupt_leaves_complete_lines_and_no_temporary_files() {
    let (input, out) = (listed(50_000), folder());
    let (overlay, file) = (out.path().join("overlay"), out.path().join("lines.jsonl"));
    let mut child = command();
    child.args(arguments!["run", input.path(), "--overlay", overlay]).stderr(Stdio::piped());
    let child = child.stdout(std::fs::File::create(&file).unwrap()).spawn().unwrap();
    let start = std::time::Instant::now();
    while std::fs::read(&file).unwrap().is_empty() {
        assert!(start.elapsed().as_secs() < 30, "no line after 30 s");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{stderr}");
    assert!(stderr.contains("interrupted") && !stderr.contains("panicked"), "{stderr}");
    let lines = lines(&std::fs::read(&file).unwrap());
    assert!(lines.iter().enumerate().all(|(i, line)| line["frame"] == i) && lines.len() < 50_000);
    let pictures = names(&overlay);
    assert_eq!(pictures.len(), lines.len());
    assert!(pictures.iter().all(|name| name.ends_with(".png") && !name.starts_with('.')), "{pictures:?}");
}

/// Largest memory in use so far, in KiB, as Linux counts it.
#[cfg(target_os = "linux")]
fn peak(process: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?.split_whitespace().next()?.parse().ok()
}

#[cfg(target_os = "linux")]
#[test]
fn memory_does_not_grow_with_the_recording() {
    let input = listed(600);
    let mut child = command();
    child.args(arguments!["run", input.path(), "--threads", "2"]).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = child.spawn().unwrap();
    let (mut early, mut late) = (None, None);
    for (i, line) in BufReader::new(child.stdout.take().unwrap()).lines().enumerate() {
        line.unwrap();
        // Past the last line the process may be gone.
        let now = peak(child.id());
        early = if i == 19 { now } else { early };
        late = now.or(late);
    }
    assert!(child.wait().unwrap().success());
    let (early, late) = (early.unwrap(), late.unwrap());
    assert!(late < early + 4096, "{early} KiB after 20 frames, {late} KiB after 600");
}
