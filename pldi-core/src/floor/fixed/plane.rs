//! How many points are on a plane and below it: the inner loop of the search for the floor. Twice, with the same bits: in plain
//! integers, and in SSE2's.

use super::Floor;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// Points in a block.
pub(super) const BLOCK: usize = 4 * FOURS;

/// Fours in a block.
pub(super) const FOURS: usize = 16;

/// A point of the scene.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    /// To the right, down and forward, in 1/4 mm.
    pub(super) place: [i16; 3],
    /// Distance to a plane within which a point belongs to it, in 1/32 mm; not negative.
    pub(super) tolerance: i16,
}

/// Four points: x, y, z and tolerance of each.
pub(super) type Four = [[i16; 8]; 2];

/// Points of the scene. The i-th is in the (i mod `FOURS`)-th four: every four is a coarse sample of the block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub struct Points {
    fours: [Four; FOURS],
}

impl Points {
    /// Points at the camera, on no plane that lies below it.
    pub const NONE: Self = Self { fours: [[[0; 8]; 2]; FOURS] };

    /// The `i`-th of the block's points, modulo [`BLOCK`].
    #[inline(always)]
    pub(super) fn get(&self, i: usize) -> Point {
        let (two, k) = (&self.fours[i % FOURS][i / (2 * FOURS) % 2], 4 * (i / FOURS % 2));
        Point { place: [two[k], two[k + 1], two[k + 2]], tolerance: two[k + 3] }
    }

    pub(super) fn set(&mut self, i: usize, point: Point) {
        let (two, k) = (&mut self.fours[i % FOURS][i / (2 * FOURS) % 2], 4 * (i / FOURS % 2));
        ([two[k], two[k + 1], two[k + 2]], two[k + 3]) = (point.place, point.tolerance);
    }

    /// All points, in the order of the memory.
    #[inline(always)]
    pub(super) fn iter(&self) -> impl Iterator<Item = Point> {
        let all: &[[i16; 4]] = self.fours.as_flattened().as_flattened().as_chunks().0;
        all.iter().map(|&[x, y, z, tolerance]| Point { place: [x, y, z], tolerance })
    }

    /// The `i`-th of the fours, modulo [`FOURS`].
    #[inline(always)]
    pub(super) fn four(&self, i: usize) -> &Four {
        &self.fours[i % FOURS]
    }

    /// All fours.
    #[inline(always)]
    pub(super) fn fours(&self) -> &[Four] {
        &self.fours
    }
}

/// A plane for points in 1/4 mm: the normal in Q15 and the height in 2^-15 of 1/4 mm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Plane {
    normal: [i16; 3],
    height: i32,
}

/// Distances to a plane count 2^-15 of 1/4 mm, tolerances 1/32 mm: 2^12 of those.
pub(super) const TOLERANCE: u32 = 12;

impl Plane {
    #[inline(always)]
    pub(super) fn new(floor: &Floor) -> Self {
        let q15 = |v: i32| ((v + (1 << 14)) >> 15).clamp(-32_768, 32_767) as i16;
        // 10 m is 40,000 quarters, and in 2^-15 below 2^31.
        Self { normal: floor.normal.map(q15), height: floor.height << 10 }
    }

    /// Height of a point, in 2^-15 of 1/4 mm, modulo 2^32.
    ///
    /// The products sum up to less than 2^15 |p|, and |p| < 2^15.8: 2^30.8. Heights wrap at 16 m, in the score at 15 m: none near the plane or
    /// below it does, and none above it unless the camera is higher than the 1 m that the farthest corners leave.
    #[inline(always)]
    pub(super) fn height_of(&self, [px, py, pz]: [i16; 3]) -> i32 {
        let [x, y, z] = self.normal;
        let product = |a: i16, b: i16| i32::from(a) * i32::from(b);
        product(x, px).wrapping_add(product(y, py)).wrapping_add(product(z, pz)).wrapping_add(self.height)
    }
}

/// How many points are on a plane, less three times those below it by more than twice their tolerance.
#[cfg(not(target_arch = "x86_64"))]
pub(super) use portable::score;
#[cfg(target_arch = "x86_64")]
pub(super) use sse2::score;

#[cfg_attr(target_arch = "x86_64", allow(dead_code, reason = "the twin is in use; the tests compare them"))]
mod portable {
    use super::{Four, Plane, TOLERANCE};

    /// In 32-bit registers, the limits by shifted operands.
    #[inline(always)]
    pub(in super::super) fn score<'a>(plane: &Plane, fours: impl Iterator<Item = &'a Four>) -> i32 {
        let (mut on, mut below) = (0, 0);
        let mut add = |x, y, z, tolerance| {
            let tolerance = i32::from(tolerance) << TOLERANCE;
            // Not farther above the lower limit than the upper one is, below 2^27.
            let above = plane.height_of([x, y, z]).wrapping_add(tolerance);
            on += i32::from(above as u32 <= (2 * tolerance) as u32);
            below += above.wrapping_add(tolerance) >> 31;
        };
        fours.for_each(|&[[a, b, c, d, e, f, g, h], [i, j, k, l, m, n, o, p]]| {
            add(a, b, c, d);
            add(e, f, g, h);
            add(i, j, k, l);
            add(m, n, o, p);
        });
        on + 3 * below
    }
}

#[cfg(target_arch = "x86_64")]
mod sse2 {
    use super::{Four, Plane, TOLERANCE};
    use safe_arch::{
        add_i32_m128i, bitor_m128i, cast_to_m128_from_m128i, cast_to_m128i_from_m128, cmp_gt_mask_i32_m128i, m128i,
        mul_i16_horizontal_add_m128i, set_splat_i32_m128i, shl_imm_u32_m128i, shr_imm_i32_m128i,
        shuffle_abi_f32_all_m128, sub_i32_m128i, zeroed_m128i,
    };

    /// The words 0, 2 or 1, 3 of two points each.
    #[inline(always)]
    fn every_other<const FROM: i32>(a: m128i, b: m128i) -> m128i {
        let (a, b) = (cast_to_m128_from_m128i(a), cast_to_m128_from_m128i(b));
        cast_to_m128i_from_m128(shuffle_abi_f32_all_m128::<FROM>(a, b))
    }

    const FIRST: i32 = 0b10_00_10_00;
    const SECOND: i32 = 0b11_01_11_01;

    #[inline(always)]
    pub(in super::super) fn score<'a>(plane: &Plane, fours: impl Iterator<Item = &'a Four>) -> i32 {
        let pair = |a: i16, b: i16| i32::from(a) & 0xFFFF | i32::from(b) << 16;
        let [nx, ny, nz] = plane.normal;
        let (nxy, nz) = (pair(nx, ny), pair(nz, 0));
        let (normal, lift) = (m128i::from([nxy, nz, nxy, nz]), set_splat_i32_m128i(plane.height));
        let (mut off, mut below, mut all) = (zeroed_m128i(), zeroed_m128i(), 0);
        for four in fours {
            let [p, q] = four.map(m128i::from);
            let (r, s) = (mul_i16_horizontal_add_m128i(p, normal), mul_i16_horizontal_add_m128i(q, normal));
            let along = add_i32_m128i(every_other::<FIRST>(r, s), every_other::<SECOND>(r, s));
            let height = add_i32_m128i(along, lift);
            let tolerance = shr_imm_i32_m128i::<16>(every_other::<SECOND>(p, q));
            let tolerance = shl_imm_u32_m128i::<{ TOLERANCE as i32 }>(tolerance);
            let lowest = sub_i32_m128i(zeroed_m128i(), tolerance);
            let over = cmp_gt_mask_i32_m128i(height, tolerance);
            off = add_i32_m128i(off, bitor_m128i(over, cmp_gt_mask_i32_m128i(lowest, height)));
            let clear = add_i32_m128i(height, add_i32_m128i(tolerance, tolerance));
            below = add_i32_m128i(below, shr_imm_i32_m128i::<31>(clear));
            all += 4;
        }
        let sum = |v: m128i| <[i32; 4]>::from(v).iter().sum::<i32>();
        all + sum(off) + 3 * sum(below)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_score_is_that_of_its_definition(
            places in proptest::collection::vec(proptest::array::uniform3(-32_000i16..=32_000), BLOCK),
            tolerance in 0i16..=16_383, shrink in 0u32..16,
            normal in proptest::array::uniform3(-1i32 << 30..=1 << 30), height in 1000i32..1_280_000,
        ) {
            let mut points = Points::NONE;
            for (i, place) in places.iter().enumerate() {
                let point = Point { place: place.map(|c| c >> shrink), tolerance };
                points.set(i, point);
                prop_assert_eq!(points.get(i).place, point.place);
            }
            let plane = Plane::new(&Floor { normal, height });
            let limit = i32::from(tolerance) << TOLERANCE;
            let truth: i32 = places.iter().map(|place| {
                let height = plane.height_of(place.map(|c| c >> shrink));
                i32::from((-limit..=limit).contains(&height)) - 3 * i32::from(height.wrapping_add(2 * limit) < 0)
            }).sum();
            prop_assert_eq!(score(&plane, points.fours().iter()), truth);
            prop_assert_eq!(portable::score(&plane, points.fours().iter()), truth);
            prop_assert_eq!(score(&plane, Points::NONE.fours().iter()), 0);
            prop_assert_eq!(portable::score(&plane, Points::NONE.fours().iter()), 0);
        }
    }
}
