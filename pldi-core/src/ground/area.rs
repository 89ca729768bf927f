//! The sensory area: where on the floor objects are looked for (paper, section 4, sensing constraints; Fig. 3).

use super::{CELL, MAP_DEPTH, MAP_WIDTH, cell_centre};
use crate::{Error, Floor, Intrinsics, math};

/// Bounds of the sensory area.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AreaParams {
    /// Nearest distance along the floor in metres, 0 to 4. Default 0.5.
    pub near: f32,
    /// Farthest distance along the floor in metres, up to 4.1. Default 4 (paper, section 6).
    pub far: f32,
    /// Leftmost angle from the principal direction, in radians, negative; NaN-free. Default -1.5: the image's border.
    pub left: f32,
    /// Rightmost angle from the principal direction, in radians. Default 1.5: the image's border.
    pub right: f32,
}

impl AreaParams {
    /// As far as the paper, as wide as the image.
    pub const DEFAULT: Self = Self { near: 0.5, far: 4.0, left: -1.5, right: 1.5 };

    /// Checks every number against its stated range.
    ///
    /// # Errors
    /// `OutOfRange` with the parameter's name.
    pub fn validate(&self) -> Result<(), Error> {
        use crate::error::within;
        within("area: near", self.near, 0.0, 4.0)?;
        within("area: far", self.far, self.near + CELL, (MAP_DEPTH - 2) as f32 * CELL)?;
        within("area: left", self.left, -1.5, 0.0)?;
        within("area: right", self.right, 0.0, 1.5)
    }
}

/// The area for a camera and a floor: forward distances `near..=far`, and right/forward slopes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SensoryArea {
    near: f32,
    far: f32,
    left: f32,
    right: f32,
}

impl SensoryArea {
    /// The sides pass through the leftmost and rightmost rays of the principal point's row (or lie within them).
    pub fn new(params: &AreaParams, intrinsics: &Intrinsics, floor: &Floor) -> Self {
        // The ray (x, 0, 1) reaches x to the right and cos(pitch) forward; a camera looking straight down has no sides.
        let forward = math::sqrt((1.0 - floor.normal[2] * floor.normal[2]).max(1e-4));
        let side = |u: f32| (u - intrinsics.cx) / intrinsics.fx / forward;
        let slope = |angle: f32| {
            let (sin, cos) = math::sin_cos(angle);
            sin / cos.max(1e-3)
        };
        Self {
            near: params.near,
            far: params.far,
            left: slope(params.left).max(side(0.0)),
            right: slope(params.right).min(side(f32::from(intrinsics.width) - 1.0)),
        }
    }

    /// Whether a point of the floor (right, forward in metres) lies in the area.
    #[inline(always)]
    pub fn contains(&self, right: f32, forward: f32) -> bool {
        self.near <= forward && forward <= self.far && self.left * forward <= right && right <= self.right * forward
    }

    /// Whether a cell lies at the area's border: it or one of its four neighbours is not inside.
    pub fn at_border(&self, column: usize, row: usize) -> bool {
        let [right, forward] = cell_centre(column, row);
        let outside = |dx: f32, dy: f32| !self.contains(right + dx, forward + dy);
        column == 0
            || column + 1 >= MAP_WIDTH
            || outside(CELL, 0.0)
            || outside(-CELL, 0.0)
            || outside(0.0, CELL)
            || outside(0.0, -CELL)
    }

    /// The distance of the area's centre from the camera along the floor: where the plane pi_f stands.
    pub fn centre(&self) -> f32 {
        0.5 * (self.near + self.far)
    }

    /// Corners (right, forward) in metres: near left, near right, far right, far left.
    pub fn corners(&self) -> [[f32; 2]; 4] {
        [(self.left, self.near), (self.right, self.near), (self.right, self.far), (self.left, self.far)]
            .map(|(slope, forward)| [slope * forward, forward])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sides_are_the_outermost_rays() {
        let floor = Floor::from_pose(1.0, 0.0, 0.0).unwrap();
        let area = SensoryArea::new(&AreaParams::DEFAULT, &Intrinsics::KINECT_QVGA, &floor);
        let edge = 159.5 / 262.5;
        assert!(area.contains(edge * 2.0 - 0.001, 2.0) && !area.contains(edge * 2.0 + 0.001, 2.0));
        assert!(area.contains(0.0, 4.0) && !area.contains(0.0, 4.01) && !area.contains(0.0, 0.49));
        assert!(area.at_border(128, 199) && !area.at_border(128, 190));
    }

    #[test]
    fn a_camera_that_looks_down_sees_wider_on_the_floor() {
        let width = |pitch| {
            let floor = Floor::from_pose(1.0, pitch, 0.0).unwrap();
            SensoryArea::new(&AreaParams::DEFAULT, &Intrinsics::KINECT_QVGA, &floor).corners()[2][0]
        };
        assert!(width(0.8) > 1.3 * width(0.0));
    }

    #[test]
    fn bounds_out_of_range_are_named() {
        let p = AreaParams { far: 9.0, ..AreaParams::DEFAULT };
        assert_eq!(p.validate(), Err(Error::OutOfRange("area: far")));
    }
}
