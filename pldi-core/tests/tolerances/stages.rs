//! Each stage of the core beside its truth, on the same input.

use super::geometry::{Frontal, Pose, project};
use super::image::{self, bilateral, domain_transform};
use super::measure::Errors;
use super::scenes::{CAMERA, H, Scene, W, all, rooms};
use crate::common::Random;
use pldi_core::floor::{FloorAxes, RansacParams, ransac};
use pldi_core::ground::density::{self, Gaussian, NO_CELL};
use pldi_core::ground::{CELL, DensityParams, MAP_DEPTH, MAP_WIDTH, SensoryArea};
use pldi_core::reconstruct::{FilterKind, FilterParams};
use pldi_core::view::Homography;
use pldi_core::{Float, Floor, Frame, Image, Intrinsics, Params, Pipeline, Rays, Workspace, math};

/// The pipeline and the memory that the stages are measured in.
pub fn pipeline<const X: usize, const Y: usize>(
    filter: FilterKind,
    camera: &Intrinsics,
) -> (Pipeline<Float, X, Y>, Box<Workspace<Float, X, Y>>) {
    let params = Params { filter: FilterParams { kind: filter, ..FilterParams::DEFAULT }, ..Params::DEFAULT };
    (Pipeline::new(&params, camera).unwrap(), Box::new(Workspace::new()))
}

/// The joint filter's result on each scene.
fn filtered() -> Vec<Box<Image<f32, W, H>>> {
    let (pipeline, mut workspace) = pipeline::<W, H>(FilterKind::Joint, &CAMERA);
    let filter = |scene: &Scene| {
        pipeline.reconstruct(&Frame::new(&scene.depth, Some(&scene.colour)).unwrap(), &mut workspace);
        Box::new(workspace.images.depth)
    };
    all().iter().map(filter).collect()
}

/// The exponential, in units of the last place.
pub fn exp() -> Errors {
    let (mut errors, mut random) = (Errors::default(), Random(1));
    for _ in 0..200_000 {
        let x = random.between(-80.0, 40.0) as f32;
        let truth = libm::exp(f64::from(x));
        let unit = f64::from(f32::from_bits((truth as f32).to_bits() + 1)) - f64::from(truth as f32);
        errors.add(f64::from(math::exp(x)) / unit, truth / unit);
    }
    errors
}

/// Sine, cosine, and the angles back.
pub fn angles() -> Errors {
    let (mut errors, mut random) = (Errors::default(), Random(2));
    for _ in 0..100_000 {
        let (a, r) = (random.between(-7.0, 7.0) as f32, random.between(-1.0, 1.0) as f32);
        let (sin, cos) = math::sin_cos(a);
        errors.add(f64::from(sin), libm::sin(f64::from(a)));
        errors.add(f64::from(cos), libm::cos(f64::from(a)));
        errors.add(f64::from(math::asin(r)), libm::asin(f64::from(r)));
        errors.add(f64::from(math::atan2(r, a)), libm::atan2(f64::from(r), f64::from(a)));
    }
    errors
}

fn add_point(errors: &mut Errors, found: [f32; 3], truth: [f64; 3]) {
    errors.add_all(&found, &truth);
}

/// Back-projection by the intrinsics, to 8 m.
pub fn back_projection() -> Errors {
    let (mut errors, mut random) = (Errors::default(), Random(3));
    for i in 0..W * H {
        let z = random.between(0.4, 8.0) as f32;
        let found = CAMERA.back_project((i % W) as f32, (i / W) as f32, z);
        add_point(&mut errors, found, image::point(&CAMERA, i % W, i / W, f64::from(z)));
    }
    errors
}

/// The same by the tables of rays.
pub fn rays() -> Errors {
    let (mut errors, mut random) = (Errors::default(), Random(3));
    let rays = Rays::<W, H>::new(&CAMERA).unwrap();
    for i in 0..W * H {
        let z = random.between(0.4, 8.0) as f32;
        let found = rays.point(i % W, i / W, z);
        add_point(&mut errors, found, image::point(&CAMERA, i % W, i / W, f64::from(z)));
    }
    errors
}

fn add_depths(errors: &mut Errors, found: &[f32], truth: &[f64]) {
    let valid = |z: f64| (z > 0.0).then_some(z);
    for (found, truth) in found.iter().zip(truth) {
        errors.add_option(valid(f64::from(*found)), valid(*truth));
    }
}

fn recursive(kind: FilterKind) -> Errors {
    let mut errors = Errors::default();
    let (pipeline, mut workspace) = pipeline::<W, H>(kind, &CAMERA);
    for scene in all() {
        pipeline.reconstruct(&Frame::new(&scene.depth, Some(&scene.colour)).unwrap(), &mut workspace);
        let colour = (kind == FilterKind::Joint).then_some(&scene.colour[..]);
        let truth = domain_transform(&scene.metres(), colour, W, H);
        add_depths(&mut errors, workspace.images.depth.as_flattened(), &truth);
    }
    errors
}

/// The joint filter by the domain transform.
pub fn joint() -> Errors {
    recursive(FilterKind::Joint)
}

/// The filter without colour.
pub fn depth_alone() -> Errors {
    recursive(FilterKind::Bilateral)
}

/// Equation 1 as written, on a small part of the scenes.
pub fn exact() -> Errors {
    let mut errors = Errors::default();
    let camera = Intrinsics { width: 48, height: 40, cx: 24.0, cy: 20.0, fx: 48.0, fy: 48.0 };
    let (pipeline, mut workspace) = pipeline::<48, 40>(FilterKind::Exact, &camera);
    for scene in all() {
        let small = scene.small(48, 40, 6);
        pipeline.reconstruct(&Frame::new(&small.depth, Some(&small.colour)).unwrap(), &mut workspace);
        let truth = bilateral(&small.metres(), &small.colour, 48, 40);
        add_depths(&mut errors, workspace.images.depth.as_flattened(), &truth);
    }
    errors
}

/// A pose as the core has it, and its truth.
pub fn pose(height: f32, pitch: f32, roll: f32) -> (FloorAxes, Pose) {
    let axes = Floor::from_pose(height, pitch, roll).unwrap().axes();
    (axes, Pose::new(f64::from(height), f64::from(pitch), f64::from(roll)))
}

fn random_pose(random: &mut Random) -> (FloorAxes, Pose) {
    let mut between = |a, b| random.between(a, b) as f32;
    pose(between(0.3, 2.5), between(-0.3, 1.3), between(-0.6, 0.6))
}

/// The floor's normal and axes by the camera's pose.
pub fn axes() -> Errors {
    let (mut errors, mut random) = (Errors::default(), Random(5));
    for _ in 0..20_000 {
        let (axes, truth) = random_pose(&mut random);
        add_point(&mut errors, axes.floor.normal, truth.up);
        add_point(&mut errors, axes.right, truth.right);
        add_point(&mut errors, axes.forward, truth.forward);
    }
    errors
}

/// Points to floor coordinates and back, within 4 m.
pub fn coordinates() -> Errors {
    let (mut errors, mut random) = (Errors::default(), Random(6));
    for _ in 0..20_000 {
        let (axes, truth) = random_pose(&mut random);
        let p: [f32; 3] = core::array::from_fn(|_| random.between(-4.0, 4.0) as f32);
        add_point(&mut errors, axes.to_floor(p), truth.to_floor(p.map(f64::from)));
        add_point(&mut errors, axes.to_camera(p), truth.to_camera(p.map(f64::from)));
    }
    errors
}

/// Camera height and the normal's components, as found in noisy rooms by random sampling; truth is the pose.
pub fn search() -> Errors {
    let mut errors = Errors::default();
    let (pipeline, mut workspace) = pipeline::<W, H>(FilterKind::Joint, &CAMERA);
    for (seed, room) in (7..).zip(rooms()) {
        let shot = room.shoot(&CAMERA, seed);
        pipeline.reconstruct(&Frame::new(&shot.depth, Some(&shot.colour)).unwrap(), &mut workspace);
        let floor = ransac::find(&workspace.images.depth, pipeline.rays(), &RansacParams::DEFAULT).unwrap();
        let truth = Pose::new(room.height, room.pitch, 0.0);
        add_point(&mut errors, floor.normal, truth.up);
        errors.add(f64::from(floor.height), truth.height);
    }
    errors
}

/// A blank map.
fn map() -> Box<Image<f32, MAP_WIDTH, MAP_DEPTH>> {
    vec![[0.0; MAP_WIDTH]; MAP_DEPTH].into_boxed_slice().try_into().unwrap()
}

/// Which cell of image L each pixel belongs to; a pixel at a border may fall to the other side.
pub fn cells() -> Errors {
    let mut errors = Errors::default();
    let (params, camera) = (DensityParams::DEFAULT, CAMERA);
    let (axes, truth) = pose(1.2, 0.4, 0.05);
    let area = SensoryArea::new(&Params::DEFAULT.area, &camera, &axes.floor);
    let rays = Rays::<W, H>::new(&camera).unwrap();
    let mut found = vec![[0u16; W]; H];
    for depth in filtered() {
        let found: &mut Image<u16, W, H> = found.as_mut_slice().try_into().unwrap();
        density::project(&depth, &rays, &axes, &area, &params, found, &mut map());
        for (i, &cell) in found.as_flattened().iter().enumerate() {
            let z = f64::from(depth[i / W][i % W]);
            let [right, forward, up] = truth.to_floor(image::point(&camera, i % W, i / W, z));
            // The outermost rays of a level camera, on the floor.
            let side = |u: f64| (u - f64::from(camera.cx)) / f64::from(camera.fx) / truth.horizontal() * forward;
            let inside = z > 0.0
                && (0.02 + 0.004 * z * z..=2.2).contains(&up)
                && (0.5..=4.0).contains(&forward)
                && (side(0.0)..=side(W as f64 - 1.0)).contains(&right);
            let (column, row) = (libm::floor(right / 0.02) as i64 + 128, libm::floor(forward / 0.02) as i64);
            let inside = inside && (0..MAP_WIDTH as i64).contains(&column);
            let expected = if inside { row * MAP_WIDTH as i64 + column } else { i64::from(NO_CELL) };
            if i64::from(cell) == expected { errors.add(0.0, 0.0) } else { errors.add_apart() }
        }
    }
    errors
}

/// The density of some counts, by the Gaussian itself.
pub fn spread() -> Errors {
    let (mut errors, mut random) = (Errors::default(), Random(9));
    let (params, focal) = (DensityParams::DEFAULT, f64::from(CAMERA.fx));
    let (mut counts, mut density) = (map(), map());
    let mut truth = vec![0.0; MAP_WIDTH * MAP_DEPTH];
    let cell = f64::from(CELL);
    for _ in 0..400 {
        let (column, row) = (random.bits() as usize % MAP_WIDTH, 25 + random.bits() as usize % 175);
        let count = random.between(0.1, 20.0) as f32;
        counts[row][column] += count;
        let (x, y) = ((column as f64 + 0.5 - 128.0) * cell, (row as f64 + 0.5) * cell);
        // Variances along and across the ray, in square cells; a quarter for the cells themselves.
        let along = libm::pow(1.425e-3 * y * y / cell, 2.0) + 0.25;
        let across = libm::pow(0.8 * y / focal / cell, 2.0) + 0.25;
        let length = (x * x + y * y).sqrt();
        for r in row.saturating_sub(12)..(row + 13).min(MAP_DEPTH) {
            for c in column.saturating_sub(12)..(column + 13).min(MAP_WIDTH) {
                let (dx, dy) = (c as f64 - column as f64, r as f64 - row as f64);
                let (a, b) = ((dx * x + dy * y) / length, (dx * y - dy * x) / length);
                let q = a * a / along + b * b / across;
                if q < 9.0 {
                    let peak = f64::from(count) / (core::f64::consts::TAU * (along * across).sqrt());
                    truth[r * MAP_WIDTH + c] += peak * libm::exp(-0.5 * q);
                }
            }
        }
    }
    density::spread(&counts, &params, CAMERA.fx, &Gaussian::new(), &mut density);
    errors.add_all(density.as_flattened(), &truth);
    errors
}

/// N of all pixels of all scenes; no normal counts as N = 0.
pub fn diffusion() -> Errors {
    let mut errors = Errors::default();
    let (pipeline, mut workspace) = pipeline::<W, H>(FilterKind::Joint, &CAMERA);
    for depth in filtered() {
        workspace.images.depth = *depth;
        pipeline.diffuse_all(&mut workspace);
        let depth: Vec<f64> = depth.as_flattened().iter().map(|z| f64::from(*z)).collect();
        for (i, n) in workspace.images.n.as_flattened().iter().enumerate() {
            errors.add(f64::from(*n) / 65535.0, image::light(&depth, &CAMERA, 0.04, i % W, i / W));
        }
    }
    errors
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
pub fn to_pixels() -> Errors {
    let (mut errors, mut random) = (Errors::default(), Random(11));
    for _ in 0..20_000 {
        let (to_image, to_plane, truth) = frontal(&mut random);
        let [s, t] = [random.between(-1.0, 1.0) as f32, random.between(0.0, 1.5) as f32];
        errors.add_all(&to_image.apply(s, t).unwrap(), &truth.plane_to_image([s, t].map(f64::from)));
        let [x, y] = [random.between(-0.3, 0.3) as f32, random.between(-0.3, 0.3) as f32];
        let on_plane = truth.view_to_plane([x, y].map(f64::from));
        let both = to_image.after(&to_plane).apply(x, y).unwrap();
        errors.add_all(&both, &truth.plane_to_image(on_plane));
    }
    errors
}

/// From pixels to points of pi_o, in metres.
pub fn to_plane() -> Errors {
    let (mut errors, mut random) = (Errors::default(), Random(12));
    for _ in 0..20_000 {
        let (to_image, _, truth) = frontal(&mut random);
        let p = [random.between(-0.6, 0.6), random.between(0.0, 1.2)];
        let pixel = truth.plane_to_image(p).map(|v| v as f32);
        let found = to_image.inverse().unwrap().apply(pixel[0], pixel[1]).unwrap();
        errors.add_all(&found, &truth.image_to_plane(pixel.map(f64::from)));
    }
    errors
}

/// The projection of points in space.
pub fn projection() -> Errors {
    let (mut errors, mut random) = (Errors::default(), Random(13));
    for _ in 0..20_000 {
        let p = [random.between(-1.0, 1.0), random.between(-1.0, 1.0), random.between(1.0, 6.0)].map(|v| v as f32);
        errors.add_all(&CAMERA.project(p).unwrap(), &project(&CAMERA, p.map(f64::from)));
    }
    errors
}
