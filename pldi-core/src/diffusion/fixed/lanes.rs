//! The sums over the neighbours of eight centres side by side, for x86-64, of which SSE2 is a part: `madd` multiplies and
//! adds eight pairs at once.

use super::group::{Centres, FRACTION, Group, Moments, Row, SLOPE_BITS, Short};
use super::normals::LANES;
use safe_arch::{
    add_i16_m128i, add_i32_m128i, add_saturating_i16_m128i, bitandnot_m128i, cmp_gt_mask_i16_m128i, m128i,
    mul_i16_horizontal_add_m128i, mul_i16_keep_high_m128i, mul_i16_keep_low_m128i, pack_i32_to_i16_m128i,
    set_i32_m128i_s, set_splat_i16_m128i, set_splat_i32_m128i, shr_all_i16_m128i, shr_all_i32_m128i, shr_imm_i16_m128i,
    shr_imm_i32_m128i, sub_i16_m128i, unpack_high_i16_m128i, unpack_low_i16_m128i, zeroed_m128i,
};

/// Columns of the window that are worked on at a time.
const CHUNK: usize = 64;

/// Offsets at a time: all lanes' neighbours lie in the chunk.
const OFFSETS: usize = CHUNK - LANES;

/// One number of 32 bits for each of the pixels.
type Long = [i32; LANES];

/// [`Moments`] of all centres.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Sums {
    n: Long,
    p: Long,
    q: Long,
    b: Long,
    pp: Long,
    pq: Long,
    pb: Long,
    qq: Long,
    qb: Long,
    bb: Long,
}

impl Sums {
    /// Those of one centre.
    #[inline(always)]
    pub fn lane(&self, i: usize) -> Moments {
        let at = |sums: &Long| sums.get(i).copied().unwrap_or(0);
        Moments {
            n: at(&self.n),
            p: at(&self.p),
            q: at(&self.q),
            b: at(&self.b),
            pp: at(&self.pp),
            pq: at(&self.pq),
            pb: at(&self.pb),
            qq: at(&self.qq),
            qb: at(&self.qb),
            bb: at(&self.bb),
        }
    }
}

/// The twin's memory; here the registers do.
#[derive(Debug, Clone, Copy, Default)]
pub struct Scratch;

/// The sums over the neighbours of a group's centres.
pub fn sums<const W: usize, const H: usize>(group: &Group<'_, W, H>, _: &mut Scratch) -> Sums {
    let mut sums = Sums::default();
    let window = &group.window;
    let offsets = 2 * window.columns + 1;
    let mut chunk = 0;
    while chunk < offsets {
        // The column of the chunk's first place; may lie outside of the image.
        let base = group.u as i32 - window.columns + chunk;
        let mut x_factors = [[0u16; CHUNK]; 2];
        let places = x_factors[0].len().min((offsets - chunk) as usize + LANES);
        let [lows, highs] = &mut x_factors;
        for (i, (low, high)) in lows.iter_mut().zip(highs).enumerate().take(places) {
            let factor = usize::try_from(base + i as i32).map_or(0, |column| group.x_factor(column));
            (*low, *high) = (factor as u16, (factor >> 16) as u16);
        }
        for row in group.rows() {
            let reach = row.reach as i32;
            // Offsets of the chunk that are in reach, and at which a lane is inside of the image.
            let from = (window.columns - reach - chunk).max(0).max(1 - LANES as i32 - base);
            let to = (window.columns + reach + 1 - chunk).min(OFFSETS as i32).min(W as i32 - base);
            if from >= to {
                continue;
            }
            let (from, to) = (from as usize, to as usize + LANES - 1);
            let mut depths = [0u16; CHUNK];
            let inside = (-base).max(from as i32) as usize;
            let there = row.depths.iter().skip((base + inside as i32) as usize);
            for (out, z) in depths.iter_mut().take(to).skip(inside).zip(there) {
                *out = *z;
            }
            let mut points = [[0i16; CHUNK]; 3];
            project(&depths, &x_factors, [row.factor, group.z_factor], group.kept, from..to, &mut points);
            let [px, py, pz] = &points;
            if let (Some(px), Some(py), Some(pz)) = (px.get(from..to), py.get(from..to), pz.get(from..to)) {
                add(&group.centres, &row, [px, py, pz], &mut sums);
            }
        }
        chunk += OFFSETS as i32;
    }
    sums
}

/// Brings the pixels `range` of a row to the fine unit: depths clamped, times the rays' factors (x in two halves of 16
/// bits; y, z), the high halves of the products.
#[inline(always)]
fn project(
    depths: &[u16; CHUNK],
    x: &[[u16; CHUNK]; 2],
    [y, z]: [i32; 2],
    [nearest, farthest]: [u16; 2],
    range: core::ops::Range<usize>,
    points: &mut [[i16; CHUNK]; 3],
) {
    let halves = |v: i32| (v as u16, (v >> 16) as u16);
    let ((y_low, y_high), (z_low, z_high)) = (halves(y), halves(z));
    let times = |low: u16, high: u16, depth: u16| {
        (((u32::from(low) * u32::from(depth)) >> 16) as u16).wrapping_add(high.wrapping_mul(depth)) as i16
    };
    let blocks = range.start / LANES..range.end.div_ceil(LANES);
    let [px, py, pz] = points;
    let [x_low, x_high] = x;
    let (px, py, pz) = (px.as_chunks_mut::<LANES>().0, py.as_chunks_mut::<LANES>().0, pz.as_chunks_mut::<LANES>().0);
    let inputs =
        depths.as_chunks::<LANES>().0.iter().zip(x_low.as_chunks::<LANES>().0).zip(x_high.as_chunks::<LANES>().0);
    let outputs = px.iter_mut().zip(py).zip(pz);
    for (((depths, low), high), ((px, py), pz)) in inputs.zip(outputs).take(blocks.end).skip(blocks.start) {
        for i in 0..LANES {
            let depth = depths[i].max(nearest).min(farthest);
            px[i] = times(low[i], high[i], depth);
            py[i] = times(y_low, y_high, depth);
            pz[i] = times(z_low, z_high, depth);
        }
    }
}

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

/// y from the centres, of a neighbour at their depths; modulo 2^16.
#[inline(always)]
fn offset(step: i32, centres: &Centres) -> Short {
    let (low, high) = (step as u16, (step >> 16) as u16);
    centres.depth.map(|z| (((u32::from(low) * u32::from(z)) >> 16) as u16).wrapping_add(high.wrapping_mul(z)) as i16)
}

/// Adds the neighbours in a row: all lanes' first neighbours are the first [`LANES`] of the points.
#[inline(always)]
fn add<const W: usize>(centres: &Centres, row: &Row<'_, W>, points: [&[i16]; 3], sums: &mut Sums) {
    let zero = zeroed_m128i();
    let mut inner = Inner { centres, n: zero, p: zero, b: zero, pp: [zero; 2], pb: [zero; 2], bb: [zero; 2] };
    let [x, y, z] = points;
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

    let q0 = load(&offset(row.step, centres));
    let y = set_splat_i16_m128i(row.y);
    let factors = interleave(q0, y);
    let half = set_splat_i32_m128i(1 << (SLOPE_BITS - 1));
    let short = |v: Pair| {
        let [low, high] = each(v, |v| shr_imm_i32_m128i::<{ SLOPE_BITS as i32 }>(add_i32_m128i(v, half)));
        pack_i32_to_i16_m128i(low, high)
    };
    let fraction = set_i32_m128i_s(FRACTION as i32);
    let slope = set_i32_m128i_s((SLOPE_BITS + FRACTION) as i32);
    let shifted = |v: Pair, by: m128i| pack_i32_to_i16_m128i(shr_all_i32_m128i(v[0], by), shr_all_i32_m128i(v[1], by));
    let q1 = plus(products(n, q0), each(products(b, y), shr_imm_i32_m128i::<{ SLOPE_BITS as i32 }>));
    let qb = madd(interleave(b, short(bb)), factors);
    add_to(&mut sums.q, q1);
    add_to(&mut sums.pq, madd(interleave(p, short(pb)), factors));
    add_to(&mut sums.qb, qb);
    add_to(&mut sums.qq, madd(interleave(shifted(q1, fraction), shifted(qb, slope)), factors));
}
