//! One object in integers beside the same in floats: view, wavelets, descriptors, nearest templates.

use crate::errors::Tally;
use crate::inputs::views;
use crate::oracle::numbers;
use crate::rows::Pair::Twins;
use crate::stages::twins::{Pipelines, compare_n, floors};
use crate::stages::{Tools, boxed};
use pldi_core::descriptor::{self, Descriptor, DescriptorKind, View, fixed};
use pldi_core::floor::{FloorMode, fixed::Floor as FixedFloor};
use pldi_core::matching::{self, Hypothesis};
use pldi_core::pipeline::mix;
use pldi_core::reconstruct::FilterKind;
use pldi_core::templates::Templates;
use pldi_core::wavelet::{self, Plane, fixed::Plane as FixedPlane};
use pldi_core::{Floor, wavelet::fixed::SHIFT};

/// A cluster of the float report: the view of the same pixels with the same N, then what follows from the same view.
pub fn measure(
    pipelines: &Pipelines,
    cluster: usize,
    floors: (&FixedFloor, &Floor),
    tools: &mut Tools,
    tally: &mut Tally,
) {
    let (float, fixed) = (&mut tools.workspace, &mut tools.fixed);
    if pipelines.float.frame_view(cluster, floors.1, float).is_none() {
        return;
    }
    mix::views_to_fixed(&float.images, &mut fixed.images);
    fixed.report.clusters.clear();
    fixed.report.clusters.extend(float.report.clusters.iter().map(mix::cluster_to_fixed));
    let seen = pipelines.fixed.frame_view(cluster, floors.0, fixed);
    let errors = tally.at("view: sampling", Twins);
    let Some((views, ())) = fixed.images.views().zip(seen) else {
        errors.decide(false);
        return;
    };
    for (found, float) in views.plane.as_flattened().iter().zip(float.images.view.as_flattened()) {
        errors.add(f64::from(*found) / f64::from(65_535 << SHIFT), f64::from(*float) / 65535.0);
    }
    let view: Box<View> = Box::new(float.images.view);
    of_view(&view, Some(&[tools.templates, tools.codes]), tally);
}

/// Wavelets, descriptors and nearest templates (of floats and of codes) of the same view. Without templates its numbers are
/// compared as they are.
pub fn of_view(view: &View, templates: Option<&[Templates<'_>; 2]>, tally: &mut Tally) {
    let (mut float, mut fixed) = (boxed::<f32, 128, 128>(0.0), boxed::<i32, 128, 128>(0));
    let planes = float.as_flattened_mut().iter_mut().zip(fixed.as_flattened_mut());
    for ((float, fixed), n) in planes.zip(view.as_flattened()) {
        (*float, *fixed) = (f32::from(*n) / 65535.0, i32::from(*n) << SHIFT);
    }
    let (float, fixed): (&mut Plane, &mut FixedPlane) = (&mut float, &mut fixed);
    wavelet::transform(float);
    wavelet::fixed::transform(fixed);
    let errors = tally.at("wavelet: coefficients", Twins);
    for (found, float) in fixed.as_flattened().iter().zip(float.as_flattened()) {
        errors.add(f64::from(*found) / f64::from(65_535 << SHIFT), f64::from(*float));
    }
    let kinds = [
        (["descriptor: paper", "descriptor: paper, numbers"], DescriptorKind::Paper),
        (["descriptor: halves", "descriptor: halves, numbers"], DescriptorKind::Halves),
    ];
    for ([canberra, absolute], kind) in kinds {
        let truth = descriptor::from_coefficients(float, kind);
        let found = descriptor::fixed::from_coefficients(fixed, kind);
        let Some(templates) = templates else {
            tally.at(absolute, Twins).add_all(&found.map(fixed::decode), &truth.map(f64::from));
            continue;
        };
        tally.at(canberra, Twins).add(apart(&found.map(fixed::decode), &truth), 0.0);
        if kind == DescriptorKind::Halves {
            nearest(&truth, templates, tally);
        }
    }
}

/// The Canberra distance in float64.
fn apart(a: &Descriptor, b: &Descriptor) -> f64 {
    numbers::canberra(&a.map(f64::from), &b.map(f64::from))
}

/// The nearest template to the same descriptor.
fn nearest(query: &Descriptor, [floats, codes]: &[Templates<'_>; 2], tally: &mut Tally) {
    let float = matching::nearest(floats, query).expect("templates of floats");
    let fixed = matching::fixed::nearest(codes, &query.map(fixed::encode)).expect("templates of codes");
    let (Some(float), Some(fixed)) = (float.first(), fixed.first()) else { panic!("there are templates") };
    let errors = tally.at("matching: nearest class", Twins);
    let distance = f64::from(fixed.distance) / 65_536.0;
    errors.add_option((fixed.class == float.class).then_some(distance), Some(f64::from(float.distance)));
}

/// What came out at the end: descriptor and hypotheses in floats and, converted, in integers.
pub fn answer(float: (&Descriptor, &[Hypothesis]), fixed: (&Descriptor, &[Hypothesis]), tally: &mut Tally) {
    tally.at("pipeline: descriptor", Twins).add(apart(float.0, fixed.0), 0.0);
    let (Some(a), Some(b)) = (float.1.first(), fixed.1.first()) else { panic!("there are templates") };
    let same = (a.class == b.class).then_some(f64::from(b.distance));
    tally.at("pipeline: nearest class", Twins).add_option(same, Some(f64::from(a.distance)));
}

/// All rendered views of an object, by their masks.
pub fn rendered(view: &views::View, tools: &mut Tools, tally: &mut Tally) {
    let floor = Floor::from_pose(view.camera.height, view.camera.pitch, view.camera.roll).expect("a pose");
    let (integers, floats) = floors(&floor);
    let pipelines = Pipelines::new(FilterKind::None, FloorMode::Fixed(floor), &views::CAMERA);
    for (z, depth) in tools.workspace.images.depth.as_flattened_mut().iter_mut().zip(&view.depth) {
        *z = f32::from(*depth) / 8000.0;
    }
    tools.fixed.images.set_depth(|u, v| view.depth[v * crate::inputs::W + u]);
    let float = pipelines.float.describe_mask(&floats, |_, _| true, &mut tools.workspace);
    let fixed = pipelines.fixed.describe_mask(&integers, |_, _| true, &mut tools.fixed);
    compare_n(tools, tally.at("diffusion: N", Twins), |label| label > 0);
    let errors = tally.at("pipeline: descriptor", Twins);
    let (Some(float), Some(fixed)) = (float, fixed) else {
        errors.decide(float.is_none() && fixed.is_none());
        return;
    };
    let a = matching::nearest(&tools.templates, &float).expect("templates of floats");
    let b = matching::fixed::nearest(&tools.codes, &fixed).expect("templates of codes");
    let b: Vec<Hypothesis> = b
        .iter()
        .map(|h| Hypothesis {
            class: h.class,
            object: h.object,
            view: h.view,
            distance: h.distance as f32 / 65_536.0,
            score: h.score as f32 / 65_536.0,
        })
        .collect();
    answer((&float, &a), (&fixed.map(fixed::decode), &b), tally);
    measure(&pipelines, 0, (&integers, &floats), tools, tally);
}
