//! The whole pipeline at 640x480, and with template files made on the spot.

mod common;

use common::pldt::file;
use common::{BENCH, Block, CHAIR, CHEST, Room, with_stack};
use pldi_core::descriptor::{Descriptor, DescriptorKind};
use pldi_core::floor::{FloorMode, RansacParams};
use pldi_core::ground::Cluster;
use pldi_core::templates::Templates;
use pldi_core::view::{Framing, ViewParams};
use pldi_core::{Error, Float, Floor, Frame, Intrinsics, Params, Pipeline, TemplateError, Workspace};

const VGA: Intrinsics = Intrinsics { width: 640, height: 480, fx: 525.0, fy: 525.0, cx: 319.0, cy: 239.0 };
const HEIGHT: f32 = 1.1;
const PITCH: f32 = 0.4;

fn room(object: &[Block], at: [f64; 2], noise: f64) -> Room<'_> {
    Room { height: f64::from(HEIGHT), pitch: f64::from(PITCH), wall: 3.6, at, object, noise }
}

/// The candidates of a room, and their descriptors.
fn candidates<const W: usize, const H: usize>(
    room: &Room<'_>,
    camera: &Intrinsics,
    floor: FloorMode,
    seed: u64,
) -> Vec<(Cluster, Descriptor)> {
    let pipeline = Pipeline::<Float, W, H>::new(&Params { floor, ..Params::DEFAULT }, camera).unwrap();
    let mut workspace = Box::new(Workspace::<Float, W, H>::new());
    let shot = room.shoot(camera, seed);
    let empty = file(&ViewParams::DEFAULT, &[]);
    let frame = Frame::new(&shot.depth, Some(&shot.colour)).unwrap();
    pipeline.run(&frame, &Templates::parse(&empty).unwrap(), &mut workspace).unwrap();
    let report = &workspace.report;
    report.detections.iter().map(|d| (report.clusters[usize::from(d.cluster)], d.descriptor)).collect()
}

fn fixed() -> FloorMode {
    FloorMode::Fixed(Floor::from_pose(HEIGHT, PITCH, 0.0).unwrap())
}

#[test]
fn a_chest_has_its_size_and_place_at_vga_and_at_qvga() {
    with_stack(|| {
        let qvga = VGA.reduced(2).unwrap();
        for (at, noise, floor) in [
            ([0.0, 2.0], 0.0, fixed()),
            ([-0.3, 2.3], 0.001, fixed()),
            ([0.2, 2.0], 0.001, FloorMode::Ransac(RansacParams::DEFAULT)),
        ] {
            let room = room(CHEST, at, noise);
            let (large, small) =
                (candidates::<640, 480>(&room, &VGA, floor, 1), candidates::<320, 240>(&room, &qvga, floor, 2));
            assert_eq!((large.len(), small.len()), (1, 1), "{at:?}");
            let (large, small) = (large[0].0, small[0].0);
            println!("{at:?}: VGA {:?} {:?}, QVGA {:?} {:?}", large.size, large.centroid, small.size, small.centroid);
            // The box faces the sensor, to which the chest stands aslant: there it is wider. Cells are 2 cm, and along the
            // line of sight the noise (7.5 mm at 2.3 m) carries single points out at both ends.
            let slope = (at[0] / at[1]).abs() as f32;
            let (cos, sin) = (1.0 / (1.0 + slope * slope).sqrt(), slope / (1.0 + slope * slope).sqrt());
            let truth = [(0.6 * cos + 0.4 * sin, 0.06), (0.5, 0.02), (0.4 * cos + 0.6 * sin, 0.07)];
            for (k, (want, tolerance)) in truth.into_iter().enumerate() {
                for size in [large.size, small.size] {
                    assert!((size[k] - want).abs() < tolerance, "{at:?} axis {k}: {size:?}");
                }
                assert!((large.size[k] - small.size[k]).abs() < 0.041, "{:?} {:?}", large.size, small.size);
                assert!((large.center[k] - small.center[k]).abs() < 0.03, "{:?} {:?}", large.center, small.center);
            }
            for k in 0..2 {
                // The mean of what is seen lies on the near sides.
                assert!((f64::from(large.centroid[k]) - at[k]).abs() < 0.2, "{at:?}: {:?}", large.centroid);
            }
        }
    });
}

#[test]
fn intrinsics_of_the_other_size_are_refused_with_both_sizes() {
    with_stack(|| {
        let error = Pipeline::<Float, 640, 480>::new(&Params::DEFAULT, &Intrinsics::KINECT_QVGA).unwrap_err();
        assert_eq!(error, Error::IntrinsicsSize { intrinsics: (320, 240), frame: (640, 480) });
        let text = error.to_string();
        assert!(text.contains("320x240") && text.contains("640x480"), "{text}");
        let error = Pipeline::<Float, 320, 240>::new(&Params::DEFAULT, &VGA).unwrap_err();
        assert_eq!(error, Error::IntrinsicsSize { intrinsics: (640, 480), frame: (320, 240) });
    });
}

#[test]
fn objects_are_recognised_from_templates_taken_elsewhere() {
    with_stack(|| {
        let objects = [("chest", CHEST), ("chair", CHAIR), ("bench", BENCH)];
        let taken = objects.map(|(name, object)| {
            let found = candidates::<640, 480>(&room(object, [0.0, 2.0], 0.001), &VGA, fixed(), 10);
            assert_eq!(found.len(), 1, "{name}");
            (name, found[0].1)
        });
        let bytes = file(&ViewParams::DEFAULT, &taken);
        let templates = Templates::parse(&bytes).unwrap();
        let pipeline = Pipeline::<Float, 640, 480>::new(&Params { floor: fixed(), ..Params::DEFAULT }, &VGA).unwrap();
        let mut workspace = Box::new(Workspace::<Float, 640, 480>::new());
        for (class, (name, object)) in (0u16..).zip(objects) {
            for (at, seed) in [([0.0, 2.0], 11), ([0.1, 2.4], 12)] {
                let shot = room(object, at, 0.001).shoot(&VGA, seed);
                let frame = Frame::new(&shot.depth, Some(&shot.colour)).unwrap();
                pipeline.run(&frame, &templates, &mut workspace).unwrap();
                let [detection] = workspace.report.detections.as_slice() else {
                    panic!("{name} at {at:?}: {:?}", workspace.report.clusters)
                };
                let hypotheses = &detection.hypotheses;
                println!("{name} at {at:?}: {hypotheses:?}");
                assert_eq!((hypotheses.len(), hypotheses[0].class, hypotheses[0].object), (3, class, class));
                assert_eq!(templates.class_name(hypotheses[0].class), name);
                assert!(hypotheses[0].score > 0.5 && hypotheses[1].score <= 0.5, "{name}: {hypotheses:?}");
            }
        }
    });
}

#[test]
fn templates_of_other_view_parameters_are_refused_before_anything_is_done() {
    with_stack(|| {
        let view = ViewParams::DEFAULT;
        let others = [
            ViewParams { descriptor: DescriptorKind::Paper, ..view },
            ViewParams { framing: Framing::Metric { side: ViewParams::METRIC_SIDE }, ..view },
            ViewParams { radius: 0.05, ..view },
        ];
        let pipeline = Pipeline::<Float, 640, 480>::new(&Params::DEFAULT, &VGA).unwrap();
        let mut workspace = Box::new(Workspace::<Float, 640, 480>::new());
        let depth = vec![1000; 640 * 480];
        for other in others {
            let bytes = file(&other, &[("chest", [0.5; 58])]);
            let result =
                pipeline.run(&Frame::new(&depth, None).unwrap(), &Templates::parse(&bytes).unwrap(), &mut workspace);
            let mismatch = TemplateError::Parameters { file: other.hash(), pipeline: view.hash() };
            assert_eq!(result, Err(Error::Templates(mismatch)));
            assert!(workspace.images.depth.as_flattened().iter().all(|z| *z == 0.0));
        }
    });
}
