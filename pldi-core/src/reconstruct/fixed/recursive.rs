//! The recursive filter of the domain transform in integers, on depth and mask at once, both ways along rows and columns.
//!
//! Four rows or columns at a time are widened to 32 bits: the weight m in Q27, and the product s = D m of depth (1/8 mm)
//! and weight in Q14, both below 2^30. `F[x] += a^d[x] (F[x-1] - F[x])` runs forth and back on them without a division;
//! then D = s/m goes back into 16 bits, rounded to nearest. So a depth is rounded once per pass, not once per step: a
//! feedback filter that rounds its own output to 1/8 mm at each step would stick up to half a millimetre beside its mean.

use super::weight;
use crate::Image;
use crate::fixed::reciprocal;

/// Rows or columns that are filtered side by side.
pub const LANES: usize = 4;

/// One number for each of the rows or columns.
type Lane = [i32; LANES];

/// Scratch for [`LANES`] rows or columns: the products and the weights. Columns may not be longer than rows.
pub type Lines<const W: usize> = [[Lane; 2]; W];

/// Filters the rows in place; `codes` index `weights` (Q16) and lie between the pixels x - 1 and x.
pub fn rows<const W: usize, const H: usize>(
    depth: &mut Image<u16, W, H>,
    mask: &mut Image<u16, W, H>,
    codes: &Image<u8, W, H>,
    weights: &[u16; 256],
    lines: &mut Lines<W>,
) {
    let (depth, depth_rest) = depth.as_chunks_mut::<LANES>();
    let (mask, mask_rest) = mask.as_chunks_mut::<LANES>();
    let (codes, codes_rest) = codes.as_chunks::<LANES>();
    for ((depth, mask), codes) in depth.iter_mut().zip(mask).zip(codes) {
        for (x, cell) in lines.iter_mut().enumerate() {
            *cell = widen(core::array::from_fn(|r| depth[r][x]), core::array::from_fn(|r| mask[r][x]));
        }
        run(lines, |x| core::array::from_fn(|r| i32::from(weights[usize::from(codes[r][x])])));
        for (x, cell) in lines.iter().enumerate() {
            for r in 0..LANES {
                (depth[r][x], mask[r][x]) = narrow(cell[0][r], cell[1][r], 0);
            }
        }
    }
    for ((depth, mask), codes) in depth_rest.iter_mut().zip(mask_rest).zip(codes_rest) {
        for (x, cell) in lines.iter_mut().enumerate() {
            *cell = widen([depth[x]; LANES], [mask[x]; LANES]);
        }
        run(lines, |x| [i32::from(weights[usize::from(codes[x])]); LANES]);
        for (x, cell) in lines.iter().enumerate() {
            (depth[x], mask[x]) = narrow(cell[0][0], cell[1][0], 0);
        }
    }
}

/// Filters the columns in place; `codes` lie between the rows y - 1 and y. Pixels whose weight is not above `floor` (Q27)
/// lose their depth.
pub fn columns<const W: usize, const H: usize>(
    depth: &mut Image<u16, W, H>,
    mask: &mut Image<u16, W, H>,
    codes: &Image<u8, W, H>,
    weights: &[u16; 256],
    floor: u32,
    lines: &mut Lines<W>,
) {
    const { assert!(H <= W, "columns longer than rows do not fit the lines") };
    let (lines, _) = lines.split_at_mut(H);
    let mut x = 0;
    while x < W {
        // The last columns may be fewer than the lanes: what is missing counts as empty.
        let lanes = LANES.min(W - x);
        for ((depth, mask), cell) in depth.iter().zip(mask.iter()).zip(lines.iter_mut()) {
            *cell = widen(quad(&depth[x..x + lanes]), quad(&mask[x..x + lanes]));
        }
        run(lines, |y| {
            let row = codes.get(y).map_or([0; LANES], |row| quad(&row[x..x + lanes]));
            row.map(|code: u8| i32::from(weights[usize::from(code)]))
        });
        for ((depth, mask), cell) in depth.iter_mut().zip(mask.iter_mut()).zip(lines.iter()) {
            for r in 0..lanes {
                (depth[x + r], mask[x + r]) = narrow(cell[0][r], cell[1][r], floor);
            }
        }
        x += LANES;
    }
}

/// The first four values, 0 where there are fewer.
#[inline(always)]
fn quad<T: Copy + Default>(values: &[T]) -> [T; LANES] {
    values
        .first_chunk()
        .copied()
        .unwrap_or_else(|| core::array::from_fn(|i| values.get(i).copied().unwrap_or_default()))
}

/// s and m of depths and mask codes.
#[inline(always)]
fn widen(depth: [u16; LANES], mask: [u16; LANES]) -> [Lane; 2] {
    let m = mask.map(weight::decode);
    // 16 bits times 27 bits, less 13: below 2^30.
    [core::array::from_fn(|r| ((i64::from(depth[r]) * i64::from(m[r]) + (1 << 12)) >> 13) as i32), m]
}

/// Depth and mask code of s and m.
#[inline(always)]
fn narrow(s: i32, m: i32, floor: u32) -> (u16, u16) {
    if m as u32 <= floor {
        return (0, 0);
    }
    // D = s 2^13 / m. The reciprocal is good to 30 bits: the quotient is rounded to nearest but for ties.
    let (mantissa, shift) = reciprocal(m as u32);
    // s < 2^30 and the mantissa < 2^32; the shift is at least 36, because m < 2^28.
    let depth = (((s as u64 * u64::from(mantissa)) >> (shift - 14)) + 1) >> 1;
    (depth.min(65_535) as u16, weight::encode(m))
}

/// The filter forth and back along the lines.
#[inline(always)]
fn run(lines: &mut [[Lane; 2]], weights: impl Fn(usize) -> Lane) {
    let Some([mut s, mut m]) = lines.first().copied() else { return };
    for (x, cell) in lines.iter_mut().enumerate().skip(1) {
        let w = weights(x);
        (s, m) = (blend(cell[0], s, w), blend(cell[1], m, w));
        *cell = [s, m];
    }
    for x in (1..lines.len()).rev() {
        let w = weights(x);
        if let Some(cell) = lines.get_mut(x - 1) {
            (s, m) = (blend(cell[0], s, w), blend(cell[1], m, w));
            *cell = [s, m];
        }
    }
}

/// here + w (from - here), rounded to nearest: between the two, so nothing ever leaves its range.
///
/// Written with unsigned products of 32 bits, which vector units have even where they lack signed ones.
#[inline(always)]
fn blend(here: Lane, from: Lane, w: Lane) -> Lane {
    let wide = |a: i32, b: i32| u64::from(a as u32) * u64::from(b as u32);
    core::array::from_fn(|r| ((wide(here[r], (1 << 16) - w[r]) + wide(from[r], w[r]) + (1 << 15)) >> 16) as i32)
}
