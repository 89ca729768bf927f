//! The recursive filter on four rows or columns side by side.

use super::quad::{self, BLOCK, Cell, LANES, Short, Way};
use super::recursive::{Lines, NO_FLOOR};
use crate::Image;

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
        four_rows(depth, mask, codes, weights, lines);
    }
    if let ([first, ..], [first_mask, ..], [first_codes, ..]) = (&*depth_rest, &*mask_rest, codes_rest) {
        // The last rows may be fewer than the lanes: the others are filtered in vain.
        let (mut four, mut four_masks) = ([*first; LANES], [*first_mask; LANES]);
        let mut four_codes = [*first_codes; LANES];
        four.iter_mut().zip(&*depth_rest).for_each(|(to, from)| *to = *from);
        four_masks.iter_mut().zip(&*mask_rest).for_each(|(to, from)| *to = *from);
        four_codes.iter_mut().zip(codes_rest).for_each(|(to, from)| *to = *from);
        four_rows(&mut four, &mut four_masks, &four_codes, weights, lines);
        depth_rest.iter_mut().zip(&four).for_each(|(to, from)| *to = *from);
        mask_rest.iter_mut().zip(&four_masks).for_each(|(to, from)| *to = *from);
    }
}

/// Filters four rows.
fn four_rows<const W: usize>(
    depth: &mut [[u16; W]; LANES],
    mask: &mut [[u16; W]; LANES],
    codes: &[[u8; W]; LANES],
    weights: &[u16; 256],
    lines: &mut Lines<W>,
) {
    let first = |rows: &[[u16; W]; LANES]| rows.each_ref().map(|row| row.first().copied().unwrap_or_default());
    let mut line = Line::new(weights, quad::widen(first(depth), first(mask)));
    for (block, cells) in lines.chunks_mut(BLOCK).enumerate() {
        let x = block * BLOCK;
        let (depth, mask) = (quad::turn(block_of(depth, x)), quad::turn(block_of(mask, x)));
        let codes = block_of(codes, x);
        for (i, cell) in cells.iter_mut().enumerate() {
            *cell = line.forth(quad::widen(depth[i], mask[i]), codes.map(|row| row[i]));
        }
    }
    for (block, cells) in lines.chunks(BLOCK).enumerate().rev() {
        let x = block * BLOCK;
        let codes = block_of(codes, x);
        let (mut depths, mut masks) = ([[0; LANES]; BLOCK], [[0; LANES]; BLOCK]);
        for (i, cell) in cells.iter().enumerate().rev() {
            [depths[i], masks[i]] = quad::narrow(line.back(*cell, codes.map(|row| row[i])), NO_FLOOR);
        }
        for (rows, block) in [(&mut *depth, depths), (&mut *mask, masks)] {
            for (row, values) in rows.iter_mut().zip(quad::turn_back(block)) {
                if let Some(to) = row.get_mut(x..).and_then(|row| row.first_chunk_mut()) {
                    *to = values;
                } else {
                    row.iter_mut().skip(x).zip(values).for_each(|(to, from)| *to = from);
                }
            }
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
    // Q30, rounded up.
    let floor = (floor.min(1 << 27) << 3) as i32 | NO_FLOOR;
    let (lines, _) = lines.split_at_mut(H);
    let mut x = 0;
    while x < W {
        // The last columns may be fewer than the lanes: what is missing counts as empty.
        let lanes = LANES.min(W - x);
        let (Some(depth_row), Some(mask_row)) = (depth.first(), mask.first()) else { return };
        let mut line = Line::new(weights, quad::widen(some(depth_row, x), some(mask_row, x)));
        for (((depth, mask), codes), cell) in depth.iter().zip(mask.iter()).zip(codes).zip(lines.iter_mut()) {
            *cell = line.forth(quad::widen(some(depth, x), some(mask, x)), some(codes, x));
        }
        for (((depth, mask), codes), cell) in depth.iter_mut().zip(mask.iter_mut()).zip(codes).zip(lines.iter()).rev() {
            let [depths, masks] = quad::narrow(line.back(*cell, some(codes, x)), floor);
            depth[x..x + lanes].copy_from_slice(&depths[..lanes]);
            mask[x..x + lanes].copy_from_slice(&masks[..lanes]);
        }
        x += LANES;
    }
}

/// Where the filter is along the lines.
struct Line<'a> {
    weights: &'a [u16; 256],
    /// What the last pixels became.
    last: Cell,
    /// The weights between the last pixels and those before them on the way back.
    between: Short,
}

impl<'a> Line<'a> {
    /// Before the first pixels, which stay as they are: they are blended with themselves.
    fn new(weights: &'a [u16; 256], first: Cell) -> Self {
        Self { weights, last: first, between: [0; LANES] }
    }

    /// The next pixels on the way forth.
    #[inline(always)]
    fn forth(&mut self, here: Cell, codes: [u8; LANES]) -> Cell {
        let w = codes.map(|code| self.weights[usize::from(code)]);
        let here = quad::blend(here, self.last, w, Way::Forth);
        self.last = here;
        here
    }

    /// The next pixels on the way back, which starts with those that the way forth has ended with.
    #[inline(always)]
    fn back(&mut self, here: Cell, codes: [u8; LANES]) -> Cell {
        let here = quad::blend(here, self.last, self.between, Way::Back);
        self.last = here;
        self.between = codes.map(|code| self.weights[usize::from(code)]);
        here
    }
}

/// Some values of a row, 0 where there are fewer.
#[inline(always)]
fn some<T: Copy + Default, const W: usize, const N: usize>(row: &[T; W], x: usize) -> [T; N] {
    let values = row.get(x..).unwrap_or(&[]);
    values
        .first_chunk()
        .copied()
        .unwrap_or_else(|| core::array::from_fn(|i| values.get(i).copied().unwrap_or_default()))
}

/// A block of four rows.
#[inline(always)]
fn block_of<T: Copy + Default, const W: usize>(rows: &[[T; W]; LANES], x: usize) -> [[T; BLOCK]; LANES] {
    rows.each_ref().map(|row| some(row, x))
}
