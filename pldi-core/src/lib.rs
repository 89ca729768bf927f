#![cfg_attr(not(test), no_std)]
#![deny(unsafe_code)]
#![doc = include_str!("../README.md")]

#[macro_use]
mod log;

mod array;
mod crc;
mod eigen;
mod error;

pub mod fixed;
pub mod math;
// In the order of the data's way.
pub mod frame;
pub mod rays;
pub mod reconstruct;
pub mod floor;
pub mod ground;
pub mod diffusion;
pub mod view;
pub mod wavelet;
pub mod descriptor;
pub mod templates;
pub mod matching;
pub mod pipeline;
pub mod serial;

#[cfg(feature = "defmt")]
mod format;

pub use error::{Error, TemplateError};
pub use floor::{Floor, FloorAxes};
pub use frame::{DepthRange, Frame, Image, Intrinsics};
pub use pipeline::{Fixed, Float, Params, Pipeline, Report, Workspace};
pub use rays::Rays;
