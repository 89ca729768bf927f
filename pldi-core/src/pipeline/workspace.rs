//! The pipeline's memory, which the caller owns.

use super::{Arithmetic, Fixed, FixedImages, Float, FloatImages, Report};
use crate::frame::{QVGA_HEIGHT, QVGA_WIDTH};

/// All images between the stages, and the result. Between calls it may be read: it holds what the last frame left.
///
/// It is too large for a microcontroller's stack: put it into a static (`new` is `const`). Nothing in it is kept from
/// frame to frame.
#[derive(Debug, Clone)]
#[allow(missing_copy_implementations, reason = "megabytes should not be copied by accident")]
pub struct Workspace<A: Arithmetic, const W: usize = QVGA_WIDTH, const H: usize = QVGA_HEIGHT> {
    /// The images, in the numbers of the arithmetic.
    pub images: A::Images<W, H>,
    /// The frame's result.
    pub report: Report<A>,
}

impl<const W: usize, const H: usize> Workspace<Float, W, H> {
    /// An empty workspace.
    pub const fn new() -> Self {
        Self { images: FloatImages::new(), report: Report::new() }
    }
}

impl<const W: usize, const H: usize> Workspace<Fixed, W, H> {
    /// An empty workspace.
    pub const fn new() -> Self {
        Self { images: FixedImages::new(), report: Report::new() }
    }
}

impl<const W: usize, const H: usize> Default for Workspace<Float, W, H> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const W: usize, const H: usize> Default for Workspace<Fixed, W, H> {
    fn default() -> Self {
        Self::new()
    }
}
