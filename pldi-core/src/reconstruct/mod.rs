//! Depth reconstructed by a joint bilateral filter (paper, section 2).
//!
//! The filter follows the colour image's and the depth's own edges, fills gaps from pixels that are near in that
//! sense, and leaves a pixel without depth where no reading reaches it. [`reconstruct`] is the fast form, the
//! recursive domain transform of Gastal and Oliveira (2011); [`exact`] is equation 1 as written, for comparison.

pub mod exact;
pub mod fixed;
pub mod guide;
pub mod recursive;

pub use guide::{GuideTable, GuideWeights};

use crate::{DepthRange, Error, Frame, Image};

/// Which filter makes the reconstructed depth out of the measured one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FilterKind {
    /// Colour and depth guide the filter (the paper's JBF). A frame without colour is filtered as `Bilateral`.
    #[default]
    Joint,
    /// Depth alone guides the filter (the paper's ablation "PLDI-BF").
    Bilateral,
    /// Equation 1 as it is written, guided by colour and depth: thousands of times slower, for comparison.
    Exact,
    /// No filter: the measured depth as it is.
    None,
}

/// Parameters of the reconstruction (Table II).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FilterParams {
    /// Which filter.
    pub kind: FilterKind,
    /// Spatial standard deviation, sigma_s, in pixels (of the frame's own size), 0.5 to 100. Default 12.
    pub sigma_space: f32,
    /// Colour standard deviation, sigma_r of the sum of the three channels' differences, 1 to 1000. Default 10.
    pub sigma_colour: f32,
    /// Depth standard deviation in metres, 0.001 to 0.25. Default 0.04.
    pub sigma_depth: f32,
    /// Passes over rows and columns, 1 to 5. Default 3.
    pub iterations: u8,
    /// A pixel stays without depth where the filtered mask is not above this, 0 < floor < 1. Default 0.001.
    pub weight_floor: f32,
}

impl Default for FilterParams {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl FilterParams {
    /// The paper's values (Table II).
    pub const DEFAULT: Self = Self {
        kind: FilterKind::Joint,
        sigma_space: 12.0,
        sigma_colour: 10.0,
        sigma_depth: 0.04,
        iterations: 3,
        weight_floor: 1e-3,
    };

    /// Checks every number against its stated range.
    ///
    /// # Errors
    /// `OutOfRange` with the parameter's name (also for NaN).
    pub fn validate(&self) -> Result<(), Error> {
        crate::error::within("sigma_space", self.sigma_space, 0.5, 100.0)?;
        crate::error::within("sigma_colour", self.sigma_colour, 1.0, 1000.0)?;
        crate::error::within("sigma_depth", self.sigma_depth, 0.001, 0.25)?;
        crate::error::within("iterations", f32::from(self.iterations), 1.0, 5.0)?;
        crate::error::within("weight_floor", self.weight_floor, 1e-6, 0.999)
    }

    /// sigma_H of iteration `i` (0 is the first) in pixels: ss sqrt(3) 2^(N-1-i) / sqrt(4^N - 1)
    /// (Gastal and Oliveira 2011, equation 14). Each is half of the one before.
    pub fn sigma_of_iteration(&self, i: u8) -> f32 {
        let four_to_n = (1u32 << (2 * u32::from(self.iterations.min(15)))) as f32;
        let power = (1u32 << u32::from(self.iterations.saturating_sub(i + 1))) as f32;
        self.sigma_space * crate::math::sqrt(3.0) * power / crate::math::sqrt(four_to_n - 1.0)
    }
}

/// Scratch memory of [`reconstruct`]: the depth-times-mask and mask images and the weights between neighbours.
#[derive(Debug, Clone)]
#[allow(missing_copy_implementations, reason = "a megabyte should not be copied by accident")]
pub struct FilterScratch<const W: usize, const H: usize> {
    weight: Image<f32, W, H>,
    guide: GuideWeights<W, H>,
}

impl<const W: usize, const H: usize> FilterScratch<W, H> {
    /// Empty scratch memory.
    pub const fn new() -> Self {
        Self { weight: [[0.0; W]; H], guide: GuideWeights::new() }
    }
}

impl<const W: usize, const H: usize> Default for FilterScratch<W, H> {
    fn default() -> Self {
        Self::new()
    }
}

/// What the filter reads of invalid pixels instead of 0: so far below every weight floor that it changes nothing,
/// so far above the subnormal numbers (on which many FPUs are slow) that decaying sums never get there.
const FAINT: f32 = 1e-20;

/// Fills `depth` with the reconstructed depth in metres, 0 where no reading reaches (equations 1 and 2 by the
/// recursive filter of Gastal and Oliveira 2011, section 5): the depth times its mask and the mask are filtered with
/// the same weights, and divided.
pub fn reconstruct<const W: usize, const H: usize>(
    frame: &Frame<'_, W, H>,
    range: DepthRange,
    params: &FilterParams,
    table: &GuideTable,
    scratch: &mut FilterScratch<W, H>,
    depth: &mut Image<f32, W, H>,
) {
    if params.kind == FilterKind::Exact {
        exact::exact(frame, range, params, depth);
        return;
    }
    let metres = frame.depth.as_flattened().iter().map(|&d| f32::from(range.apply(d)) * 1e-3);
    if params.kind == FilterKind::None {
        depth.as_flattened_mut().iter_mut().zip(metres).for_each(|(out, z)| *out = z);
        return;
    }
    let weight = &mut scratch.weight;
    for ((sum, weight), z) in depth.as_flattened_mut().iter_mut().zip(weight.as_flattened_mut()).zip(metres) {
        (*sum, *weight) = if z > 0.0 { (z, 1.0) } else { (FAINT, FAINT) };
    }
    let colour = frame.colour.filter(|_| params.kind == FilterKind::Joint);
    scratch.guide.fill(frame.depth, colour, range, table);
    for iteration in 0..params.iterations {
        if iteration > 0 {
            scratch.guide.halve_sigma();
        }
        recursive::rows(depth, weight, &scratch.guide.horizontal);
        recursive::columns(depth, weight, &scratch.guide.vertical);
    }
    for (sum, &weight) in depth.as_flattened_mut().iter_mut().zip(weight.as_flattened()) {
        *sum = if weight > params.weight_floor { *sum / weight } else { 0.0 };
    }
}

#[cfg(test)]
mod tests;
