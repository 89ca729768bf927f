//! A simulated RGB-D camera: a z-buffer, and the Kinect v1's way of measuring on top of it.
//!
//! Camera frame: x to the right, y down, z forward; pixel (0, 0) is the centre of the top-left pixel; depth is z in mm,
//! 0 where there is no reading.

mod camera;
mod model;
mod noise;
mod raster;
mod ring;
mod scene;
mod sensor;
mod shade;

pub use camera::CameraPose;
pub use model::KinectModel;
pub use ring::{Pitch, ViewRing, Views};
pub use scene::{Instance, Light, Pose, Room, Scene, Sun};
pub use sensor::{Capture, Rendering, Sensor};

#[cfg(test)]
mod tests;
