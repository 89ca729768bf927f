//! What one arithmetic has made, in the numbers of the other: so that hosts look at both with the same eyes, and stages of
//! the two can follow each other where one wants to know which of them makes a difference.
//!
//! ```no_run
//! # use pldi_core::pipeline::{FixedParams, Params, QvgaFixedPipeline, QvgaFixedWorkspace, QvgaPipeline, QvgaWorkspace, mix};
//! # use pldi_core::{Frame, Intrinsics, rays};
//! # let params = Params::DEFAULT;
//! # let (camera, depth) = (Intrinsics::KINECT_QVGA, [[2000; 320]; 240]);
//! # let frame = Frame { depth: &depth, colour: None };
//! let float = QvgaPipeline::new(&params, &camera)?;
//! let fixed = QvgaFixedPipeline::new(&FixedParams::new(&params)?, &rays::fixed::Intrinsics::new(&camera)?)?;
//! let (mut a, mut b) = (Box::new(QvgaWorkspace::new()), Box::new(QvgaFixedWorkspace::new()));
//!
//! // The float filter, then everything else in integers.
//! float.reconstruct(&frame, &mut a);
//! mix::depth_to_fixed(&a.images, &mut b.images);
//! let floor = fixed.find_floor(&mut b);
//! # assert_eq!(floor, None);
//! # Ok::<(), pldi_core::Error>(())
//! ```
//!
//! For hosts: this module computes in floats.

use super::{Detection, Fixed, FixedImages, Float, FloatImages, Hypotheses, Report};
use crate::fixed::{METRE, METRE_OF_DEPTH};
use crate::ground::Cluster;
use crate::matching::Hypothesis;
use crate::{descriptor, math};

/// A length in metres.
fn metres(length: i32) -> f32 {
    length as f32 / METRE as f32
}

/// A length in 1/128 mm, rounded to nearest.
fn units(length: f32) -> i32 {
    math::round(length * METRE as f32)
}

/// The reconstructed depth.
pub fn depth_to_float<const W: usize, const H: usize>(from: &FixedImages<W, H>, to: &mut FloatImages<W, H>) {
    for (to, from) in to.depth.as_flattened_mut().iter_mut().zip(from.depth().as_flattened()) {
        *to = f32::from(*from) / METRE_OF_DEPTH as f32;
    }
}

/// The reconstructed depth, rounded to 1/8 mm; beyond 8191.875 mm it saturates.
pub fn depth_to_fixed<const W: usize, const H: usize>(from: &FloatImages<W, H>, to: &mut FixedImages<W, H>) {
    to.set_depth(|u, v| math::round(from.depth[v][u] * METRE_OF_DEPTH as f32).clamp(0, 65_535) as u16);
}

/// Whatever images of the ground and the views are there: those that are not stay as they were.
pub fn images_to_float<const W: usize, const H: usize>(from: &FixedImages<W, H>, to: &mut FloatImages<W, H>) {
    depth_to_float(from, to);
    if let Some(labels) = from.labels() {
        for (to, from) in to.labels.as_flattened_mut().iter_mut().zip(labels.as_flattened()) {
            *to = u16::from(*from);
        }
    }
    if let Some(ground) = from.ground() {
        to.map_labels = *ground.map_labels;
        for (to, from) in to.density.as_flattened_mut().iter_mut().zip(ground.density.as_flattened()) {
            *to = f32::from(*from) / 1024.0;
        }
        to.points.clear();
        // As many fit as there are.
        let _ = to.points.extend_from_slice(ground.points);
    }
    if let Some(views) = from.views() {
        to.n = *views.n;
        for (to, from) in to.coefficients.as_flattened_mut().iter_mut().zip(views.plane.as_flattened()) {
            *to = *from as f32 / (128.0 * 65_535.0);
        }
    }
}

/// A cluster.
pub fn cluster_to_float(from: &Cluster<i32>) -> Cluster {
    Cluster {
        pixels: from.pixels,
        bbox: from.bbox,
        centroid: from.centroid.map(metres),
        top: metres(from.top),
        center: from.center.map(metres),
        size: from.size.map(metres),
        rejection: from.rejection,
    }
}

/// A cluster, rounded to 1/128 mm.
pub fn cluster_to_fixed(from: &Cluster) -> Cluster<i32> {
    Cluster {
        pixels: from.pixels,
        bbox: from.bbox,
        centroid: from.centroid.map(units),
        top: units(from.top),
        center: from.center.map(units),
        size: from.size.map(units),
        rejection: from.rejection,
    }
}

/// The result of a frame.
pub fn report_to_float(from: &Report<Fixed>, to: &mut Report<Float>) {
    to.clear();
    to.floor = from.floor.map(|floor| floor.to_float());
    // All capacities are the same: as many fit as there are.
    for cluster in &from.clusters {
        let _ = to.clusters.push(cluster_to_float(cluster));
    }
    to.contours.clone_from(&from.contours);
    for detection in &from.detections {
        let q16 = |value: u32| value as f32 / 65_536.0;
        let mut hypotheses = Hypotheses::<Float>::new();
        for h in &detection.hypotheses {
            let Hypothesis { class, object, view, .. } = *h;
            let _ = hypotheses.push(Hypothesis { class, object, view, distance: q16(h.distance), score: q16(h.score) });
        }
        let _ = to.detections.push(Detection {
            cluster: detection.cluster,
            descriptor: detection.descriptor.map(descriptor::fixed::decode),
            hypotheses,
        });
    }
}

/// The labels of clusters, and N: what views are made of. `to` must hold the depth already.
pub fn views_to_fixed<const W: usize, const H: usize>(from: &FloatImages<W, H>, to: &mut FixedImages<W, H>) {
    if let Some(gallery) = to.gallery() {
        for (to, from) in gallery.labels.as_flattened_mut().iter_mut().zip(from.labels.as_flattened()) {
            *to = u8::try_from(*from).unwrap_or(0);
        }
        *gallery.n = from.n;
    }
}
