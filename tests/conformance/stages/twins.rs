//! The pipeline in integers beside that in floats: all the way on the same frame, and each stage on the same input.

use crate::errors::{Errors, Tally};
use crate::inputs::{H, Scene, W};
use crate::rows::Pair::Twins;
use crate::stages::clusters::Clusters;
use crate::stages::frame::{N_STEP, fraction};
use crate::stages::{Tools, twin_object};
use pldi_core::floor::FloorMode;
use pldi_core::pipeline::{
    FixedParams, Params, QvgaFixedPipeline, QvgaFixedWorkspace, QvgaPipeline, QvgaWorkspace, Report, mix,
};
use pldi_core::reconstruct::{FilterKind, FilterParams};
use pldi_core::{Error, Fixed, Floor, Frame, Intrinsics, floor, rays};

/// The two pipelines for the same parameters and the same camera.
pub struct Pipelines {
    /// In floats.
    pub float: QvgaPipeline,
    /// In integers.
    pub fixed: QvgaFixedPipeline,
}

impl Pipelines {
    /// For a filter, a floor that is known or searched for, and a camera.
    pub fn new(kind: FilterKind, floor: FloorMode, camera: &Intrinsics) -> Self {
        let params = Params { filter: FilterParams { kind, ..FilterParams::DEFAULT }, floor, ..Params::DEFAULT };
        let fixed = FixedParams::new(&params).expect("parameters within the ranges");
        let integers = rays::fixed::Intrinsics::new(camera).expect("a camera within the ranges");
        Self {
            float: QvgaPipeline::new(&params, camera).expect("a camera within the ranges"),
            fixed: QvgaFixedPipeline::new(&fixed, &integers).expect("a camera within the ranges"),
        }
    }
}

/// A floor in integers, and in the floats that are exactly it, as far as floats go.
pub fn floors(float: &Floor) -> (floor::fixed::Floor, Floor) {
    let fixed = floor::fixed::Floor::new(float).expect("a floor within the ranges");
    (fixed, fixed.to_float())
}

/// All of it on one frame.
pub fn measure(scene: &Scene, tools: &mut Tools, tally: &mut Tally) {
    let frame = Frame::new(&scene.depth, scene.colour.as_deref()).expect("a frame");
    let known = scene.pose.filter(|_| !scene.shows_floor);
    let known = known.map(|[height, pitch, roll]| Floor::from_pose(height, pitch, roll).expect("a pose"));
    let pipelines =
        Pipelines::new(FilterKind::Joint, known.map_or_else(FloorMode::default, FloorMode::Fixed), &scene.camera);
    if scene.stride > 0 {
        let depth_alone = Pipelines::new(FilterKind::Bilateral, FloorMode::default(), &scene.camera);
        depth_alone.float.reconstruct(&frame, &mut tools.workspace);
        depth_alone.fixed.reconstruct(&frame, &mut tools.fixed);
        depths(tools, tally.at("reconstruct: bilateral", Twins));
    }
    whole(&pipelines, &frame, tools, tally);
    mix::depth_to_float(&tools.fixed.images, &mut tools.workspace.images);
    let found = search(&pipelines, known.is_none(), tools, tally);
    if let Some(floor) = found {
        stages(&pipelines, &floor, tools, tally);
    }
}

/// From the frame to the answers.
fn whole(pipelines: &Pipelines, frame: &Frame<'_, W, H>, tools: &mut Tools, tally: &mut Tally) {
    let Pipelines { float, fixed } = pipelines;
    float.reconstruct(frame, &mut tools.workspace);
    fixed.reconstruct(frame, &mut tools.fixed);
    depths(tools, tally.at("reconstruct: joint", Twins));
    // What lies beyond the integers' range is a plane at its end for both.
    let filtered = Box::new(tools.workspace.images.depth);
    let far = f32::from(u16::MAX) / 8000.0;
    tools.workspace.images.depth.as_flattened_mut().iter_mut().for_each(|z| *z = z.min(far));
    float.diffuse_all(&mut tools.workspace);
    fixed.diffuse_all(&mut tools.fixed);
    compare_n(tools, tally.at("pipeline: N", Twins), |_| true);
    tools.workspace.images.depth = *filtered;

    let results =
        (float.recognise(&tools.templates, &mut tools.workspace), fixed.recognise(&tools.codes, &mut tools.fixed));
    let (a, b) = (&tools.workspace, &tools.fixed);
    let floors = (a.report.floor, b.report.floor.map(|floor| floor.to_float()));
    add_floors(tally.at("pipeline: floor", Twins), floors.0, floors.1);
    if let (Some(_), Some(_)) = floors {
        // More than there is room for: in both or in neither.
        let full = |result: &Result<(), Error>| matches!(result, Err(Error::Capacity(_)));
        assert!([&results.0, &results.1].into_iter().all(|result| result.is_ok() || full(result)), "{results:?}");
        if full(&results.0) || full(&results.1) {
            tally.at("pipeline: clusters", Twins).decide(full(&results.0) && full(&results.1));
        } else {
            let errors = tally.at("pipeline: clusters", Twins);
            let same = Clusters::fixed(b).compare(&Clusters::float(a), errors);
            candidates_n(tools, &same, tally.at("pipeline: N of candidates", Twins));
            answers(&tools.workspace, &tools.fixed, &same, tally);
        }
    }
}

/// Depths, that in floats cut where the integers end. 1 mm counts as another depth.
fn depths(tools: &Tools, errors: &mut Errors) {
    let valid = |z: f64| (z > 0.0).then_some(z);
    let found = tools.fixed.images.depth().as_flattened();
    for (found, float) in found.iter().zip(tools.workspace.images.depth.as_flattened()) {
        let float = f64::from(*float).min(f64::from(u16::MAX) / 8000.0);
        errors.add_within(valid(f64::from(*found) / 8000.0), valid(float), 1e-3);
    }
}

/// N of the pixels that belong to the same candidate in both.
fn candidates_n(tools: &Tools, pairs: &[(usize, usize)], errors: &mut Errors) {
    let (float, fixed) = (&tools.workspace, &tools.fixed);
    let candidates = pairs.iter().filter(|(i, j)| {
        float.report.clusters[*i].rejection.is_none() && fixed.report.clusters[*j].rejection.is_none()
    });
    // Labels, from 1, of the candidate in integers for each in floats.
    let mut partner = vec![0; float.report.clusters.len() + 1];
    candidates.for_each(|(i, j)| partner[i + 1] = j + 1);
    let (Some(views), Some(labels)) = (fixed.images.views(), fixed.images.labels()) else { panic!("N was computed") };
    let a = float.images.labels.as_flattened().iter().zip(float.images.n.as_flattened());
    let b = labels.as_flattened().iter().zip(views.n.as_flattened());
    for ((label, float), (other, fixed)) in a.zip(b) {
        if *other > 0 && partner[usize::from(*label)] == usize::from(*other) {
            errors.add_within(fraction(*fixed), fraction(*float), N_STEP);
        }
    }
}

/// N of the pixels that have depth, where `wanted` holds of their label.
pub fn compare_n(tools: &Tools, errors: &mut Errors, wanted: impl Fn(u8) -> bool) {
    let fixed = &tools.fixed.images;
    let (Some(views), Some(labels)) = (fixed.views(), fixed.labels()) else { panic!("N was computed") };
    let float = tools.workspace.images.n.as_flattened();
    let pixels = fixed.depth().as_flattened().iter().zip(labels.as_flattened());
    for ((found, float), (depth, label)) in views.n.as_flattened().iter().zip(float).zip(pixels) {
        if *depth > 0 && wanted(*label) {
            // A surface seen edge-on has an N of about 0, which rounding makes none or some.
            let edge_on = |n: u16| f64::from(n) / 65535.0 < N_STEP;
            let value = |n: u16, other: u16| fraction(n).or((edge_on(n) && edge_on(other)).then_some(0.0));
            errors.add_within(value(*found, *float), value(*float, *found), N_STEP);
        }
    }
}

fn add_floors(errors: &mut Errors, float: Option<Floor>, fixed: Option<Floor>) {
    match (float, fixed) {
        (Some(float), Some(fixed)) => {
            errors.add_all(&fixed.normal, &float.normal.map(f64::from));
            errors.add(f64::from(fixed.height), f64::from(float.height));
        }
        (float, fixed) => errors.decide(float.is_none() && fixed.is_none()),
    }
}

/// The floor that the stages after it are measured with: that in floats, rounded. Where it is searched for, the searches are
/// compared.
fn search(pipelines: &Pipelines, searched: bool, tools: &mut Tools, tally: &mut Tally) -> Option<Floor> {
    let float = pipelines.float.find_floor(&mut tools.workspace);
    let fixed = pipelines.fixed.find_floor(&mut tools.fixed);
    if searched {
        add_floors(tally.at("floor: search", Twins), float, fixed.map(|floor| floor.to_float()));
    }
    float
}

/// The stages after the floor, each on what the float stages gave.
fn stages(pipelines: &Pipelines, floor: &Floor, tools: &mut Tools, tally: &mut Tally) {
    let (integers, floats) = floors(floor);
    let results = [
        pipelines.float.find_candidates(&floats, &mut tools.workspace),
        pipelines.fixed.find_candidates(&integers, &mut tools.fixed),
    ];
    density(tools, tally.at("ground: density", Twins));
    if results.iter().all(Result::is_ok) {
        let float = Clusters::float(&tools.workspace);
        Clusters::fixed(&tools.fixed).compare(&float, tally.at("ground: clusters", Twins));
    } else {
        tally.at("ground: clusters", Twins).decide(results.iter().all(Result::is_err));
        tools.workspace.report.clusters.clear();
    }
    pipelines.float.diffuse_all(&mut tools.workspace);
    pipelines.fixed.diffuse_all(&mut tools.fixed);
    compare_n(tools, tally.at("diffusion: N", Twins), |_| true);
    pipelines.float.diffuse_candidates(&mut tools.workspace);
    for i in 0..tools.workspace.report.clusters.len() {
        if tools.workspace.report.clusters[i].rejection.is_none() {
            twin_object::measure(pipelines, i, (&integers, &floats), tools, tally);
        }
    }
}

/// Densities, those in floats cut where the integers end; occupied in one and not in the other counts.
fn density(tools: &Tools, errors: &mut Errors) {
    let ground = tools.fixed.images.ground().expect("the ground map was made");
    let float = tools.workspace.images.density.as_flattened();
    for (found, float) in ground.density.as_flattened().iter().zip(float) {
        let found = f64::from(*found) / 1024.0;
        let float = f64::from(*float).min(f64::from(u16::MAX) / 1024.0);
        errors.add(found, float);
        errors.decide((found >= 1.0) == (float >= 1.0));
    }
}

/// Descriptors and nearest classes of the clusters that are candidates in both.
fn answers(float: &QvgaWorkspace, fixed: &QvgaFixedWorkspace, pairs: &[(usize, usize)], tally: &mut Tally) {
    let mut report = Report::new();
    let integers: &Report<Fixed> = &fixed.report;
    mix::report_to_float(integers, &mut report);
    for (i, j) in pairs {
        let find = |report: &Report, cluster: usize| {
            report.detections.iter().find(|d| usize::from(d.cluster) == cluster).cloned()
        };
        if let (Some(a), Some(b)) = (find(&float.report, *i), find(&report, *j)) {
            twin_object::answer((&a.descriptor, &a.hypotheses), (&b.descriptor, &b.hypotheses), tally);
        }
    }
}
