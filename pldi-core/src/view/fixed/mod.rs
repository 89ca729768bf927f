//! The frontal view in fixed point, see [`crate::view`].
//!
//! Coordinates are in Q26, below 32 in absolute value: rays per unit of depth, points of the plane pi_o and heights in
//! metres, view coordinates in the image plane at unit distance.

pub mod framing;
pub mod homography;
pub mod warp;

pub use framing::{Framing, Frontal, ViewParams};
pub use homography::Homography;
