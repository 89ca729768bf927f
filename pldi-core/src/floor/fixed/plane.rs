//! How many points are on a plane and below it: the inner loop of the search for the floor. Twice, with the same bits: in plain
//! integers, and in SSE2's.

use super::Floor;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// Points in a block.
pub(super) const BLOCK: usize = 32;

/// Of each block every fourth point comes first: so many.
pub(super) const FIRST: usize = BLOCK / 4;

/// Points of the scene in 1/4 mm, in the order in which they are scored side by side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub struct Points {
    /// To the right.
    pub(super) x: [i16; BLOCK],
    /// Down.
    pub(super) y: [i16; BLOCK],
    /// Forward.
    pub(super) z: [i16; BLOCK],
    /// Distance to a plane within which a point belongs to it, in 1/32 mm.
    pub(super) tolerance: [i16; BLOCK],
}

impl Points {
    /// Points at the camera that belong to no plane.
    pub const NONE: Self = Self { x: [0; BLOCK], y: [0; BLOCK], z: [0; BLOCK], tolerance: [-1; BLOCK] };
}

/// A plane for points in 1/4 mm: the normal in Q15 and the height in 2^-15 of 1/4 mm.
#[derive(Debug, Clone, Copy)]
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
    /// The products sum up to less than 2^15 |p|, and |p| < 2^15.8: 2^30.8. Heights wrap at 16 m: none near the plane or
    /// below it does, and none above it unless the camera is higher than the 2 m that the farthest corners leave.
    #[inline(always)]
    pub(super) fn height_of(&self, [px, py, pz]: [i16; 3]) -> i32 {
        let [x, y, z] = self.normal;
        let product = |a: i16, b: i16| i32::from(a) * i32::from(b);
        product(x, px).wrapping_add(product(y, py)).wrapping_add(product(z, pz)).wrapping_add(self.height)
    }
}

/// Eight points of a block.
#[derive(Debug, Clone, Copy)]
pub(super) struct Eight<'a> {
    x: &'a [i16; FIRST],
    y: &'a [i16; FIRST],
    z: &'a [i16; FIRST],
    tolerance: &'a [i16; FIRST],
}

impl Points {
    /// The block's points, those first of which every fourth comes first.
    #[inline(always)]
    pub(super) fn eights(&self) -> impl Iterator<Item = Eight<'_>> {
        fn of(all: &[i16; BLOCK]) -> &[[i16; FIRST]] {
            all.as_chunks().0
        }
        let (xy, zt) = (of(&self.x).iter().zip(of(&self.y)), of(&self.z).iter().zip(of(&self.tolerance)));
        xy.zip(zt).map(|((x, y), (z, tolerance))| Eight { x, y, z, tolerance })
    }
}

/// Counts points on a plane, and those below it by more than twice their tolerance.
#[cfg(not(target_arch = "x86_64"))]
pub(super) use portable::count;
#[cfg(target_arch = "x86_64")]
pub(super) use sse2::count;

#[cfg_attr(target_arch = "x86_64", allow(dead_code, reason = "the twin is in use; the tests compare them"))]
mod portable {
    use super::{Eight, FIRST, Plane, TOLERANCE};

    pub(in super::super) fn count<'a>(plane: &Plane, points: impl Iterator<Item = Eight<'a>>) -> [i32; 2] {
        let (mut on, mut below) = (0, 0);
        for eight in points {
            for i in 0..FIRST {
                let height = plane.height_of([eight.x[i], eight.y[i], eight.z[i]]);
                let tolerance = i32::from(eight.tolerance[i]) << TOLERANCE;
                on += i32::from(height <= tolerance && height >= -tolerance);
                below += i32::from(height < -2 * tolerance);
            }
        }
        [on, below]
    }
}

#[cfg(target_arch = "x86_64")]
mod sse2 {
    use super::{Eight, FIRST, Plane, TOLERANCE};
    use safe_arch::{
        add_i32_m128i, bitor_m128i, cmp_gt_mask_i32_m128i, m128i, mul_i16_horizontal_add_m128i, set_splat_i32_m128i,
        shr_imm_i32_m128i, sub_i32_m128i, unpack_high_i16_m128i, unpack_low_i16_m128i, zeroed_m128i,
    };

    #[inline(always)]
    pub(in super::super) fn count<'a>(plane: &Plane, points: impl Iterator<Item = Eight<'a>>) -> [i32; 2] {
        let pair = |a: i16, b: i16| set_splat_i32_m128i(i32::from(a) & 0xFFFF | i32::from(b) << 16);
        let [nx, ny, nz] = plane.normal;
        let (nxy, nz, lift) = (pair(nx, ny), pair(nz, 0), set_splat_i32_m128i(plane.height));
        let (mut off, mut below, mut all) = (zeroed_m128i(), zeroed_m128i(), 0);
        for eight in points {
            let [x, y, z, tolerance] = [eight.x, eight.y, eight.z, eight.tolerance].map(|v| m128i::from(*v));
            for unpack in [unpack_low_i16_m128i, unpack_high_i16_m128i] {
                let xy = mul_i16_horizontal_add_m128i(unpack(x, y), nxy);
                let z = mul_i16_horizontal_add_m128i(unpack(z, zeroed_m128i()), nz);
                let height = add_i32_m128i(add_i32_m128i(xy, z), lift);
                let tolerance = shr_imm_i32_m128i::<{ 16 - TOLERANCE as i32 }>(unpack(zeroed_m128i(), tolerance));
                let lowest = sub_i32_m128i(zeroed_m128i(), tolerance);
                let over = cmp_gt_mask_i32_m128i(height, tolerance);
                off = add_i32_m128i(off, bitor_m128i(over, cmp_gt_mask_i32_m128i(lowest, height)));
                below = add_i32_m128i(below, cmp_gt_mask_i32_m128i(sub_i32_m128i(lowest, tolerance), height));
            }
            all += FIRST as i32;
        }
        let sum = |v: m128i| <[i32; 4]>::from(v).iter().sum::<i32>();
        [all + sum(off), -sum(below)]
    }
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn both_ways_give_the_same_counts(
            numbers in proptest::collection::vec(-32_000i16..=32_000, 3 * BLOCK), tolerance in 0i16..16_383,
            normal in proptest::array::uniform3(-1i32 << 30..=1 << 30), height in 1000i32..1_280_000,
        ) {
            let part = |k: usize| core::array::from_fn(|i| numbers[k * BLOCK + i]);
            let mut points = Points { x: part(0), y: part(1), z: part(2), tolerance: [tolerance; BLOCK] };
            points.tolerance[5] = -1;
            let plane = Plane::new(&Floor { normal, height });
            prop_assert_eq!(count(&plane, points.eights()), portable::count(&plane, points.eights()));
            prop_assert_eq!(count(&plane, Points::NONE.eights()), [0, 0]);
        }
    }
}
