//! The 58 numbers of a view (paper, section 5): statistics of its normalised wavelet coefficients.

pub mod fixed;

use crate::math;
use crate::wavelet::{self, LEVELS, Plane, SIZE};

/// Numbers in a descriptor: 3 directions x 3 statistics x 6 levels, and the 4 values of the coarsest level.
pub const LENGTH: usize = 9 * (LEVELS - 1) + 4;

/// A view: N of one object, seen frontally, as fractions of 65535, row by row; 0 beside the object.
pub type View = [[u16; SIZE]; SIZE];

/// The descriptor of a view.
///
/// Coefficients are taken as absolute values and divided by the sum of all of them. Order: the coarsest level's
/// approximation, horizontal, vertical and diagonal value; then, level by level from 2x2 to 64x64, the horizontal,
/// vertical and diagonal sub-band with three statistics each, see [`DescriptorKind`].
pub type Descriptor = [f32; LENGTH];

/// Which three statistics describe a sub-band. Descriptors of different kinds must not be compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum DescriptorKind {
    /// Mean, population standard deviation and skewness m3/sd^3 (0 where sd is 0), as in the paper.
    Paper = 0,
    /// Mean of the upper half, mean of the lower half, standard deviation of the whole: objects stand upright, so
    /// where along the height the detail sits tells classes apart.
    #[default]
    Halves = 1,
}

impl DescriptorKind {
    /// The kind with this number, as template files record it.
    pub const fn from_number(number: u8) -> Option<Self> {
        match number {
            0 => Some(Self::Paper),
            1 => Some(Self::Halves),
            _ => None,
        }
    }

    /// The name used on command lines and in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Halves => "halves",
        }
    }
}

/// The descriptor of a view; `scratch` receives the wavelet coefficients (not normalised). A view that is 0
/// everywhere has 58 zeros.
pub fn describe(view: &View, kind: DescriptorKind, scratch: &mut Plane) -> Descriptor {
    for (to, from) in scratch.as_flattened_mut().iter_mut().zip(view.as_flattened()) {
        *to = f32::from(*from) / 65535.0;
    }
    wavelet::transform(scratch);
    from_coefficients(scratch, kind)
}

/// The descriptor of wavelet coefficients in the layout of [`wavelet::transform`].
pub fn from_coefficients(coefficients: &Plane, kind: DescriptorKind) -> Descriptor {
    let mut out = [0.0; LENGTH];
    let total: f32 = coefficients.iter().map(|row| lanes_sum(row, f32::abs)).sum();
    // Written so that NaN fails the test.
    if !(total > 0.0) {
        return out;
    }
    let scale = 1.0 / total;
    let corner = [coefficients[0][0], coefficients[1][0], coefficients[0][1], coefficients[1][1]];
    out[..4].copy_from_slice(&corner.map(|c| c.abs() * scale));
    let mut size = 2;
    let mut bands = out[4..].as_chunks_mut::<3>().0.iter_mut();
    while size < SIZE {
        for (top, left) in [(size, 0), (0, size), (size, size)] {
            if let Some(numbers) = bands.next() {
                *numbers = Band { coefficients, top, left, size }.statistics(kind, scale);
            }
        }
        size *= 2;
    }
    out
}

/// One sub-band: a square of the coefficients.
struct Band<'a> {
    coefficients: &'a Plane,
    top: usize,
    left: usize,
    size: usize,
}

impl Band<'_> {
    /// Sum of f(|c|) over the rows `from..to` of the band.
    fn sum(&self, from: usize, to: usize, f: impl Fn(f32) -> f32 + Copy) -> f32 {
        let rows = self.coefficients.iter().skip(self.top + from).take(to - from);
        rows.map(|row| row.get(self.left..self.left + self.size).map_or(0.0, |row| lanes_sum(row, |c| f(c.abs()))))
            .sum()
    }

    fn statistics(&self, kind: DescriptorKind, scale: f32) -> [f32; 3] {
        let count = (self.size * self.size) as f32;
        let (upper, lower) = (self.sum(0, self.size / 2, |a| a), self.sum(self.size / 2, self.size, |a| a));
        let mean = (upper + lower) / count;
        let variance = self.sum(0, self.size, |a| (a - mean) * (a - mean)) / count;
        let deviation = math::sqrt(variance);
        match kind {
            DescriptorKind::Halves => [upper / (0.5 * count) * scale, lower / (0.5 * count) * scale, deviation * scale],
            DescriptorKind::Paper => {
                // Equal coefficients have no skewness; their rounding errors have.
                let skewness = if deviation * scale > 1e-12 && deviation > 1e-6 * mean {
                    let third = self.sum(0, self.size, |a| (a - mean) * (a - mean) * (a - mean)) / count;
                    third / (variance * deviation)
                } else {
                    0.0
                };
                [mean * scale, deviation * scale, skewness]
            }
        }
    }
}

/// Sum of f over a slice in four lanes: the same order of additions on every target, short chains of rounding errors.
#[inline(always)]
fn lanes_sum(values: &[f32], f: impl Fn(f32) -> f32) -> f32 {
    let mut lanes = [0.0f32; 4];
    let (chunks, rest) = values.as_chunks::<4>();
    for chunk in chunks {
        for i in 0..4 {
            lanes[i] += f(chunk[i]);
        }
    }
    for (lane, value) in lanes.iter_mut().zip(rest) {
        *lane += f(*value);
    }
    (lanes[0] + lanes[2]) + (lanes[1] + lanes[3])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blank() -> Box<Plane> {
        vec![[0.0; SIZE]; SIZE].into_boxed_slice().try_into().unwrap()
    }

    #[test]
    fn a_blank_view_has_58_zeros() {
        let view: Box<View> = vec![[0; SIZE]; SIZE].into_boxed_slice().try_into().unwrap();
        assert_eq!(describe(&view, DescriptorKind::Paper, &mut blank()), [0.0; 58]);
    }

    #[test]
    fn a_constant_view_is_all_approximation() {
        let view: Box<View> = vec![[40_000; SIZE]; SIZE].into_boxed_slice().try_into().unwrap();
        let d = describe(&view, DescriptorKind::Halves, &mut blank());
        assert!((d[0] - 1.0).abs() < 1e-3, "{}", d[0]);
    }

    #[test]
    fn known_coefficients_have_known_statistics() {
        // The horizontal 2x2 band holds 1, -2, 3, 4 (rows first), everything else is 0.
        let mut c = blank();
        (c[2][0], c[2][1], c[3][0], c[3][1]) = (1.0, -2.0, 3.0, 4.0);
        let sd = 1.25f32.sqrt();
        let paper = from_coefficients(&c, DescriptorKind::Paper);
        for (got, want) in paper[4..7].iter().zip([0.25, sd / 10.0, 0.0]) {
            assert!((got - want).abs() < 1e-6, "{paper:?}");
        }
        let halves = from_coefficients(&c, DescriptorKind::Halves);
        for (got, want) in halves[4..7].iter().zip([0.15, 0.35, sd / 10.0]) {
            assert!((got - want).abs() < 1e-6, "{halves:?}");
        }
        assert!(paper[7..].iter().chain(&paper[..4]).all(|v| *v == 0.0));
    }

    #[test]
    fn one_outlier_skews_to_the_right() {
        // n - 1 zeros and a one: skewness (n - 2) / sqrt(n - 1).
        let mut c = blank();
        c[4][2] = 5.0;
        let d = from_coefficients(&c, DescriptorKind::Paper);
        let band = &d[4 + 9..4 + 12];
        assert!((band[2] - 14.0 / 15.0f32.sqrt()).abs() < 1e-5, "{band:?}");
    }

    #[test]
    fn scaling_a_view_changes_nothing() {
        let view = |s: u16| -> Box<View> {
            let rows: Vec<[u16; SIZE]> =
                (0..SIZE).map(|y| core::array::from_fn(|x| s * ((x * 7 + y * y) % 100) as u16)).collect();
            rows.into_boxed_slice().try_into().unwrap()
        };
        let [a, b] = [100, 600].map(|s| describe(&view(s), DescriptorKind::Paper, &mut blank()));
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-3 * a.abs() + 1e-7), "{a:?} {b:?}");
    }
}
