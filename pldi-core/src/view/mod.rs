//! The frontal view of a candidate (paper, section 4, end): the plane through it, the homography between the planes
//! pi_o and pi_f, and the 128x128 image.

pub mod fixed;
pub mod framing;
pub mod homography;
pub mod warp;

pub use framing::{Framing, Frontal, ViewParams};
pub use homography::Homography;
