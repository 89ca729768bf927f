//! Things to see and a sensor to see them with, for testing and demonstrating `pldi`: procedural furniture, a Kinect v1
//! simulator, and recordings of a robot among the furniture with the truth about every object in view.
//!
//! Everything follows from seeds alone and comes out the same bit for bit on every platform. Nothing is read from
//! files and no float function of the platform is called.
//!
//! * [`furniture()`]: an object of one of twelve [`Class`]es. Seeds from [`TEMPLATE_SEEDS`] on are for templates, seeds
//!   from [`HELD_OUT_SEEDS`] on for testing.
//! * [`Sensor`]: takes [`Capture`]s of a [`Scene`], with a Kinect's noise, quantisation, shadows and missing readings, or
//!   without any.
//! * [`ViewRing`]: views of one object from all around, as templates are made from.
//! * [`Recording`]: a drive through a room, frame by frame, and [`write_tum`] to keep it.
//!
//! Lengths are in metres and angles in rad unless a name says otherwise. The world has z up; the camera's frame has x to
//! the right, y down, z forward.
//!
//! ```
//! use std::sync::Arc;
//! use pldi_fixtures::{Class, Recording, Sensor, ViewRing, furniture};
//!
//! // Four views of a chair, as a Kinect sees it from 2 m away.
//! let chair = Arc::new(furniture(Class::Chair, 0));
//! let ring = ViewRing { views: 4, ..ViewRing::default() };
//! for (camera, capture) in ring.captures(chair, Sensor::kinect_v1(), 7) {
//!     let seen = capture.depth.iter().filter(|&&mm| mm > 0).count();
//!     assert!(seen > 5_000, "{seen} readings from {camera:?}");
//! }
//!
//! // A frame of a robot's drive, with the truth.
//! let frame = Recording::demo().frame(6).expect("the demo has 12 frames");
//! for object in frame.truth.iter().filter(|o| !o.occluded && !o.cut_by_frame) {
//!     println!("{} at {:.1} m", object.class, object.distance);
//! }
//! # assert!(frame.truth.len() >= 3);
//! ```
//!
//! What the simulator leaves out: multiple reflections, motion during the exposure, lens distortion, the error of the
//! registration between the two cameras, cast shadows of the light.

pub mod furniture;
pub mod kinect;
pub mod mesh;
pub mod recording;
pub mod rng;
mod vec3;

pub use furniture::{Class, HELD_OUT_SEEDS, TEMPLATE_SEEDS, furniture};
pub use kinect::{
    CameraPose, Capture, Instance, KinectModel, Light, Pitch, Pose, Rendering, Room, Scene, Sensor, Sun, ViewRing,
    Views,
};
pub use mesh::{Bounds, Material, Mesh, Texture, Transform, Triangle};
pub use recording::{
    Drive, HIDDEN_SHARE, ObjectTruth, PlacedObject, RecordedFrame, Recording, RoomPlan, TumFrame, TumWriter, write_tum,
};
