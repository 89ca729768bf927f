//! The sensory area in fixed point.

use super::{CELL, cell_centre};
use crate::Error;
use crate::fixed::{METRE, ONE_Q30, quantise, sin_cos};
use crate::floor::fixed::Floor;
use crate::ground::{MAP_DEPTH, MAP_WIDTH};
use crate::rays::fixed::Intrinsics;

/// Bounds of the sensory area, see [`crate::ground::AreaParams`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AreaParams {
    /// Nearest distance along the floor, 1/128 mm.
    pub near: i32,
    /// Farthest distance along the floor, 1/128 mm.
    pub far: i32,
    /// Leftmost angle from the principal direction, radians in Q28, not positive.
    pub left: i32,
    /// Rightmost angle from the principal direction, radians in Q28, not negative.
    pub right: i32,
}

impl AreaParams {
    /// The parameters rounded to their units; at compile time in a `const`.
    ///
    /// # Errors
    /// `OutOfRange` with the parameter's name, for ranges as in [`crate::ground::AreaParams::validate`].
    pub const fn new(float: &crate::ground::AreaParams) -> Result<Self, Error> {
        const LENGTH: f64 = METRE as f64;
        const ANGLE: f64 = (1u32 << 28) as f64;
        const CELL: f32 = crate::ground::CELL;
        let Some(near) = quantise(float.near, 0.0, 4.0, LENGTH) else {
            return Err(Error::OutOfRange("area: near"));
        };
        let Some(far) = quantise(float.far, float.near + CELL, (MAP_DEPTH - 2) as f32 * CELL, LENGTH) else {
            return Err(Error::OutOfRange("area: far"));
        };
        let Some(left) = quantise(float.left, -1.5, 0.0, ANGLE) else {
            return Err(Error::OutOfRange("area: left"));
        };
        let Some(right) = quantise(float.right, 0.0, 1.5, ANGLE) else {
            return Err(Error::OutOfRange("area: right"));
        };
        Ok(Self { near: near as i32, far: far as i32, left: left as i32, right: right as i32 })
    }

    /// Checks numbers that were put together by hand.
    ///
    /// # Errors
    /// `OutOfRange` with the parameter's name, for ranges as in [`crate::ground::AreaParams::validate`].
    pub const fn validate(&self) -> Result<(), Error> {
        // 1.5 radians.
        const WIDEST: i32 = 3 << 27;
        if self.near < 0 || self.near > 4 * METRE {
            return Err(Error::OutOfRange("area: near"));
        }
        if self.far < self.near + CELL || self.far > (MAP_DEPTH as i32 - 2) * CELL {
            return Err(Error::OutOfRange("area: far"));
        }
        if self.left < -WIDEST || self.left > 0 {
            return Err(Error::OutOfRange("area: left"));
        }
        if self.right < 0 || self.right > WIDEST {
            return Err(Error::OutOfRange("area: right"));
        }
        Ok(())
    }
}

/// The area for a camera and a floor: forward distances in 1/128 mm, and right/forward slopes in Q16.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SensoryArea {
    pub(super) near: i32,
    pub(super) far: i32,
    pub(super) left: i32,
    pub(super) right: i32,
}

impl SensoryArea {
    /// The sides pass through the leftmost and rightmost rays of the principal point's row (or lie within them).
    ///
    /// Slopes are rounded down, at most 2 units off for cameras that look down by less than 60 degrees; all below 2^29.
    pub fn new(params: &AreaParams, intrinsics: &Intrinsics, floor: &Floor) -> Self {
        const ONE: i64 = ONE_Q30 as i64;
        let down = i64::from(floor.normal[2]).clamp(-ONE, ONE);
        // The ray (x, 0, 1) reaches x to the right and cos(pitch) forward; a camera looking straight down has no sides.
        let forward = (((ONE * ONE - down * down) as u64).isqrt() as i64).max(ONE / 100);
        let side = |column: i64| {
            let ray = ((((column << 16) - i64::from(intrinsics.cx)) << 30) / i64::from(intrinsics.fx.max(1)))
                .clamp(-(ONE << 5), ONE << 5);
            (ray << 16).div_euclid(forward) as i32
        };
        let slope = |angle: i32| {
            let (sin, cos) = sin_cos(angle);
            (i64::from(sin) << 16).div_euclid(i64::from(cos).max(ONE / 1000)) as i32
        };
        Self {
            near: params.near,
            far: params.far,
            left: slope(params.left).max(side(0)),
            right: slope(params.right).min(side(i64::from(intrinsics.width) - 1)),
        }
    }

    /// Whether a point of the floor (right, forward) lies in the area.
    #[inline(always)]
    pub fn contains(&self, right: i32, forward: i32) -> bool {
        let across = i64::from(right) << 16;
        let side = |slope: i32| i64::from(slope) * i64::from(forward);
        self.near <= forward && forward <= self.far && side(self.left) <= across && across <= side(self.right)
    }

    /// Whether a cell lies at the area's border: it or one of its four neighbours is not inside.
    pub fn at_border(&self, column: u8, row: u8) -> bool {
        let [right, forward] = cell_centre(column, row);
        let outside = |dx: i32, dy: i32| !self.contains(right + dx, forward + dy);
        column == 0
            || usize::from(column) + 1 >= MAP_WIDTH
            || outside(CELL, 0)
            || outside(-CELL, 0)
            || outside(0, CELL)
            || outside(0, -CELL)
    }

    /// The distance of the area's centre from the camera along the floor: where the plane pi_f stands.
    pub fn centre(&self) -> i32 {
        (self.near + self.far) / 2
    }

    /// Corners (right, forward): near left, near right, far right, far left.
    pub fn corners(&self) -> [[i32; 2]; 4] {
        [(self.left, self.near), (self.right, self.near), (self.right, self.far), (self.left, self.far)]
            .map(|(slope, forward)| [((i64::from(slope) * i64::from(forward)) >> 16) as i32, forward])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ground;

    fn areas(camera: crate::Intrinsics, pitch: f32) -> (ground::SensoryArea, SensoryArea) {
        let floor = crate::Floor::from_pose(1.2, pitch, 0.05).unwrap();
        let normal = floor.normal.map(|v| (f64::from(v) * 1_073_741_824.0) as i32);
        let params = ground::AreaParams::DEFAULT;
        (
            ground::SensoryArea::new(&params, &camera, &floor),
            SensoryArea::new(
                &AreaParams::new(&params).unwrap(),
                &Intrinsics::new(&camera).unwrap(),
                &Floor { normal, height: 153_600 },
            ),
        )
    }

    #[test]
    fn corners_agree_with_the_float_ones() {
        for pitch in [-0.3, 0.0, 0.4, 0.9] {
            let (float, fixed) = areas(crate::Intrinsics::KINECT_QVGA, pitch);
            for (a, b) in float.corners().iter().flatten().zip(fixed.corners().iter().flatten()) {
                assert!((a * 128_000.0 - *b as f32).abs() < 20.0, "{pitch}: {a} {b}");
            }
            assert!((float.centre() * 128_000.0 - fixed.centre() as f32).abs() < 1.0);
        }
    }

    #[test]
    fn cells_at_the_border_agree() {
        let (float, fixed) = areas(crate::Intrinsics::PRIMESENSE_QVGA, 0.3);
        let mut differences = 0;
        for row in 0..MAP_DEPTH as u8 {
            for column in 0..=255 {
                let float = float.at_border(usize::from(column), usize::from(row));
                differences += usize::from(float != fixed.at_border(column, row));
            }
        }
        assert!(differences <= 4, "{differences}");
    }

    #[test]
    fn the_widest_lens_and_the_steepest_look() {
        let camera = crate::Intrinsics { fx: 32.0, cx: -320.0, ..crate::Intrinsics::KINECT_QVGA };
        let (_, area) = areas(camera, core::f32::consts::FRAC_PI_2);
        assert!(!area.contains(i32::MAX, 256_000) && !area.contains(i32::MIN, 256_000));
        assert!(!area.contains(0, i32::MAX) && !area.contains(0, i32::MIN));
    }

    #[test]
    fn bounds_out_of_range_are_named() {
        let p = ground::AreaParams { far: 9.0, ..ground::AreaParams::DEFAULT };
        assert_eq!(AreaParams::new(&p), Err(Error::OutOfRange("area: far")));
        let p = ground::AreaParams { left: f32::NAN, ..ground::AreaParams::DEFAULT };
        assert_eq!(AreaParams::new(&p), Err(Error::OutOfRange("area: left")));
    }
}
