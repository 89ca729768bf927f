//! Sources of RGB-D frames, brought to the form that the pipeline takes: QVGA, depth in mm, intrinsics that belong.
//!
//! [`open`] opens whatever a URI names; each format is a [`Source`] in a file of its own.

pub(crate) mod ahead;
mod bag;
mod camera_info;
pub(crate) mod files;
mod folder;
#[doc(hidden)]
pub mod fuzz;
pub(crate) mod image;
mod intrinsics;
mod lists;
mod mcap;
mod open;
pub mod openni2;
pub mod pair;
mod prepare;
mod reduce;
mod ros;
mod scale;
mod source;
mod stamp;
mod yuv;

use pldi_core::Intrinsics;

pub use camera_info::read_camera_info;
pub use intrinsics::{IntrinsicsSpec, parse_intrinsics};
pub use open::{Input, Mode, OpenOptions, is_image, open};
pub use prepare::{Frame, Preparation};
pub use reduce::reduce;
pub use scale::DepthScale;
pub use source::{Images, RawFrame, Source, Stop};
pub use stamp::Stamp;

/// Largest factor by which a frame may exceed QVGA: 5120x3840, beyond any depth sensor.
pub const MAX_FACTOR: u16 = 16;

/// One RGB-D frame, reduced to QVGA.
#[derive(Debug, Clone, PartialEq)]
pub struct QvgaFrame {
    /// Number of the frame in its source, from 0.
    pub index: usize,
    /// Time of the depth image in seconds, on the source's clock.
    pub stamp: f64,
    /// Name of the frame within its source: the depth image's file as listed.
    pub name: String,
    /// Depth in mm, 0 = no reading, 320 x 240 values row by row.
    pub depth: Vec<u16>,
    /// Colour, 8 bits each of red, green and blue, 320 x 240 x 3 values row by row.
    pub colour: Option<Vec<u8>>,
    /// The camera, for the 320x240 image.
    pub intrinsics: Intrinsics,
    /// The factor k by which the frame was reduced.
    pub factor: u16,
    /// Width and height before.
    pub original_size: (u16, u16),
}

impl QvgaFrame {
    /// The frame as the pipeline takes it.
    ///
    /// # Errors
    /// `PixelCount` where a buffer was changed to another length.
    pub fn as_frame(&self) -> Result<pldi_core::Frame<'_, 320, 240>, pldi_core::Error> {
        pldi_core::Frame::new(&self.depth, self.colour.as_deref())
    }
}
