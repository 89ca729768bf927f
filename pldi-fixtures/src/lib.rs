//! Fixtures.

pub mod furniture;
pub mod kinect;
pub mod mesh;
pub mod rng;
mod vec3;

pub use furniture::{Class, HELD_OUT_SEEDS, TEMPLATE_SEEDS, furniture};
pub use kinect::{
    CameraPose, Capture, Instance, KinectModel, Light, Pitch, Pose, Rendering, Room, Scene, Sensor, Sun, ViewRing,
    Views,
};
pub use mesh::{Bounds, Material, Mesh, Texture, Transform, Triangle};
