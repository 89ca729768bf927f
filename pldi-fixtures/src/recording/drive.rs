//! Where the robot drives: from stop to stop, each with one object whole in the image.

use core::f32::consts::{PI, TAU};

use super::plan::{RoomPlan, distance, distance_to_point, wrap};
use super::{FRAME_MARGIN, PlacedObject};
use crate::kinect::{CameraPose, Sensor};
use crate::rng::Rng;

/// How a recording is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// Number of frames.
    pub frames: usize,
    /// Frames per second; default 5.
    pub rate: f32,
    /// Height of the camera in metres; default 1.2.
    pub height: f32,
    /// Tilt of the camera in rad, positive looks down; default 0.30 (17 degrees).
    pub pitch: f32,
}

impl Drive {
    /// Seconds from one stop to the next; the last fifth is spent standing.
    pub const LEG: f32 = 3.0;

    /// A drive with a frame at each stop and none on the way.
    #[must_use]
    pub fn stops(frames: usize) -> Self {
        Self { frames, rate: 1.0 / Self::LEG, ..Self::default() }
    }
}

impl Default for Drive {
    fn default() -> Self {
        Self { frames: 60, rate: 5.0, height: 1.2, pitch: 0.30 }
    }
}

/// Most stops for one object.
const VIEWS: usize = 4;

/// Least and greatest horizontal distance of a stop from its object's middle, in metres.
const AWAY: [f32; 2] = [1.4, 3.7];

/// How far from the camera along the floor an object may reach, in metres: the far end of what is looked at.
const FAR: f32 = 3.83;

/// How near it may reach, in metres.
const NEAR: f32 = 0.7;

/// Least distance of an object's footprint from the sides of the view, in metres.
const CLEAR: f32 = 0.17;

/// Least distance of the camera from footprints while it moves, in metres.
const AISLE: f32 = 0.3;

/// Least distance of the camera from the walls, in metres.
const FROM_WALL: f32 = 0.3;

impl RoomPlan {
    /// The robot's path. It stops up to four times for each object, where the sensor has it whole, in front of
    /// everything else and within 3.83 m, each time from another side as far as the room allows; first once for each
    /// object, then for each again. Objects without such a place are passed over.
    pub(super) fn path(&self, sensor: &Sensor, drive: &Drive, seed: u64) -> Vec<CameraPose> {
        let mut rng = Rng::new(seed);
        let mut views: Vec<Vec<CameraPose>> =
            (0..self.objects.len()).map(|i| self.stops_for(i, sensor, drive, &mut rng)).collect();
        views.retain(|v| !v.is_empty());
        let first = rng.below(views.len().max(1));
        views.rotate_left(first);
        let mut stops: Vec<CameraPose> =
            (0..VIEWS).flat_map(|k| views.iter().filter_map(move |v| v.get(k).copied())).collect();
        if stops.is_empty() {
            stops.push(CameraPose::new(0.0, 0.0, 0.0, drive.height, drive.pitch));
        }
        (0..drive.frames)
            .map(|i| {
                let time = i as f32 / drive.rate.max(0.01) / Drive::LEG;
                // Rounding must not put a frame that belongs to a stop before it.
                let number = (time + 1e-4).floor();
                let at = |k: usize| stops[(number as usize + k) % stops.len()];
                let (a, b) = (at(0), at(1));
                let t = ((time - number).max(0.0) / 0.8).min(1.0);
                let t = t * t * (3.0 - 2.0 * t);
                let [x, y] = self.between([a.x, a.y], [b.x, b.y], t);
                CameraPose { x, y, yaw: wrap(a.yaw + t * wrap(b.yaw - a.yaw)), ..a }
            })
            .collect()
    }

    /// The point at `t` (0..=1) of the way from `a` to `b`: straight on, or over the room's middle where an object
    /// stands in the way.
    fn between(&self, a: [f32; 2], b: [f32; 2], t: f32) -> [f32; 2] {
        let on = |a: [f32; 2], b: [f32; 2], t: f32| [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
        if a == b || self.free_way(a, b) {
            return on(a, b, t);
        }
        let length = |p: [f32; 2]| (p[0] * p[0] + p[1] * p[1]).sqrt();
        let part = length(a) / (length(a) + length(b)).max(1e-6);
        if t < part { on(a, [0.0; 2], t / part) } else { on([0.0; 2], b, (t - part) / (1.0 - part).max(1e-6)) }
    }

    /// Whether the robot can drive straight from `a` to `b`.
    fn free_way(&self, a: [f32; 2], b: [f32; 2]) -> bool {
        let way = [a, b, b, a];
        self.objects.iter().all(|o| {
            let corners = o.footprint();
            distance_to_point(&corners, a).min(distance_to_point(&corners, b)) >= AISLE
                && distance(&corners, &way) >= AISLE
        })
    }

    /// Stops for object number `i`, from different directions, as far as many tries find them.
    fn stops_for(&self, i: usize, sensor: &Sensor, drive: &Drive, rng: &mut Rng) -> Vec<CameraPose> {
        let object = &self.objects[i];
        let mut stops: Vec<(f32, CameraPose)> = Vec::new();
        // From well apart directions first, then from less far apart.
        for apart in [0.7, 0.35] {
            for attempt in 0..400 {
                let bearing = rng.range(-PI, PI);
                let away = rng.range(AWAY[0], AWAY[1]);
                let (s, c) = libm::sincosf(bearing);
                let (x, y) = (object.pose.x + away * c, object.pose.y + away * s);
                // Not always in the middle of the image; the largest fit nowhere else.
                let aside = if attempt % 2 == 0 { 0.25 } else { 0.04 };
                let yaw = wrap(bearing + PI + rng.range(-aside, aside));
                let camera = CameraPose::new(x, y, yaw, drive.height, drive.pitch);
                let new = stops.iter().all(|(other, _)| wrap(bearing - other).abs() >= apart);
                if stops.len() < VIEWS && new && self.can_stand([x, y]) && self.sees(i, sensor, &camera) {
                    stops.push((bearing, camera));
                }
            }
        }
        stops.into_iter().map(|(_, camera)| camera).collect()
    }

    /// Whether the robot can stand at a place and reach it from the room's middle.
    fn can_stand(&self, p: [f32; 2]) -> bool {
        (0..2).all(|k| p[k] >= self.room.min[k] + FROM_WALL && p[k] <= self.room.max[k] - FROM_WALL)
            && self.free_way(p, [0.0; 2])
    }

    /// Whether a camera has object number `i` whole in its image, near enough, and nothing in front of it.
    fn sees(&self, i: usize, sensor: &Sensor, camera: &CameraPose) -> bool {
        let object = &self.objects[i];
        let far = ahead(&object.footprint(), camera).1;
        if !within_view(object, sensor, camera) || !whole(object, sensor, camera) {
            return false;
        }
        let (middle, half) = bearings(object, camera);
        self.objects.iter().enumerate().all(|(k, other)| {
            let (bearing, width) = bearings(other, camera);
            k == i || ahead(&other.footprint(), camera).0 > far || wrap(bearing - middle).abs() > half + width + 0.03
        })
    }
}

/// How far a footprint lies from the camera along its heading: least and greatest distance in metres.
fn ahead(footprint: &[[f32; 2]; 4], camera: &CameraPose) -> (f32, f32) {
    let forward = footprint.map(|p| on_floor(p, camera)[1]);
    forward.into_iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), d| (low.min(d), high.max(d)))
}

/// A point of the floor as the camera sees it: to the right and forward in metres.
fn on_floor(p: [f32; 2], camera: &CameraPose) -> [f32; 2] {
    let (s, c) = libm::sincosf(camera.yaw);
    let (x, y) = (p[0] - camera.x, p[1] - camera.y);
    [x * s - y * c, x * c + y * s]
}

/// Whether the object's footprint lies near enough, and well between the upright planes through the outermost rays of
/// the image's middle row (below that row the image shows more).
fn within_view(object: &PlacedObject, sensor: &Sensor, camera: &CameraPose) -> bool {
    let k = &sensor.intrinsics;
    let slope = k.cx.min(f32::from(k.width) - 1.0 - k.cx) / k.fx / libm::cosf(camera.pitch);
    object.footprint().iter().all(|&p| {
        let [right, forward] = on_floor(p, camera);
        (NEAR..=FAR).contains(&forward) && right.abs() + CLEAR <= slope * (forward - CLEAR)
    })
}

/// Whether the object's bounding box lies within the image, a few pixels from its borders.
fn whole(object: &PlacedObject, sensor: &Sensor, camera: &CameraPose) -> bool {
    let k = &sensor.intrinsics;
    let margin = FRAME_MARGIN * f32::from(k.width);
    let top = object.bounds().max[2];
    object.footprint().iter().all(|corner| {
        [0.0, top].into_iter().all(|z| {
            let seen = k.project(camera.to_camera([corner[0], corner[1], z]));
            seen.is_some_and(|[u, v]| {
                let (right, bottom) = (f32::from(k.width) - 1.0 - margin, f32::from(k.height) - 1.0 - margin);
                (margin..=right).contains(&u) && (margin..=bottom).contains(&v)
            })
        })
    })
}

/// The bearing of an object's middle from the camera and half the angle that its footprint takes up, in rad.
fn bearings(object: &PlacedObject, camera: &CameraPose) -> (f32, f32) {
    let to = |p: [f32; 2]| libm::atan2f(p[1] - camera.y, p[0] - camera.x);
    let middle = to([object.pose.x, object.pose.y]);
    let half = object.footprint().iter().map(|&p| wrap(to(p) - middle).abs()).fold(0.0, f32::max);
    (middle, half.min(TAU))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::furniture::{Class, HELD_OUT_SEEDS};

    #[test]
    fn every_class_is_seen_whole_from_several_sides() {
        let sensor = Sensor::kinect_v1();
        for class in Class::ALL {
            let (mut objects, mut seen, mut views) = (0, 0, 0);
            for seed in 0..12 {
                // The class in question among others.
                let others = Class::ALL.iter().enumerate().filter(|(i, c)| (i + seed) % 3 == 0 && **c != class);
                let mut list: Vec<(Class, u64)> =
                    others.map(|(i, &c)| (c, HELD_OUT_SEEDS + (12 * seed + i) as u64)).collect();
                list.push((class, HELD_OUT_SEEDS + seed as u64));
                let plan = RoomPlan::furnish(seed as u64, &list);
                let Some(i) = plan.objects.iter().position(|o| o.class == class) else { continue };
                let stops = plan.stops_for(i, &sensor, &Drive::default(), &mut Rng::new(seed as u64));
                objects += 1;
                seen += usize::from(!stops.is_empty());
                views += stops.len();
            }
            assert!(objects >= 10 && seen >= 7 && views >= 20, "{}: {objects}, {seen}, {views}", class.name());
        }
    }
}
