//! Whatever the input: no panic, and nothing left over from the frame before.

mod common;

use common::{BENCH, CHAIR, CHEST, Random, Room, with_stack};
use pldi_core::descriptor::DescriptorKind;
use pldi_core::floor::{FloorMode, RansacParams};
use pldi_core::ground::Limits;
use pldi_core::reconstruct::{FilterKind, FilterParams};
use pldi_core::templates::Templates;
use pldi_core::view::{Framing, ViewParams};
use pldi_core::{Error, Float, Floor, Frame, Intrinsics, Params, Pipeline, Workspace};
use proptest::prelude::*;
use proptest::test_runner::TestRunner;

const W: usize = 64;
const H: usize = 48;
type Small = Workspace<Float, W, H>;

/// A template file without templates.
fn empty(view: &ViewParams) -> Vec<u8> {
    common::pldt::file(view, &[])
}

/// Any camera that is not refused.
fn camera() -> impl Strategy<Value = Intrinsics> {
    let focal = || prop_oneof![4 => 0.8f32..1.2, 1 => 0.11f32..99.0];
    let centre = || prop_oneof![4 => 0.4f32..0.6, 1 => -0.99f32..1.99];
    (focal(), focal(), centre(), centre()).prop_map(|(fx, fy, cx, cy)| Intrinsics {
        width: W as u16,
        height: H as u16,
        fx: fx * W as f32,
        fy: fy * H as f32,
        cx: cx * W as f32,
        cy: cy * H as f32,
    })
}

/// Any depth and colour: noise, rooms, rooms with wrong pixels.
fn images() -> impl Strategy<Value = (Vec<u16>, Option<Vec<u8>>)> {
    let camera = Intrinsics { width: 64, height: 48, fx: 60.0, fy: 60.0, cx: 31.5, cy: 23.5 };
    (any::<u64>(), 0..6u8, 0.0f64..1.0, any::<bool>()).prop_map(move |(seed, kind, wrong, coloured)| {
        let mut random = Random(seed);
        let object = [CHEST, CHAIR, BENCH][random.bits() as usize % 3];
        let mut between = |a, b| random.between(a, b);
        let (height, pitch, wall) = (between(0.3, 2.0), between(-0.3, 1.2), between(1.0, 5.0));
        let (at, noise) = ([between(-1.0, 1.0), between(0.5, 4.0)], between(0.0, 0.02));
        let mut shot = Room { height, pitch, wall, at, object, noise }.shoot(&camera, seed);
        let share = match kind {
            0 => 1.0,
            1 | 2 => 0.2 * wrong,
            _ => 0.0,
        };
        for depth in &mut shot.depth {
            if random.unit() < share {
                *depth = random.bits() as u16 >> (random.bits() % 8);
            }
        }
        if kind == 3 {
            shot.colour.iter_mut().for_each(|c| *c = random.bits() as u8);
        }
        (shot.depth, coloured.then_some(shot.colour))
    })
}

fn floor() -> impl Strategy<Value = FloorMode> {
    let pose = (0.011f32..10.0, -1.57f32..1.57, -1.57f32..1.57);
    prop_oneof![
        pose.prop_map(|(h, p, r)| FloorMode::Fixed(Floor::from_pose(h, p, r).unwrap())),
        (0.3f32..2.0, 0.0f32..1.0).prop_map(|(h, p)| FloorMode::Fixed(Floor::from_pose(h, p, 0.0).unwrap())),
        (any::<u32>(), 1u16..400, 0.0f32..1.0).prop_map(|(seed, samples, support)| FloorMode::Ransac(RansacParams {
            seed,
            samples,
            support: support * support * support,
            ..RansacParams::DEFAULT
        })),
    ]
}

/// Parameters within their ranges; half of them let every cluster through.
fn params() -> impl Strategy<Value = Params> {
    let filter = prop_oneof![
        9 => Just(FilterKind::Joint),
        6 => Just(FilterKind::Bilateral),
        4 => Just(FilterKind::None),
        1 => Just(FilterKind::Exact),
    ];
    let sigmas = (0.5f32..30.0, 1.0f32..1000.0, 0.001f32..0.25, 1u8..=5, 1e-6f32..0.9);
    let view = (any::<bool>(), prop_oneof![Just(None), (0.1f32..10.0).prop_map(Some)], 0.005f32..0.3);
    (filter, sigmas, floor(), any::<bool>(), 0.0f32..3.0, view).prop_map(|(kind, s, floor, lax, threshold, view)| {
        let d = Params::DEFAULT;
        let (sigma_space, sigma_colour, sigma_depth, iterations, weight_floor) = s;
        let descriptor = if view.0 { DescriptorKind::Paper } else { DescriptorKind::Halves };
        let framing = view.1.map_or(Framing::Fit, |side| Framing::Metric { side });
        let open = Limits { min_pixels: 0, area: (0.0, 1e4), length: (0.0, 1e4), min_top: 0.0, margin: 0, ..d.limits };
        Params {
            filter: FilterParams { kind, sigma_space, sigma_colour, sigma_depth, iterations, weight_floor },
            floor,
            density: pldi_core::ground::DensityParams { threshold, ..d.density },
            limits: if lax { Limits { max_occluded: 1.0, ..open } } else { d.limits },
            view: ViewParams { descriptor, framing, radius: view.2 },
            ..d
        }
    })
}

/// A frame's report, every bit of it (numbers are printed so that they read back as the same).
fn run(
    pipeline: &Pipeline<Float, W, H>,
    images: &(Vec<u16>, Option<Vec<u8>>),
    workspace: &mut Small,
) -> Result<String, Error> {
    let file = empty(&pipeline.params().view);
    let frame = Frame::new(&images.0, images.1.as_deref()).unwrap();
    pipeline.run(&frame, &Templates::parse(&file).unwrap(), workspace)?;
    Ok(format!("{:?}", workspace.report))
}

/// Bits of the images that a frame leaves behind.
fn left_behind(workspace: &Small) -> Vec<u32> {
    let mut out: Vec<u32> = workspace.images.depth.as_flattened().iter().map(|z| z.to_bits()).collect();
    if workspace.report.floor.is_some() {
        out.extend(
            workspace
                .images
                .labels
                .as_flattened()
                .iter()
                .chain(workspace.images.n.as_flattened())
                .map(|v| u32::from(*v)),
        );
        out.extend(
            workspace
                .images
                .counts
                .as_flattened()
                .iter()
                .chain(workspace.images.density.as_flattened())
                .map(|v| v.to_bits()),
        );
        out.extend(workspace.images.map_labels.as_flattened().iter().map(|v| u32::from(*v)));
    }
    if !workspace.report.detections.is_empty() {
        out.extend(workspace.images.view.as_flattened().iter().map(|v| u32::from(*v)));
        out.extend(workspace.images.coefficients.as_flattened().iter().map(|v| v.to_bits()));
    }
    out
}

/// Runs a property on many inputs, on a large stack.
fn check<S>(cases: u32, inputs: S, mut property: impl FnMut(S::Value) + Send + 'static)
where
    S: Strategy + Send + 'static,
{
    with_stack(move || {
        let config = ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() };
        let seed = proptest::test_runner::TestRng::deterministic_rng(config.rng_algorithm);
        let mut runner = TestRunner::new_with_rng(config, seed);
        let property = std::cell::RefCell::new(&mut property);
        let result = runner.run(&inputs, |input| {
            (property.borrow_mut())(input);
            Ok(())
        });
        if let Err(error) = result {
            panic!("{error}");
        }
    });
}

#[test]
fn no_frame_makes_the_pipeline_panic() {
    let mut workspace = Box::new(Small::new());
    let (mut found, mut full) = (0, 0);
    check(120, (images(), camera(), params()), move |(images, camera, params)| {
        let pipeline = Pipeline::new(&params, &camera).unwrap();
        match run(&pipeline, &images, &mut workspace) {
            Ok(_) => found += workspace.report.detections.len(),
            Err(Error::Capacity(_)) => full += 1,
            Err(other) => panic!("{other}"),
        }
        assert!(workspace.images.depth.as_flattened().iter().all(|z| z.is_finite() && *z >= 0.0));
        for detection in &workspace.report.detections {
            assert!(detection.descriptor.iter().all(|v| v.is_finite()), "{:?}", detection.descriptor);
            assert!(detection.hypotheses.is_empty());
        }
        // The calls that `run` does not make.
        pipeline.diffuse_all(&mut workspace);
        let floor = Floor::from_pose(1.0, 0.3, 0.0).unwrap();
        let described = pipeline.describe_mask(&floor, |u, v| (u ^ v) % 3 > 0, &mut workspace);
        assert!(described.is_none_or(|d| d.iter().all(|v| v.is_finite())));
        println!("{found} candidates, {full} frames with too many");
    });
}

#[test]
fn nothing_is_left_over_from_the_frame_before() {
    let mut used = Box::new(Small::new());
    let camera = Intrinsics { width: 64, height: 48, fx: 60.0, fy: 60.0, cx: 31.5, cy: 23.5 };
    check(70, (images(), images(), params()), move |(a, b, params)| {
        let pipeline = Pipeline::new(&params, &camera).unwrap();
        let mut fresh = Box::new(Small::new());
        let alone = run(&pipeline, &b, &mut fresh);
        // `used` has seen all cases before, then A twice.
        let once = run(&pipeline, &a, &mut used);
        assert_eq!(once, run(&pipeline, &a, &mut used));
        assert_eq!(alone, run(&pipeline, &b, &mut used));
        if alone.is_ok() {
            assert!(left_behind(&fresh) == left_behind(&used), "the images differ");
        }
    });
}
