//! What was recognised, frame by frame.

use std::path::Path;

use super::messages::{Detection, Encoding, Header, Marker, Pose, Shape, camera_info, detections, image, markers};
use super::{FRAME, McapFile, Topic, boxes};
use crate::Error;
use crate::input::Stamp;
use crate::overlay;
use crate::report::DetectionReport;
use crate::runner::Processed;

const DETECTIONS: Topic = Topic { name: "/pldi/detections", message: "vision_msgs/Detection3DArray" };
const MARKERS: Topic = Topic { name: "/pldi/markers", message: "visualization_msgs/MarkerArray" };
const CAMERA: Topic = Topic { name: "/pldi/camera_info", message: "sensor_msgs/CameraInfo" };
const N: Topic = Topic { name: "/pldi/n", message: "sensor_msgs/Image" };

/// How opaque boxes are.
const OPACITY: f32 = 0.35;
/// Height of letters in metres, and of their middle above the box.
const LETTERS: f32 = 0.12;

/// A frame's messages, ready to be written.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameMessages {
    stamp: Stamp,
    messages: [(Topic, Vec<u8>); 4],
}

impl FrameMessages {
    /// What is told about a frame: all candidates with their boxes, as detections and as markers, and N of the whole
    /// image with its camera. Computes that N, in place of the candidates'.
    ///
    /// # Errors
    /// `Content` where ROS cannot tell the frame's time.
    pub fn new(seen: &mut Processed<'_>) -> Result<Self, Error> {
        let stamp = seen.frame.stamp;
        let header = Header::new(stamp, seen.frame.frame_id.as_deref().unwrap_or(FRAME))?;
        let boxes: Vec<(&DetectionReport, Pose)> =
            seen.report.detections.iter().filter_map(|d| Some((d, pose(seen, d)?))).collect();
        let candidates: Vec<Detection<'_>> = boxes
            .iter()
            .map(|(d, pose)| {
                let results = d.results.iter().map(|h| (h.class_id.as_str(), h.score)).collect();
                Detection { results, pose: *pose, size: d.size }
            })
            .collect();
        let detections = detections(&header, &candidates);
        let up = seen.workspace.report.floor.map_or([0.0, -1.0, 0.0], |floor| floor.normal);
        let pairs: Vec<Marker> = boxes.iter().flat_map(|(d, pose)| marked(seen, d, *pose, up)).collect();
        let markers = markers(&header, &pairs);
        let camera = seen.frame.qvga.intrinsics;
        let info = camera_info(&header, &camera);
        // Viewers show 8 bits as they are, black to white; of 16 bits they would show those of a depth image.
        let n: Vec<u8> = seen.whole_n().iter().map(|n| (n >> 8) as u8).collect();
        let n = image(&header, (camera.width, camera.height), Encoding::Mono8, &n);
        Ok(Self { stamp, messages: [(DETECTIONS, detections), (MARKERS, markers), (CAMERA, info), (N, n)] })
    }
}

/// Where a candidate's box is.
fn pose(seen: &Processed<'_>, detection: &DetectionReport) -> Option<Pose> {
    let report = &seen.workspace.report;
    let cluster = report.clusters.get(detection.id.checked_sub(1)?)?;
    Some(boxes::pose(report.floor.as_ref()?, cluster.centroid, detection.center))
}

/// A candidate's box, and above it what it is.
fn marked(seen: &Processed<'_>, detection: &DetectionReport, pose: Pose, up: [f32; 3]) -> Vec<Marker> {
    let [r, g, b] = overlay::candidate_colour(seen.report, detection).map(|part| f32::from(part) / 255.0);
    let id = detection.id;
    let cube = Marker { id, shape: Shape::Cube(detection.size), pose, colour: [r, g, b, OPACITY] };
    let Some(best) = detection.results.first() else { return vec![cube] };
    let above = 0.5 * detection.size[1] + LETTERS;
    let position = std::array::from_fn(|i| pose.position[i] + above * up[i]);
    let shape = Shape::Text(format!("{} {:.2}", best.class_id, best.score), LETTERS);
    vec![cube, Marker { id, shape, pose: Pose { position, ..pose }, colour: [r, g, b, 1.0] }]
}

/// An MCAP file of results. It appears under its name, in place of a file that was there, when it [ends](Self::end);
/// also when it is dropped with frames in it, so that nothing done is lost.
#[derive(Debug)]
pub struct Results(McapFile);

impl Results {
    /// Begins a file.
    ///
    /// # Errors
    /// `Write`.
    pub fn create(path: &Path) -> Result<Self, Error> {
        McapFile::create(path).map(Self)
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// `Write`.
    pub fn add(&mut self, frame: &FrameMessages) -> Result<(), Error> {
        frame.messages.iter().try_for_each(|(topic, bytes)| self.0.message(*topic, frame.stamp, bytes))
    }

    /// Ends the file. One without frames appears only where the work was `done`.
    ///
    /// # Errors
    /// `Write`.
    pub fn end(self, done: bool) -> Result<(), Error> {
        if done || !self.0.is_empty() { self.0.finish() } else { Ok(()) }
    }
}
