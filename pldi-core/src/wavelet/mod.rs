//! The two-dimensional discrete wavelet transform of a view (paper, section 5, equations 4 and 5): Daubechies D8,
//! 7 levels, periodic, in place.
//!
//! The layout is Mallat's: after a level of size s the approximation stands at rows and columns 0..s/2, the
//! horizontal detail below it (high-pass along the columns), the vertical detail beside it, the diagonal detail
//! diagonally. The phase is that of PyWavelets' `periodization` mode with "db4": output o weighs inputs 2o-3..=2o+4.
//! The transform is orthonormal; equation 4's factor 1/2B would only scale all coefficients alike.

pub mod fixed;

/// Side of a view in pixels, 2B in the paper.
pub const SIZE: usize = 128;

/// Levels of the transform: log2 of [`SIZE`].
pub const LEVELS: usize = 7;

/// A square image of [`SIZE`] x [`SIZE`], or its coefficients.
pub type Plane = [[f32; SIZE]; SIZE];

/// The scaling filter of Daubechies' wavelet with 8 taps (4 vanishing moments).
#[expect(clippy::excessive_precision, reason = "as published")]
const LOW: [f32; 8] = [
    0.230_377_813_308_896_5,
    0.714_846_570_552_915_7,
    0.630_880_767_929_858_9,
    -0.027_983_769_416_859_9,
    -0.187_034_811_719_093_1,
    0.030_841_381_835_560_8,
    0.032_883_011_666_885_2,
    -0.010_597_401_785_069_0,
];

/// The wavelet filter, g[k] = (-1)^k h[7 - k].
const HIGH: [f32; 8] = [LOW[7], -LOW[6], LOW[5], -LOW[4], LOW[3], -LOW[2], LOW[1], -LOW[0]];

/// Columns that are transformed side by side.
const LANES: usize = 8;

/// Half of the largest signal.
const HALF: usize = SIZE / 2;

/// Room for the wrapped neighbours of the even and odd samples: two before, two behind.
const PAD: usize = 2;

/// Replaces an image by its wavelet coefficients, all [`LEVELS`] levels.
pub fn transform(plane: &mut Plane) {
    let mut size = SIZE;
    while size >= 2 {
        for row in plane.iter_mut().take(size) {
            transform_row(row, size);
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
fn transform_row(row: &mut [f32; SIZE], size: usize) {
    // Never larger; the compiler does not see it.
    let half = (size / 2).min(HALF);
    let (mut even, mut odd) = ([0.0; HALF + 2 * PAD], [0.0; HALF + 2 * PAD]);
    let (pairs, _) = row.as_chunks::<2>();
    for i in 0..half + 2 * PAD {
        let [e, o] = pairs[(i + size - PAD) & (half - 1) & (HALF - 1)];
        (even[i], odd[i]) = (e, o);
    }
    for o in 0..half {
        row[o] = taps(&LOW, |k| if k % 2 == 1 { even[o + k / 2 + 1] } else { odd[o + k / 2] });
        row[half + o] = taps(&HIGH, |k| if k % 2 == 1 { even[o + k / 2 + 1] } else { odd[o + k / 2] });
    }
}

/// One level along the columns `first..first + LANES` (as many of them as lie within `size`).
fn transform_columns(plane: &mut Plane, first: usize, size: usize) {
    let (half, width) = ((size / 2).min(HALF), LANES.min(size - first));
    let mut input = [[0.0; LANES]; SIZE];
    for (to, from) in input.iter_mut().zip(plane.iter()).take(size) {
        to[..width].copy_from_slice(&from[first..first + width]);
    }
    for o in 0..half {
        // Outputs 1 and 2 before the end wrap around at the bottom, output 0 and 1 at the top.
        let rows: [&[f32; LANES]; 8] =
            core::array::from_fn(|k| &input[(2 * o + k + 4 * size - 3) & (size - 1) & (SIZE - 1)]);
        let (mut low, mut high) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            low[i] = taps(&LOW, |k| rows[k][i]);
            high[i] = taps(&HIGH, |k| rows[k][i]);
        }
        plane[o][first..first + width].copy_from_slice(&low[..width]);
        plane[half + o][first..first + width].copy_from_slice(&high[..width]);
    }
}

/// The sum of eight products, always in the same order.
#[inline(always)]
fn taps(filter: &[f32; 8], x: impl Fn(usize) -> f32) -> f32 {
    ((filter[0] * x(0) + filter[1] * x(1)) + (filter[2] * x(2) + filter[3] * x(3)))
        + ((filter[4] * x(4) + filter[5] * x(5)) + (filter[6] * x(6) + filter[7] * x(7)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn plane_of(f: impl Fn(usize, usize) -> f32) -> Box<Plane> {
        let rows: Vec<[f32; SIZE]> = (0..SIZE).map(|y| core::array::from_fn(|x| f(x, y))).collect();
        rows.into_boxed_slice().try_into().unwrap()
    }

    fn energy(plane: &Plane) -> f64 {
        plane.as_flattened().iter().map(|v| f64::from(*v) * f64::from(*v)).sum()
    }

    #[test]
    fn a_constant_is_one_coefficient() {
        let mut plane = plane_of(|_, _| 0.5);
        transform(&mut plane);
        assert!((plane[0][0] - 64.0).abs() < 1e-4);
        assert!(plane.as_flattened()[1..].iter().all(|c| c.abs() < 2e-5));
    }

    #[test]
    fn an_impulse_gives_the_filters_taps() {
        // Input column 64 reaches output o with the tap k = 64 - 2o + 3.
        let mut row = [0.0; SIZE];
        row[64] = 1.0;
        transform_row(&mut row, SIZE);
        for o in 30..34 {
            let k = 67 - 2 * o;
            assert_eq!((row[o], row[HALF + o]), (LOW[k], HIGH[k]), "{o}");
        }
    }

    #[test]
    fn edges_go_to_the_band_of_their_direction() {
        // A horizontal edge is detail along the columns: the band below the approximation.
        let mut plane = plane_of(|_, y| if y < 41 { 1.0 } else { 0.0 });
        transform(&mut plane);
        let sum = |rows: core::ops::Range<usize>, columns: core::ops::Range<usize>| -> f32 {
            rows.flat_map(|y| columns.clone().map(move |x| (x, y))).map(|(x, y)| plane[y][x].abs()).sum()
        };
        assert!(sum(64..128, 0..64) > 10.0);
        assert!(sum(0..64, 64..128) < 1e-3 && sum(64..128, 64..128) < 1e-3);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]

        #[test]
        fn the_transform_keeps_the_energy(values in proptest::collection::vec(0.0f32..1.0, SIZE * SIZE)) {
            let mut plane = plane_of(|x, y| values[y * SIZE + x]);
            let before = energy(&plane);
            transform(&mut plane);
            prop_assert!((energy(&plane) / before - 1.0).abs() < 2e-6);
        }

        /// Rows before columns or columns before rows: the transposed image has the transposed coefficients.
        #[test]
        fn transposing_commutes(values in proptest::collection::vec(0.0f32..1.0, SIZE * SIZE)) {
            let mut a = plane_of(|x, y| values[y * SIZE + x]);
            let mut b = plane_of(|x, y| values[x * SIZE + y]);
            transform(&mut a);
            transform(&mut b);
            for y in 0..SIZE {
                for x in 0..SIZE {
                    prop_assert!((a[y][x] - b[x][y]).abs() < 3e-5);
                }
            }
        }
    }
}
