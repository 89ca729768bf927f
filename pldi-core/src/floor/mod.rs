//! The floor plane: from a known camera pose, or found in each frame (paper, section 4, indoor scene constraint).

pub mod fixed;
pub mod ransac;

use crate::array::transposed;
use crate::{Error, math};
pub use ransac::RansacParams;

/// The floor in the camera frame: points p with normal . p + height = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Floor {
    /// Unit normal, pointing up (towards the camera).
    pub normal: [f32; 3],
    /// Height of the camera above the floor in metres, positive.
    pub height: f32,
}

impl Floor {
    /// The floor seen by a camera `height` metres above it, looking down by `pitch` and turned clockwise about its
    /// axis by `roll` (both in radians; a level camera has 0, 0).
    ///
    /// # Errors
    /// `OutOfRange` unless 0 < height <= 10 and the angles lie within a quarter turn.
    pub fn from_pose(height: f32, pitch: f32, roll: f32) -> Result<Self, Error> {
        const QUARTER: f32 = core::f32::consts::FRAC_PI_2;
        crate::error::within("camera height", height, 0.01, 10.0)?;
        crate::error::within("camera pitch", pitch, -QUARTER, QUARTER)?;
        crate::error::within("camera roll", roll, -QUARTER, QUARTER)?;
        let ((sp, cp), (sr, cr)) = (math::sin_cos(pitch), math::sin_cos(roll));
        Ok(Self { normal: [sr * -cp, cr * -cp, -sp], height })
    }

    /// Checks a plane that was put together by hand: a unit normal and a height as in [`Floor::from_pose`].
    ///
    /// # Errors
    /// `OutOfRange` with what is wrong (also for NaN).
    pub fn validate(&self) -> Result<(), Error> {
        let [x, y, z] = self.normal;
        crate::error::within("length of the floor's normal", x * x + y * y + z * z, 0.999, 1.001)?;
        crate::error::within("camera height", self.height, 0.01, 10.0)
    }

    /// Height of a point of the camera frame above the floor, in metres.
    #[inline(always)]
    pub fn height_of(&self, p: [f32; 3]) -> f32 {
        self.normal[0] * p[0] + self.normal[1] * p[1] + self.normal[2] * p[2] + self.height
    }

    /// How far the camera looks down, in radians.
    pub fn pitch(&self) -> f32 {
        math::asin(-self.normal[2])
    }

    /// How far the camera is turned clockwise about its axis, in radians.
    pub fn roll(&self) -> f32 {
        math::atan2(-self.normal[0], -self.normal[1])
    }

    /// The frame on the floor below the camera.
    pub fn axes(&self) -> FloorAxes {
        let n = self.normal;
        // The principal direction (0, 0, 1) without its part along the normal. A camera that looks straight down
        // has none: then "forward" is where the top of its image is.
        let mut forward = [-n[2] * n[0], -n[2] * n[1], 1.0 - n[2] * n[2]];
        let mut length2 = 1.0 - n[2] * n[2];
        if length2 < 1e-6 {
            (forward, length2) = ([0.0, -1.0, 0.0], 1.0);
        }
        let scale = 1.0 / math::sqrt(length2);
        let forward = forward.map(|v| v * scale);
        FloorAxes { right: crate::eigen::cross(forward, n), forward, floor: *self }
    }
}

/// Floor coordinates: x to the right, y forward (the principal direction along the floor), origin below the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FloorAxes {
    /// Unit vector to the right along the floor, in the camera frame.
    pub right: [f32; 3],
    /// Unit vector forward along the floor, in the camera frame.
    pub forward: [f32; 3],
    /// The plane.
    pub floor: Floor,
}

impl FloorAxes {
    /// Right, forward and height of a point of the camera frame, in metres.
    #[inline(always)]
    pub fn to_floor(&self, p: [f32; 3]) -> [f32; 3] {
        let (r, f) = (self.right, self.forward);
        [r[0] * p[0] + r[1] * p[1] + r[2] * p[2], f[0] * p[0] + f[1] * p[1] + f[2] * p[2], self.floor.height_of(p)]
    }

    /// The point of the camera frame with these floor coordinates (right, forward, height in metres).
    #[inline]
    pub fn to_camera(&self, q: [f32; 3]) -> [f32; 3] {
        let up = q[2] - self.floor.height;
        transposed([self.right, self.forward, self.floor.normal]).map(|[r, f, n]| q[0] * r + q[1] * f + up * n)
    }
}

/// Where the floor comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FloorMode {
    /// The camera's pose is known, see [`Floor::from_pose`].
    Fixed(Floor),
    /// Found in each frame.
    Ransac(RansacParams),
}

impl Default for FloorMode {
    fn default() -> Self {
        Self::Ransac(RansacParams::DEFAULT)
    }
}

#[cfg(feature = "nalgebra")]
impl From<Floor> for nalgebra::Vector4<f32> {
    /// The homogeneous plane (normal, height).
    fn from(floor: Floor) -> Self {
        let [x, y, z] = floor.normal;
        Self::new(x, y, z, floor.height)
    }
}

#[cfg(feature = "nalgebra")]
impl From<FloorAxes> for nalgebra::Matrix4<f32> {
    /// The extrinsics: the homogeneous matrix that takes points of the camera frame to floor coordinates.
    fn from(axes: FloorAxes) -> Self {
        let (r, f, n) = (axes.right, axes.forward, axes.floor.normal);
        Self::new(r[0], r[1], r[2], 0.0, f[0], f[1], f[2], 0.0, n[0], n[1], n[2], axes.floor.height, 0.0, 0.0, 0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_level_camera_has_the_floor_below() {
        let floor = Floor::from_pose(1.2, 0.0, 0.0).unwrap();
        assert_eq!(floor.normal, [-0.0, -1.0, -0.0]);
        assert!((floor.height_of([0.3, 1.2, 2.0])).abs() < 1e-6);
        let q = floor.axes().to_floor([0.3, 0.2, 2.0]);
        assert!((q[0] - 0.3).abs() < 1e-6 && (q[1] - 2.0).abs() < 1e-6 && (q[2] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn planes_that_are_none_are_refused() {
        let good = Floor::from_pose(1.2, 0.3, 0.1).unwrap();
        assert_eq!(good.validate(), Ok(()));
        let normal = "length of the floor's normal";
        assert_eq!(Floor { normal: [0.0; 3], ..good }.validate(), Err(Error::OutOfRange(normal)));
        assert_eq!(Floor { normal: [f32::NAN, 0.0, 1.0], ..good }.validate(), Err(Error::OutOfRange(normal)));
        assert_eq!(Floor { height: f32::INFINITY, ..good }.validate(), Err(Error::OutOfRange("camera height")));
    }

    #[test]
    fn impossible_poses_are_refused() {
        assert_eq!(Floor::from_pose(0.0, 0.0, 0.0), Err(Error::OutOfRange("camera height")));
        assert_eq!(Floor::from_pose(1.0, f32::NAN, 0.0), Err(Error::OutOfRange("camera pitch")));
        assert!(
            Floor::from_pose(1.0, core::f32::consts::FRAC_PI_2, 0.0)
                .unwrap()
                .axes()
                .forward
                .iter()
                .all(|v| v.is_finite())
        );
    }

    proptest! {
        #[test]
        fn pose_and_coordinates_come_back(
            height in 0.2f32..2.5, pitch in -0.3f32..1.4, roll in -0.5f32..0.5, p in proptest::array::uniform3(-3.0f32..3.0),
        ) {
            let floor = Floor::from_pose(height, pitch, roll).unwrap();
            prop_assert!((floor.pitch() - pitch).abs() < 1e-3 && (floor.roll() - roll).abs() < 1e-3);
            let axes = floor.axes();
            let back = axes.to_camera(axes.to_floor(p));
            prop_assert!((0..3).all(|i| (back[i] - p[i]).abs() < 1e-4));
        }
    }
}
