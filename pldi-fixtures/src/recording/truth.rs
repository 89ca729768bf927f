//! What is true about the objects of a frame.

use serde::{Deserialize, Serialize};

use super::plan::{RoomPlan, wrap};
use crate::kinect::{CameraPose, Capture, Scene, Sensor};

/// The share of an object's pixels within the image that others may hide before it counts as occluded.
pub const HIDDEN_SHARE: f32 = 0.03;

/// The truth about one object in one frame. All of it is geometry: noise and missing readings do not enter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObjectTruth {
    /// Name of the class.
    pub class: String,
    /// Seed of the object.
    pub object: u64,
    /// Its number in the scene; its pixels are labelled `instance + 1`.
    pub instance: usize,
    /// Middle of its bounding box in the camera's frame, in metres.
    pub centre: [f32; 3],
    /// Its extent along its own x, y and z axes, in metres.
    pub size: [f32; 3],
    /// Its turn against the camera's heading in rad, -pi to pi, counter-clockwise from above; pi faces the camera.
    pub yaw: f32,
    /// Horizontal distance from the camera to its middle in metres.
    pub distance: f32,
    /// Pixels that show it.
    pub visible: usize,
    /// Pixels that would show it if it stood alone.
    pub alone: usize,
    /// Pixels that would show it if it stood alone and the image had no borders.
    pub unclipped: usize,
    /// More than [`HIDDEN_SHARE`] of its pixels within the image are hidden by other objects.
    pub occluded: bool,
    /// It touches the left, right or bottom border of the image, or a part of it lies outside.
    pub cut_by_frame: bool,
    /// First and last column and row that show it: u0, v0, u1, v1, all inclusive.
    pub bbox: [usize; 4],
}

/// The truth about each object with a visible pixel.
pub(super) fn truths(
    plan: &RoomPlan,
    scene: &Scene,
    sensor: &Sensor,
    camera: &CameraPose,
    capture: &Capture,
) -> Vec<ObjectTruth> {
    let (width, height) = (capture.width, capture.height);
    let mut boxes = vec![([usize::MAX, usize::MAX, 0, 0], 0usize); plan.objects.len()];
    for (pixel, &label) in capture.labels.iter().enumerate() {
        if let Some((bbox, count)) = usize::from(label).checked_sub(1).and_then(|i| boxes.get_mut(i)) {
            let (u, v) = (pixel % width, pixel / width);
            *bbox = [bbox[0].min(u), bbox[1].min(v), bbox[2].max(u), bbox[3].max(v)];
            *count += 1;
        }
    }
    let mut truths = Vec::new();
    for (instance, (object, (bbox, visible))) in plan.objects.iter().zip(boxes).enumerate() {
        if visible == 0 {
            continue;
        }
        let [alone, unclipped] = sensor.pixels_alone(&scene.instances[instance], camera);
        let bounds = object.bounds();
        let centre = object.pose.transform().apply(bounds.centre());
        let (dx, dy) = (centre[0] - camera.x, centre[1] - camera.y);
        let touches = bbox[0] == 0 || bbox[2] + 1 == width || bbox[3] + 1 == height;
        truths.push(ObjectTruth {
            class: object.class.name().to_owned(),
            object: object.object,
            instance,
            centre: camera.to_camera(centre),
            size: bounds.size(),
            yaw: wrap(object.pose.yaw - camera.yaw),
            distance: (dx * dx + dy * dy).sqrt(),
            visible,
            alone,
            unclipped,
            occluded: ((alone - visible.min(alone)) as f32) > HIDDEN_SHARE * alone as f32,
            cut_by_frame: touches || unclipped > alone,
            bbox,
        });
    }
    truths
}
