//! Truth, paths and files of recordings.

use super::*;
use crate::furniture::{Class, HELD_OUT_SEEDS};
use crate::kinect::{Light, Pose, Room};
use crate::mesh::Material;

fn small() -> Sensor {
    Sensor::kinect_v1().with_intrinsics(pldi_core::Intrinsics::PRIMESENSE_QVGA)
}

fn facing(objects: Vec<PlacedObject>) -> Recording {
    let room = Room::floor_only(12.0, Material::plain([180; 3]));
    let plan = RoomPlan { room, light: Light::default(), objects };
    Recording::along(plan, vec![CameraPose::new(0.0, 0.0, 0.0, 1.2, 0.3)], small(), 5.0, 1)
}

#[test]
fn objects_behind_others_are_occluded_and_those_at_the_border_cut() {
    let recording = facing(vec![
        PlacedObject::new(Class::Box, 1, Pose { x: 1.8, y: 0.0, yaw: 0.0 }),
        PlacedObject::new(Class::Chair, 2, Pose { x: 2.5, y: 0.05, yaw: 3.0 }),
        PlacedObject::new(Class::Bin, 3, Pose { x: 2.2, y: 0.75, yaw: 0.0 }),
        PlacedObject::new(Class::Armchair, 4, Pose { x: 2.2, y: -1.3, yaw: 3.0 }),
        PlacedObject::new(Class::Stool, 4, Pose { x: -2.0, y: 0.0, yaw: 3.0 }),
    ]);
    let truth = recording.frame(0).unwrap().truth;
    let flags: Vec<_> = truth.iter().map(|t| (t.class.as_str(), t.occluded, t.cut_by_frame)).collect();
    assert_eq!(
        flags,
        [("box", false, false), ("chair", true, false), ("bin", false, false), ("armchair", false, true)]
    );
    for t in &truth {
        assert!(t.visible <= t.alone && t.alone <= t.unclipped);
    }
    // The box stands straight ahead: its middle in the camera's frame follows by hand.
    let (s, c) = libm::sincosf(0.3);
    let below = 1.2 - 0.5 * truth[0].size[2];
    let expected = [0.0, below * c - 1.8 * s, 1.8 * c + below * s];
    for (found, expected) in truth[0].centre.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-5);
    }
    assert!((truth[0].distance - 1.8).abs() < 1e-5);
    assert!((truth[2].bbox[0]..=truth[2].bbox[2]).contains(&(159 - (0.75f32 / 2.2 * 285.0 / 1.05) as usize)));
}

#[test]
fn a_drive_shows_whole_objects_from_close_enough() {
    let drive = Drive { frames: 24, rate: 2.0, ..Drive::default() };
    let (mut whole, mut frames) = (0, 0);
    for seed in 0..3 {
        let plan = RoomPlan::generate(seed, &Class::ALL, HELD_OUT_SEEDS..HELD_OUT_SEEDS + 100);
        for frame in Recording::new(plan, small(), drive, seed).frames() {
            frames += 1;
            let clear = |t: &&ObjectTruth| !t.occluded && !t.cut_by_frame && (1.4..3.6).contains(&t.distance);
            whole += usize::from(frame.truth.iter().any(|t| clear(&t)));
        }
    }
    assert!(2 * whole > frames, "an object stands clear in only {whole} of {frames} frames");
}

#[test]
fn the_demo_shows_free_objects_of_many_classes() {
    let mut recording = Recording::demo();
    assert_eq!((recording.len(), recording.sensor.intrinsics.width), (12, 640));
    recording.sensor.intrinsics = pldi_core::Intrinsics::PRIMESENSE_QVGA;
    let mut classes = std::collections::BTreeSet::new();
    let mut sightings = 0;
    for (i, frame) in recording.frames().enumerate() {
        let clear: Vec<_> = frame.truth.iter().filter(|t| !t.occluded && !t.cut_by_frame).collect();
        assert!(!clear.is_empty(), "frame {i}: {:?}", frame.truth);
        sightings += clear.len();
        classes.extend(clear.iter().map(|t| t.class.clone()));
        assert!(frame.truth.iter().all(|t| t.object >= HELD_OUT_SEEDS));
    }
    assert!(classes.len() >= 6 && sightings >= 40, "{sightings} of {classes:?}");
}

#[test]
fn folders_hold_what_was_taken() {
    let recording = facing(vec![PlacedObject::new(Class::Bin, 3, Pose { x: 2.2, y: 0.0, yaw: 0.0 })]);
    let folder = tempfile::tempdir().unwrap();
    write_tum(&recording, "test", folder.path()).unwrap();
    let frame = recording.frame(0).unwrap();
    let depth = image::open(folder.path().join("depth/0000.png")).unwrap().into_luma16();
    assert_eq!(depth.into_raw(), frame.capture.depth);
    let colour = image::open(folder.path().join("rgb/0000.png")).unwrap().into_rgb8();
    assert_eq!(colour.into_raw(), frame.capture.colour);
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert_eq!(read("associations.txt"), "0.000000 rgb/0000.png 0.000000 depth/0000.png\n");
    assert!(read("camera_info.yaml").contains("data: [285.63, 0.0, 159.5, 0.0, 285.63, 119.5, 0.0, 0.0, 1.0]"));
    let truth: serde_json::Value = serde_json::from_str(&read("truth.json")).unwrap();
    let objects: Vec<ObjectTruth> = serde_json::from_value(truth["frames"][0]["objects"].clone()).unwrap();
    assert_eq!(objects, frame.truth);
    assert!(!folder.path().join("truth.json.part").exists());
}
