//! Stages that work on single numbers and points: the float ones beside their truth.

use crate::common::Random;
use crate::errors::Tally;
use crate::inputs::analytic::CAMERA;
use crate::inputs::{H, W};
use crate::oracle::geometry::{Frontal, Pose, project};
use crate::oracle::image;
use crate::rows::Pair::Float;
use crate::stages::pose;
use pldi_core::floor::FloorAxes;
use pldi_core::math;
use pldi_core::view::Homography;

/// All of them; each is a job of its own.
pub const JOBS: &[fn(&mut Tally)] = &[exp, angles, back_projection, projection, axes, coordinates, to_pixels, to_plane];

/// The exponential, in units of the last place.
fn exp(tally: &mut Tally) {
    let errors = tally.at("math: exp", Float);
    let mut random = Random(1);
    for _ in 0..200_000 {
        let x = random.between(-80.0, 40.0) as f32;
        let truth = libm::exp(f64::from(x));
        let unit = f64::from(f32::from_bits((truth as f32).to_bits() + 1)) - f64::from(truth as f32);
        errors.add(f64::from(math::exp(x)) / unit, truth / unit);
    }
}

/// Sine, cosine, and the angles back.
fn angles(tally: &mut Tally) {
    let errors = tally.at("math: sin, cos, asin, atan2", Float);
    let mut random = Random(2);
    for _ in 0..100_000 {
        let (a, r) = (random.between(-7.0, 7.0) as f32, random.between(-1.0, 1.0) as f32);
        let (sin, cos) = math::sin_cos(a);
        errors.add(f64::from(sin), libm::sin(f64::from(a)));
        errors.add(f64::from(cos), libm::cos(f64::from(a)));
        errors.add(f64::from(math::asin(r)), libm::asin(f64::from(r)));
        errors.add(f64::from(math::atan2(r, a)), libm::atan2(f64::from(r), f64::from(a)));
    }
}

/// Back-projection by the intrinsics, to 8 m.
fn back_projection(tally: &mut Tally) {
    let errors = tally.at("frame: back-projection", Float);
    let mut random = Random(3);
    for i in 0..W * H {
        let z = random.between(0.4, 8.0) as f32;
        let found = CAMERA.back_project((i % W) as f32, (i / W) as f32, z);
        errors.add_all(&found, &image::point(&CAMERA, i % W, i / W, f64::from(z)));
    }
}

/// The projection of points in space.
fn projection(tally: &mut Tally) {
    let errors = tally.at("frame: projection", Float);
    let mut random = Random(13);
    for _ in 0..20_000 {
        let p = [random.between(-1.0, 1.0), random.between(-1.0, 1.0), random.between(1.0, 6.0)].map(|v| v as f32);
        errors.add_all(&CAMERA.project(p).unwrap(), &project(&CAMERA, p.map(f64::from)));
    }
}

fn random_pose(random: &mut Random) -> (FloorAxes, Pose) {
    let mut between = |a, b| random.between(a, b) as f32;
    pose(between(0.3, 2.5), between(-0.3, 1.3), between(-0.6, 0.6))
}

/// The floor's normal and axes by the camera's pose.
fn axes(tally: &mut Tally) {
    let errors = tally.at("floor: pose and axes", Float);
    let mut random = Random(5);
    for _ in 0..20_000 {
        let (axes, truth) = random_pose(&mut random);
        errors.add_all(&axes.floor.normal, &truth.up);
        errors.add_all(&axes.right, &truth.right);
        errors.add_all(&axes.forward, &truth.forward);
    }
}

/// Points to floor coordinates and back, within 4 m.
fn coordinates(tally: &mut Tally) {
    let errors = tally.at("floor: coordinates", Float);
    let mut random = Random(6);
    for _ in 0..20_000 {
        let (axes, truth) = random_pose(&mut random);
        let p: [f32; 3] = core::array::from_fn(|_| random.between(-4.0, 4.0) as f32);
        errors.add_all(&axes.to_floor(p), &truth.to_floor(p.map(f64::from)));
        errors.add_all(&axes.to_camera(p), &truth.to_camera(p.map(f64::from)));
    }
}

/// An object's place, the core's homographies of it, and the truth.
fn frontal(random: &mut Random) -> (Homography, Homography, Frontal) {
    let mut between = |a, b| random.between(a, b) as f32;
    let (axes, truth) = pose(between(0.6, 1.6), between(0.1, 0.7), between(-0.1, 0.1));
    let (right, forward, middle) = (between(-1.0, 1.0), between(1.5, 3.5), between(0.2, 1.0));
    let to_image = Homography::plane_to_image(&axes, &CAMERA, [right, forward]).unwrap();
    let to_plane = Homography::view_to_plane(axes.floor.height, middle);
    let centroid = [f64::from(right), f64::from(forward)];
    (to_image, to_plane, Frontal::new(truth, CAMERA, centroid, f64::from(middle)))
}

/// From points of the planes, up to 1 m from the centroid, to pixels, directly and by way of the frontal view.
fn to_pixels(tally: &mut Tally) {
    let errors = tally.at("view: planes to pixels", Float);
    let mut random = Random(11);
    for _ in 0..20_000 {
        let (to_image, to_plane, truth) = frontal(&mut random);
        let [s, t] = [random.between(-1.0, 1.0) as f32, random.between(0.0, 1.5) as f32];
        errors.add_all(&to_image.apply(s, t).unwrap(), &truth.plane_to_image([s, t].map(f64::from)));
        let [x, y] = [random.between(-0.3, 0.3) as f32, random.between(-0.3, 0.3) as f32];
        let on_plane = truth.view_to_plane([x, y].map(f64::from));
        let both = to_image.after(&to_plane).apply(x, y).unwrap();
        errors.add_all(&both, &truth.plane_to_image(on_plane));
    }
}

/// From pixels to points of pi_o, in metres.
fn to_plane(tally: &mut Tally) {
    let errors = tally.at("view: pixels to plane", Float);
    let mut random = Random(12);
    for _ in 0..20_000 {
        let (to_image, _, truth) = frontal(&mut random);
        let p = [random.between(-0.6, 0.6), random.between(0.0, 1.2)];
        let pixel = truth.plane_to_image(p).map(|v| v as f32);
        let found = to_image.inverse().unwrap().apply(pixel[0], pixel[1]).unwrap();
        errors.add_all(&found, &truth.image_to_plane(pixel.map(f64::from)));
    }
}
