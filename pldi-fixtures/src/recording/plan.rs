//! Rooms with objects along the walls and a free space in the middle for the robot.

use core::f32::consts::{PI, TAU};
use std::sync::Arc;

use crate::furniture::{Class, HELD_OUT_SEEDS, furniture};
use crate::kinect::{Light, Pose, Room, Sun};
use crate::mesh::{Bounds, Material, Mesh, Texture};
use crate::rng::{Rng, derive};

/// Least distance between two objects' footprints, in metres.
const APART: f32 = 0.35;

/// Least distance of an object's footprint from a wall, in metres.
const FROM_WALL: f32 = 0.4;

/// Radius of the space in the middle that stays free for the robot, in metres.
const FREE: f32 = 0.9;

/// The middle of the robot's way in the demo.
pub(super) const DEMO_ROBOT: [f32; 2] = [-1.0, 0.0];

/// One object of a room.
#[derive(Debug, Clone)]
pub struct PlacedObject {
    /// What it is.
    pub class: Class,
    /// The seed it was made from.
    pub object: u64,
    /// Its shape.
    pub mesh: Arc<Mesh>,
    /// Where it stands.
    pub pose: Pose,
}

impl PlacedObject {
    /// The object of a class and seed at a place.
    #[must_use]
    pub fn new(class: Class, object: u64, pose: Pose) -> Self {
        Self { class, object, mesh: Arc::new(furniture(class, object)), pose }
    }

    /// The bounding box in the object's own frame, in metres.
    pub(super) fn bounds(&self) -> Bounds {
        self.mesh.bounds().unwrap_or(Bounds { min: [0.0; 3], max: [0.0; 3] })
    }

    /// The corners of the bounding box's footprint in the world, in turn, in metres.
    pub(super) fn footprint(&self) -> [[f32; 2]; 4] {
        let (b, place) = (self.bounds(), self.pose.transform());
        [(b.min[0], b.min[1]), (b.max[0], b.min[1]), (b.max[0], b.max[1]), (b.min[0], b.max[1])].map(|(x, y)| {
            let p = place.apply([x, y, 0.0]);
            [p[0], p[1]]
        })
    }
}

/// What stands in a room: the plan of a recording. The room's middle is the world's origin.
#[derive(Debug, Clone)]
pub struct RoomPlan {
    /// Floor and walls.
    pub room: Room,
    /// The light.
    pub light: Light,
    /// The objects.
    pub objects: Vec<PlacedObject>,
}

impl RoomPlan {
    /// A room of 3 to 6 objects of `classes` with object seeds from `seeds`, without overlaps, as [`RoomPlan::furnish`]
    /// places them.
    ///
    /// For held-out objects pass `HELD_OUT_SEEDS..HELD_OUT_SEEDS + n`.
    #[must_use]
    pub fn generate(seed: u64, classes: &[Class], seeds: core::ops::Range<u64>) -> Self {
        let mut rng = Rng::new(derive(seed, 12));
        let count = seeds.end.saturating_sub(seeds.start) as usize;
        let wanted = if classes.is_empty() || count == 0 { 0 } else { 3 + rng.below(4) };
        let objects: Vec<(Class, u64)> =
            (0..wanted).map(|_| (rng.pick(classes), seeds.start + rng.below(count) as u64)).collect();
        Self::furnish(seed, &objects)
    }

    /// A room with these objects (class and seed), of which those are left out for which there is no place: footprints
    /// at least 0.35 m from each other and 0.4 m from the walls, fronts more or less towards the middle, which stays
    /// free.
    #[must_use]
    pub fn furnish(seed: u64, objects: &[(Class, u64)]) -> Self {
        let mut rng = Rng::new(derive(seed, 11));
        let half = [rng.range(3.1, 4.0), rng.range(3.0, 3.7)];
        let mut plan = Self { room: room(&mut rng, half), light: light(&mut rng), objects: Vec::new() };
        let start = rng.range(0.0, TAU);
        // How much of the way around the room is furnished: less means more objects in one view.
        let arc = TAU * rng.range(0.55, 0.95);
        // A sector of the room for each object, so that few hide behind others when seen from the middle. The largest
        // choose first.
        let mut placed: Vec<(usize, PlacedObject)> = Vec::new();
        let made = |&(class, object): &(Class, u64)| PlacedObject::new(class, object, Pose::default());
        let mut waiting: Vec<(usize, PlacedObject)> = objects.iter().map(made).enumerate().collect();
        let extent = |o: &PlacedObject| o.bounds().size()[0] * o.bounds().size()[1];
        waiting.sort_by(|(_, a), (_, b)| extent(b).total_cmp(&extent(a)));
        for (i, object) in waiting {
            let angle = start + i as f32 * arc / objects.len() as f32;
            if let Some(object) = plan.place(&mut rng, object, angle) {
                plan.objects.push(object.clone());
                placed.push((i, object));
            }
        }
        placed.sort_by_key(|(i, _)| *i);
        plan.objects = placed.into_iter().map(|(_, object)| object).collect();
        plan
    }

    /// Finds a place for an object about the direction `angle` from the middle, or farther and farther from that
    /// direction where there is no room; `None` where there is none anywhere.
    fn place(&self, rng: &mut Rng, mut object: PlacedObject, angle: f32) -> Option<PlacedObject> {
        for attempt in 0..120 {
            let aside = 0.2 + 0.025 * attempt as f32;
            let angle = angle + rng.range(-aside, aside);
            let radius = rng.range(1.3, 3.0);
            let (s, c) = libm::sincosf(angle);
            let yaw = match object.class {
                Class::Bin | Class::Plant | Class::Box | Class::Stool => rng.range(0.0, TAU),
                // Also along the wall.
                Class::Bed => angle + 0.5 * PI * rng.below(4) as f32 + rng.range(-0.3, 0.3),
                _ => angle + PI + rng.range(-0.7, 0.7),
            };
            object.pose = Pose { x: radius * c, y: radius * s, yaw: wrap(yaw) };
            if self.fits(&object) {
                return Some(object);
            }
        }
        None
    }

    /// The room of [`super::Recording::demo`].
    pub(super) fn demo() -> Self {
        let mut rng = Rng::new(4);
        let mut room = room(&mut rng, [3.4, 3.4]);
        room.floor = Material::new([176, 132, 88], Texture::Planks(0.14));
        room.walls = [
            None,
            Some(Material::new([214, 208, 190], Texture::Stripes(0.11))),
            Some(Material::new([196, 206, 208], Texture::Noise)),
            Some(Material::new([214, 208, 190], Texture::Noise)),
        ];
        // Polar about the middle of the robot's way, so that the free angles between the objects are plain to see:
        // bearing in degrees, distance in metres, turn away from facing the robot in rad. Near and far objects alternate.
        let place = |class, object, bearing: f32, distance: f32, turn: f32| {
            let angle = bearing * PI / 180.0;
            let (s, c) = libm::sincosf(angle);
            let [x, y] = DEMO_ROBOT;
            let pose = Pose { x: x + distance * c, y: y + distance * s, yaw: wrap(angle + PI + turn) };
            PlacedObject::new(class, HELD_OUT_SEEDS + object, pose)
        };
        let objects = vec![
            place(Class::Armchair, 1, 35.5, 3.2, 0.5),
            place(Class::Stool, 0, 22.5, 2.3, 0.3),
            place(Class::Chair, 1, 10.5, 3.1, -0.6),
            place(Class::Bin, 2, 0.0, 2.2, 0.0),
            place(Class::SwivelChair, 4, -11.5, 3.2, 0.5),
            place(Class::Box, 10, -22.5, 2.3, 0.3),
            place(Class::Plant, 6, -35.0, 3.15, 0.0),
        ];
        Self { room, light: Light::default(), objects }
    }

    /// Whether an object would keep its distances.
    fn fits(&self, placed: &PlacedObject) -> bool {
        let corners = placed.footprint();
        let (low, high) = (self.room.min, self.room.max);
        let inside = corners.iter().all(|p| (0..2).all(|k| p[k] >= low[k] + FROM_WALL && p[k] <= high[k] - FROM_WALL));
        inside
            && distance_to_point(&corners, [0.0; 2]) >= FREE + 0.3
            && self.objects.iter().all(|other| distance(&corners, &other.footprint()) >= APART)
    }
}

/// Floor and walls of a room that reaches `half` metres from the origin: two or three papered walls, the rest plaster.
fn room(rng: &mut Rng, half: [f32; 2]) -> Room {
    let floor = match rng.below(3) {
        0 => Material::new([190, 184, 172], Texture::Tiles(rng.range(0.3, 0.6))),
        1 => Material::new([150, 150, 146], Texture::Checker(0.5)),
        _ => Material::new([178, 132, 86], Texture::Planks(rng.range(0.09, 0.18))),
    };
    let paper = rng.pick(&[[206, 198, 180], [176, 196, 204], [200, 180, 170], [184, 200, 176]]);
    let papered = rng.below(4);
    let third = rng.chance(0.5);
    let walls = [0, 1, 2, 3].map(|i| {
        let has_paper = i == papered || i == (papered + 2) % 4 || (third && i == (papered + 1) % 4);
        let texture = if has_paper { Texture::Stripes(0.09) } else { Texture::Noise };
        Some(Material::new(if has_paper { paper } else { [216, 214, 208] }, texture))
    });
    Room { min: half.map(|h| -h), max: half, wall_height: 2.5, floor, walls }
}

/// A lamp somewhere above, in a third of the rooms a patch of sun.
fn light(rng: &mut Rng) -> Light {
    let toward = |azimuth: f32, elevation: f32| {
        let ((sa, ca), (se, ce)) = (libm::sincosf(azimuth), libm::sincosf(elevation));
        [ca * ce, sa * ce, se]
    };
    let ambient = rng.range(0.45, 0.7);
    let direction = toward(rng.range(0.0, TAU), rng.range(0.7, 1.3));
    let sun = rng.chance(0.33).then(|| {
        let (s, c) = libm::sincosf(rng.range(0.0, TAU));
        Sun {
            direction: toward(rng.range(0.0, TAU), rng.range(0.5, 0.9)),
            centre: [1.8 * c, 1.8 * s],
            half: [rng.range(0.25, 0.5), rng.range(0.4, 0.8)],
            yaw: rng.range(0.0, PI),
        }
    });
    Light { direction, ambient, diffuse: 1.05 - ambient, sun }
}

/// The angle brought into -pi..=pi.
pub(super) fn wrap(angle: f32) -> f32 {
    angle - TAU * (angle / TAU).round()
}

/// Distance from a point to a convex polygon, in metres; 0 inside.
pub(super) fn distance_to_point(polygon: &[[f32; 2]; 4], p: [f32; 2]) -> f32 {
    let mut inside = true;
    let mut nearest = f32::INFINITY;
    for i in 0..4 {
        let (a, b) = (polygon[i], polygon[(i + 1) % 4]);
        let (e, q) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
        inside &= e[0] * q[1] - e[1] * q[0] >= 0.0;
        let t = ((e[0] * q[0] + e[1] * q[1]) / (e[0] * e[0] + e[1] * e[1]).max(1e-12)).clamp(0.0, 1.0);
        let d = [q[0] - t * e[0], q[1] - t * e[1]];
        nearest = nearest.min((d[0] * d[0] + d[1] * d[1]).sqrt());
    }
    if inside { 0.0 } else { nearest }
}

/// Distance between two rectangles in metres; 0 where they overlap.
pub(super) fn distance(a: &[[f32; 2]; 4], b: &[[f32; 2]; 4]) -> f32 {
    // A side of one that has the other wholly beyond it tells them apart; without one they overlap.
    let apart = |p: &[[f32; 2]; 4], q: &[[f32; 2]; 4]| {
        (0..4).any(|i| {
            let (s, t) = (p[i], p[(i + 1) % 4]);
            q.iter().all(|r| (t[0] - s[0]) * (r[1] - s[1]) - (t[1] - s[1]) * (r[0] - s[0]) < 0.0)
        })
    };
    if !apart(a, b) && !apart(b, a) {
        return 0.0;
    }
    let from =
        |p: &[[f32; 2]; 4], q: &[[f32; 2]; 4]| p.iter().map(|&c| distance_to_point(q, c)).fold(f32::INFINITY, f32::min);
    from(a, b).min(from(b, a))
}

#[cfg(test)]
mod tests {
    use super::super::Drive;
    use super::*;
    use crate::kinect::Sensor;

    #[test]
    fn rectangles_are_as_far_apart_as_they_look() {
        let square = |x: f32, y: f32| [[x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0]];
        assert_eq!(distance(&square(0.0, 0.0), &square(0.5, 0.5)), 0.0);
        assert!((distance(&square(0.0, 0.0), &square(1.4, 0.2)) - 0.4).abs() < 1e-6);
        assert!((distance(&square(0.0, 0.0), &square(4.0, 5.0)) - 5.0).abs() < 1e-6);
        // A cross: no corner lies inside the other.
        let wide = [[-2.0, 0.4], [2.0, 0.4], [2.0, 0.6], [-2.0, 0.6]];
        assert_eq!(distance(&square(0.0, 0.0), &wide), 0.0);
    }

    #[test]
    fn the_demo_keeps_its_distances() {
        let objects = RoomPlan::demo().objects;
        for (i, a) in objects.iter().enumerate() {
            for b in &objects[..i] {
                let found = distance(&a.footprint(), &b.footprint());
                assert!(found >= APART, "{:?} and {:?}: {found} m", a.class, b.class);
            }
        }
    }

    #[test]
    fn generated_rooms_keep_their_distances() {
        let mut counts = 0;
        for seed in 0..12 {
            let plan = RoomPlan::generate(seed, &Class::ALL, HELD_OUT_SEEDS..HELD_OUT_SEEDS + 40);
            counts += plan.objects.len();
            assert!((2..=6).contains(&plan.objects.len()), "seed {seed}: {} objects", plan.objects.len());
            for (i, a) in plan.objects.iter().enumerate() {
                assert!(a.object >= HELD_OUT_SEEDS);
                for p in a.footprint() {
                    assert!((0..2).all(|k| p[k].abs() <= plan.room.max[k] - 0.4 + 1e-5));
                }
                for b in &plan.objects[..i] {
                    assert!(distance(&a.footprint(), &b.footprint()) >= APART);
                }
            }
            for camera in plan.path(&Sensor::kinect_v1(), &Drive::default(), seed) {
                let position = [camera.x, camera.y];
                assert!(plan.objects.iter().all(|o| distance_to_point(&o.footprint(), position) > 0.2));
            }
        }
        assert!(counts >= 12 * 3, "only {counts} objects in 12 rooms");
    }
}
