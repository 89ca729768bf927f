//! Distances between neighbouring pixels in the transformed domain, in 8 bits, and the weights that belong to them.
//!
//! d = 1 + (ss/s_rgb) sum_c |dI_c| + (ss/s_d) |dJ| (paper, equation 2 with the ratios of Gastal and Oliveira 2011). The
//! code k stands for d = 1 + k step. The step is a whole part of what a millimetre of depth counts, so that with the
//! default parameters, where a level of colour counts as much as 4 mm, nothing is rounded at all; and large enough for
//! code 254 to reach a weight of e^-9 in the first iteration. Code 255 is every larger distance, and its weight is 0:
//! nothing is passed on.

use super::{FilterParams, MAX_ITERATIONS};
use crate::fixed::exp_neg;
use crate::reconstruct::FilterKind;

/// e^-9 is a weight of 1/8000: beyond this many decay lengths nothing is passed on.
const REACH: u64 = 9;

/// sqrt(2/3) in Q32.
const ROOT_OF_TWO_THIRDS: u64 = 3_506_826_111;

/// How differences become codes, and codes weights.
#[derive(Debug, Clone)]
#[allow(missing_copy_implementations, reason = "2.5 kB of tables")]
pub struct DistanceTable {
    /// Codes per level of colour, Q16: at most 46.
    pub(super) per_level: u32,
    /// Codes per mm, Q16: at most 47.
    pub(super) per_mm: u32,
    /// Depth differences beyond this many mm count as this many.
    pub(super) max_step: u16,
    /// a^d of each iteration, Q16.
    weights: [[u16; 256]; MAX_ITERATIONS],
}

/// What can be divided by: validated parameters never come to 0, but the compiler does not know.
const fn divisor(x: u64) -> u64 {
    if x == 0 { 1 } else { x }
}

/// A distance (Q24) in steps (Q24), Q16, at most 47.
const fn codes(distance: u64, step: u64) -> u32 {
    let codes = ((distance << 16) + step / 2) / divisor(step);
    if codes > 47 << 16 { 47 << 16 } else { codes as u32 }
}

impl DistanceTable {
    /// The tables for validated parameters; at compile time in a `const` or `static`.
    pub const fn new(params: &FilterParams) -> Self {
        let space = params.sigma_space as u64;
        let n = if params.iterations == 0 { 1 } else { params.iterations as u32 };
        let n = if n > MAX_ITERATIONS as u32 { MAX_ITERATIONS as u32 } else { n };
        // rate = sqrt(2) / sigma_H of the first iteration = sqrt(2/3) sqrt(4^N - 1) / (ss 2^(N-1)), Q24: at most 4.
        let root = (((1u64 << (2 * n)) - 1) << 40).isqrt();
        let rate = (((ROOT_OF_TWO_THIRDS * root) >> 12) / divisor(space << (n - 1))) | 1;
        // Distances in Q24.
        let colour = (space << 24) / divisor(params.sigma_colour as u64);
        let mm = (space << 15) / divisor(params.sigma_depth as u64);
        let least = ((REACH << 48) / rate).div_ceil(254) | 1;
        let step = if mm > least { mm.div_ceil(divisor(mm / least)) } else { least };
        let per_level = if matches!(params.kind, FilterKind::Joint) { codes(colour, step) } else { 0 };
        let per_mm = codes(mm, step);
        // From there on the code is 255 whatever the colours say.
        let max_step = (255u32 << 16).div_ceil(if per_mm == 0 { 1 } else { per_mm });
        let max_step = if max_step > 2047 { 2047 } else { max_step as u16 };
        let mut weights = [[0; 256]; MAX_ITERATIONS];
        let mut i = 0;
        while i < MAX_ITERATIONS {
            let mut k = 0;
            // Code 255 is every larger distance: nothing is passed on.
            while k < 255 {
                // Q24 times Q16: below 2^31 each.
                let distance = ((1 << 24) + k as u64 * step) >> 8;
                let exponent = ((rate << i) * distance) >> 16;
                let weight = if exponent > u32::MAX as u64 { 0 } else { exp_neg(exponent as u32) };
                weights[i][k] = (weight.saturating_add(1 << 15) >> 16) as u16;
                k += 1;
            }
            i += 1;
        }
        Self { per_level, per_mm, max_step, weights }
    }

    /// a^d in Q16 by code, for each iteration.
    pub fn weights(&self) -> &[[u16; 256]; MAX_ITERATIONS] {
        &self.weights
    }

    /// The codes between the pixels of a row and their neighbours in `other` (the row above, or the row itself shifted by
    /// one): depths in mm, 0 where there is no reading. The depth's term is only between two readings.
    #[inline(always)]
    pub fn codes<const N: usize>(
        &self,
        depth: [&[u16; N]; 2],
        colour: Option<[&[[u8; 3]; N]; 2]>,
        codes: &mut [u8; N],
    ) {
        let step = |p: u16, q: u16| if p == 0 || q == 0 { 0 } else { u32::from(p.abs_diff(q).min(self.max_step)) };
        let contrast = |p: [u8; 3], q: [u8; 3]| {
            u32::from(p[0].abs_diff(q[0])) + u32::from(p[1].abs_diff(q[1])) + u32::from(p[2].abs_diff(q[2]))
        };
        // At most 47 * 765 + 256 + 47 codes in Q16: below 2^32.
        let code = |distance: u32| ((distance + (1 << 15)) >> 16).min(255) as u8;
        match colour {
            Some([here, there]) => {
                for i in 0..N {
                    let distance =
                        self.per_mm * step(depth[0][i], depth[1][i]) + self.per_level * contrast(here[i], there[i]);
                    codes[i] = code(distance);
                }
            }
            None => {
                for i in 0..N {
                    codes[i] = code(self.per_mm * step(depth[0][i], depth[1][i]));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reconstruct;

    #[test]
    fn the_default_parameters_are_not_rounded() {
        let table = DistanceTable::new(&FilterParams::new(&reconstruct::FilterParams::DEFAULT).unwrap());
        assert_eq!((table.per_level.next_multiple_of(4096), table.per_mm.next_multiple_of(4096)), (4 << 16, 1 << 16));
        let (depth, other) = ([1000, 1000, 0, 2000], [1003, 1400, 900, 2001]);
        let mut codes = [0; 4];
        table.codes([&depth, &other], None, &mut codes);
        assert_eq!(codes, [3, 255, 0, 1]);
        table.codes([&depth, &other], Some([&[[9; 3]; 4], &[[10, 8, 9]; 4]]), &mut codes);
        assert_eq!(codes, [11, 255, 8, 9]);
    }

    #[test]
    fn weights_are_those_of_the_domain_transform() {
        for (space, iterations) in [(12.0f32, 3), (0.5, 1), (100.0, 5), (3.0, 2)] {
            let float =
                reconstruct::FilterParams { sigma_space: space, iterations, ..reconstruct::FilterParams::DEFAULT };
            let table = DistanceTable::new(&FilterParams::new(&float).unwrap());
            let mm = f64::from(space) / 40.0;
            let step = mm / (f64::from(table.per_mm) / 65_536.0);
            for i in 0..iterations {
                let rate = 2f64.sqrt() / f64::from(float.sigma_of_iteration(i));
                for (k, w) in table.weights[usize::from(i)].iter().enumerate().take(255) {
                    let truth = libm::exp(-rate * (1.0 + k as f64 * step));
                    // Half a unit of the weight, and the step's rounding.
                    assert!((f64::from(*w) / 65_536.0 - truth).abs() < 1.2e-5, "{space} {i} {k}: {w} {truth}");
                }
            }
        }
    }

    #[test]
    fn extremes_do_not_overflow() {
        for space in [0.5, 100.0] {
            for sigma_colour in [1.0, 1000.0] {
                for sigma_depth in [0.001, 0.25] {
                    let float = reconstruct::FilterParams {
                        sigma_space: space,
                        sigma_colour,
                        sigma_depth,
                        ..reconstruct::FilterParams::DEFAULT
                    };
                    let table = DistanceTable::new(&FilterParams::new(&float).unwrap());
                    let mut codes = [0; 1];
                    table.codes([&[1], &[u16::MAX]], Some([&[[0; 3]], &[[255; 3]]]), &mut codes);
                    assert!(codes[0] >= 1, "{float:?}");
                }
            }
        }
    }
}
