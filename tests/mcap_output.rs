//! MCAP files that the command writes: what they say, and that nothing but the input decides it.

mod common;

use std::path::Path;
use std::process::Stdio;

use common::{command, copy, folder, lines, listed, names, pldi, recording};
use pldi_host::output::png;
use serde_json::Value;

/// Topic, log time and content of each message.
fn messages(path: &Path) -> Vec<(String, u64, Vec<u8>)> {
    let bytes = std::fs::read(path).expect("the file");
    let summary = mcap::Summary::read(&bytes).expect("a whole file").expect("a summary");
    let messages: Vec<_> = mcap::MessageStream::new(&bytes)
        .expect("an MCAP file")
        .map(|m| m.expect("a message"))
        .map(|m| (m.channel.topic.clone(), m.log_time, m.data.into_owned()))
        .collect();
    assert_eq!(summary.stats.expect("statistics").message_count, messages.len() as u64);
    messages
}

fn of_topic(messages: &[(String, u64, Vec<u8>)], topic: &str) -> Vec<(u64, Vec<u8>)> {
    messages.iter().filter(|(name, ..)| name == topic).map(|(_, time, data)| (*time, data.clone())).collect()
}

/// Takes a message apart, field by field.
struct Fields<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Fields<'a> {
    fn new(message: &'a [u8]) -> Self {
        assert_eq!(message[..4], [0, 1, 0, 0]);
        Self { bytes: &message[4..], at: 0 }
    }

    fn take(&mut self, count: usize) -> &'a [u8] {
        self.at += count;
        &self.bytes[self.at - count..self.at]
    }

    fn number<const N: usize>(&mut self) -> [u8; N] {
        self.at = self.at.next_multiple_of(N);
        self.take(N).try_into().unwrap()
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.number())
    }

    fn f64(&mut self) -> f64 {
        f64::from_le_bytes(self.number())
    }

    fn f64s<const N: usize>(&mut self) -> [f64; N] {
        std::array::from_fn(|_| self.f64())
    }

    fn string(&mut self) -> &'a str {
        let length = self.u32() as usize;
        std::str::from_utf8(self.take(length).strip_suffix(&[0]).unwrap()).unwrap()
    }

    /// Nanoseconds; the frame must be the camera's.
    fn header(&mut self) -> u64 {
        let (seconds, nanoseconds) = (self.u32(), self.u32());
        assert_eq!(self.string(), "camera_depth_optical_frame");
        u64::from(seconds) * 1_000_000_000 + u64::from(nanoseconds)
    }

    /// Time, size, encoding and pixels.
    fn image(mut self) -> (u64, (u32, u32), &'a str, &'a [u8]) {
        let (stamp, height, width) = (self.header(), self.u32(), self.u32());
        let encoding = self.string();
        assert_eq!(self.take(1), [0]);
        assert_eq!(self.u32() % width, 0);
        let length = self.u32() as usize;
        let pixels = self.take(length);
        assert_eq!(self.at, self.bytes.len());
        (stamp, (width, height), encoding, pixels)
    }
}

/// Compares a message of detections with the line of its frame.
fn compare(message: &[u8], line: &Value) -> usize {
    let mut fields = Fields::new(message);
    let stamp = fields.header();
    assert_eq!(stamp as f64 / 1e9, line["stamp"].as_f64().unwrap());
    let detections = line["detections"].as_array().unwrap();
    assert_eq!(fields.u32() as usize, detections.len());
    for detection in detections {
        assert_eq!(fields.header(), stamp);
        let results = detection["results"].as_array().unwrap();
        assert_eq!(fields.u32() as usize, results.len());
        let number = |value: &Value| value.as_f64().unwrap() as f32;
        let numbers = |value: &Value| value.as_array().unwrap().iter().map(number).collect::<Vec<f32>>();
        let mut pose = None;
        for result in results {
            assert_eq!(fields.string(), result["class_id"].as_str().unwrap());
            assert_eq!(fields.f64() as f32, number(&result["score"]));
            pose = Some(fields.f64s::<7>());
            assert_eq!(fields.f64s(), [0.0; 36]);
        }
        let own = fields.f64s::<7>();
        assert!(pose.is_none_or(|pose| pose == own));
        let size = fields.f64s::<3>();
        assert_eq!(own[..3].iter().map(|v| *v as f32).collect::<Vec<f32>>(), numbers(&detection["center"]));
        assert_eq!(size.map(|v| v as f32).to_vec(), numbers(&detection["size"]));
        stands(own, size, &line["floor"]);
        assert_eq!(fields.string(), "");
    }
    assert_eq!(fields.at, message.len() - 4);
    detections.len()
}

/// The middle of the box's lower side lies on the floor, and its third axis leads away from the camera.
fn stands([x, y, z, i, j, k, w]: [f64; 7], size: [f64; 3], floor: &Value) {
    let down = [2.0 * (i * j - k * w), 1.0 - 2.0 * (i * i + k * k), 2.0 * (j * k + i * w)];
    let away = [2.0 * (i * k + j * w), 2.0 * (j * k - i * w), 1.0 - 2.0 * (i * i + j * j)];
    let normal: Vec<f64> = floor["normal"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    let middle = [x, y, z];
    let height: f64 = (0..3).map(|a| normal[a] * (middle[a] + 0.5 * size[1] * down[a])).sum();
    assert!((height + floor["height"].as_f64().unwrap()).abs() < 1e-4, "{height} {floor}");
    let (level, ahead): (f64, f64) =
        ((0..3).map(|a| normal[a] * away[a]).sum(), (0..3).map(|a| middle[a] * away[a]).sum());
    assert!(level.abs() < 1e-5 && ahead > 0.0, "{away:?}");
}

#[test]
fn results_are_those_of_the_lines() {
    let out = folder();
    let (one, two) = (out.path().join("1.mcap"), out.path().join("2.mcap"));
    let written = pldi(arguments!["run", *recording(), "--mcap", one, "--threads", "1"]).ok();
    pldi(arguments!["run", *recording(), "--mcap", two, "--threads", "2"]).ok();
    assert!(std::fs::read(&one).unwrap() == std::fs::read(&two).unwrap(), "the number of threads changes nothing");
    assert_eq!(names(out.path()), ["1.mcap", "2.mcap"]);
    let (lines, messages) = (written.lines(), messages(&one));
    let detections = of_topic(&messages, "/pldi/detections");
    assert_eq!((lines.len(), detections.len(), messages.len()), (3, 3, 12));
    let count: usize = lines.iter().zip(&detections).map(|(line, (_, message))| compare(message, line)).sum();
    assert!(count >= 3);
    let stamps: Vec<u64> = detections.iter().map(|(time, _)| *time).collect();
    assert_eq!(stamps, [0, 200_000_000, 400_000_000]);
    for (line, (_, message)) in lines.iter().zip(of_topic(&messages, "/pldi/markers")) {
        // One that deletes those before, a box and a text for each candidate.
        let count = 1 + 2 * line["detections"].as_array().unwrap().len() as u32;
        assert_eq!(Fields::new(&message).u32(), count);
        let text = String::from_utf8_lossy(&message);
        for detection in line["detections"].as_array().unwrap() {
            assert!(text.contains(detection["results"][0]["class_id"].as_str().unwrap()));
        }
    }
}

#[test]
fn n_is_that_of_the_stages() {
    for arithmetic in ["float", "fixed"] {
        let out = folder();
        let (file, stages) = (out.path().join("out.mcap"), out.path().join("stages"));
        let more = ["--arithmetic", arithmetic];
        let mut run = command();
        run.args(arguments!["run", *recording(), "--mcap", file, "--overlay", out.path().join("o")]).args(more);
        assert!(run.stdout(Stdio::null()).status().unwrap().success());
        let mut look = command();
        look.args(arguments!["stages", *recording(), "--frame", "1", "--out", stages]).args(more);
        assert!(look.status().unwrap().success());
        let (size, n) = png::read_grey16(&stages.join("n.png")).unwrap();
        let high: Vec<u8> = n.iter().map(|n| (n >> 8) as u8).collect();
        let images = of_topic(&messages(&file), "/pldi/n");
        let image = Fields::new(&images[1].1).image();
        assert_eq!((image.0, image.1, image.2), (200_000_000, (320, 240), "mono8"));
        assert_eq!(size, (320, 240));
        assert!(image.3 == high, "{arithmetic}");
        assert!(high.iter().filter(|n| **n > 0).count() > 10_000);
    }
}

#[test]
fn a_recording_holds_the_images_and_the_camera() {
    let out = folder();
    let file = out.path().join("out.mcap");
    pldi(arguments!["record", *recording(), "--out", file]).ok();
    let messages = messages(&file);
    assert_eq!(messages.len(), 12);
    let depth = of_topic(&messages, "/camera/depth/image_raw");
    let colour = of_topic(&messages, "/camera/color/image_raw");
    for i in 0..3 {
        let (stamp, size, encoding, pixels) = Fields::new(&depth[i].1).image();
        let (_, values) = png::read_grey16(&recording().join(format!("depth/{i:04}.png"))).unwrap();
        assert_eq!((stamp, size, encoding), (i as u64 * 200_000_000, (640, 480), "16UC1"));
        assert!(pixels == values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>());
        let (_, size, encoding, pixels) = Fields::new(&colour[i].1).image();
        assert_eq!((size, encoding), ((640, 480), "rgb8"));
        let picture = image::open(recording().join(format!("rgb/{i:04}.png"))).unwrap().into_rgb8();
        assert!(picture.as_raw() == pixels);
    }
    assert_eq!(of_topic(&messages, "/camera/depth/camera_info").len(), 3);
    assert_eq!(of_topic(&messages, "/camera/color/camera_info").len(), 3);
    let again = pldi(arguments!["record", *recording(), "--out", file]);
    assert!(again.code == Some(1) && again.stderr.contains("there already"), "{}", again.stderr);
}

#[test]
fn what_was_done_before_an_error_stays() {
    let (copy, out) = (copy(), folder());
    let file = out.path().join("out.mcap");
    std::fs::write(&file, "old").unwrap();
    std::fs::remove_file(copy.path().join("depth/0000.png")).unwrap();
    assert_eq!(pldi(arguments!["run", copy.path(), "--mcap", file]).code, Some(1));
    assert_eq!(std::fs::read(&file).unwrap(), b"old", "nothing was done");
    let outcome = pldi(arguments!["run", copy.path(), "--mcap", file, "--keep-going"]);
    assert_eq!((outcome.code, of_topic(&messages(&file), "/pldi/n").len()), (Some(1), 2));
    std::fs::copy(recording().join("depth/0000.png"), copy.path().join("depth/0000.png")).unwrap();
    std::fs::remove_file(copy.path().join("depth/0001.png")).unwrap();
    assert_eq!(pldi(arguments!["run", copy.path(), "--mcap", file]).code, Some(1));
    assert_eq!(of_topic(&messages(&file), "/pldi/n").len(), 1);
    let outcome = pldi(arguments!["run", *recording(), "--mcap", out.path().join("no/such/place.mcap")]);
    assert!(outcome.code == Some(1) && outcome.stderr.contains("there is no folder"), "{}", outcome.stderr);
    assert_eq!(names(out.path()), ["out.mcap"]);
}

#[test]
fn an_interrupt_leaves_a_whole_file() {
    let (input, out) = (listed(50_000), folder());
    let (file, text) = (out.path().join("out.mcap"), out.path().join("lines.jsonl"));
    let mut child = command();
    child.args(arguments!["run", input.path(), "--mcap", file]).stderr(Stdio::null());
    let mut child = child.stdout(std::fs::File::create(&text).unwrap()).spawn().unwrap();
    while std::fs::read(&text).unwrap().is_empty() {
        assert!(child.try_wait().unwrap().is_none());
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    assert!(std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let (lines, messages) = (lines(&std::fs::read(&text).unwrap()), messages(&file));
    let detections = of_topic(&messages, "/pldi/detections");
    assert!(lines.len() == detections.len() && messages.len() == 4 * lines.len() && lines.len() < 50_000);
    assert_eq!(names(out.path()), ["lines.jsonl", "out.mcap"]);
}
