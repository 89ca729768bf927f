//! The planes pi_o and pi_f and their homographies in fixed point.
//!
//! A homography means the same at any positive scale. So its entries have none: after every product they are scaled by the
//! power of two that brings the largest to 30 bits (block floating point), and the inverse is the adjugate with the
//! determinant's sign, without a division. Between planes and the image, maps go to rays instead of pixels: all entries are
//! then of like size, and 30 bits leave none of them coarse.

use crate::array::transposed;
use crate::fixed::{METRE, mul_q30, quantise, reciprocal, unit};
use crate::floor::fixed::FloorAxes;
use crate::rays::fixed::Intrinsics;

/// Distance of pi_f from the camera along the floor in 1/128 mm, see [`crate::view::homography::FRONTAL_DISTANCE`].
pub const FRONTAL_DISTANCE: i32 = match quantise(crate::view::homography::FRONTAL_DISTANCE, 0.5, 8.0, METRE as f64) {
    Some(distance) => distance as i32,
    None => panic!("a distance in a room"),
};

/// A 3x3 matrix, row by row, that acts on homogeneous coordinates; any positive multiple of it is the same map. All entries
/// are below 2^30 in absolute value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Homography(pub [[i32; 3]; 3]);

impl Homography {
    /// Entries of 64 bits (below 2^63) scaled so that the largest has 30 bits; rounded to nearest.
    fn normalised(entries: [[i64; 3]; 3]) -> Self {
        let largest = entries.as_flattened().iter().fold(0, |bits, v| bits | v.unsigned_abs());
        let bits = 64 - largest.leading_zeros();
        Self(entries.map(|row| {
            row.map(|v| {
                if bits > 30 {
                    let shift = bits - 30;
                    // Rounding may carry into the 31st bit.
                    (((v >> (shift - 1)) + 1) >> 1).clamp(-(1 << 30) + 1, (1 << 30) - 1) as i32
                } else {
                    (v << (30 - bits)) as i32
                }
            })
        }))
    }

    /// From the coordinates (s, t) of the vertical plane through the floor point `centroid` (right, forward in 1/128 mm),
    /// facing the camera, to rays. `None` for a centroid below the camera.
    pub fn plane_to_rays(axes: &FloorAxes, centroid: [i32; 2]) -> Option<Self> {
        let [x, y] = centroid.map(i64::from);
        // A millimetre.
        if x.unsigned_abs().pow(2) + y.unsigned_abs().pow(2) <= 128 * 128 {
            return None;
        }
        let [sin, cos, _] = unit([x, y, 0])?;
        let foot = axes.to_camera([centroid[0], centroid[1], 0]);
        // Directions in Q30, the foot in metres, Q30.
        let rows = transposed([axes.right, axes.forward, axes.floor.normal]);
        let across = rows.map(|[right, forward, _]| mul_q30(cos, right) - mul_q30(sin, forward));
        let foot = foot.map(|c| (i64::from(c) << 23) / 1000);
        Some(Self::normalised(transposed([across.map(i64::from), axes.floor.normal.map(i64::from), foot])))
    }

    /// From a frontal view to the coordinates (s, t), see [`crate::view::Homography::view_to_plane`]: `height` and `middle`
    /// in 1/128 mm, cut at 100 m.
    pub fn view_to_plane(height: i32, middle: i32) -> Self {
        let cut = |length: i32| i64::from(length.clamp(-100 * METRE, 100 * METRE));
        let (height, drop, d) = (cut(height), cut(height) - cut(middle), i64::from(FRONTAL_DISTANCE));
        // Below 2^30.7 with 6 more bits.
        let length = ((((drop << 6) * (drop << 6)) + ((d << 6) * (d << 6))) as u64).isqrt().max(1) as i64;
        let (sin, cos) = ((drop << 36) / length, (d << 36) / length);
        // Metres in Q24 (below 2^31) times Q30.
        let times = |length: i64, q30: i64| (((length << 17) / 1000) * q30) >> 24;
        // The ray (x, y, 1) goes x to the right, y cos + sin down and cos - y sin forward.
        Self::normalised([
            [(d << 23) / 1000, 0, 0],
            [0, -times(height, sin) - times(d, cos), times(height, cos) - times(d, sin)],
            [0, -sin, cos],
        ])
    }

    /// This map after another: `self.after(g)` takes x to self(g(x)).
    pub fn after(&self, first: &Self) -> Self {
        let columns = transposed(first.0);
        let product = |row: [i32; 3], column: [i32; 3]| {
            let part = |k: usize| i64::from(row[k]) * i64::from(column[k]);
            part(0) + part(1) + part(2)
        };
        Self::normalised(self.0.map(|row| columns.map(|column| product(row, column))))
    }

    /// A map to rays, continued to the camera's pixels.
    pub fn to_pixels(&self, intrinsics: &Intrinsics) -> Self {
        let [x, y, z] = self.0;
        // Q16 pixels below 2^31 times entries below 2^30.
        let pixel = |ray: [i32; 3], focal: i32, centre: i32| {
            transposed([ray, z, z])
                .map(|[ray, z, _]| i64::from(ray) * i64::from(focal) + i64::from(z) * i64::from(centre))
        };
        Self::normalised([
            pixel(x, intrinsics.fx, intrinsics.cx),
            pixel(y, intrinsics.fy, intrinsics.cy),
            z.map(|v| i64::from(v) << 16),
        ])
    }

    /// The inverse map, scaled so that points seen by the camera keep a positive third coordinate; `None` where there
    /// is none (or none that 30 bits can tell).
    pub fn inverse(&self) -> Option<Self> {
        let m = self.0;
        let minor = |a: usize, b: usize, c: usize, d: usize| {
            i64::from(m[a][c]) * i64::from(m[b][d]) - i64::from(m[a][d]) * i64::from(m[b][c])
        };
        let adjugate = Self::normalised([
            [minor(1, 2, 1, 2), -minor(0, 2, 1, 2), minor(0, 1, 1, 2)],
            [-minor(1, 2, 0, 2), minor(0, 2, 0, 2), -minor(0, 1, 0, 2)],
            [minor(1, 2, 0, 1), -minor(0, 2, 0, 1), minor(0, 1, 0, 1)],
        ]);
        let part = |k: usize| i64::from(m[0][k]) * i64::from(adjugate.0[k][0]);
        let determinant = part(0) + part(1) + part(2);
        // What the adjugate's rounding makes of three products is below 2^31.
        if determinant.unsigned_abs() < 1 << 33 {
            return None;
        }
        Some(if determinant > 0 { adjugate } else { Self(adjugate.0.map(|row| row.map(|v| -v))) })
    }

    /// What the points (x, y) of one y (Q26) have in common.
    #[inline(always)]
    pub(super) fn along(&self, y: i32) -> Along {
        Along {
            slopes: self.0.map(|r| r[0]),
            starts: self.0.map(|r| i64::from(r[1]) * i64::from(y) + (i64::from(r[2]) << 26)),
        }
    }

    /// The image of a point, all in Q26; `None` behind the camera, near infinity, or beyond 32. For maps whose last row is
    /// not small (the others' last coordinate has few bits) at most 2^-20 of the point's distance off.
    pub fn apply(&self, x: i32, y: i32) -> Option<[i32; 2]> {
        let along = self.along(y);
        let w = along.last(x)?;
        Some([w.under(along.at(0, x))?, w.under(along.at(1, x))?])
    }
}

/// Points of one y before the division by their last coordinate.
pub(super) struct Along {
    slopes: [i32; 3],
    starts: [i64; 3],
}

impl Along {
    /// Coordinate `k` at `x` (Q26), not yet divided: below 2^30 * (2 * 2^31 + 2^26), of which the upper half is kept.
    #[inline(always)]
    pub(super) fn at(&self, k: usize, x: i32) -> i32 {
        ((i64::from(self.slopes[k]) * i64::from(x) + self.starts[k]) >> 32) as i32
    }

    /// The last coordinate, to divide by.
    #[inline(always)]
    pub(super) fn last(&self, x: i32) -> Option<Inverse> {
        let w = self.at(2, x);
        // Nearer to 0 it is rounding errors that would be divided by.
        (w > 1 << 9).then(|| Inverse(reciprocal(w as u32)))
    }
}

/// The reciprocal of a last coordinate.
#[derive(Clone, Copy)]
pub(super) struct Inverse((u32, u32));

impl Inverse {
    /// A coordinate over the last one, Q26; `None` beyond 32.
    #[inline(always)]
    pub(super) fn under(self, coordinate: i32) -> Option<i32> {
        let (mantissa, shift) = self.0;
        // The last coordinate is above 2^9, so the shift is 41 to 62.
        let shift = shift - 26;
        let room = 32u32.saturating_sub(shift);
        let raised = coordinate << room;
        if shift <= 32 && raised >> room == coordinate {
            // The same number, without a shift of 64 bits: they are slow where numbers have 32.
            return Some(((i64::from(raised) * i64::from(mantissa)) >> 32) as i32);
        }
        // Below 2^31 * 2^32.
        i32::try_from((i64::from(coordinate) * i64::from(mantissa)) >> shift).ok()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::floor::fixed::Floor;
    use crate::view;
    use proptest::prelude::*;

    const ONE: f32 = 67_108_864.0;

    /// The same pose in both arithmetics.
    pub(in crate::view::fixed) fn axes(pitch: f32, roll: f32) -> (crate::FloorAxes, FloorAxes) {
        let floor = crate::Floor::from_pose(1.2, pitch, roll).unwrap();
        let normal = floor.normal.map(|v| (f64::from(v) * 1_073_741_824.0) as i32);
        (floor.axes(), Floor { normal, height: (floor.height * 128_000.0) as i32 }.axes())
    }

    proptest! {
        #[test]
        fn plane_points_project_like_the_float_ones(
            pitch in 0.0f32..0.9, roll in -0.2f32..0.2, right in -1.5f32..1.5, forward in 1.0f32..4.0,
            s in -0.8f32..0.8, t in 0.0f32..1.5,
        ) {
            let camera = crate::Intrinsics::KINECT_QVGA;
            let (float_axes, fixed_axes) = axes(pitch, roll);
            let units = [right, forward].map(|v| (v * 128_000.0) as i32);
            let float = view::Homography::plane_to_image(&float_axes, &camera, [right, forward]).unwrap();
            let fixed = Homography::plane_to_rays(&fixed_axes, units).unwrap();
            let point = [s, t].map(|v| (v * ONE) as i32);
            if let (Some(a), Some(b)) = (float.apply(s, t), fixed.apply(point[0], point[1]))
                && (0.0..320.0).contains(&a[0]) && (0.0..240.0).contains(&a[1])
            {
                let b = [b[0] as f32 / ONE * camera.fx + camera.cx, b[1] as f32 / ONE * camera.fy + camera.cy];
                prop_assert!((a[0] - b[0]).abs() < 0.01 && (a[1] - b[1]).abs() < 0.01, "{a:?} {b:?}");
                let pixels = fixed.to_pixels(&crate::rays::fixed::Intrinsics::new(&camera).unwrap());
                let w = pixels.along(point[1]).at(2, point[0]) as f32;
                let u = pixels.along(point[1]).at(0, point[0]) as f32 / w;
                prop_assert!((a[0] - u).abs() < 0.02, "{a:?} {u}");
                let ray = fixed.apply(point[0], point[1]).unwrap();
                let back = fixed.inverse().unwrap().apply(ray[0], ray[1]).unwrap();
                prop_assert!((0..2).all(|i| (back[i] - point[i]).abs() < 1500), "{back:?} {point:?}");
            }
        }

        #[test]
        fn views_agree_with_the_float_ones(
            height in 0.3f32..2.5, middle in 0.0f32..2.0, x in -0.4f32..0.4, y in -0.4f32..0.4,
        ) {
            let float = view::Homography::view_to_plane(height, middle).apply(x, y).unwrap();
            let fixed = Homography::view_to_plane((height * 128_000.0) as i32, (middle * 128_000.0) as i32)
                .apply((x * ONE) as i32, (y * ONE) as i32).unwrap();
            for (a, b) in float.iter().zip(fixed) {
                prop_assert!((a - b as f32 / ONE).abs() < 3e-5, "{float:?} {fixed:?}");
            }
        }

        /// Whatever the entries: no overflow, and inverses undo.
        #[test]
        fn extremes(
            entries in proptest::array::uniform9(-(1i32 << 30) + 1..1 << 30), x in any::<i32>(), y in any::<i32>(),
            pose in proptest::array::uniform5(any::<i32>()),
        ) {
            let h = Homography([[entries[0], entries[1], entries[2]], [entries[3], entries[4], entries[5]], [entries[6], entries[7], entries[8]]]);
            let _ = h.apply(x, y);
            let _ = h.after(&h).apply(x, y);
            let _ = Homography::view_to_plane(pose[0], pose[1]);
            let lens = Intrinsics { width: 320, height: 240, fx: pose[2], fy: pose[3], cx: pose[4], cy: pose[0] };
            let _ = h.to_pixels(&lens);
            if let Some(inverse) = h.inverse() {
                let one = inverse.after(&h);
                prop_assert!(one.0[0][0] > 0 || one.0[0][0].abs() < 1 << 24, "{one:?}");
            }
        }
    }

    #[test]
    fn a_point_below_the_camera_has_no_plane() {
        assert_eq!(Homography::plane_to_rays(&axes(0.3, 0.0).1, [0, 0]), None);
    }

    #[test]
    fn singular_maps_have_no_inverse() {
        assert_eq!(Homography([[0; 3]; 3]).inverse(), None);
        let row = [1 << 29, 12_345, -99_999];
        assert_eq!(Homography([row, row, [1, 2, 3]]).inverse(), None);
    }
}
