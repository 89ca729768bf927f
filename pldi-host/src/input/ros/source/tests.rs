use std::sync::Arc;

use super::super::messages::tests::{Writer, image, info};
use super::super::{Image, messages::Header};
use super::*;

const DEPTH: &str = "/camera/depth/image_raw";
const COLOUR: &str = "/camera/rgb/image_raw";
const INFO: &str = "/camera/depth/camera_info";

/// Messages in memory; one byte of "file" each.
struct Memory {
    messages: Vec<Message>,
    at: usize,
    indexed: bool,
}

impl Log for Memory {
    fn path(&self) -> &Path {
        Path::new("x.mcap")
    }

    fn next(&mut self, until: u64, wanted: &dyn Fn(&Channel) -> bool) -> Result<Step, Error> {
        while let Some(message) = self.messages.get(self.at) {
            if self.at as u64 > until {
                return Ok(Step::Nothing);
            }
            self.at += 1;
            if wanted(&message.channel) {
                return Ok(Step::Message(message.clone()));
            }
        }
        Ok(Step::End)
    }

    fn position(&self) -> u64 {
        self.at as u64
    }

    fn rewind(&mut self) {
        self.at = 0;
    }

    fn index(&mut self) -> Option<Vec<(Channel, u64)>> {
        self.indexed.then(|| self.messages.iter().map(|m| (Channel::clone(&m.channel), 1)).collect())
    }

    fn seen(&self) -> Vec<(Channel, u64)> {
        self.messages[..self.at].iter().map(|m| (Channel::clone(&m.channel), 1)).collect()
    }
}

fn message(topic: &str, kind: &str, data: Vec<u8>) -> Message {
    let type_name = format!("sensor_msgs/msg/{kind}");
    let channel = Channel { topic: topic.into(), type_name, encoding: "cdr".into() };
    Message { channel: Arc::new(channel), time: 99, data }
}

/// Milliseconds in nanoseconds.
const MS: i64 = 1_000_000;

fn picture(topic: &str, stamp: i64, encoding: &str, width: u32) -> Message {
    let bytes = if encoding == "16UC1" { 2 } else { 3 };
    let (step, data) = (width * bytes, vec![7; (width * bytes) as usize]);
    let header = Header { stamp, frame_id: "camera" };
    let image = Image { header, encoding, width, height: 1, step, data: &data, ..image() };
    message(topic, "Image", Writer::new(true).image(&image))
}

fn depth(ms: i64) -> Message {
    picture(DEPTH, ms * MS, "16UC1", 4)
}

fn colour(ms: i64) -> Message {
    picture(COLOUR, ms * MS, "rgb8", 4)
}

fn calibration(fx: f64) -> Message {
    let mut info = info();
    info.k[0] = fx;
    message(INFO, "CameraInfo", Writer::new(true).info(&info))
}

fn opened(messages: Vec<Message>, indexed: bool, options: &OpenOptions) -> Result<Box<dyn Source>, Error> {
    open(Box::new(Memory { messages, at: 0, indexed }), options)
}

fn frames(messages: Vec<Message>) -> Result<Vec<RawFrame>, Error> {
    let mut source = opened(messages, false, &OpenOptions::default())?;
    std::iter::from_fn(|| source.next(&Stop::default()).transpose()).collect()
}

#[test]
fn pairs_become_frames_with_the_camera() {
    let messages =
        vec![colour(1000), depth(1005), calibration(500.0), depth(1038), colour(1033), depth(1071), colour(1066)];
    for indexed in [false, true] {
        let mut source = opened(messages.clone(), indexed, &OpenOptions::default()).unwrap();
        assert_eq!(source.frames(), indexed.then_some(3));
        let mut found = Vec::new();
        while let Some(frame) = source.next(&Stop::default()).unwrap() {
            let (intrinsics, origin) = frame.camera.clone().unwrap();
            assert_eq!((intrinsics.fx, origin.to_string()), (500.0, format!("x.mcap: {INFO}")));
            found.push((frame.stamp.0 / MS, frame.colour_stamp.unwrap().0 / MS, frame.name.clone()));
            let images = (frame.images)().unwrap();
            assert_eq!((images.size, images.depth, images.colour), ((4, 1), vec![0x0707; 4], Some(vec![7; 12])));
        }
        let name = |ms: &str| format!("{DEPTH} at {ms}000000");
        let expected = [(1005, 1000, name("1.005")), (1038, 1033, name("1.038")), (1071, 1066, name("1.071"))];
        assert_eq!(found, expected);
        assert_eq!(source.frames(), indexed.then_some(0));
    }
}

#[test]
fn a_calibration_that_changes_is_followed() {
    let fx: Vec<f32> =
        frames(vec![calibration(500.0), depth(1), calibration(500.0), depth(2), calibration(600.0), depth(3)])
            .unwrap()
            .into_iter()
            .map(|f| f.camera.unwrap().0.fx)
            .collect();
    assert_eq!(fx, [500.0, 500.0, 600.0]);
    // What the user gives goes first: a broken calibration is not even looked at.
    let messages = vec![calibration(0.0), depth(1)];
    assert!(frames(messages.clone()).unwrap_err().to_string().contains("fx = 0"));
    let options = OpenOptions { intrinsics: Some("1,1,1,1".parse().unwrap()), ..OpenOptions::default() };
    let mut source = opened(messages, false, &options).unwrap();
    assert!(source.next(&Stop::default()).unwrap().unwrap().camera.is_none());
}

#[test]
fn without_colour_there_is_depth() {
    let found = frames(vec![depth(1), depth(2)]).unwrap();
    assert_eq!(found.len(), 2);
    assert!(found.into_iter().all(|f| f.colour_stamp.is_none() && (f.images)().unwrap().colour.is_none()));
}

#[test]
fn one_broken_message_is_one_broken_frame() {
    let mut broken = depth(2);
    broken.data.pop();
    let found = frames(vec![depth(1), broken, depth(3)]).unwrap();
    let results: Vec<_> = found.into_iter().map(|f| (f.images)()).collect();
    let error = results[1].as_ref().unwrap_err().to_string();
    assert!(
        results[0].is_ok() && results[2].is_ok() && error.contains("x.mcap: /camera/depth/image_raw at 0.002"),
        "{error}"
    );
    assert!(error.contains("cut"), "{error}");
    // Not even a stamp.
    let mut broken = depth(2);
    broken.data.truncate(6);
    assert_eq!(frames(vec![depth(0), broken, depth(3)]).unwrap().len(), 3);
}

#[test]
fn sizes_that_differ_are_refused_with_a_hint() {
    let frames = frames(vec![depth(1), picture(COLOUR, MS, "rgb8", 8)]).unwrap();
    let error = (frames.into_iter().next().unwrap().images)().unwrap_err().to_string();
    for part in ["image_raw at 0.001000000: 4x1, but", "is 8x1", "--depth"] {
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn no_frame_at_all_is_an_error() {
    let apart = frames(vec![depth(1000), colour(1500), depth(1100), colour(1600)]).unwrap_err().to_string();
    assert!(apart.contains("2 depth images have no image of /camera/rgb/image_raw within 0.02 s"), "{apart}");
    assert!(frames(vec![]).unwrap_err().to_string().contains("no depth topic"));
    let some = frames(vec![depth(1000), colour(1000), depth(1500), colour(1600)]).unwrap();
    assert_eq!(some.len(), 1);
}

#[test]
fn headers_without_stamps_get_the_time_of_recording() {
    let mut late = depth(0);
    late.time = 5;
    let stamps: Vec<i64> = frames(vec![depth(0), late]).unwrap().iter().map(|f| f.stamp.0).collect();
    assert_eq!(stamps, [99, 5]);
}

#[test]
fn a_raised_stop_ends_the_reading() {
    let mut source = opened(vec![depth(1)], false, &OpenOptions::default()).unwrap();
    let stop = Stop::default();
    stop.raise();
    assert!(source.next(&stop).unwrap().is_none());
    assert!(source.next(&Stop::default()).unwrap().is_some());
}
