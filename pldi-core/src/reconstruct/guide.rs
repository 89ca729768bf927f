//! The guide of the domain transform: how much of its neighbour each pixel takes (paper, equation 2).
//!
//! Neighbouring pixels lie d = 1 + (ss/s_rgb) sum_c |dI_c| + (ss/s_d) |dJ| apart in the transformed domain, the
//! depth's term only between two readings; the filter's feedback coefficient between them is a^d with
//! a = exp(-sqrt(2)/sigma_H). Colour differences are integers 0..=765 and depth differences integers in mm, so a^d is
//! the product of two table entries: no exponential is left per pixel.

use super::FilterParams;
use crate::{DepthRange, Image, math};

/// Depth differences beyond this many mm count as this many.
const MAX_STEP: usize = 2047;

/// a^d of the first iteration as a product: `colour[sum of the channels' differences] * depth[difference in mm]`.
#[derive(Debug, Clone)]
#[allow(missing_copy_implementations, reason = "11 kB of tables")]
pub struct GuideTable {
    colour: [f32; 3 * 255 + 1],
    depth: [f32; MAX_STEP + 1],
}

impl GuideTable {
    /// The tables for validated parameters.
    pub fn new(params: &FilterParams) -> Self {
        let rate = math::sqrt(2.0) / params.sigma_of_iteration(0);
        let per_level = params.sigma_space / params.sigma_colour;
        let per_mm = params.sigma_space / (params.sigma_depth * 1000.0);
        let mut table = Self { colour: [0.0; 766], depth: [0.0; MAX_STEP + 1] };
        for (i, w) in table.colour.iter_mut().enumerate() {
            *w = flushed(math::exp(-rate * (1.0 + per_level * i as f32)));
        }
        for (i, w) in table.depth.iter_mut().enumerate() {
            *w = flushed(math::exp(-rate * per_mm * i as f32));
        }
        table
    }
}

/// Weights too small to matter become 0, so that their squares do not become subnormal.
fn flushed(weight: f32) -> f32 {
    if weight < 1e-12 { 0.0 } else { weight }
}

/// The weight of each pixel's left and upper neighbour; the first column and the first row are unused.
#[derive(Debug, Clone)]
#[allow(missing_copy_implementations, reason = "two images")]
pub struct GuideWeights<const W: usize, const H: usize> {
    pub(super) horizontal: Image<f32, W, H>,
    pub(super) vertical: Image<f32, W, H>,
}

impl<const W: usize, const H: usize> Default for GuideWeights<W, H> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const W: usize, const H: usize> GuideWeights<W, H> {
    /// All weights 0.
    pub const fn new() -> Self {
        Self { horizontal: [[0.0; W]; H], vertical: [[0.0; W]; H] }
    }

    /// Computes the weights of the first iteration.
    pub fn fill(
        &mut self,
        depth: &Image<u16, W, H>,
        colour: Option<&Image<[u8; 3], W, H>>,
        range: DepthRange,
        table: &GuideTable,
    ) {
        let step = |p: u16, q: u16| {
            let (p, q) = (range.apply(p), range.apply(q));
            if p == 0 || q == 0 { 0 } else { usize::from(p.abs_diff(q)).min(MAX_STEP) }
        };
        let contrast = |p: [u8; 3], q: [u8; 3]| {
            usize::from(p[0].abs_diff(q[0])) + usize::from(p[1].abs_diff(q[1])) + usize::from(p[2].abs_diff(q[2]))
        };
        for y in 0..H {
            let (row, above) = (&depth[y], &depth[y.saturating_sub(1)]);
            let (horizontal, vertical) = (&mut self.horizontal[y], &mut self.vertical[y]);
            for x in 0..W {
                horizontal[x] = table.depth[step(row[x], row[x.saturating_sub(1)])];
                vertical[x] = table.depth[step(row[x], above[x])];
            }
            if let Some(colour) = colour {
                let (row, above) = (&colour[y], &colour[y.saturating_sub(1)]);
                for x in 0..W {
                    horizontal[x] *= table.colour[contrast(row[x], row[x.saturating_sub(1)])];
                    vertical[x] *= table.colour[contrast(row[x], above[x])];
                }
            } else {
                horizontal.iter_mut().chain(vertical).for_each(|w| *w *= table.colour[0]);
            }
        }
    }

    /// Squares every weight: the same weights for half the sigma, which is the next iteration's.
    pub fn halve_sigma(&mut self) {
        for w in self.horizontal.as_flattened_mut().iter_mut().chain(self.vertical.as_flattened_mut()) {
            *w = if *w < 1e-12 { 0.0 } else { *w * *w };
        }
    }
}
