//! The wavelet transform in fixed point: the same filter, layout and phase.
//!
//! Headroom: the largest view, N = 65535 everywhere, is one coefficient of 128 * 65535 * 128 = 2^30 - 2^14, and as the
//! transform is orthonormal no coefficient of any view, on any level, exceeds the root of the view's energy, which is that
//! number. Rounding adds at most half a unit to each of 128 * 128 numbers in each pass over rows or columns, 64 units to
//! that root (half as many on each further level: 256 in all); the rounded taps lengthen it by less than 2^-26 in each
//! of 14 passes, 224 units in all. So every coefficient stays below 2^30 in absolute value.

mod single;

use super::{HALF, PAD, SIZE};

/// A square image of [`SIZE`] x [`SIZE`] in units of 1/128 of N's (N shifted left by [`SHIFT`]), or its coefficients in the
/// same unit.
pub type Plane = [[i32; SIZE]; SIZE];

/// Fraction bits of a [`Plane`] below the unit of N.
pub const SHIFT: u32 = 7;

/// The scaling filter in Q30, rounded so that taps 0, 2, 4, 6 and taps 1, 3, 5, 7 have the same sum: constants have no
/// detail at all.
const LOW: [i32; 8] =
    [247_366_293, 767_560_660, 677_403_066, -30_047_344, -200_827_100, 33_115_682, 35_307_865, -11_378_874];

/// The wavelet filter, as in the float transform.
const HIGH: [i32; 8] = [LOW[7], -LOW[6], LOW[5], -LOW[4], LOW[3], -LOW[2], LOW[1], -LOW[0]];

/// What samples are raised by while they are weighed: then they lie in 0..2^31, and unsigned products do. SSE2 has no
/// others with 64 bits.
const RAISE: u32 = 1 << 30;

/// Columns that are transformed side by side.
const LANES: usize = 8;

/// Replaces an image by its wavelet coefficients, all levels.
///
/// In: 0..=65535 * 128. Out: below 2^30 in absolute value. Each pass rounds to nearest, halves up. Inputs beyond the
/// range do not panic, but wrap.
pub fn transform(plane: &mut Plane) {
    if cfg!(target_pointer_width = "64") { side_by_side(plane) } else { single::transform(plane) }
}

/// The transform for machines that compute several columns at once.
fn side_by_side(plane: &mut Plane) {
    let mut size = SIZE;
    while size >= 2 {
        for row in plane.iter_mut().take(size) {
            // Black rows stay what they are: there are many around an object.
            if row.iter().take(size).any(|c| *c != 0) {
                transform_row(row, size);
            }
        }
        let mut first = 0;
        while first < size {
            transform_columns(plane, first, size);
            first += LANES;
        }
        size /= 2;
    }
}

/// One level along a row of `size` values.
fn transform_row(row: &mut [i32; SIZE], size: usize) {
    // Never larger; the compiler does not see it.
    let half = (size / 2).min(HALF);
    let (mut even, mut odd) = ([0; HALF + 2 * PAD], [0; HALF + 2 * PAD]);
    let (pairs, _) = row.as_chunks::<2>();
    for i in 0..half + 2 * PAD {
        let [e, o] = pairs[(i + size - PAD) & (half - 1) & (HALF - 1)];
        (even[i], odd[i]) = (raise(e), raise(o));
    }
    for o in 0..half {
        let x = |k: usize| if k % 2 == 1 { even[o + k / 2 + 1] } else { odd[o + k / 2] };
        (row[o], row[half + o]) = (taps(&LOW, x), taps(&HIGH, x));
    }
}

/// One level along the columns `first..first + LANES` (as many of them as lie within `size`).
fn transform_columns(plane: &mut Plane, first: usize, size: usize) {
    let (half, width) = ((size / 2).min(HALF), LANES.min(size - first));
    let mut input = [[0; LANES]; SIZE];
    let mut any = 0;
    for (to, from) in input.iter_mut().zip(plane.iter()).take(size) {
        for (to, from) in to.iter_mut().zip(&from[first..first + width]) {
            *to = raise(*from);
            any |= *from;
        }
    }
    if any == 0 {
        return;
    }
    for o in 0..half {
        let rows: [&[u32; LANES]; 8] =
            core::array::from_fn(|k| &input[(2 * o + k + 4 * size - 3) & (size - 1) & (SIZE - 1)]);
        let (mut low, mut high) = ([0; LANES], [0; LANES]);
        for i in 0..LANES {
            low[i] = taps(&LOW, |k| rows[k][i]);
            high[i] = taps(&HIGH, |k| rows[k][i]);
        }
        plane[o][first..first + width].copy_from_slice(&low[..width]);
        plane[half + o][first..first + width].copy_from_slice(&high[..width]);
    }
}

/// A sample as [`taps`] wants it.
#[inline(always)]
fn raise(x: i32) -> u32 {
    (x as u32).wrapping_add(RAISE)
}

/// The sum of eight products of Q30 taps and raised samples, rounded to nearest and no longer raised.
///
/// The raised samples are below 2^31 and the taps' absolute values add up to less than 2^31, so that the sum is exact
/// as a signed number of 64 bits; bits 30 to 61 are the result.
#[inline(always)]
fn taps(filter: &[i32; 8], x: impl Fn(usize) -> u32) -> i32 {
    let raised: i64 = filter.iter().map(|tap| i64::from(*tap)).sum::<i64>() << 30;
    let mut sum = (1u64 << 29).wrapping_sub(raised as u64);
    for (k, tap) in filter.iter().enumerate() {
        let x = x(k);
        sum = if cfg!(target_arch = "x86_64") {
            let product = u64::from(tap.unsigned_abs()).wrapping_mul(u64::from(x));
            if *tap < 0 { sum.wrapping_sub(product) } else { sum.wrapping_add(product) }
        } else {
            // Others multiply and add with sign at once; the product is the same.
            sum.wrapping_add((i64::from(*tap) * i64::from(x as i32)) as u64)
        };
    }
    (sum >> 30) as u32 as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wavelet;
    use proptest::prelude::*;

    fn plane_of(f: impl Fn(usize, usize) -> u16) -> Box<Plane> {
        let rows: Vec<[i32; SIZE]> = (0..SIZE).map(|y| core::array::from_fn(|x| i32::from(f(x, y)) << SHIFT)).collect();
        rows.into_boxed_slice().try_into().unwrap()
    }

    /// What the signed sum of products says, in the plainest form.
    fn plain_row(row: &[i32], size: usize) -> Vec<i32> {
        let half = size / 2;
        let sum = |filter: &[i32; 8], o: usize| {
            let terms = filter.iter().enumerate();
            let sum: i64 =
                terms.map(|(k, tap)| i64::from(*tap) * i64::from(row[(2 * o + k + 4 * size - 3) % size])).sum();
            i32::try_from((sum + (1 << 29)) >> 30).unwrap()
        };
        (0..half).map(|o| sum(&LOW, o)).chain((0..half).map(|o| sum(&HIGH, o))).collect()
    }

    fn largest(plane: &Plane) -> u32 {
        plane.as_flattened().iter().map(|c| c.unsigned_abs()).max().unwrap()
    }

    /// The exact transform with the published taps, in double precision.
    fn exact(plane: &Plane) -> Vec<f64> {
        let published = [
            0.230_377_813_308_896_5,
            0.714_846_570_552_915_7,
            0.630_880_767_929_858_9,
            -0.027_983_769_416_859_9,
            -0.187_034_811_719_093_1,
            0.030_841_381_835_560_8,
            0.032_883_011_666_885_2,
            -0.010_597_401_785_069,
        ];
        let high: [f64; 8] = core::array::from_fn(|k| if k % 2 == 0 { published[7 - k] } else { -published[7 - k] });
        let mut values: Vec<f64> = plane.as_flattened().iter().map(|c| f64::from(*c)).collect();
        let mut size = SIZE;
        while size >= 2 {
            for (along, across) in [(1, SIZE), (SIZE, 1)] {
                for line in 0..size {
                    let old: Vec<f64> = (0..size).map(|i| values[line * across + i * along]).collect();
                    let sum = |filter: &[f64; 8], o: usize| -> f64 {
                        (0..8).map(|k| filter[k] * old[(2 * o + k + 4 * size - 3) % size]).sum()
                    };
                    for o in 0..size / 2 {
                        values[line * across + o * along] = sum(&published, o);
                        values[line * across + (size / 2 + o) * along] = sum(&high, o);
                    }
                }
            }
            size /= 2;
        }
        values
    }

    #[test]
    fn the_taps_are_those_of_the_float_transform() {
        for (fixed, float) in LOW.iter().chain(&HIGH).zip(wavelet::LOW.iter().chain(&wavelet::HIGH)) {
            assert!((f64::from(*fixed) / 1_073_741_824.0 - f64::from(*float)).abs() < 3e-8, "{fixed} {float}");
        }
        assert_eq!(HIGH.iter().sum::<i32>(), 0);
    }

    #[test]
    fn a_constant_is_one_coefficient() {
        for n in [0, 1, 40_000, u16::MAX] {
            let mut plane = plane_of(|_, _| n);
            transform(&mut plane);
            // All pixels round alike: up to half a unit of the finest level, 64 times, and so on.
            assert!((plane[0][0] - (i32::from(n) << 14)).abs() <= 128, "{n}: {}", plane[0][0]);
            assert!(plane.as_flattened()[1..].iter().all(|c| *c == 0));
        }
    }

    /// The views with the largest coefficients of all: 65535 where a basis function is positive (or negative), else 0.
    #[test]
    fn the_largest_coefficients_fit() {
        for (row, column) in [(0, 0), (1, 0), (1, 1), (2, 3), (5, 9), (20, 40), (64, 0), (100, 127)] {
            // The transform's inverse is its transpose: a basis function from what each impulse contributes would be
            // slow; its sign is that of the impulse responses of the float transform, row by column.
            let response = |i: usize, j: usize| {
                let mut plane: Box<wavelet::Plane> = vec![[0.0; SIZE]; SIZE].into_boxed_slice().try_into().unwrap();
                plane[i][j] = 1.0;
                wavelet::transform(&mut plane);
                plane
            };
            let sign = |i: usize, j: usize| response(i, j)[row][column];
            // Every 4th pixel decides for its block.
            let coarse: Vec<f32> = (0..32 * 32).map(|p| sign(4 * (p / 32) + 2, 4 * (p % 32) + 2)).collect();
            for side in [1.0, -1.0] {
                let mut plane = plane_of(|x, y| if side * coarse[(y / 4) * 32 + x / 4] > 0.0 { u16::MAX } else { 0 });
                transform(&mut plane);
                assert!(largest(&plane) < 1 << 30, "{row} {column}");
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        #[test]
        fn the_raised_sums_are_the_signed_sums(
            values in proptest::collection::vec(-(1i32 << 29)..1 << 29, SIZE), level in 1u32..=7,
        ) {
            let size = 1 << level;
            let mut row: [i32; SIZE] = values.try_into().unwrap();
            let want = plain_row(&row, size);
            transform_row(&mut row, size);
            prop_assert_eq!(&row[..size], &want[..]);
        }

        #[test]
        fn errors_are_a_few_units(values in proptest::collection::vec(any::<u16>(), SIZE * SIZE), binary: bool) {
            let value = |v: u16| if binary { if v > 32_767 { u16::MAX } else { 0 } } else { v };
            let mut plane = plane_of(|x, y| value(values[y * SIZE + x]));
            let truth = exact(&plane);
            let mut float: Box<wavelet::Plane> = vec![[0.0; SIZE]; SIZE].into_boxed_slice().try_into().unwrap();
            for (to, from) in float.as_flattened_mut().iter_mut().zip(plane.as_flattened()) {
                *to = *from as f32 / (65_535.0 * 128.0);
            }
            let mut single = plane.clone();
            single::transform(&mut single);
            transform(&mut plane);
            prop_assert!(plane == single);
            wavelet::transform(&mut float);
            prop_assert!(largest(&plane) < 1 << 30);
            for ((got, want), float) in plane.as_flattened().iter().zip(truth).zip(float.as_flattened()) {
                prop_assert!((f64::from(*got) - want).abs() < 16.0, "{got} {want}");
                prop_assert!((f64::from(*got) / (65_535.0 * 128.0) - f64::from(*float)).abs() < 5e-5);
            }
        }

        /// What is black is skipped in different ways: an object with holes, in one or two parts.
        #[test]
        fn one_by_one_or_side_by_side(
            seed in any::<u32>(), bounds in proptest::array::uniform4(0..SIZE), sparse in 0u32..8, inverse in any::<bool>(),
        ) {
            let mut plane = plane_of(|x, y| {
                let inside = (bounds[0]..=bounds[1]).contains(&x) && (bounds[2]..=bounds[3]).contains(&y);
                let noise = ((x + y * SIZE) as u32 ^ seed).wrapping_mul(0x9E37_79B1) >> 8;
                if inside == inverse || noise & 7 < sparse { 0 } else { (noise >> 8) as u16 }
            });
            let mut single = plane.clone();
            single::transform(&mut single);
            side_by_side(&mut plane);
            prop_assert!(plane == single);
        }

        /// Whatever is in the plane: no panic.
        #[test]
        fn inputs_beyond_the_range_wrap(values in proptest::collection::vec(any::<i32>(), SIZE * SIZE)) {
            let rows: Vec<[i32; SIZE]> = values.chunks_exact(SIZE).map(|row| row.try_into().unwrap()).collect();
            let mut plane: Box<Plane> = rows.into_boxed_slice().try_into().unwrap();
            single::transform(&mut plane.clone());
            transform(&mut plane);
        }
    }
}
