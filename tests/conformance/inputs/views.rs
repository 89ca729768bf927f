//! Rendered views of single objects, as the ModelNet10 protocol takes them: procedural furniture, longest side 1 m, seen
//! from 20 sides at 2 m distance and 1.2 m height, exact depth.

use std::sync::Arc;

use pldi_core::Intrinsics;
use pldi_fixtures::{CameraPose, Class, HELD_OUT_SEEDS, Scene as World, Sensor, ViewRing, furniture};

/// The camera.
pub const CAMERA: Intrinsics = Intrinsics { width: 320, height: 240, fx: 285.63, fy: 285.63, cx: 159.5, cy: 119.5 };

/// Objects of each class.
const EACH: usize = 9;

/// Objects in all.
pub const OBJECTS: usize = EACH * Class::ALL.len();

/// Views of each object.
pub const VIEWS: usize = 20;

/// One view.
#[derive(Debug, Clone)]
pub struct View {
    /// Where it was taken from.
    pub camera: CameraPose,
    /// Depth in 1/8 mm, row by row, 0 = nothing: what float and fixed point both can hold exactly.
    pub depth: Vec<u16>,
}

/// All views of one object.
pub fn views(object: usize) -> Vec<View> {
    let class = Class::ALL[object % Class::ALL.len()];
    let mut mesh = furniture(class, HELD_OUT_SEEDS + (object / Class::ALL.len()) as u64);
    mesh.scale_longest_side_to(1.0);
    let height = mesh.bounds().map_or(0.0, |b| b.max[2]);
    let world = World::of(Arc::new(mesh));
    let ring = ViewRing { views: VIEWS, ..ViewRing::default() };
    let view = |i: usize| {
        let camera = ring.camera(i, height);
        let rendering = Sensor::noise_free(CAMERA).render(&world, &camera);
        View { camera, depth: rendering.depth.iter().map(|z| (z * 8000.0 + 0.5) as u16).collect() }
    };
    (0..VIEWS).map(view).collect()
}
