//! What every format gives: frames in order, still to be decoded.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use pldi_core::Intrinsics;

use super::{DepthScale, Stamp};
use crate::Error;
use crate::error::IntrinsicsOrigin;

/// Where frames come from, one after the other.
///
/// A format implements this in a file of its own and has a line in the table of [`open`](super::open).
pub trait Source: Send {
    /// The next frame; `None` at the end, or where `stop` was raised while it waited.
    ///
    /// # Errors
    /// What ends the source: a device that is gone, a file that cannot be read on. What is wrong with one frame alone is
    /// told when its images are decoded, and does not hinder the frames behind it.
    fn next(&mut self, stop: &Stop) -> Result<Option<RawFrame>, Error>;

    /// Number of frames from here on, where it is known without reading them; a recording that was cut may hold fewer.
    fn frames(&self) -> Option<usize> {
        None
    }

    /// Whether frames that nobody takes in time are lost.
    fn is_live(&self) -> bool {
        false
    }
}

/// A frame as its source hands it over. Its images are decoded by whoever takes it, on a thread of their own where
/// there are several.
pub struct RawFrame {
    /// Time of the depth image.
    pub stamp: Stamp,
    /// Time of the colour image, where there is one.
    pub colour_stamp: Option<Stamp>,
    /// Name within the source: a file, a topic and its message.
    pub name: String,
    /// Name of the depth camera's coordinate frame, where the source has one: `camera_depth_optical_frame`.
    pub frame_id: Option<String>,
    /// The camera as the source knows it, for the images' size, and where that is from.
    pub camera: Option<(Intrinsics, IntrinsicsOrigin)>,
    /// Frames lost between this and the one before.
    pub dropped: u64,
    /// Decodes the images.
    pub images: Box<dyn FnOnce() -> Result<Images, Error> + Send>,
}

impl fmt::Debug for RawFrame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { stamp, colour_stamp, name, frame_id, camera, dropped, images: _ } = self;
        f.debug_struct("RawFrame")
            .field("stamp", stamp)
            .field("colour_stamp", colour_stamp)
            .field("name", name)
            .field("frame_id", frame_id)
            .field("camera", camera)
            .field("dropped", dropped)
            .finish_non_exhaustive()
    }
}

/// A frame's images as they were taken: registered, of one size, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Images {
    /// Width and height of both.
    pub size: (u16, u16),
    /// Depth in the unit of `scale`, 0 = no reading.
    pub depth: Vec<u16>,
    /// What the depths mean.
    pub scale: DepthScale,
    /// Colour, 8 bits each of red, green and blue.
    pub colour: Option<Vec<u8>>,
}

impl Images {
    /// Depth in mm, 0 = no reading.
    pub fn depth_mm(&self) -> Vec<u16> {
        self.depth.iter().map(|&value| self.scale.to_mm(value)).collect()
    }
}

/// Asks a source that waits for a frame to give up. Clones are one and the same.
#[derive(Debug, Clone, Default)]
pub struct Stop {
    own: Arc<AtomicBool>,
    parent: Option<Arc<Self>>,
}

impl Stop {
    /// One that is raised together with this, and by itself.
    pub fn child(&self) -> Self {
        Self { own: Arc::default(), parent: Some(Arc::new(self.clone())) }
    }

    /// Asks to give up.
    pub fn raise(&self) {
        self.own.store(true, Ordering::SeqCst);
    }

    /// Whether to give up.
    pub fn is_raised(&self) -> bool {
        self.own.load(Ordering::SeqCst) || self.parent.as_ref().is_some_and(|parent| parent.is_raised())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stop_reaches_its_children_alone() {
        let parent = Stop::default();
        let (child, other) = (parent.child(), parent.child());
        child.raise();
        assert_eq!([&parent, &child, &other].map(Stop::is_raised), [false, true, false]);
        parent.clone().raise();
        assert!(parent.is_raised() && other.is_raised());
    }
}
