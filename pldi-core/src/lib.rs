#![no_std]
#![deny(unsafe_code)]
//! Recognise furniture-sized objects from one RGB-D frame.
mod error;
pub mod frame;
pub mod math;

pub use error::{Error, TemplateError};
pub use frame::{DepthRange, Frame, Image, Intrinsics};

/// Template files.
pub mod templates {
    /// Version.
    pub const VERSION: u16 = 1;
}
