//! The pipeline in integers on frames that no sensor gives: nothing may overflow (tests run with overflow checks), and whole
//! frames and rows must agree.

mod common;

use pldi_core::floor::FloorMode;
use pldi_core::frame::{DepthRange, QVGA_HEIGHT as H, QVGA_WIDTH as W};
use pldi_core::ground::Limits;
use pldi_core::pipeline::{FixedParams, Params, QvgaFixedPipeline, QvgaFixedWorkspace};
use pldi_core::reconstruct::fixed::{ColourRow, DepthRow};
use pldi_core::reconstruct::{FilterKind, FilterParams};
use pldi_core::view::{Framing, ViewParams};
use pldi_core::{Error, Floor, Frame, Image, Intrinsics, rays};

type Depth = Box<Image<u16, W, H>>;
type Colour = Box<Image<[u8; 3], W, H>>;

fn depth_of(f: impl FnMut(usize, usize) -> u16) -> Depth {
    let mut f = f;
    let rows: Vec<[u16; W]> = (0..H).map(|v| core::array::from_fn(|u| f(u, v))).collect();
    rows.into_boxed_slice().try_into().unwrap()
}

fn colour_of(f: impl FnMut(usize, usize) -> [u8; 3]) -> Colour {
    let mut f = f;
    let rows: Vec<[[u8; 3]; W]> = (0..H).map(|v| core::array::from_fn(|u| f(u, v))).collect();
    rows.into_boxed_slice().try_into().unwrap()
}

fn depths() -> Vec<Depth> {
    let mut random = common::Random(5);
    let mut all = Vec::new();
    for value in [0, 1, 40, 500, 4000, 8191, 8192, 9999, 10_000, u16::MAX] {
        all.push(depth_of(|_, _| value));
    }
    for (a, b) in [(0, 4000), (1, u16::MAX), (1, 8191), (2000, 2001), (0, 1)] {
        all.push(depth_of(|u, v| if (u + v) % 2 == 0 { a } else { b }));
        all.push(depth_of(|u, v| if (u / 9 + v / 7) % 2 == 0 { a } else { b }));
    }
    all.push(depth_of(|_, _| random.bits() as u16));
    all.push(depth_of(|_, _| (random.bits() % 4000) as u16));
    // Everything near: the largest windows of the normals.
    all.push(depth_of(|u, v| 41 + ((u ^ v) % 5) as u16));
    all
}

fn settings() -> Vec<(Params, Intrinsics)> {
    let kinect = Intrinsics::KINECT_QVGA;
    let floor = |height, pitch| FloorMode::Fixed(Floor::from_pose(height, pitch, 0.1).unwrap());
    let wide = Intrinsics { fx: 32.0, fy: 24.0, cx: 640.0, cy: -240.0, ..kinect };
    let long = Intrinsics { fx: 32_000.0, fy: 24_000.0, cx: -320.0, cy: 480.0, ..kinect };
    let loose =
        Limits { min_pixels: 0, area: (0.0, 1e4), length: (0.0, 1e4), min_top: 0.0, margin: 0, ..Limits::DEFAULT };
    let filter = FilterParams {
        sigma_space: 100.0,
        sigma_colour: 1000.0,
        sigma_depth: 0.25,
        iterations: 5,
        ..FilterParams::DEFAULT
    };
    let view = ViewParams { framing: Framing::Metric { side: 10.0 }, radius: 0.5, ..ViewParams::DEFAULT };
    vec![
        (Params::DEFAULT, kinect),
        (Params { floor: floor(1.0, 0.4), limits: loose, ..Params::DEFAULT }, kinect),
        (
            Params {
                floor: floor(10.0, 1.5),
                limits: loose,
                range: DepthRange { min: 1, max: u16::MAX },
                ..Params::DEFAULT
            },
            wide,
        ),
        (Params { floor: floor(0.01, -1.5), limits: loose, filter, ..Params::DEFAULT }, long),
        (
            Params {
                floor: floor(0.5, 0.0),
                limits: loose,
                view,
                filter: FilterParams { kind: FilterKind::None, ..filter },
                ..Params::DEFAULT
            },
            wide,
        ),
    ]
}

#[test]
fn nothing_overflows() {
    common::with_stack(|| {
        let mut random = common::Random(9);
        let noise = colour_of(|_, _| core::array::from_fn(|_| random.bits() as u8));
        let checks = colour_of(|u, v| if (u + v) % 2 == 0 { [0; 3] } else { [255; 3] });
        let mut workspace = Box::new(QvgaFixedWorkspace::new());
        let mut described = 0;
        for (i, (params, camera)) in settings().into_iter().enumerate() {
            let params = FixedParams::new(&params).unwrap();
            let camera = rays::fixed::Intrinsics::new(&camera).unwrap();
            let pipeline = QvgaFixedPipeline::new(&params, &camera).unwrap();
            // With normals of half a metre, or a lens that fills the image with 4 cm, a frame takes seconds: a few have to do.
            let slow = params.view.radius > 1000 || camera.fx > 1000 << 16;
            let step = if slow { 7 } else { 1 };
            for (k, depth) in depths().iter().enumerate().step_by(step) {
                let colour = [None, Some(&*noise), Some(&*checks)][(i + k) % 3];
                pipeline.reconstruct(&Frame { depth, colour }, &mut workspace);
                let Some(floor) = pipeline.find_floor(&mut workspace) else { continue };
                match pipeline.find_candidates(&floor, &mut workspace) {
                    Ok(()) | Err(Error::Capacity(_)) => {}
                    Err(error) => panic!("{error}"),
                }
                pipeline.diffuse_candidates(&mut workspace);
                for cluster in 0..workspace.report.clusters.len().min(12) {
                    described += usize::from(pipeline.describe(cluster, &floor, &mut workspace).is_some());
                }
                let whole = pipeline.describe_mask(&floor, |u, v| (u + v) % 3 > 0, &mut workspace);
                described += usize::from(whole.is_some());
            }
        }
        assert!(described > 60, "{described}");
    });
}

#[test]
fn rows_and_whole_frames_leave_the_same_bits() {
    common::with_stack(|| {
        let mut random = common::Random(3);
        let depth = depth_of(|u, v| if random.bits().is_multiple_of(5) { 0 } else { (800 + 3 * u + 5 * v) as u16 });
        let colour = colour_of(|u, v| [(u / 3) as u8, v as u8, (u * v / 300) as u8]);
        let camera = rays::fixed::Intrinsics::new(&Intrinsics::KINECT_QVGA).unwrap();
        let pipeline = QvgaFixedPipeline::new(&FixedParams::new(&Params::DEFAULT).unwrap(), &camera).unwrap();
        let (mut whole, mut rows) = (Box::new(QvgaFixedWorkspace::new()), Box::new(QvgaFixedWorkspace::new()));
        pipeline.reconstruct(&Frame { depth: &depth, colour: Some(&colour) }, &mut whole);
        // A frame that is given up half-way leaves nothing behind.
        pipeline.begin(&mut rows);
        for _ in 0..100 {
            pipeline.push(DepthRow::Millimetres(&[7; W]), None, &mut rows).unwrap();
        }
        assert!(matches!(pipeline.finish(&mut rows), Err(Error::PixelCount { .. })));
        pipeline.begin(&mut rows);
        for (depth, colour) in depth.iter().zip(colour.iter()) {
            let colour = [colour.as_flattened()];
            pipeline.push(DepthRow::Millimetres(depth), Some(ColourRow::Rgb888(&colour)), &mut rows).unwrap();
        }
        pipeline.finish(&mut rows).unwrap();
        assert_eq!(whole.images.depth(), rows.images.depth());
    });
}
