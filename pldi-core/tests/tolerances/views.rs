//! Views and what follows from them, beside their truth.

use super::geometry::{Fitted, Pose};
use super::image::{domain_transform, light, point};
use super::measure::Errors;
use super::numbers::{self, Kind};
use super::scenes::{CAMERA, H, W, rooms};
use super::stages::{pipeline, pose};
use crate::common::{Random, Shot};
use pldi_core::descriptor::{self, Descriptor, DescriptorKind, View};
use pldi_core::reconstruct::FilterKind;
use pldi_core::view::{Framing, Homography, framing, warp};
use pldi_core::wavelet::{self, Plane, SIZE};
use pldi_core::{Float, Floor, Frame, Image, Workspace, matching};

fn boxed<T: Copy, const X: usize, const Y: usize>(value: T) -> Box<Image<T, X, Y>> {
    vec![[value; X]; Y].into_boxed_slice().try_into().unwrap_or_else(|_| unreachable!())
}

/// What the core makes of the object in each of the rooms: the frame, the truth of its pose, workspace, descriptor.
fn objects(kind: FilterKind) -> Vec<(Shot, Pose, Box<Workspace<Float, W, H>>, Descriptor)> {
    let one = |(seed, room): (u64, crate::common::Room<'_>)| {
        let (pipeline, mut workspace) = pipeline::<W, H>(kind, &CAMERA);
        let shot = room.shoot(&CAMERA, seed);
        let floor = Floor::from_pose(room.height as f32, room.pitch as f32, 0.0).unwrap();
        let truth = Pose::new(f64::from(room.height as f32), f64::from(room.pitch as f32), 0.0);
        pipeline.reconstruct(&Frame::new(&shot.depth, Some(&shot.colour)).unwrap(), &mut workspace);
        let mask = |u: usize, v: usize| shot.object[v * W + u];
        let found = pipeline.describe_mask(&floor, mask, &mut workspace).unwrap();
        (shot, truth, workspace, found)
    };
    (20..).zip(rooms()).map(one).collect()
}

/// The views of all objects, and views of noise.
fn views() -> Vec<Box<View>> {
    let mut views: Vec<_> =
        objects(FilterKind::Joint).into_iter().map(|(_, _, w, _)| Box::new(w.images.view)).collect();
    let mut random = Random(30);
    for amplitude in [65_535.0, 900.0] {
        let mut view = boxed(0);
        view.as_flattened_mut().iter_mut().for_each(|v| *v = random.between(0.0, amplitude) as u16);
        views.push(view);
    }
    views
}

fn fractions(view: &View) -> Vec<f64> {
    view.as_flattened().iter().map(|v| f64::from(*v) / 65535.0).collect()
}

/// Pixels of the object that have depth.
fn pixels(workspace: &Workspace<Float, W, H>) -> Vec<(usize, usize)> {
    let on = |i: &usize| workspace.images.labels[i / W][i % W] == 1;
    (0..W * H).filter(on).map(|i| (i % W, i / W)).collect()
}

/// The truth of an object's square, from the pixels that carry its label and their depth.
fn fitted(pose: Pose, depth: impl Fn(usize, usize) -> f64, pixels: &[(usize, usize)]) -> Fitted {
    let on_floor = pixels.iter().map(|&(u, v)| pose.to_floor(point(&CAMERA, u, v, depth(u, v))));
    let sum = on_floor.fold([0.0; 2], |sum, q| [sum[0] + q[0], sum[1] + q[1]]);
    Fitted::new(pose, CAMERA, sum.map(|v| v / pixels.len() as f64), pixels)
}

/// The fitted square, and which pixel each of its corners comes from: in pixels.
pub fn square() -> Errors {
    let mut errors = Errors::default();
    for (_, truth, workspace, _) in objects(FilterKind::Joint) {
        let truth = fitted(truth, |u, v| f64::from(workspace.images.depth[v][u]), &pixels(&workspace));
        let (cluster, floor) = (workspace.report.clusters[0], workspace.report.floor.unwrap());
        let to_image = Homography::plane_to_image(&floor.axes(), &CAMERA, cluster.centroid).unwrap();
        let pixel = 1.0 / CAMERA.fx;
        let found =
            framing::frontal(Framing::Fit, &workspace.images.labels, 1, cluster.bbox, &to_image, floor.height, pixel)
                .unwrap();
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (0.0, 0.0)] {
            let at = |k: usize, side: f32| found.centre[k] + side * found.half;
            let point = [(0, x), (1, y)].map(|(k, side)| truth.centre[k] + f64::from(side) * truth.half);
            let pixel = truth.frontal.plane_to_image(truth.frontal.view_to_plane(point));
            errors.add_all(&found.to_image.apply(at(0, x), at(1, y)).unwrap(), &pixel);
        }
    }
    errors
}

/// The view of N, sampled where the truth says.
pub fn sampling() -> Errors {
    let mut errors = Errors::default();
    for (_, truth, workspace, _) in objects(FilterKind::Joint) {
        let truth = fitted(truth, |u, v| f64::from(workspace.images.depth[v][u]), &pixels(&workspace));
        let n = |u: i64, v: i64| match (usize::try_from(u), usize::try_from(v)) {
            (Ok(u), Ok(v)) if u < W && v < H && workspace.images.labels[v][u] == 1 => {
                f64::from(workspace.images.n[v][u]) / 65535.0
            }
            _ => 0.0,
        };
        for (found, truth) in fractions(&workspace.images.view).iter().zip(truth.sample(n)) {
            errors.add(*found, truth);
        }
    }
    errors
}

/// The view of a panel with a smooth pattern, beside the pattern itself, away from the panel's edges.
pub fn pattern() -> Errors {
    let mut errors = Errors::default();
    let wave = |[s, t]: [f64; 2]| 0.5 + 0.2 * libm::sin(9.0 * s + 1.0) + 0.2 * libm::cos(8.0 * t - 3.0 * s);
    let inside = |[s, t]: [f64; 2], margin: f64| s.abs() < 0.4 - margin && (margin..0.9 - margin).contains(&t);
    for (pitch, roll, centroid) in [(0.3, 0.0, [0.0, 2.0]), (0.45, 0.06, [0.5, 1.8]), (0.25, -0.04, [-0.6, 2.6])] {
        let (axes, truth) = pose(1.2, pitch, roll);
        let truth = super::geometry::Frontal::new(truth, CAMERA, centroid, 0.0);
        let (mut n, mut labels) = (boxed::<u16, W, H>(0), boxed::<u16, W, H>(0));
        let (mut bbox, mut seen) = ([u16::MAX, u16::MAX, 0, 0], Vec::new());
        for v in 0..H {
            for u in 0..W {
                let at = truth.image_to_plane([u as f64, v as f64]);
                if inside(at, 0.0) {
                    (n[v][u], labels[v][u]) = ((wave(at) * 65535.0 + 0.5) as u16, 5);
                    let (x, y) = (u as u16, v as u16);
                    bbox = [bbox[0].min(x), bbox[1].min(y), bbox[2].max(x), bbox[3].max(y)];
                    seen.push((u, v));
                }
            }
        }
        let to_image = Homography::plane_to_image(&axes, &CAMERA, centroid.map(|v| v as f32)).unwrap();
        let pixel = 1.0 / CAMERA.fx;
        let frontal = framing::frontal(Framing::Fit, &labels, 5, bbox, &to_image, 1.2, pixel).unwrap();
        let mut view: Box<View> = boxed(0);
        warp::warp(&n, &labels, 5, &frontal, &mut view);
        let (_, truth_pose) = pose(1.2, pitch, roll);
        let fitted = Fitted::new(truth_pose, CAMERA, centroid, &seen);
        for (i, found) in fractions(&view).iter().enumerate() {
            let at = fitted.plane_point(i % SIZE, i / SIZE);
            if inside(at, 0.03) {
                errors.add(*found, wave(at));
            }
        }
    }
    errors
}

/// All wavelet coefficients.
pub fn wavelets() -> Errors {
    assert!(numbers::defect_of_the_filter() < 1e-11, "{}", numbers::defect_of_the_filter());
    let mut errors = Errors::default();
    for view in views() {
        let values = fractions(&view);
        let mut plane: Box<Plane> = boxed(0.0);
        plane.as_flattened_mut().iter_mut().zip(&values).for_each(|(p, v)| *p = *v as f32);
        wavelet::transform(&mut plane);
        let (approximation, levels) = numbers::wavelets(&values);
        errors.add(f64::from(plane[0][0]), approximation);
        for (level, bands) in levels.iter().enumerate() {
            let size = 1 << level;
            for (band, (top, left)) in bands.iter().zip([(size, 0), (0, size), (size, size)]) {
                for (i, truth) in band.iter().enumerate() {
                    errors.add(f64::from(plane[top + i / size][left + i % size]), *truth);
                }
            }
        }
    }
    errors
}

/// The Canberra distance between a descriptor and its truth.
fn apart(found: &Descriptor, truth: &[f64]) -> f64 {
    let found: Vec<f64> = found.iter().map(|v| f64::from(*v)).collect();
    assert_eq!(found.len(), truth.len());
    numbers::canberra(&found, truth)
}

fn descriptors(kind: DescriptorKind, truth: Kind) -> Errors {
    let mut errors = Errors::default();
    for view in views() {
        let found = descriptor::describe(&view, kind, &mut boxed(0.0));
        errors.add(apart(&found, &numbers::descriptor(&fractions(&view), truth)), 0.0);
    }
    errors
}

/// The paper's statistics.
pub fn paper() -> Errors {
    descriptors(DescriptorKind::Paper, Kind::Paper)
}

/// The means of halves.
pub fn halves() -> Errors {
    descriptors(DescriptorKind::Halves, Kind::Halves)
}

/// The Canberra distance between descriptors, up to 58.
pub fn canberra() -> Errors {
    let (mut errors, mut random) = (Errors::default(), Random(40));
    let mut all: Vec<Descriptor> =
        views().iter().map(|view| descriptor::describe(view, DescriptorKind::Halves, &mut boxed(0.0))).collect();
    all.extend((0..60).map(|_| core::array::from_fn(|i| (random.between(-0.2, 1.0) * ((i % 7) as f64)) as f32)));
    for a in &all {
        for b in &all {
            let truth = numbers::canberra(&a.map(f64::from), &b.map(f64::from));
            errors.add(f64::from(matching::canberra(a, b)), truth);
        }
    }
    errors
}

/// From the frame to the descriptor of an object whose pixels are known: all stages' errors together.
pub fn frame_to_descriptor() -> Errors {
    let mut errors = Errors::default();
    for (shot, pose, _, found) in objects(FilterKind::Joint) {
        let depth: Vec<f64> = shot.depth.iter().map(|d| f64::from(*d) / 1000.0).collect();
        let depth = domain_transform(&depth, Some(&shot.colour), W, H);
        let pixels: Vec<_> = (0..W * H).filter(|&i| shot.object[i] && depth[i] > 0.0).map(|i| (i % W, i / W)).collect();
        let fitted = fitted(pose, |u, v| depth[v * W + u], &pixels);
        let mut n = vec![0.0; W * H];
        for &(u, v) in &pixels {
            n[v * W + u] = light(&depth, &CAMERA, 0.04, u, v);
        }
        let at = |u: i64, v: i64| {
            if (0..W as i64).contains(&u) && (0..H as i64).contains(&v) { n[(v * W as i64 + u) as usize] } else { 0.0 }
        };
        errors.add(apart(&found, &numbers::descriptor(&fitted.sample(at), Kind::Halves)), 0.0);
    }
    errors
}
