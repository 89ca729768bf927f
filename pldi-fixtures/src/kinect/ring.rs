//! Views of one object from a ring around it: how templates are made.

use std::sync::Arc;

use super::camera::CameraPose;
use super::scene::{Room, Scene};
use super::sensor::{Capture, Sensor};
use crate::mesh::{Material, Mesh};
use crate::rng::derive;

/// How a ring's cameras are tilted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pitch {
    /// By this angle in rad, positive looks down.
    Fixed(f32),
    /// Towards this height in metres above the object's foot.
    At(f32),
    /// Towards half the object's height.
    HalfHeight,
}

/// Cameras on a ring around an object at the origin: the first on the +x axis, then counter-clockwise in equal steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewRing {
    /// Number of views.
    pub views: usize,
    /// Horizontal distance from the object's centre in metres.
    pub distance: f32,
    /// Height of the camera above the floor in metres.
    pub height: f32,
    /// Tilt of the camera.
    pub pitch: Pitch,
    /// Look of a floor under the object; `None` leaves the object floating in nothing.
    pub floor: Option<Material>,
}

impl Default for ViewRing {
    /// 20 views from 2 m away and 1.2 m high, looking at half the object's height, no floor.
    fn default() -> Self {
        Self { views: 20, distance: 2.0, height: 1.2, pitch: Pitch::HalfHeight, floor: None }
    }
}

impl ViewRing {
    /// The pose of view number `i`, for an object of this height in metres.
    #[must_use]
    pub fn camera(&self, i: usize, object_height: f32) -> CameraPose {
        let angle = i as f32 * core::f32::consts::TAU / self.views.max(1) as f32;
        let (s, c) = libm::sincosf(angle);
        let pitch = match self.pitch {
            Pitch::Fixed(pitch) => pitch,
            Pitch::At(z) => libm::atan2f(self.height - z, self.distance),
            Pitch::HalfHeight => libm::atan2f(self.height - 0.5 * object_height, self.distance),
        };
        let (x, y) = (self.distance * c, self.distance * s);
        CameraPose::new(x, y, angle + core::f32::consts::PI, self.height, pitch)
    }

    /// The views of a mesh (standing on z = 0, centred on x = y = 0), taken one by one as the iterator is asked.
    #[must_use]
    pub fn captures(self, mesh: Arc<Mesh>, sensor: Sensor, seed: u64) -> Views {
        let object_height = mesh.bounds().map_or(0.0, |b| b.max[2]);
        let mut scene = Scene::of(mesh);
        scene.room = self.floor.map(|floor| Room::floor_only(20.0, floor));
        Views { ring: self, scene, sensor, object_height, seed, next: 0 }
    }
}

/// The views of one object: an iterator of poses and captures.
#[derive(Debug, Clone)]
pub struct Views {
    ring: ViewRing,
    scene: Scene,
    sensor: Sensor,
    object_height: f32,
    seed: u64,
    next: usize,
}

impl Iterator for Views {
    type Item = (CameraPose, Capture);

    fn next(&mut self) -> Option<Self::Item> {
        if self.next >= self.ring.views {
            return None;
        }
        let camera = self.ring.camera(self.next, self.object_height);
        let capture = self.sensor.capture(&self.scene, &camera, derive(self.seed, self.next as u64));
        self.next += 1;
        Some((camera, capture))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = self.ring.views - self.next;
        (left, Some(left))
    }
}

impl ExactSizeIterator for Views {}
