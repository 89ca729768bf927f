//! The stages that see whole frames: filters, floor, ground map, N; then each candidate.

use crate::errors::{Errors, Tally};
use crate::inputs::{H, Scene, W};
use crate::oracle::geometry::Pose;
use crate::oracle::image::{bilateral, domain_transform, light};
use crate::rows::Pair::Float;
use crate::stages::{Tools, ground, object, pipeline, twins};
use pldi_core::floor::{RansacParams, ransac};
use pldi_core::pipeline::QvgaPipeline;
use pldi_core::reconstruct::{FilterKind, FilterParams};
use pldi_core::{Float as Float32, Floor, Frame, Intrinsics, Params, Pipeline, Workspace};

/// N of so much more or less counts as another.
pub const N_STEP: f64 = 1.0 / 128.0;

/// All stages on one frame.
pub fn measure(scene: &Scene, tools: &mut Tools, tally: &mut Tally) {
    twins::measure(scene, tools, tally);
    let frame = Frame::new(&scene.depth, scene.colour.as_deref()).expect("a frame");
    if scene.stride > 0 {
        exact(scene, tally);
        pipeline(FilterKind::Bilateral, &scene.camera).reconstruct(&frame, &mut tools.workspace);
        let truth = domain_transform(&scene.metres(), None, W, H);
        add_depths(tally.at("reconstruct: bilateral", Float), tools.workspace.images.depth.as_flattened(), &truth);
    }
    let pipeline = pipeline(FilterKind::Joint, &scene.camera);
    pipeline.reconstruct(&frame, &mut tools.workspace);
    let mut truth = None;
    if scene.stride > 0 {
        let depth = domain_transform(&scene.metres(), scene.colour.as_deref(), W, H);
        add_depths(tally.at("reconstruct: joint", Float), tools.workspace.images.depth.as_flattened(), &depth);
        truth = Some(depth);
        diffusion(scene, &pipeline, tools, tally);
    }
    if let Some(floor) = floor(scene, &pipeline, tools, tally) {
        ground::measure(scene, &pipeline, &floor, truth.as_deref(), tools, tally);
        objects(&pipeline, &floor, truth.as_deref(), tools, tally);
    }
}

/// Depths and where there are none.
fn add_depths(errors: &mut Errors, found: &[f32], truth: &[f64]) {
    let valid = |z: f64| (z > 0.0).then_some(z);
    for (found, truth) in found.iter().zip(truth) {
        errors.add_option(valid(f64::from(*found)), valid(*truth));
    }
}

/// Equation 1 as written, on a small part of the scene.
fn exact(scene: &Scene, tally: &mut Tally) {
    let camera = Intrinsics { width: 48, height: 40, cx: 24.0, cy: 20.0, fx: 48.0, fy: 48.0 };
    let params =
        Params { filter: FilterParams { kind: FilterKind::Exact, ..FilterParams::DEFAULT }, ..Params::DEFAULT };
    let pipeline = Pipeline::<Float32, 48, 40>::new(&params, &camera).expect("a camera");
    let mut workspace = Box::new(Workspace::<Float32, 48, 40>::new());
    let (depth, colour) = scene.small(48, 40, 6);
    pipeline.reconstruct(&Frame::new(&depth, Some(&colour)).expect("a frame"), &mut workspace);
    let metres: Vec<f64> = depth.iter().map(|&d| if d <= 10_000 { f64::from(d) / 1000.0 } else { 0.0 }).collect();
    let truth = bilateral(&metres, &colour, 48, 40);
    add_depths(tally.at("reconstruct: equation 1", Float), workspace.images.depth.as_flattened(), &truth);
}

/// N of the filtered depth.
fn diffusion(scene: &Scene, pipeline: &QvgaPipeline, tools: &mut Tools, tally: &mut Tally) {
    pipeline.diffuse_all(&mut tools.workspace);
    let depth: Vec<f64> = tools.workspace.images.depth.as_flattened().iter().map(|z| f64::from(*z)).collect();
    let errors = tally.at("diffusion: N", Float);
    for (i, n) in tools.workspace.images.n.as_flattened().iter().enumerate().step_by(scene.stride) {
        let truth = light(&depth, &scene.camera, 0.04, i % W, i / W);
        errors.add_within(fraction(*n), some(truth), N_STEP);
    }
}

/// N as a fraction; `None` where there is none.
pub fn fraction(n: u16) -> Option<f64> {
    (n > 0).then(|| f64::from(n) / 65535.0)
}

/// N, if it is as large that it does not round to none.
pub fn some(n: f64) -> Option<f64> {
    (n * 65535.0 >= 0.5).then_some(n)
}

/// The floor, as the pose says or as it is found; where both are there, one is measured by the other.
fn floor(scene: &Scene, pipeline: &QvgaPipeline, tools: &Tools, tally: &mut Tally) -> Option<Floor> {
    let find = || ransac::find(&tools.workspace.images.depth, pipeline.rays(), &RansacParams::DEFAULT);
    let Some([height, pitch, roll]) = scene.pose else { return find() };
    if scene.shows_floor {
        let errors = tally.at("floor: search", Float);
        match find() {
            Some(floor) => {
                let truth = Pose::new(f64::from(height), f64::from(pitch), f64::from(roll));
                errors.add_all(&floor.normal, &truth.up);
                errors.add(f64::from(floor.height), truth.height);
            }
            None => errors.decide(false),
        }
    }
    Some(Floor::from_pose(height, pitch, roll).expect("a pose"))
}

/// Each candidate's view and descriptor.
fn objects(pipeline: &QvgaPipeline, floor: &Floor, truth: Option<&[f64]>, tools: &mut Tools, tally: &mut Tally) {
    pipeline.diffuse_candidates(&mut tools.workspace);
    for i in 0..tools.workspace.report.clusters.len() {
        if tools.workspace.report.clusters[i].rejection.is_none() {
            object::measure(pipeline, i, floor, truth, tools, tally);
        }
    }
}
