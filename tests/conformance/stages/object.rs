//! One object: its view, the wavelets, the descriptors and the nearest templates, beside their truth.

use crate::common::Random;
use crate::errors::Tally;
use crate::inputs::{H, W, analytic, extremes, views};
use crate::oracle::geometry::{Fitted, Frontal, Pose};
use crate::oracle::image::{light, point};
use crate::oracle::numbers::{self, Kind};
use crate::rows::Pair::{Fixed, Float, Twins};
use crate::rows::Set;
use crate::stages::frame::{N_STEP, fraction, some};
use crate::stages::{Tools, boxed, pipeline, pose, twin_object};
use pldi_core::descriptor::{self, Descriptor, DescriptorKind, View};
use pldi_core::pipeline::{QvgaPipeline, QvgaWorkspace};
use pldi_core::reconstruct::FilterKind;
use pldi_core::templates::Templates;
use pldi_core::view::{Framing, Homography, framing, warp};
use pldi_core::wavelet::{self, Plane, SIZE};
use pldi_core::{Floor, Intrinsics, matching};

fn fractions(view: &View) -> Vec<f64> {
    view.as_flattened().iter().map(|v| f64::from(*v) / 65535.0).collect()
}

/// Pixels of a cluster.
fn pixels(workspace: &QvgaWorkspace, label: u16) -> Vec<(usize, usize)> {
    (0..W * H).map(|i| (i % W, i / W)).filter(|&(u, v)| workspace.images.labels[v][u] == label).collect()
}

/// The truth of an object's square, from its pixels and their depth.
fn fitted(pose: Pose, camera: Intrinsics, depth: impl Fn(usize, usize) -> f64, pixels: &[(usize, usize)]) -> Fitted {
    let on_floor = pixels.iter().map(|&(u, v)| pose.to_floor(point(&camera, u, v, depth(u, v))));
    let sum = on_floor.fold([0.0; 2], |sum, q| [sum[0] + q[0], sum[1] + q[1]]);
    Fitted::new(pose, camera, sum.map(|v| v / pixels.len() as f64), pixels)
}

/// The pixel's N where it lies on the object, else 0.
fn on_object(pixels: &[(usize, usize)], n: impl Fn(usize, usize) -> f64) -> impl Fn(i64, i64) -> f64 {
    let mut image = vec![0.0; W * H];
    for &(u, v) in pixels {
        image[v * W + u] = n(u, v);
    }
    move |u, v| {
        if (0..W as i64).contains(&u) && (0..H as i64).contains(&v) { image[v as usize * W + u as usize] } else { 0.0 }
    }
}

/// A cluster of the workspace's report, from labels and N to the descriptor; and from the frame to the descriptor where
/// the filtered depth's truth is given.
pub fn measure(
    pipeline: &QvgaPipeline,
    cluster: usize,
    floor: &Floor,
    depth: Option<&[f64]>,
    tools: &mut Tools,
    tally: &mut Tally,
) {
    let workspace = &mut *tools.workspace;
    let Some(found) = pipeline.describe(cluster, floor, workspace) else { return };
    let label = cluster as u16 + 1;
    let (camera, pixels) = (*pipeline.rays().intrinsics(), pixels(workspace, label));
    let pose = Pose::above(floor.normal.map(f64::from), f64::from(floor.height));
    let truth = fitted(pose, camera, |u, v| f64::from(workspace.images.depth[v][u]), &pixels);
    square(cluster, &camera, floor, &truth, workspace, tally);
    let n = on_object(&pixels, |u, v| f64::from(workspace.images.n[v][u]) / 65535.0);
    let errors = tally.at("view: sampling", Float);
    for (found, truth) in fractions(&workspace.images.view).iter().zip(truth.sample(n)) {
        errors.add(*found, truth);
    }
    of_view(&workspace.images.view, tally);
    if let Some(depth) = depth {
        let pixels: Vec<_> = pixels.into_iter().filter(|&(u, v)| depth[v * W + u] > 0.0).collect();
        let fitted = fitted(pose, camera, |u, v| depth[v * W + u], &pixels);
        let n = on_object(&pixels, |u, v| light(depth, &camera, 0.04, u, v));
        let truth = numbers::descriptor(&fitted.sample(n), Kind::Halves);
        tally.at("pipeline: frame to descriptor", Float).add(apart(&found, &truth), 0.0);
    }
}

/// The fitted square, and which pixel each of its corners comes from: in pixels.
fn square(
    cluster: usize,
    camera: &Intrinsics,
    floor: &Floor,
    truth: &Fitted,
    workspace: &QvgaWorkspace,
    tally: &mut Tally,
) {
    let (label, cluster) = (cluster as u16 + 1, workspace.report.clusters[cluster]);
    let found = Homography::plane_to_image(&floor.axes(), camera, cluster.centroid).and_then(|to_image| {
        let pixel = 1.0 / camera.fx;
        framing::frontal(Framing::Fit, &workspace.images.labels, label, cluster.bbox, &to_image, floor.height, pixel)
    });
    let found = found.expect("a cluster that has a descriptor has a view");
    for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (0.0, 0.0)] {
        let at = |k: usize, side: f32| found.centre[k] + side * found.half;
        let point = [(0, x), (1, y)].map(|(k, side)| truth.centre[k] + f64::from(side) * truth.half);
        let pixel = truth.frontal.plane_to_image(truth.frontal.view_to_plane(point));
        let found = found.to_image.apply(at(0, x), at(1, y)).expect("a pixel");
        tally.at("view: fitted square", Float).add_all(&found, &pixel);
    }
}

/// Wavelets and descriptors of a view.
fn of_view(view: &View, tally: &mut Tally) {
    let values = fractions(view);
    let mut plane: Box<Plane> = boxed(0.0);
    plane.as_flattened_mut().iter_mut().zip(&values).for_each(|(p, v)| *p = *v as f32);
    wavelet::transform(&mut plane);
    let errors = tally.at("wavelet: coefficients", Float);
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
    let kinds = [
        (["descriptor: paper", "descriptor: paper, numbers"], DescriptorKind::Paper, Kind::Paper),
        (["descriptor: halves", "descriptor: halves, numbers"], DescriptorKind::Halves, Kind::Halves),
    ];
    for ([canberra, absolute], kind, truth) in kinds {
        let found = descriptor::from_coefficients(&plane, kind);
        let truth = numbers::descriptor_of(approximation, &levels, truth);
        // A number that should be 0 is as far off as can be in Canberra's eyes, however small it is.
        if tally.set() == Set::Extremes {
            tally.at(absolute, Float).add_all(&found, &truth);
        } else {
            tally.at(canberra, Float).add(apart(&found, &truth), 0.0);
        }
    }
}

/// The Canberra distance between a descriptor and its truth.
fn apart(found: &Descriptor, truth: &[f64]) -> f64 {
    let found: Vec<f64> = found.iter().map(|v| f64::from(*v)).collect();
    assert_eq!(found.len(), truth.len());
    numbers::canberra(&found, truth)
}

/// All rendered views of one object.
pub fn views(object: usize, tools: &mut Tools, tally: &mut Tally) {
    let pipeline = pipeline(FilterKind::None, &views::CAMERA);
    for (i, view) in views::views(object).iter().enumerate() {
        twin_object::rendered(view, tools, tally);
        let floor = Floor::from_pose(view.camera.height, view.camera.pitch, view.camera.roll).expect("a pose");
        for (z, depth) in tools.workspace.images.depth.as_flattened_mut().iter_mut().zip(&view.depth) {
            *z = f32::from(*depth) / 8000.0;
        }
        let Some(found) = pipeline.describe_mask(&floor, |_, _| true, &mut tools.workspace) else { continue };
        let depth: Vec<f64> = view.depth.iter().map(|d| f64::from(*d) / 8000.0).collect();
        let errors = tally.at("diffusion: N", Float);
        for (u, v) in pixels(&tools.workspace, 1).into_iter().step_by(11) {
            let truth = light(&depth, &views::CAMERA, 0.04, u, v);
            errors.add_within(fraction(tools.workspace.images.n[v][u]), some(truth), N_STEP);
        }
        // The whole way on some of the views.
        let whole = (i + object).is_multiple_of(views::VIEWS);
        measure(&pipeline, 0, &floor, whole.then_some(&depth[..]), tools, tally);
        nearest(&tools.templates, &found, tally);
    }
}

/// The nearest template, its class and distance.
fn nearest(templates: &Templates<'_>, descriptor: &Descriptor, tally: &mut Tally) {
    let query = descriptor.map(f64::from);
    let distances = templates.iter().map(|t| (numbers::canberra(&query, &t.descriptor().map(f64::from)), t.class()));
    let truth = distances.min_by(|a, b| a.0.total_cmp(&b.0)).expect("a template");
    let found = matching::nearest(templates, descriptor).expect("templates of floats");
    let best = found.first().filter(|h| h.class == truth.1);
    tally.at("matching: nearest class", Float).add_option(best.map(|h| f64::from(h.distance)), Some(truth.0));
}

/// Views at the ends of the range.
pub fn extreme_views(tally: &mut Tally) {
    for view in extremes::views() {
        of_view(&view, tally);
        twin_object::of_view(&view, None, tally);
    }
}

/// What defines the wavelets' filter holds of the truth's own.
pub fn check_the_filter() {
    assert!(numbers::defect_of_the_filter() < 1e-11, "{}", numbers::defect_of_the_filter());
}

/// The Canberra distance between descriptors, up to 58.
pub fn canberra(tally: &mut Tally) {
    let mut random = Random(40);
    let mut all: Vec<Descriptor> = extremes::views()
        .iter()
        .map(|view| descriptor::describe(view, DescriptorKind::Halves, &mut boxed(0.0)))
        .collect();
    let extremes = all.len();
    all.extend((0..60).map(|_| core::array::from_fn(|i| (random.between(-0.2, 1.0) * ((i % 7) as f64)) as f32)));
    for (i, a) in all.iter().enumerate() {
        for (j, b) in all.iter().enumerate() {
            let truth = numbers::canberra(&a.map(f64::from), &b.map(f64::from));
            let float = f64::from(matching::canberra(a, b));
            tally.at("matching: Canberra distance", Float).add(float, truth);
            let codes = [a, b].map(|d| d.map(descriptor::fixed::encode));
            let found = f64::from(matching::fixed::canberra(&codes[0], &codes[1])) / 65_536.0;
            // Magnitudes that no code has count as 0.
            if i.min(j) >= extremes {
                tally.at("matching: Canberra distance", Twins).add(found, float);
            }
            let [a, b] = codes.map(|d| d.map(|code| f64::from(descriptor::fixed::decode(code))));
            tally.at("matching: Canberra distance", Fixed).add(found, numbers::canberra(&a, &b));
        }
    }
}

/// The view of a panel with a smooth pattern, beside the pattern itself, away from the panel's edges.
pub fn pattern(tally: &mut Tally) {
    let camera = analytic::CAMERA;
    let wave = |[s, t]: [f64; 2]| 0.5 + 0.2 * libm::sin(9.0 * s + 1.0) + 0.2 * libm::cos(8.0 * t - 3.0 * s);
    let inside = |[s, t]: [f64; 2], margin: f64| s.abs() < 0.4 - margin && (margin..0.9 - margin).contains(&t);
    for (pitch, roll, centroid) in [(0.3, 0.0, [0.0, 2.0]), (0.45, 0.06, [0.5, 1.8]), (0.25, -0.04, [-0.6, 2.6])] {
        let (axes, truth) = pose(1.2, pitch, roll);
        let level = Frontal::new(truth, camera, centroid, 0.0);
        let (mut n, mut labels) = (boxed::<u16, W, H>(0), boxed::<u16, W, H>(0));
        let (mut bbox, mut seen) = ([u16::MAX, u16::MAX, 0, 0], Vec::new());
        for v in 0..H {
            for u in 0..W {
                let at = level.image_to_plane([u as f64, v as f64]);
                if inside(at, 0.0) {
                    (n[v][u], labels[v][u]) = ((wave(at) * 65535.0 + 0.5) as u16, 5);
                    let (x, y) = (u as u16, v as u16);
                    bbox = [bbox[0].min(x), bbox[1].min(y), bbox[2].max(x), bbox[3].max(y)];
                    seen.push((u, v));
                }
            }
        }
        let to_image = Homography::plane_to_image(&axes, &camera, centroid.map(|v| v as f32)).expect("a plane in view");
        let pixel = 1.0 / camera.fx;
        let frontal = framing::frontal(Framing::Fit, &labels, 5, bbox, &to_image, 1.2, pixel).expect("pixels");
        let mut view: Box<View> = boxed(0);
        warp::warp(&n, &labels, 5, &frontal, &mut view);
        let fitted = Fitted::new(truth, camera, centroid, &seen);
        for (i, found) in fractions(&view).iter().enumerate() {
            let at = fitted.plane_point(i % SIZE, i / SIZE);
            if inside(at, 0.03) {
                tally.at("view: smooth pattern", Float).add(*found, wave(at));
            }
        }
    }
}
