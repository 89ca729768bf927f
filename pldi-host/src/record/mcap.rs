//! Recordings as MCAP files, as a ROS 2 camera driver would publish them.

use std::path::Path;

use super::{Recorder, Taken};
use crate::Error;
use crate::input::Images;
use crate::output::mcap::{Encoding, FRAME, Header, McapFile, Topic, camera_info, image};

const COLOUR: Topic = Topic { name: "/camera/color/image_raw", message: "sensor_msgs/Image" };
const COLOUR_CAMERA: Topic = Topic { name: "/camera/color/camera_info", message: "sensor_msgs/CameraInfo" };
const DEPTH: Topic = Topic { name: "/camera/depth/image_raw", message: "sensor_msgs/Image" };
const DEPTH_CAMERA: Topic = Topic { name: "/camera/depth/camera_info", message: "sensor_msgs/CameraInfo" };

/// Writes the images as they are, uncompressed but for the file's own chunks, which any viewer and tool reads.
pub(super) struct McapRecorder(McapFile);

impl McapRecorder {
    pub(super) fn create(path: &Path) -> Result<Self, Error> {
        McapFile::create(path).map(Self)
    }
}

impl Recorder for McapRecorder {
    fn frame(&mut self, frame: &Taken) -> Result<(), Error> {
        let Taken { stamp, colour_stamp, frame_id, camera, images } = frame;
        let Images { size, depth, scale, colour } = images;
        // Colour is registered to depth: one camera took both.
        let camera_frame = frame_id.as_deref().unwrap_or(FRAME);
        // Both at first: a frame is written whole or not at all.
        let depth_header = Header::new(*stamp, camera_frame)?;
        let colour_header = Header::new(*colour_stamp, camera_frame)?;
        let file = &mut self.0;
        if let Some(colour) = colour {
            file.message(COLOUR, *colour_stamp, &image(&colour_header, *size, Encoding::Rgb8, colour))?;
        }
        let mm: Vec<u8> = depth.iter().flat_map(|&raw| scale.millimetres(raw).to_le_bytes()).collect();
        file.message(DEPTH, *stamp, &image(&depth_header, *size, Encoding::Depth16, &mm))?;
        let Some(camera) = camera else { return Ok(()) };
        if colour.is_some() {
            file.message(COLOUR_CAMERA, *colour_stamp, &camera_info(&colour_header, camera))?;
        }
        file.message(DEPTH_CAMERA, *stamp, &camera_info(&depth_header, camera))
    }

    fn finish(self: Box<Self>) -> Result<(), Error> {
        // Without a frame there is nothing that could be read.
        if self.0.is_empty() { Ok(()) } else { self.0.finish() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::{DepthScale, Stamp};
    use pldi_core::Intrinsics;

    fn taken(i: i64, colour: bool, scale: DepthScale) -> Taken {
        let camera = Some(Intrinsics { width: 3, height: 2, fx: 262.5, fy: 262.75, cx: 1.0, cy: 0.5 });
        let depth = vec![0, 1000, 12_000, 65_535, 5, 8];
        let images = Images { size: (3, 2), depth, scale, colour: colour.then(|| (0..18).collect()) };
        let ns = 1_700_000_000_123_456_789 + i * 33_333_333;
        Taken { stamp: Stamp(ns), colour_stamp: Stamp(ns - 4_000_001), frame_id: None, camera, images }
    }

    /// Topic, log time and bytes of each message.
    fn messages(path: &Path) -> Vec<(String, u64, Vec<u8>)> {
        let bytes = std::fs::read(path).unwrap();
        let messages = mcap::MessageStream::new(&bytes).unwrap();
        messages.map(|m| m.unwrap()).map(|m| (m.channel.topic.clone(), m.log_time, m.data.into_owned())).collect()
    }

    #[test]
    fn frames_are_written_as_drivers_publish_them() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("out.mcap");
        let mut recorder = Box::new(McapRecorder::create(&path).unwrap());
        recorder.frame(&taken(0, true, DepthScale::Millimetres)).unwrap();
        let named = Taken { frame_id: Some("lens".to_owned()), ..taken(1, false, DepthScale::Tum) };
        recorder.frame(&named).unwrap();
        assert!(!path.exists());
        recorder.finish().unwrap();
        let messages = messages(&path);
        let topics: Vec<&str> = messages.iter().map(|(topic, ..)| topic.as_str()).collect();
        let first = [COLOUR, DEPTH, COLOUR_CAMERA, DEPTH_CAMERA, DEPTH, DEPTH_CAMERA].map(|topic| topic.name);
        assert_eq!(topics, first);
        assert_eq!((messages[0].1, messages[1].1), (1_700_000_000_119_456_788, 1_700_000_000_123_456_789));
        let names = messages.iter().map(|(.., bytes)| bytes[16..].split(|b| *b == 0).next().unwrap().to_vec());
        let expected = [[FRAME; 4].as_slice(), &["lens"; 2]].concat();
        assert_eq!(names.collect::<Vec<_>>(), expected.iter().map(|name| name.as_bytes()).collect::<Vec<_>>());
        let tail = |i: usize, n: usize| messages[i].2[messages[i].2.len() - n..].to_vec();
        assert_eq!(tail(0, 18), (0..18).collect::<Vec<u8>>());
        // Far readings stay, and so do those that are none.
        assert_eq!(tail(1, 12), [0, 1000, 12_000, 65_535, 5, 8u16].map(u16::to_le_bytes).concat());
        assert_eq!(tail(4, 12), [0, 200, 2400, 13_107, 1, 2u16].map(u16::to_le_bytes).concat());
    }

    #[test]
    fn what_is_dropped_stays_and_nothing_is_nothing() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("out.mcap");
        Box::new(McapRecorder::create(&path).unwrap()).finish().unwrap();
        drop(McapRecorder::create(&path).unwrap());
        assert_eq!(std::fs::read_dir(place.path()).unwrap().count(), 0);
        let mut recorder = McapRecorder::create(&path).unwrap();
        let late = Taken { stamp: Stamp(5_000_000_000_000_000_000), ..taken(0, true, DepthScale::Millimetres) };
        assert!(recorder.frame(&late).unwrap_err().to_string().contains("2038"));
        recorder.frame(&taken(0, true, DepthScale::Millimetres)).unwrap();
        drop(recorder);
        assert_eq!(messages(&path).len(), 4);
        assert_eq!(std::fs::read_dir(place.path()).unwrap().count(), 1);
    }
}
