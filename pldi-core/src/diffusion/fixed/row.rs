//! The inner loop of the normals: one row of the window, for eight centres side by side. Twice, with the same bits: in
//! plain integers, and in SSE2's.

/// Pixels that are worked on side by side.
pub const LANES: usize = 8;

/// What is left of pb and bb (2^-10) beside a slope of [`Row::y`] (2^10): their product has the unit of the sums.
const SLOPE_BITS: u32 = 10;

/// One number of 16 bits for each of the pixels.
pub type Short = [i16; LANES];

/// One number of 32 bits for each of the pixels.
pub type Long = [i32; LANES];

/// The centres, in fine units; coordinates of points count modulo 2^16.
#[derive(Debug, Clone, Copy)]
pub struct Centres {
    /// x, y and z.
    pub point: [Short; 3],
    /// Depth in 1/8 mm.
    pub depth: [u16; LANES],
    /// Largest sum of the squares (each 2^-16, rounded down) of a neighbour's offset; -1 for lanes without a centre.
    pub limit: Short,
    /// The moments' unit is 2^shift fine units.
    pub shift: u32,
    /// Moments with y count in 2^-fraction of that.
    pub fraction: u32,
}

/// One row of the window.
#[derive(Debug, Clone, Copy)]
pub struct Row<'a> {
    /// x, y and z of the points seen at the row's columns: all lanes' first neighbours are the first [`LANES`].
    pub points: [&'a [i16]; 3],
    /// Difference of the rays' y to the centres' row: times a depth, in 2^-16 of the moments' fraction.
    pub step: i32,
    /// The rays' y, in 2^-(10 + fraction).
    pub y: i16,
}

/// Sums over the neighbours, relative to the centres: count, first and second moments of x (p), y (q) and z (b).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Sums {
    pub n: Long,
    pub p: Long,
    pub q: Long,
    pub b: Long,
    pub pp: Long,
    pub pq: Long,
    pub pb: Long,
    pub qq: Long,
    pub qb: Long,
    pub bb: Long,
}

impl Row<'_> {
    /// y from the centres, of a neighbour at their depths; modulo 2^16.
    #[inline(always)]
    fn offset(&self, centres: &Centres) -> Short {
        let (low, high) = (self.step as u16, (self.step >> 16) as u16);
        centres
            .depth
            .map(|z| (((u32::from(low) * u32::from(z)) >> 16) as u16).wrapping_add(high.wrapping_mul(z)) as i16)
    }
}

#[cfg(not(target_arch = "x86_64"))]
pub use portable::add;
#[cfg(target_arch = "x86_64")]
pub use sse2::add;

/// For all machines: one lane after the other, so that the sums stay in registers.
#[cfg_attr(target_arch = "x86_64", allow(dead_code, reason = "the twin is in use; the tests compare them"))]
mod portable {
    use super::{Centres, LANES, Row, SLOPE_BITS, Sums};

    /// Adds the neighbours in a row.
    pub fn add(centres: &Centres, row: &Row<'_>, sums: &mut Sums) {
        let [x, y, z] = row.points;
        let count = (x.len() + 1).saturating_sub(LANES);
        let offset = row.offset(centres);
        for i in 0..LANES {
            let [cx, cy, cz] = centres.point.map(|c| c[i]);
            let limit = i32::from(centres.limit[i]);
            let (mut n, mut p1, mut b1, mut pp, mut pb, mut bb) = (0i32, 0i32, 0i32, 0i32, 0i32, 0i32);
            for ((x, y), z) in x.iter().zip(y).zip(z).skip(i).take(count) {
                let square = |v: i16| (i32::from(v) * i32::from(v)) >> 16;
                let (p, q, b) = (x.wrapping_sub(cx), y.wrapping_sub(cy), z.wrapping_sub(cz));
                if square(p) + square(q) + square(b) <= limit {
                    let (p, b) = (i32::from(p) >> centres.shift, i32::from(b) >> centres.shift);
                    n += 1;
                    p1 += p;
                    b1 += b;
                    pp += p * p;
                    pb += p * b;
                    bb += b * b;
                }
            }
            // q = q0 + y b for all neighbours in the row.
            let (y, fraction) = (i32::from(row.y), centres.fraction);
            let q0 = i32::from(offset[i]);
            let short = |v: i32| (v + (1 << (SLOPE_BITS - 1))) >> SLOPE_BITS;
            let q1 = n * q0 + ((b1 * y) >> SLOPE_BITS);
            let qb = b1 * q0 + short(bb) * y;
            let more = [
                (&mut sums.n, n),
                (&mut sums.p, p1),
                (&mut sums.q, q1),
                (&mut sums.b, b1),
                (&mut sums.pp, pp),
                (&mut sums.pq, p1 * q0 + short(pb) * y),
                (&mut sums.pb, pb),
                (&mut sums.qq, (q1 >> fraction) * q0 + (qb >> (SLOPE_BITS + fraction)) * y),
                (&mut sums.qb, qb),
                (&mut sums.bb, bb),
            ];
            for (sum, more) in more {
                sum[i] += more;
            }
        }
    }
}

/// For x86-64, of which SSE2 is a part: `madd` multiplies and adds eight pairs at once.
#[cfg(target_arch = "x86_64")]
mod sse2 {
    use super::{Centres, LANES, Long, Row, SLOPE_BITS, Short, Sums};
    use safe_arch::{
        add_i16_m128i, add_i32_m128i, add_saturating_i16_m128i, bitandnot_m128i, cmp_gt_mask_i16_m128i, m128i,
        mul_i16_horizontal_add_m128i, mul_i16_keep_high_m128i, mul_i16_keep_low_m128i, pack_i32_to_i16_m128i,
        set_i32_m128i_s, set_splat_i16_m128i, set_splat_i32_m128i, shr_all_i16_m128i, shr_all_i32_m128i,
        shr_imm_i16_m128i, shr_imm_i32_m128i, sub_i16_m128i, unpack_high_i16_m128i, unpack_low_i16_m128i, zeroed_m128i,
    };

    type Pair = [m128i; 2];

    #[inline(always)]
    fn load(v: &Short) -> m128i {
        m128i::from(*v)
    }

    #[inline(always)]
    fn add_to(sum: &mut Long, [low, high]: Pair) {
        if let ([a, b], []) = sum.as_chunks_mut::<4>() {
            *a = add_i32_m128i(m128i::from(*a), low).into();
            *b = add_i32_m128i(m128i::from(*b), high).into();
        }
    }

    #[inline(always)]
    fn each(a: Pair, f: impl Fn(m128i) -> m128i) -> Pair {
        [f(a[0]), f(a[1])]
    }

    #[inline(always)]
    fn plus(a: Pair, b: Pair) -> Pair {
        [add_i32_m128i(a[0], b[0]), add_i32_m128i(a[1], b[1])]
    }

    #[inline(always)]
    fn interleave(a: m128i, b: m128i) -> Pair {
        [unpack_low_i16_m128i(a, b), unpack_high_i16_m128i(a, b)]
    }

    #[inline(always)]
    fn madd(a: Pair, b: Pair) -> Pair {
        [mul_i16_horizontal_add_m128i(a[0], b[0]), mul_i16_horizontal_add_m128i(a[1], b[1])]
    }

    /// Products of 32 bits.
    #[inline(always)]
    fn products(a: m128i, b: m128i) -> Pair {
        interleave(mul_i16_keep_low_m128i(a, b), mul_i16_keep_high_m128i(a, b))
    }

    /// With 32 bits.
    #[inline(always)]
    fn widen(a: m128i) -> Pair {
        interleave(a, shr_imm_i16_m128i::<15>(a))
    }

    /// Sums over one row.
    struct Inner<'a> {
        centres: &'a Centres,
        n: m128i,
        p: m128i,
        b: m128i,
        pp: Pair,
        pb: Pair,
        bb: Pair,
    }

    impl Inner<'_> {
        /// x and z of a neighbour of each centre, 0 where it is not within the radius.
        #[inline(always)]
        fn near(&mut self, x: &Short, y: &Short, z: &Short) -> [m128i; 2] {
            let [cx, cy, cz] = &self.centres.point;
            let p = sub_i16_m128i(load(x), load(cx));
            let q = sub_i16_m128i(load(y), load(cy));
            let b = sub_i16_m128i(load(z), load(cz));
            // At most 2^14 each: only the second sum saturates, beyond any limit.
            let square = |v| mul_i16_keep_high_m128i(v, v);
            let square = add_saturating_i16_m128i(add_saturating_i16_m128i(square(p), square(q)), square(b));
            let far = cmp_gt_mask_i16_m128i(square, load(&self.centres.limit));
            let shift = set_i32_m128i_s(self.centres.shift as i32);
            // n counts those that are far, below 0.
            self.n = add_i16_m128i(self.n, far);
            let p = shr_all_i16_m128i(bitandnot_m128i(far, p), shift);
            let b = shr_all_i16_m128i(bitandnot_m128i(far, b), shift);
            self.p = add_i16_m128i(self.p, p);
            self.b = add_i16_m128i(self.b, b);
            [p, b]
        }

        /// Adds the second moments of two neighbours.
        #[inline(always)]
        fn add(&mut self, [p0, b0]: [m128i; 2], [p1, b1]: [m128i; 2]) {
            let (p, b) = (interleave(p0, p1), interleave(b0, b1));
            self.pp = plus(self.pp, madd(p, p));
            self.pb = plus(self.pb, madd(p, b));
            self.bb = plus(self.bb, madd(b, b));
        }
    }

    /// Adds the neighbours in a row.
    #[inline(always)]
    pub fn add(centres: &Centres, row: &Row<'_>, sums: &mut Sums) {
        let zero = zeroed_m128i();
        let mut inner = Inner { centres, n: zero, p: zero, b: zero, pp: [zero; 2], pb: [zero; 2], bb: [zero; 2] };
        let [x, y, z] = row.points;
        let count = (x.len() + 1).saturating_sub(LANES);
        let mut neighbours = x.array_windows::<LANES>().zip(y.array_windows::<LANES>()).zip(z.array_windows::<LANES>());
        while let Some(((x, y), z)) = neighbours.next() {
            let first = inner.near(x, y, z);
            let second = match neighbours.next() {
                Some(((x, y), z)) => inner.near(x, y, z),
                None => [zero; 2],
            };
            inner.add(first, second);
        }
        let Inner { n, p, b, pp, pb, bb, .. } = inner;
        // No window has more than 2^15 columns.
        let n = add_i16_m128i(n, set_splat_i16_m128i(count as i16));
        add_to(&mut sums.n, widen(n));
        add_to(&mut sums.p, widen(p));
        add_to(&mut sums.b, widen(b));
        add_to(&mut sums.pp, pp);
        add_to(&mut sums.pb, pb);
        add_to(&mut sums.bb, bb);

        let q0 = load(&row.offset(centres));
        let y = set_splat_i16_m128i(row.y);
        let factors = interleave(q0, y);
        let half = set_splat_i32_m128i(1 << (SLOPE_BITS - 1));
        let short = |v: Pair| {
            let [low, high] = each(v, |v| shr_imm_i32_m128i::<{ SLOPE_BITS as i32 }>(add_i32_m128i(v, half)));
            pack_i32_to_i16_m128i(low, high)
        };
        let fraction = set_i32_m128i_s(centres.fraction as i32);
        let slope = set_i32_m128i_s((SLOPE_BITS + centres.fraction) as i32);
        let shifted =
            |v: Pair, by: m128i| pack_i32_to_i16_m128i(shr_all_i32_m128i(v[0], by), shr_all_i32_m128i(v[1], by));
        let q1 = plus(products(n, q0), each(products(b, y), shr_imm_i32_m128i::<{ SLOPE_BITS as i32 }>));
        let qb = madd(interleave(b, short(bb)), factors);
        add_to(&mut sums.q, q1);
        add_to(&mut sums.pq, madd(interleave(p, short(pb)), factors));
        add_to(&mut sums.qb, qb);
        add_to(&mut sums.qq, madd(interleave(shifted(q1, fraction), shifted(qb, slope)), factors));
    }
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn both_ways_give_the_same_bits(
            points in proptest::collection::vec(proptest::array::uniform3(-3000i16..3000), 8..60),
            centre in proptest::array::uniform3(proptest::array::uniform8(-500i16..500)),
            depth in proptest::array::uniform8(any::<u16>()),
            y in -4000i16..4000, step in -3000i32..3000, radius in 40i32..4000,
        ) {
            let [x, py, z] = [0, 1, 2].map(|k| points.iter().map(|p| p[k]).collect::<Vec<_>>());
            let mut limit = [((radius * radius) >> 16) as i16; LANES];
            limit[3] = -1;
            let shift = (0..8).find(|s| (radius >> s) * 55 < 16_000).unwrap();
            let centres = Centres { point: centre, depth, limit, shift, fraction: 2 };
            let row = Row { points: [&x, &py, &z], step, y };
            let (mut a, mut b) = (Sums::default(), Sums::default());
            for _ in 0..3 {
                portable::add(&centres, &row, &mut a);
                add(&centres, &row, &mut b);
            }
            prop_assert_eq!(a, b);
        }
    }
}
