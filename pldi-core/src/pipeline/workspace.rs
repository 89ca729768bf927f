//! The pipeline's memory, which the caller owns.

use super::Report;
use crate::Image;
use crate::descriptor::View;
use crate::ground::{MAP_DEPTH, MAP_WIDTH, Map};
use crate::reconstruct::FilterScratch;
use crate::wavelet::{Plane, SIZE};

/// All images between the stages. Between calls it may be read: it holds what the last frame left.
///
/// It is too large for a microcontroller's stack: put it into a static (`new` is `const`). Nothing in it is kept from
/// frame to frame.
#[derive(Debug, Clone)]
#[allow(missing_copy_implementations, reason = "megabytes should not be copied by accident")]
pub struct Workspace<const W: usize, const H: usize> {
    /// The reconstructed depth in metres, 0 = none.
    pub depth: Image<f32, W, H>,
    /// The number of each pixel's cluster, from 1; 0 = none.
    pub labels: Image<u16, W, H>,
    /// N, 65535 = 1; 0 = none.
    pub n: Image<u16, W, H>,
    /// Image L: points above the floor per cell, in pixels as if seen from 2 m.
    pub counts: Map<f32>,
    /// Their density, in the same unit.
    pub density: Map<f32>,
    /// The number of each cell's cluster, from 1; 0 = none.
    pub map_labels: Map<u8>,
    /// The view of the last candidate, 65535 = 1.
    pub view: View,
    /// Its wavelet coefficients.
    pub coefficients: Plane,
    /// The frame's result.
    pub report: Report,
    pub(super) marks: Map<u8>,
    pub(super) filter: FilterScratch<W, H>,
}

impl<const W: usize, const H: usize> Workspace<W, H> {
    /// An empty workspace.
    pub const fn new() -> Self {
        Self {
            depth: [[0.0; W]; H],
            labels: [[0; W]; H],
            n: [[0; W]; H],
            counts: [[0.0; MAP_WIDTH]; MAP_DEPTH],
            density: [[0.0; MAP_WIDTH]; MAP_DEPTH],
            map_labels: [[0; MAP_WIDTH]; MAP_DEPTH],
            view: [[0; SIZE]; SIZE],
            coefficients: [[0.0; SIZE]; SIZE],
            report: Report::new(),
            marks: [[0; MAP_WIDTH]; MAP_DEPTH],
            filter: FilterScratch::new(),
        }
    }
}

impl<const W: usize, const H: usize> Default for Workspace<W, H> {
    fn default() -> Self {
        Self::new()
    }
}
