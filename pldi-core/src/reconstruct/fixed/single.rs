//! The steps of the recursive filter on one pixel, and the filter one line after the other: the form for machines with few
//! registers and no instructions for several numbers at once.
//!
//! On the way along a line a pixel is the weight m in Q30 and the product s = D m of depth (1/8 mm) and weight in Q15,
//! both below 2^31: differences fit 32 bits.
//!
//! Where no depth is missing near by, m is [`WHOLE`] and stays so: then only s is computed, with the same bits.

use super::recursive::{LANES, Lines, NO_FLOOR};
use super::weight;
use crate::Image;
use crate::fixed::reciprocal_of_16_bits;
use zerocopy::{FromBytes, IntoBytes};

/// s and m of a pixel.
type Cell = [i32; 2];

/// The weight of a pixel with a reading, Q30.
pub const WHOLE: i32 = weight::decode(weight::ONE);

/// From this weight on (Q30) two terms of a series do for the division by it.
pub const NEAR: i32 = (1 << 30) - 4_000_000;

/// s and m of a depth and a mask code.
#[inline(always)]
pub fn widen(depth: u16, code: u16) -> Cell {
    let m = weight::decode(code);
    // 16 bits times 30 bits, less 15: below 2^31.
    [((i64::from(depth) * i64::from(m) + (1 << 14)) >> 15) as i32, m]
}

/// Depth and mask code of s and m: D = s 2^15 / m, at most 0.51 units off.
#[inline(always)]
pub fn narrow([s, m]: Cell, floor: i32) -> [u16; 2] {
    if m <= floor {
        return [0, 0];
    }
    let (s, m) = (s as u32, m as u32);
    let code = weight::encode(m as i32);
    if m > NEAR as u32 {
        // 1/m = 1 + d + d^2, where d = 1 - m is below 2^-8; Q24.
        let d = ((1 << 30) - m) >> 6;
        let more = d + (((d * d) >> 16) >> 8);
        // s + s d in Q15: D and half a unit are below 2^16.
        return [((s + ((((s >> 15) * more) >> 16) << 7) + (1 << 14)) >> 15) as u16, code];
    }
    // The floor is at least 7: at most 28 leading zeros, at least 2. As D is below 2^16, s is below 2 m.
    let zeros = m.leading_zeros();
    let (s, m) = (s << (zeros - 2), m << zeros);
    let r = reciprocal_of_16_bits(m);
    // e = 1 - m r in Q32, below 2^-8; 1/m = r (1 + e + e^2) but for 2^-24.
    let e = (((1i64 << 47) - i64::from(m) * i64::from(r)) >> 15) as i32;
    let e = e + (((e >> 9) * (e >> 9)) >> 14);
    // s r in Q14: as s is below 2^31 (but for its rounding where m is next to nothing), below 2^31.
    let q = ((u64::from(s) * u64::from(r)) >> 16) as u32;
    let q = i64::from(q) + ((i64::from(q) * i64::from(e)) >> 32);
    [((q + (1 << 13)) >> 14).clamp(0, 65_535) as u16, code]
}

/// here + w (last - here) for w in Q16, rounded down: a step of the way forth.
#[inline(always)]
fn down(here: i32, last: i32, w: u16) -> i32 {
    let product = i64::from(last - here) * i64::from(w);
    // Halves of 32 bits: two additions with a shift, where one of 64 bits would take four instructions.
    here + (((product >> 32) as i32) << 16) + (product as u32 >> 16) as i32
}

/// here - w (here - last), rounded up: a step of the way back.
#[inline(always)]
fn up(here: i32, last: i32, w: u16) -> i32 {
    let product = i64::from(here - last) * i64::from(w);
    here - (((product >> 32) as i32) << 16) - (product as u32 >> 16) as i32
}

/// Filters a line both ways; pixels whose weight is not above `floor` (Q30) lose their depth.
///
/// The loops are functions of their own: what is live in each of them just fits the registers.
fn line<const L: usize>(
    depth: &mut [u16; L],
    mask: &mut [u16; L],
    codes: &[u8; L],
    weights: &[u16; 256],
    floor: i32,
    cells: &mut [Cell; L],
) {
    let (Some(d), Some(code)) = (depth.first(), mask.first()) else { return };
    // The first pixel is blended with itself: it stays as it is.
    let mut last = widen(*d, *code);
    let mut x = 0;
    while x < L {
        if last[1] == WHOLE {
            (x, last[0]) = whole_forth(depth, mask, codes, weights, cells, x, last[0]);
        }
        (x, last) = forth(depth, mask, codes, weights, cells, x, last);
    }
    let mut w = 0;
    while x > 0 {
        if last[1] == WHOLE && floor < WHOLE {
            (x, last[0]) = whole_back(depth, codes, weights, &mut w, cells, x, last[0]);
        }
        (x, last) = back(depth, mask, codes, weights, &mut w, floor, cells, x, last);
    }
}

/// The way forth from `x` on, as long as pixels and what comes before them are whole.
#[inline(never)]
fn whole_forth<const L: usize>(
    depth: &[u16; L],
    mask: &[u16; L],
    codes: &[u8; L],
    weights: &[u16; 256],
    cells: &mut [Cell; L],
    mut x: usize,
    mut last: i32,
) -> (usize, i32) {
    while x < L && mask[x] == weight::ONE {
        // What `widen` gives for the largest weight.
        last = down(i32::from(depth[x]) * (WHOLE >> 15), last, weights[usize::from(codes[x])]);
        cells[x] = [last, WHOLE];
        x += 1;
    }
    (x, last)
}

/// The way forth from `x` on, up to the next pixel where the other loop can go on.
#[inline(never)]
fn forth<const L: usize>(
    depth: &[u16; L],
    mask: &[u16; L],
    codes: &[u8; L],
    weights: &[u16; 256],
    cells: &mut [Cell; L],
    mut x: usize,
    mut last: Cell,
) -> (usize, Cell) {
    while x < L && !(mask[x] == weight::ONE && last[1] == WHOLE) {
        let ([s, m], w) = (widen(depth[x], mask[x]), weights[usize::from(codes[x])]);
        last = [down(s, last[0], w), down(m, last[1], w)];
        cells[x] = last;
        x += 1;
    }
    (x, last)
}

/// The way back from before `x` on, as long as pixels and what comes after them are whole. Their mask stays what it was.
#[inline(never)]
fn whole_back<const L: usize>(
    depth: &mut [u16; L],
    codes: &[u8; L],
    weights: &[u16; 256],
    w: &mut u16,
    cells: &[Cell; L],
    x: usize,
    mut last: i32,
) -> (usize, i32) {
    let mut weight = *w;
    let mut left = x.min(L);
    while left > 0 {
        let [s, m] = cells[left - 1];
        if m != WHOLE {
            break;
        }
        left -= 1;
        last = up(s, last, weight);
        // What `narrow` gives for this weight: there, d is 2^-13.
        let s = last as u32;
        depth[left] = ((s + ((s >> 20) << 7) + (1 << 14)) >> 15) as u16;
        weight = weights[usize::from(codes[left])];
    }
    *w = weight;
    (left, last)
}

/// The way back from before `x` on, up to the next pixel where the other loop can go on.
#[inline(never)]
#[allow(clippy::too_many_arguments, reason = "all of them live in registers")]
fn back<const L: usize>(
    depth: &mut [u16; L],
    mask: &mut [u16; L],
    codes: &[u8; L],
    weights: &[u16; 256],
    w: &mut u16,
    floor: i32,
    cells: &[Cell; L],
    x: usize,
    mut last: Cell,
) -> (usize, Cell) {
    let mut left = x.min(L);
    while left > 0 {
        let [s, m] = cells[left - 1];
        if m == WHOLE && last[1] == WHOLE && floor < WHOLE {
            break;
        }
        left -= 1;
        last = [up(s, last[0], *w), up(m, last[1], *w)];
        [depth[left], mask[left]] = narrow(last, floor);
        *w = weights[usize::from(codes[left])];
    }
    (left, last)
}

/// Filters the rows in place; `codes` index `weights` (Q16) and lie between the pixels x - 1 and x.
pub fn rows<const W: usize, const H: usize>(
    depth: &mut Image<u16, W, H>,
    mask: &mut Image<u16, W, H>,
    codes: &Image<u8, W, H>,
    weights: &[u16; 256],
    lines: &mut Lines<W>,
) {
    let Ok((cells, _)) = <[Cell; W]>::mut_from_prefix(lines.as_mut_bytes()) else { return };
    for ((depth, mask), codes) in depth.iter_mut().zip(mask).zip(codes) {
        line(depth, mask, codes, weights, NO_FLOOR, cells);
    }
}

/// Filters the columns in place; `codes` lie between the rows y - 1 and y. Pixels whose weight is not above `floor` (Q27)
/// lose their depth. Some columns are turned into lines together, so that what a cache fetches is used.
pub fn columns<const W: usize, const H: usize>(
    depth: &mut Image<u16, W, H>,
    mask: &mut Image<u16, W, H>,
    codes: &Image<u8, W, H>,
    weights: &[u16; 256],
    floor: u32,
    lines: &mut Lines<W>,
) {
    const { assert!(H <= W, "columns longer than rows do not fit the lines") };
    // Q30, rounded up.
    let floor = (floor.min(1 << 27) << 3) as i32 | NO_FLOOR;
    // 8 bytes, and four times 4 bytes and 1, of the 32 for each.
    let Ok((cells, rest)) = <[Cell; H]>::mut_from_prefix(lines.as_mut_bytes()) else { return };
    let Ok(([turned_depth, turned_mask], rest)) = <[[[u16; H]; LANES]; 2]>::mut_from_prefix(rest) else { return };
    let Ok((turned_codes, _)) = <[[u8; H]; LANES]>::mut_from_prefix(rest) else { return };
    let mut turned = Turned { depth: turned_depth, mask: turned_mask, codes: turned_codes };
    let mut x = 0;
    while x + LANES <= W {
        turned.filter::<LANES, W>(depth, mask, codes, weights, floor, cells, x);
        x += LANES;
    }
    while x < W {
        turned.filter::<1, W>(depth, mask, codes, weights, floor, cells, x);
        x += 1;
    }
}

/// Some columns as lines.
struct Turned<'a, const H: usize> {
    depth: &'a mut [[u16; H]; LANES],
    mask: &'a mut [[u16; H]; LANES],
    codes: &'a mut [[u8; H]; LANES],
}

impl<const H: usize> Turned<'_, H> {
    /// Filters the columns x..x + N.
    #[allow(clippy::too_many_arguments, reason = "images and tables")]
    fn filter<const N: usize, const W: usize>(
        &mut self,
        depth: &mut Image<u16, W, H>,
        mask: &mut Image<u16, W, H>,
        codes: &Image<u8, W, H>,
        weights: &[u16; 256],
        floor: i32,
        cells: &mut [Cell; H],
        x: usize,
    ) {
        turn::<N, W, H>(depth, x, self.depth);
        turn::<N, W, H>(mask, x, self.mask);
        turn_codes::<N, W, H>(codes, x, self.codes);
        for ((depth, mask), codes) in self.depth.iter_mut().zip(self.mask.iter_mut()).zip(self.codes.iter()).take(N) {
            line(depth, mask, codes, weights, floor, cells);
        }
        turn_back::<N, W, H>(self.depth, x, depth);
        turn_back::<N, W, H>(self.mask, x, mask);
    }
}

/// Columns as lines.
#[inline(never)]
fn turn<const N: usize, const W: usize, const H: usize>(
    image: &Image<u16, W, H>,
    x: usize,
    lines: &mut [[u16; H]; LANES],
) {
    for y in 0..H {
        let Some(values) = image[y].get(x..).and_then(|row| row.first_chunk::<N>()) else { return };
        for i in 0..N {
            lines[i][y] = values[i];
        }
    }
}

/// Columns as lines: a word of four codes is one load.
#[inline(never)]
fn turn_codes<const N: usize, const W: usize, const H: usize>(
    image: &Image<u8, W, H>,
    x: usize,
    lines: &mut [[u8; H]; LANES],
) {
    for y in 0..H {
        let Some(values) = image[y].get(x..).and_then(|row| row.first_chunk::<N>()) else { return };
        let mut word = [0; LANES];
        word.iter_mut().zip(values).for_each(|(to, from)| *to = *from);
        let word = u32::from_le_bytes(word);
        for i in 0..N {
            lines[i][y] = (word >> (8 * i)) as u8;
        }
    }
}

/// Lines as columns.
#[inline(never)]
fn turn_back<const N: usize, const W: usize, const H: usize>(
    lines: &[[u16; H]; LANES],
    x: usize,
    image: &mut Image<u16, W, H>,
) {
    for y in 0..H {
        let Some(values) = image[y].get_mut(x..).and_then(|row| row.first_chunk_mut::<N>()) else { return };
        for i in 0..N {
            values[i] = lines[i][y];
        }
    }
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::super::four;
    use super::*;
    use proptest::prelude::*;

    const W: usize = 21;
    const H: usize = 18;

    fn image<T: Copy + Default>(values: &[T]) -> Image<T, W, H> {
        let mut image = [[T::default(); W]; H];
        image.as_flattened_mut().iter_mut().zip(values).for_each(|(to, from)| *to = *from);
        image
    }

    proptest! {
        #[test]
        fn one_line_after_the_other_is_as_four_at_once(
            depth in proptest::collection::vec(any::<u16>(), W * H),
            mask in proptest::collection::vec(prop_oneof![4 => Just(weight::ONE), 1 => Just(0u16), 1 => any::<u16>()], W * H),
            codes in proptest::collection::vec(any::<u8>(), W * H),
            weights in proptest::collection::vec(any::<u16>(), 256),
            floor in prop_oneof![0u32..1 << 27, Just(0), Just(134), Just(1 << 27)],
        ) {
            let weights: [u16; 256] = weights.try_into().unwrap();
            let codes = image(&codes);
            let (mut depth, mut mask) = ([image(&depth); 2], [image(&mask); 2]);
            let mut lines = [[[0; LANES]; 2]; W];
            for _ in 0..2 {
                rows(&mut depth[0], &mut mask[0], &codes, &weights, &mut lines);
                four::rows(&mut depth[1], &mut mask[1], &codes, &weights, &mut lines);
                prop_assert_eq!(depth[0], depth[1]);
                prop_assert_eq!(mask[0], mask[1]);
                columns(&mut depth[0], &mut mask[0], &codes, &weights, floor, &mut lines);
                four::columns(&mut depth[1], &mut mask[1], &codes, &weights, floor, &mut lines);
                prop_assert_eq!(depth[0], depth[1]);
                prop_assert_eq!(mask[0], mask[1]);
            }
        }
    }
}
