//! Recordings of a robot that drives through a room, frame by frame, with the truth about every object in view.

mod drive;
mod plan;
mod truth;
mod tum;

use std::sync::Arc;

pub use drive::Drive;
pub use plan::{PlacedObject, RoomPlan};
pub use truth::{HIDDEN_SHARE, ObjectTruth};
pub use tum::{TumFrame, TumWriter, write_tum};

use crate::kinect::{CameraPose, Capture, Instance, Scene, Sensor};
use crate::rng::derive;

/// A recording: what stands where, where the robot drives, which sensor it carries. Frames are made when asked for, so
/// its memory does not grow with its length.
#[derive(Debug, Clone)]
pub struct Recording {
    /// The room and its objects.
    pub plan: RoomPlan,
    /// The camera's pose at each frame.
    pub path: Vec<CameraPose>,
    /// The camera.
    pub sensor: Sensor,
    /// Frames per second.
    pub rate: f32,
    /// Seed of the sensor's noise.
    pub seed: u64,
    scene: Scene,
}

/// One frame of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedFrame {
    /// Time since the first frame in seconds.
    pub stamp: f64,
    /// Where the camera was.
    pub camera: CameraPose,
    /// What it took.
    pub capture: Capture,
    /// The objects of which at least one pixel is visible, in the order of their labels.
    pub truth: Vec<ObjectTruth>,
}

/// Least distance of whole objects from the image's borders, as a share of its width.
const FRAME_MARGIN: f32 = 0.015;

impl Recording {
    /// A drive through the room of a plan, past every object in turn. `seed` moves the path and the noise.
    #[must_use]
    pub fn new(plan: RoomPlan, sensor: Sensor, drive: Drive, seed: u64) -> Self {
        let path = plan.path(&sensor, &drive, derive(seed, 1));
        Self::along(plan, path, sensor, drive.rate, derive(seed, 2))
    }

    /// A drive along a path of one's own.
    #[must_use]
    pub fn along(plan: RoomPlan, path: Vec<CameraPose>, sensor: Sensor, rate: f32, seed: u64) -> Self {
        let instances = plan.objects.iter().map(|o| Instance { mesh: Arc::clone(&o.mesh), pose: o.pose }).collect();
        let scene = Scene { instances, room: Some(plan.room), light: plan.light };
        Self { plan, path, sensor, rate, seed, scene }
    }

    /// The recording that the project shows itself with: 12 frames at 640x480 of an armchair, a stool, a chair, a bin, a
    /// swivel chair, a box and a plant that stand free in a room, all from held-out seeds.
    #[must_use]
    pub fn demo() -> Self {
        let plan = RoomPlan::demo();
        let frames = 12;
        let path = (0..frames)
            .map(|i| {
                let t = i as f32 / (frames - 1) as f32;
                // Slowly forward and a little to the side while the head turns from left to right.
                let [x, y] = plan::DEMO_ROBOT;
                CameraPose::new(x - 0.1 + 0.2 * t, y + 0.05 - 0.1 * t, 0.26 - 0.52 * t, 1.2, 0.30)
            })
            .collect();
        Self::along(plan, path, Sensor::kinect_v1(), 5.0, 20)
    }

    /// The scene as the camera sees it; instance i is object i of the plan.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Number of frames.
    #[must_use]
    pub fn len(&self) -> usize {
        self.path.len()
    }

    /// Whether there are no frames.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.path.is_empty()
    }

    /// Frame number `i`; `None` past the end. Frames may be asked for in any order.
    #[must_use]
    pub fn frame(&self, i: usize) -> Option<RecordedFrame> {
        let camera = *self.path.get(i)?;
        let capture = self.sensor.capture(&self.scene, &camera, derive(self.seed, i as u64));
        let truth = truth::truths(&self.plan, &self.scene, &self.sensor, &camera, &capture);
        Some(RecordedFrame { stamp: i as f64 / f64::from(self.rate), camera, capture, truth })
    }

    /// All frames in turn, each made when it is asked for.
    pub fn frames(&self) -> impl Iterator<Item = RecordedFrame> {
        (0..self.len()).filter_map(|i| self.frame(i))
    }
}

#[cfg(test)]
mod tests;
