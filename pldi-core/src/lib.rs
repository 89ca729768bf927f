#![cfg_attr(not(test), no_std)]
#![deny(unsafe_code)]
//! Recognise furniture-sized objects from one RGB-D frame.

mod error;

pub mod math;
// In the order of the data's way.
pub mod descriptor;
pub mod diffusion;
pub mod floor;
pub mod frame;
pub mod ground;
pub mod matching;
pub mod pipeline;
pub mod rays;
pub mod reconstruct;
pub mod templates;
pub mod view;
pub mod wavelet;

pub use error::{Error, TemplateError};
pub use floor::{Floor, FloorAxes};
pub use frame::{DepthRange, Frame, Image, Intrinsics};
pub use pipeline::{Params, Pipeline, Report, Workspace};
pub use rays::Rays;
