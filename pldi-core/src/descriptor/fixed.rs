//! The descriptor in fixed point: each number as the logarithm of its magnitude.
//!
//! The Canberra distance asks for the ratio of two numbers, |a - b| / (a + b) = tanh(|ln a - ln b| / 2). Between
//! logarithms that is a subtraction and a table, the relative precision is the same for small and large numbers, 16 bits
//! are enough, and neither the division by the sum of all coefficients nor the standard deviation's root is left.

use super::{DescriptorKind, LENGTH};
use crate::fixed::log2;
use crate::wavelet::SIZE;
use crate::wavelet::fixed::{Plane, transform};

/// The 58 numbers of a view, in the order of [`super::Descriptor`], as codes.
///
/// Bit 15 is the sign (only skewness can be negative). The other bits are 0 for 0, else the magnitude's base-2 logarithm
/// in Q10 plus 26: codes 1..=32767 are 2^-25.999 to 2^5.999 in steps of 0.068 %. Smaller magnitudes are 0, larger ones
/// saturate (a skewness is below 64, all others are at most 1). [`SIGN`] alone is no code.
pub type Descriptor = [u16; LENGTH];

/// The sign's bit.
pub const SIGN: u16 = 1 << 15;

/// The code of 1.
const CODE_OF_ONE: i32 = 26 << 10;

/// Bits that the largest coefficient of a sub-band is brought to for its variance, and its deviations for their cubes.
const SQUARE_BITS: u32 = 24;
const CUBE_BITS: u32 = 20;

/// Bits that cubes lose before they are summed.
const CUBE_SHIFT: u32 = 12;

/// The descriptor of a view, which holds N << 7 (see [`Plane`]) and becomes its wavelet coefficients. A view that is 0
/// everywhere has 58 zeros.
pub fn describe(view: &mut Plane, kind: DescriptorKind) -> Descriptor {
    transform(view);
    from_coefficients(view, kind)
}

/// The descriptor of wavelet coefficients in the layout of [`transform`], of any size.
///
/// Numbers are within 1.5 steps of their codes; skewness, where it is small beside 1, within 0.002 and not relatively.
pub fn from_coefficients(coefficients: &Plane, kind: DescriptorKind) -> Descriptor {
    let corner = [coefficients[0][0], coefficients[1][0], coefficients[0][1], coefficients[1][1]];
    let corner = corner.map(|c| u64::from(c.unsigned_abs()));
    let mut sums = [Sums::default(); (LENGTH - 4) / 3];
    for (sums, band) in sums.iter_mut().zip(Band::all(coefficients)) {
        *sums = band.sums();
    }
    // At most 2^14 coefficients of at most 2^31.
    let total = corner.iter().sum::<u64>() + sums.iter().map(|s| s.upper + s.lower).sum::<u64>();
    let mut out = [0; LENGTH];
    let Some(total) = log2(total) else { return out };
    let (first, rest) = out.split_at_mut(4);
    for (code, c) in first.iter_mut().zip(corner) {
        *code = log2(c).map_or(0, |log| code_of(log - total));
    }
    for ((numbers, band), sums) in rest.as_chunks_mut::<3>().0.iter_mut().zip(Band::all(coefficients)).zip(sums) {
        *numbers = band.statistics(kind, &sums, total);
    }
    out
}

/// One sub-band: a square of the coefficients, 2^level on a side.
#[derive(Clone, Copy)]
struct Band<'a> {
    coefficients: &'a Plane,
    top: usize,
    left: usize,
    level: u32,
}

/// What can be summed before the largest coefficient is known.
#[derive(Clone, Copy, Default)]
struct Sums {
    upper: u64,
    lower: u64,
    /// All absolute values or-ed: as many bits as the largest has.
    bits: u32,
}

impl<'a> Band<'a> {
    /// The sub-bands in the order of their numbers.
    fn all(coefficients: &'a Plane) -> impl Iterator<Item = Self> {
        (1..SIZE.ilog2()).flat_map(move |level| {
            let size = 1 << level;
            [(size, 0), (0, size), (size, size)].map(|(top, left)| Self { coefficients, top, left, level })
        })
    }

    fn size(&self) -> usize {
        1 << self.level
    }

    fn rows(&self) -> impl Iterator<Item = &'a [i32]> {
        let (left, size) = (self.left, self.size());
        self.coefficients.iter().skip(self.top).take(size).filter_map(move |row| row.get(left..left + size))
    }

    fn sums(&self) -> Sums {
        let mut sums = Sums::default();
        for (i, row) in self.rows().enumerate() {
            let (mut sum, mut bits) = (0, 0);
            for c in row {
                sum += u64::from(c.unsigned_abs());
                bits |= c.unsigned_abs();
            }
            *if i < self.size() / 2 { &mut sums.upper } else { &mut sums.lower } += sum;
            sums.bits |= bits;
        }
        sums
    }

    fn statistics(&self, kind: DescriptorKind, sums: &Sums, total: i32) -> [u16; 3] {
        if sums.bits == 0 {
            return [0; 3];
        }
        // Logarithms of 2^-n and of the shift, in Q16.
        let count = (2 * self.level as i32) << 16;
        let scale = Scale::new(sums.bits);
        let code = |sum: u64, count: i32| log2(sum).map_or(0, |log| code_of(log - count - total));
        let (squares, mean) = self.squares(scale);
        let variance = log2(squares).map(|log| log - count);
        let deviation = variance.map_or(0, |v| code_of(v / 2 - (scale.exponent() << 16) - total));
        match kind {
            DescriptorKind::Halves => {
                [code(sums.upper, count - (1 << 16)), code(sums.lower, count - (1 << 16)), deviation]
            }
            DescriptorKind::Paper => {
                // Equal coefficients have no skewness; their rounding errors have.
                let real = squares > ((u64::from(mean) * u64::from(mean)) >> 40) << (2 * self.level);
                let skewness = variance.filter(|_| real).map_or(0, |variance| self.skewness(scale, mean, variance));
                [code(sums.upper + sums.lower, count), deviation, skewness]
            }
        }
    }

    /// The sum of squared deviations from the mean, and the mean, of the scaled coefficients.
    ///
    /// At most 2^12 squares below 2^48: sums stay below 2^60. The mean is rounded: what that adds to the squares is taken
    /// off again, but for less than one unit.
    fn squares(&self, scale: Scale) -> (u64, u32) {
        let (mut sum, mut squares) = (0u64, 0u64);
        for row in self.rows() {
            for c in row {
                let a = u64::from(scale.apply(*c));
                sum += a;
                squares += a * a;
            }
        }
        let bits = 2 * self.level;
        let mean = (sum + (1 << (bits - 1))) >> bits;
        // sum (a - m)^2 = sum a^2 - m (2 sum a - n m), where m (..) may pass 2^64 on the way, but the result does not.
        let about = squares.wrapping_sub(mean.wrapping_mul((2 * sum).wrapping_sub(mean << bits)));
        let off = sum.abs_diff(mean << bits);
        (about.saturating_sub((off * off) >> bits), mean as u32)
    }

    /// The code of m3 / sd^3, where the logarithm of the variance (Q16) is that of the scaled coefficients.
    ///
    /// Deviations of 20 bits have cubes below 2^60; without 12 bits, 2^12 of them stay below 2^60.
    fn skewness(&self, scale: Scale, mean: u32, variance: i32) -> u16 {
        const DROP: u32 = SQUARE_BITS - CUBE_BITS;
        let mut third = 0i64;
        for row in self.rows() {
            for c in row {
                let d = (scale.apply(*c) as i32 - mean as i32 + (1 << (DROP - 1))) >> DROP;
                let d = i64::from(d);
                third += (d * d * d + (1 << (CUBE_SHIFT - 1))) >> CUBE_SHIFT;
            }
        }
        let Some(log) = log2(third.unsigned_abs()) else { return 0 };
        let shifts = (CUBE_SHIFT + 3 * DROP) as i32 - 2 * self.level as i32;
        let code = code_of(log + (shifts << 16) - 3 * variance / 2);
        if third < 0 && code > 0 { code | SIGN } else { code }
    }
}

/// The shift that gives the largest coefficient of a sub-band [`SQUARE_BITS`] bits: to the left or to the right.
#[derive(Clone, Copy)]
struct Scale {
    left: u32,
    right: u32,
}

impl Scale {
    fn new(bits: u32) -> Self {
        let bits = 32 - bits.leading_zeros();
        Self { left: SQUARE_BITS.saturating_sub(bits), right: bits.saturating_sub(SQUARE_BITS) }
    }

    /// The scaled absolute value, below 2^24.
    #[inline(always)]
    fn apply(self, c: i32) -> u32 {
        (c.unsigned_abs() << self.left) >> self.right
    }

    fn exponent(self) -> i32 {
        self.left as i32 - self.right as i32
    }
}

/// The code of a magnitude whose logarithm is known in Q16; rounded to nearest, 0 below the range, saturated above.
fn code_of(log: i32) -> u16 {
    let code = ((log + (1 << 5)) >> 6).saturating_add(CODE_OF_ONE);
    code.clamp(0, i32::from(i16::MAX)) as u16
}

/// The code of a float, from its bits: the same on every machine. NaN counts as infinite.
pub fn encode(value: f32) -> u16 {
    let bits = value.to_bits();
    let exponent = (bits >> 23 & 0xFF) as i32;
    // Numbers without the leading bit lie far below the range.
    let mantissa = u64::from(bits & 0x7F_FFFF | 0x80_0000);
    let Some(log) = log2(mantissa).filter(|_| exponent > 0) else { return 0 };
    let code = code_of(log + ((exponent - 150) << 16));
    if bits >> 31 == 1 && code > 0 { code | SIGN } else { code }
}

/// The number that a code stands for: for hosts, and where descriptors are looked at.
pub fn decode(code: u16) -> f32 {
    let magnitude = i32::from(code & !SIGN);
    if magnitude == 0 {
        return 0.0;
    }
    let value = libm::exp2f((magnitude - CODE_OF_ONE) as f32 / 1024.0);
    if code & SIGN == 0 { value } else { -value }
}

#[cfg(test)]
mod tests;
