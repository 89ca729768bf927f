//! The reconstruction in integers, in place: depth in 1/8 mm, two images of quantised distances (u8), one of mask
//! weights (u16).
//!
//! The colours and the measured depths themselves are not kept: what the filter needs of them is how far neighbouring
//! pixels lie apart in the transformed domain, and that is computed row by row as the rows arrive ([`intake`]).

#[cfg(target_arch = "x86_64")]
mod arrays;
pub mod distances;
#[cfg(target_arch = "x86_64")]
mod four;
pub mod intake;
#[cfg(target_arch = "x86_64")]
mod quad;
#[cfg_attr(target_arch = "x86_64", allow(dead_code, reason = "the twin is in use"))]
mod packed;
pub mod recursive;
#[cfg_attr(target_arch = "x86_64", allow(dead_code, reason = "of the filter itself, the twin is in use"))]
mod single;
pub mod weight;

pub use distances::DistanceTable;
pub use intake::{Bayer, ColourRow, DepthRow, Disparity, Intake};

use super::FilterKind;
use crate::fixed::quantise;
use crate::{DepthRange, Error, Image};

/// Iterations at most.
pub const MAX_ITERATIONS: usize = 5;

/// Parameters of the reconstruction in integers, see [`super::FilterParams`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FilterParams {
    /// Which filter; `Exact` has no fixed-point form.
    pub kind: FilterKind,
    /// Spatial standard deviation in pixels, Q16: 0.5 to 100.
    pub sigma_space: u32,
    /// Standard deviation of the sum of the three channels' differences, Q16: 1 to 1000.
    pub sigma_colour: u32,
    /// Standard deviation of the depth in 1/128 mm: 1 to 250 mm.
    pub sigma_depth: u32,
    /// Passes over rows and columns, 1 to 5.
    pub iterations: u8,
    /// A pixel stays without depth where the filtered mask is not above this, Q27: 1e-6 to 0.999.
    pub weight_floor: u32,
}

impl FilterParams {
    /// The float parameters, rounded; at compile time in a `const`.
    ///
    /// # Errors
    /// `OutOfRange` with the parameter's name.
    pub const fn new(float: &super::FilterParams) -> Result<Self, Error> {
        let Some(sigma_space) = quantise(float.sigma_space, 0.5, 100.0, 65_536.0) else {
            return Err(Error::OutOfRange("sigma_space"));
        };
        let Some(sigma_colour) = quantise(float.sigma_colour, 1.0, 1000.0, 65_536.0) else {
            return Err(Error::OutOfRange("sigma_colour"));
        };
        let Some(sigma_depth) = quantise(float.sigma_depth, 0.001, 0.25, 128_000.0) else {
            return Err(Error::OutOfRange("sigma_depth"));
        };
        let Some(weight_floor) = quantise(float.weight_floor, 1e-6, 0.999, 134_217_728.0) else {
            return Err(Error::OutOfRange("weight_floor"));
        };
        let params = Self {
            kind: float.kind,
            sigma_space: sigma_space as u32,
            sigma_colour: sigma_colour as u32,
            sigma_depth: sigma_depth as u32,
            iterations: float.iterations,
            weight_floor: weight_floor as u32,
        };
        match params.validate() {
            Ok(()) => Ok(params),
            Err(error) => Err(error),
        }
    }

    /// Checks every number against its stated range.
    ///
    /// # Errors
    /// `OutOfRange` with the parameter's name.
    pub const fn validate(&self) -> Result<(), Error> {
        if self.sigma_space < 1 << 15 || self.sigma_space > 100 << 16 {
            return Err(Error::OutOfRange("sigma_space"));
        }
        if self.sigma_colour < 1 << 16 || self.sigma_colour > 1000 << 16 {
            return Err(Error::OutOfRange("sigma_colour"));
        }
        if self.sigma_depth < 128 || self.sigma_depth > 250 * 128 {
            return Err(Error::OutOfRange("sigma_depth"));
        }
        if self.iterations == 0 || self.iterations as usize > MAX_ITERATIONS {
            return Err(Error::OutOfRange("iterations"));
        }
        if self.weight_floor < 134 || self.weight_floor > 134_083_511 {
            return Err(Error::OutOfRange("weight_floor"));
        }
        if matches!(self.kind, FilterKind::Exact) {
            return Err(Error::OutOfRange("filter kind (the exact filter has no fixed-point form)"));
        }
        Ok(())
    }
}

/// What the filter works on besides the depth, 4 bytes for each pixel.
#[derive(Debug)]
pub struct Scratch<'a, const W: usize, const H: usize> {
    /// Distance of each pixel from its left neighbour, see [`DistanceTable`].
    pub horizontal: &'a mut Image<u8, W, H>,
    /// Distance of each pixel from its upper neighbour.
    pub vertical: &'a mut Image<u8, W, H>,
    /// Mask weights, see [`weight`].
    pub mask: &'a mut Image<u16, W, H>,
}

/// Fills `depth` with the reconstructed depth in 1/8 mm, 0 where no reading reaches.
///
/// `depth` and `scratch` hold what [`Intake`] made of a frame's rows; `lines` is scratch for four rows or columns.
pub fn filter<const W: usize, const H: usize>(
    params: &FilterParams,
    table: &DistanceTable,
    scratch: &mut Scratch<'_, W, H>,
    lines: &mut recursive::Lines<W>,
    depth: &mut Image<u16, W, H>,
) {
    if params.kind == FilterKind::None {
        return;
    }
    for (mask, depth) in scratch.mask.as_flattened_mut().iter_mut().zip(depth.as_flattened()) {
        *mask = if *depth > 0 { weight::ONE } else { 0 };
    }
    for (iteration, weights) in table.weights().iter().enumerate().take(usize::from(params.iterations)) {
        let last = iteration + 1 == usize::from(params.iterations);
        recursive::rows(depth, scratch.mask, scratch.horizontal, weights, lines);
        let floor = if last { params.weight_floor } else { 0 };
        recursive::columns(depth, scratch.mask, scratch.vertical, weights, floor, lines);
    }
}

/// A measured depth in mm as it is stored: 1/8 mm, saturated at 8191.875 mm; 0 where it is no reading.
#[inline(always)]
pub fn eighths(range: DepthRange, depth: u16) -> u16 {
    range.apply(depth).saturating_mul(8)
}

#[cfg(test)]
mod tests;
