//! Sources of RGB-D frames, brought to the form that the pipeline takes: QVGA, depth in mm, intrinsics that belong.

mod camera_info;
pub(crate) mod files;
pub(crate) mod image;
mod intrinsics;
mod lists;
mod recording;
mod reduce;
mod scale;

use pldi_core::Intrinsics;

pub use camera_info::read_camera_info;
pub use intrinsics::{IntrinsicsSpec, parse_intrinsics};
pub use recording::{OpenOptions, Recording};
pub use reduce::reduce;
pub use scale::DepthScale;

use crate::Error;

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

/// A frame's images before they were reduced.
#[derive(Debug, Clone, PartialEq)]
pub struct Original {
    /// Width and height of both.
    pub size: (u16, u16),
    /// Depth in mm, 0 = no reading, row by row.
    pub depth: Vec<u16>,
    /// Colour, 8 bits each of red, green and blue, row by row.
    pub colour: Option<Vec<u8>>,
}

/// Where frames come from. Frames are read when they are asked for, in any order and from several threads at once.
pub trait FrameSource: Send + Sync {
    /// Number of frames.
    fn len(&self) -> usize;

    /// Whether there is no frame at all.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Reads the frame of number `index`. A frame that cannot be read does not hinder the others.
    ///
    /// # Errors
    /// What is wrong with the frame's files, or that there is no such frame.
    fn frame(&self, index: usize) -> Result<QvgaFrame, Error>;

    /// The images of frame number `index` as they were taken, to be looked at; where a source has nothing else, the
    /// reduced ones.
    ///
    /// # Errors
    /// As [`FrameSource::frame`].
    fn original(&self, index: usize) -> Result<Original, Error> {
        let QvgaFrame { depth, colour, .. } = self.frame(index)?;
        Ok(Original { size: (320, 240), depth, colour })
    }
}
