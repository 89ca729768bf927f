//! The steps of the recursive filter on four pixels side by side, for x86-64, of which SSE2 is a part. What is rare there
//! is left to the form for one pixel; the tests compare the two.

/// Pixels that are worked on side by side.
pub const LANES: usize = 4;

/// Columns of four rows that are turned at once.
pub const BLOCK: usize = 8;

/// One number for each of the pixels.
pub type Lane = [i32; LANES];

/// One number as it is stored for each of the pixels.
pub type Short = [u16; LANES];

/// s and m.
pub type Cell = [Lane; 2];

/// The way along the line: on the way forth numbers are rounded down, on the way back up, so that neither leaves a bias.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    Forth,
    Back,
}

pub use sse2::{blend, narrow, turn, turn_back, widen};

/// In plain integers.
mod portable {
    use super::super::single;
    #[cfg(test)]
    use super::{BLOCK, Way};
    use super::{Cell, LANES, Short};

    /// s and m of depths and mask codes.
    #[inline(always)]
    pub fn widen(depth: Short, mask: Short) -> Cell {
        let mut cell = Cell::default();
        for r in 0..LANES {
            [cell[0][r], cell[1][r]] = single::widen(depth[r], mask[r]);
        }
        cell
    }

    /// Depths and mask codes of s and m; nothing where m is not above the floor (Q30, at least 7).
    #[inline(always)]
    pub fn narrow(cell: Cell, floor: i32) -> [Short; 2] {
        let mut pair = [Short::default(); 2];
        for r in 0..LANES {
            [pair[0][r], pair[1][r]] = single::narrow([cell[0][r], cell[1][r]], floor);
        }
        pair
    }

    #[cfg(test)]
    /// here + w (from - here), w in Q16: between the two, so nothing ever leaves its range.
    #[inline(always)]
    pub fn blend(here: Cell, from: Cell, w: Short, way: Way) -> Cell {
        let part = |a: i32, b: i32, w: u16| ((i64::from(a - b) * i64::from(w)) >> 16) as i32;
        core::array::from_fn(|k| {
            core::array::from_fn(|r| {
                let (here, from) = (here[k][r], from[k][r]);
                if way == Way::Forth { here + part(from, here, w[r]) } else { here - part(here, from, w[r]) }
            })
        })
    }

    #[cfg(test)]
    /// Four rows of a block as columns.
    #[inline(always)]
    pub fn turn(rows: [[u16; BLOCK]; LANES]) -> [Short; BLOCK] {
        core::array::from_fn(|x| rows.map(|row| row[x]))
    }

    #[cfg(test)]
    /// The columns of a block as four rows.
    #[inline(always)]
    pub fn turn_back(columns: [Short; BLOCK]) -> [[u16; BLOCK]; LANES] {
        core::array::from_fn(|r| columns.map(|column| column[r]))
    }
}

/// In SSE2's.
mod sse2 {
    use super::super::single::NEAR;
    use super::{BLOCK, Cell, LANES, Short, Way, portable};
    use safe_arch::{
        add_i16_m128i, add_i32_m128i, bitand_m128i, bitxor_m128i, cmp_gt_mask_i16_m128i, cmp_gt_mask_i32_m128i, m128i,
        move_mask_i8_m128i, mul_i16_horizontal_add_m128i, mul_i16_keep_low_m128i, mul_u16_keep_high_m128i,
        pack_i32_to_i16_m128i, set_i64_m128i_s, set_splat_i16_m128i, set_splat_i32_m128i, shl_imm_u16_m128i,
        shl_imm_u32_m128i, shr_imm_i16_m128i, shr_imm_i32_m128i, shr_imm_u32_m128i, sub_i32_m128i,
        unpack_high_i16_m128i, unpack_high_i32_m128i, unpack_low_i16_m128i, unpack_low_i32_m128i, zeroed_m128i,
    };

    /// The lower half.
    #[inline(always)]
    fn load(v: Short) -> m128i {
        set_i64_m128i_s(zerocopy::transmute!(v))
    }

    /// Both halves.
    #[inline(always)]
    fn store(v: m128i) -> [Short; 2] {
        let halves: [i64; 2] = v.into();
        zerocopy::transmute!(halves)
    }

    /// See the twin. Mask codes of one half and more (the usual ones) are a number of 13 bits, shifted by 17.
    #[inline(always)]
    pub fn widen(depth: Short, mask: Short) -> Cell {
        let (d, code) = (load(depth), load(mask));
        let half = cmp_gt_mask_i16_m128i(code, set_splat_i16_m128i(-4097));
        let negative = bitand_m128i(half, shr_imm_i16_m128i::<15>(code));
        if move_mask_i8_m128i(negative) & 0xFF != 0xFF {
            return if mask == [0; LANES] { Cell::default() } else { portable::widen(depth, mask) };
        }
        let m = bitxor_m128i(code, set_splat_i16_m128i(0xE000_u16 as i16));
        // Of 15 bits: s is four times the product of m.
        let four = shl_imm_u16_m128i::<2>(m);
        let s = unpack_low_i16_m128i(mul_i16_keep_low_m128i(d, four), mul_u16_keep_high_m128i(d, four));
        [s.into(), unpack_low_i16_m128i(zeroed_m128i(), add_i16_m128i(m, m)).into()]
    }

    /// See the twin.
    #[inline(always)]
    pub fn narrow([s, m]: Cell, floor: i32) -> [Short; 2] {
        let (short, weight) = (m128i::from(s), m128i::from(m));
        let near = cmp_gt_mask_i32_m128i(weight, set_splat_i32_m128i(floor.max(NEAR)));
        if move_mask_i8_m128i(near) != 0xFFFF {
            return portable::narrow([s, m], floor);
        }
        let s = short;
        // Of 16 bits in 32.
        let high = |a, b| mul_u16_keep_high_m128i(a, b);
        let d = shr_imm_u32_m128i::<6>(sub_i32_m128i(set_splat_i32_m128i(1 << 30), weight));
        let more = add_i32_m128i(d, shr_imm_u32_m128i::<8>(high(d, d)));
        let product = shl_imm_u32_m128i::<7>(high(shr_imm_u32_m128i::<15>(s), more));
        let depth = add_i32_m128i(add_i32_m128i(s, product), set_splat_i32_m128i(1 << 14));
        // With the sign of 16 bits, or packing would saturate.
        let depth = shr_imm_i32_m128i::<16>(shl_imm_u32_m128i::<1>(depth));
        let code = shr_imm_u32_m128i::<17>(add_i32_m128i(weight, set_splat_i32_m128i(1 << 16)));
        store(pack_i32_to_i16_m128i(depth, sub_i32_m128i(code, set_splat_i32_m128i(0x2000))))
    }

    /// See the twin. A difference is 2^16 h + l, and h w is that of the signed w, and 2^16 h more where w has its top bit.
    #[inline(always)]
    pub fn blend(here: Cell, from: Cell, w: Short, way: Way) -> Cell {
        let (w, zero) = (load(w), zeroed_m128i());
        let (low, high) = (unpack_low_i16_m128i(w, zero), unpack_low_i16_m128i(zero, w));
        let top = shr_imm_i16_m128i::<15>(high);
        core::array::from_fn(|k| {
            let (here, from) = (m128i::from(here[k]), m128i::from(from[k]));
            let d = if way == Way::Forth { sub_i32_m128i(from, here) } else { sub_i32_m128i(here, from) };
            let part = add_i32_m128i(mul_u16_keep_high_m128i(d, low), bitand_m128i(d, top));
            let part = add_i32_m128i(part, mul_i16_horizontal_add_m128i(d, high));
            if way == Way::Forth { add_i32_m128i(here, part) } else { sub_i32_m128i(here, part) }.into()
        })
    }

    /// See the twin.
    #[inline(always)]
    pub fn turn(rows: [[u16; BLOCK]; LANES]) -> [Short; BLOCK] {
        let [a, b, c, d] = rows.map(m128i::from);
        let (low, high) = (
            [unpack_low_i16_m128i(a, b), unpack_low_i16_m128i(c, d)],
            [unpack_high_i16_m128i(a, b), unpack_high_i16_m128i(c, d)],
        );
        let pair = |[a, b]: [m128i; 2]| [store(unpack_low_i32_m128i(a, b)), store(unpack_high_i32_m128i(a, b))];
        let [[[a, b], [c, d]], [[e, f], [g, h]]] = [pair(low), pair(high)];
        [a, b, c, d, e, f, g, h]
    }

    /// See the twin.
    #[inline(always)]
    pub fn turn_back(columns: [Short; BLOCK]) -> [[u16; BLOCK]; LANES] {
        let [a, b, c, d, e, f, g, h] = columns.map(load);
        let pair = |a, b, c, d| {
            let (ab, cd) = (unpack_low_i16_m128i(a, b), unpack_low_i16_m128i(c, d));
            [unpack_low_i32_m128i(ab, cd), unpack_high_i32_m128i(ab, cd)]
        };
        let ([a, b], [c, d]) = (pair(a, b, c, d), pair(e, f, g, h));
        let rows = |a, b| [safe_arch::unpack_low_i64_m128i(a, b).into(), safe_arch::unpack_high_i64_m128i(a, b).into()];
        let ([a, b], [c, d]) = (rows(a, c), rows(b, d));
        [a, b, c, d]
    }
}

#[cfg(test)]
mod tests {
    use super::super::single;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn depths_and_weights_come_back(depth in any::<u16>(), code in 1u16..) {
            let [s, m] = single::widen(depth, code);
            let [d, c] = single::narrow([s, m], 7);
            prop_assert_eq!(c, code);
            // s has 15 bits below the unit of D m.
            prop_assert!(f64::from(d.abs_diff(depth)) <= 16_384.0 / f64::from(m) + 0.51, "{} {}", d, depth);
        }

        #[test]
        fn quotients_are_rounded(m in 8i32..=8191 << 17, bits in 0u32..28, part in 0u32..=u32::MAX) {
            let m = (m >> bits).max(8);
            let most = (u64::from(m as u32) * 65_535) >> 15;
            let s = ((most * u64::from(part)) >> 32) as i32;
            let truth = f64::from(s) * 32_768.0 / f64::from(m);
            prop_assert!((f64::from(single::narrow([s, m], 7)[0]) - truth).abs() <= 0.51, "{} {}", s, m);
        }

        #[test]
        fn both_ways_give_the_same_bits(
            words in proptest::array::uniform32(any::<u16>()), wide in proptest::array::uniform16(0i32..), near: bool,
            floor in 7i32..1 << 30,
        ) {
            let rows: [[u16; BLOCK]; LANES] = core::array::from_fn(|r| core::array::from_fn(|x| words[8 * r + x]));
            prop_assert_eq!(portable::turn(rows), turn(rows));
            prop_assert_eq!(turn_back(turn(rows)), rows);
            prop_assert_eq!(portable::turn_back(portable::turn(rows)), rows);
            let [depth, mask, w, ..] = portable::turn(rows);
            let mask = if near { mask.map(|code| code | 0xF000) } else { mask };
            prop_assert_eq!(portable::widen(depth, mask), widen(depth, mask));
            let lanes: [Lane; 4] = core::array::from_fn(|k| core::array::from_fn(|r| wide[4 * k + r]));
            for way in [Way::Forth, Way::Back] {
                let (here, from) = ([lanes[0], lanes[1]], [lanes[2], lanes[3]]);
                prop_assert_eq!(portable::blend(here, from, w, way), blend(here, from, w, way));
            }
            let m = lanes[0].map(|m| if near { (8191 << 17) - m % 4_000_000 } else { (m >> (m & 15)).min(8191 << 17) });
            // At most 2 m.
            let s = core::array::from_fn(|r| ((i64::from(m[r]) * i64::from(depth[r])) >> 15) as i32);
            let floor = if near { floor } else { floor >> 20 | 7 };
            prop_assert_eq!(portable::narrow([s, m], floor), narrow([s, m], floor));
        }
    }
}
