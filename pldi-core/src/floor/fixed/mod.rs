//! The floor in integers: from a known camera pose, or found in each frame.

pub mod ransac;

use crate::Error;
use crate::fixed::{METRE, ONE_Q30, mul_q30, quantise, sin_cos, unit};
pub use ransac::RansacParams;

/// A quarter turn in radians, Q28.
pub(super) const QUARTER: i32 = 421_657_428;

/// The largest height of a camera, 10 m.
const HIGHEST: i32 = 10 * METRE;

/// The smallest height of a camera, 1 cm.
const LOWEST: i32 = METRE / 100;

/// The floor in the camera frame: points p with normal . p + height = 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Floor {
    /// Unit normal in Q30, pointing up (towards the camera).
    pub normal: [i32; 3],
    /// Height of the camera above the floor in 1/128 mm, positive.
    pub height: i32,
}

impl Floor {
    /// The floor seen by a camera `height` (1/128 mm) above it, looking down by `pitch` and turned clockwise about its axis
    /// by `roll` (both in radians, Q28).
    ///
    /// # Errors
    /// `OutOfRange` unless the height is 1 cm to 10 m and the angles lie within a quarter turn.
    pub const fn from_pose(height: i32, pitch: i32, roll: i32) -> Result<Self, Error> {
        if height < LOWEST || height > HIGHEST {
            return Err(Error::OutOfRange("camera height"));
        }
        if pitch < -QUARTER || pitch > QUARTER {
            return Err(Error::OutOfRange("camera pitch"));
        }
        if roll < -QUARTER || roll > QUARTER {
            return Err(Error::OutOfRange("camera roll"));
        }
        let ((sp, cp), (sr, cr)) = (sin_cos(pitch), sin_cos(roll));
        Ok(Self { normal: [-mul_q30(sr, cp), -mul_q30(cr, cp), -sp], height })
    }

    /// A floor in floats, rounded.
    ///
    /// # Errors
    /// `OutOfRange` for what is no unit normal (to 1/1000) or no height of 1 cm to 10 m.
    pub const fn new(float: &crate::Floor) -> Result<Self, Error> {
        const ONE: f64 = ONE_Q30 as f64;
        let [x, y, z] = float.normal;
        let (Some(x), Some(y), Some(z)) =
            (quantise(x, -1.001, 1.001, ONE), quantise(y, -1.001, 1.001, ONE), quantise(z, -1.001, 1.001, ONE))
        else {
            return Err(Error::OutOfRange("length of the floor's normal"));
        };
        let Some(height) = quantise(float.height, 0.01, 10.0, METRE as f64) else {
            return Err(Error::OutOfRange("camera height"));
        };
        let floor = Self { normal: [x as i32, y as i32, z as i32], height: height as i32 };
        match floor.validate() {
            Ok(()) => Ok(floor),
            Err(error) => Err(error),
        }
    }

    /// Checks a plane that was put together by hand: a unit normal (to 1/1000) and a height of 1 cm to 10 m.
    ///
    /// # Errors
    /// `OutOfRange` with what is wrong.
    pub const fn validate(&self) -> Result<(), Error> {
        let [x, y, z] = [self.normal[0] as i64, self.normal[1] as i64, self.normal[2] as i64];
        // Below 3 * 2^62 / 2^30.
        let square = ((x * x) >> 30) + ((y * y) >> 30) + ((z * z) >> 30);
        if square < ONE_Q30 as i64 / 1000 * 999 || square > ONE_Q30 as i64 / 1000 * 1001 {
            return Err(Error::OutOfRange("length of the floor's normal"));
        }
        if self.height < LOWEST || self.height > HIGHEST {
            return Err(Error::OutOfRange("camera height"));
        }
        Ok(())
    }

    /// Height of a point of the camera frame above the floor; all in 1/128 mm, rounded to nearest.
    #[inline(always)]
    pub fn height_of(&self, p: [i32; 3]) -> i32 {
        dot(self.normal, p) + self.height
    }

    /// The same floor in floats: for hosts.
    pub fn to_float(&self) -> crate::Floor {
        crate::Floor {
            normal: self.normal.map(|v| v as f32 / ONE_Q30 as f32),
            height: self.height as f32 / METRE as f32,
        }
    }

    /// The frame on the floor below the camera.
    pub fn axes(&self) -> FloorAxes {
        let n = self.normal.map(i64::from);
        let one = i64::from(ONE_Q30);
        let square = one - ((n[2] * n[2]) >> 30);
        let forward = if square < one / 1_000_000 {
            [0, -ONE_Q30, 0]
        } else {
            unit([-((n[2] * n[0]) >> 30), -((n[2] * n[1]) >> 30), square]).unwrap_or([0, -ONE_Q30, 0])
        };
        let cross = |a: usize, b: usize| mul_q30(forward[a], self.normal[b]) - mul_q30(forward[b], self.normal[a]);
        FloorAxes { right: [cross(1, 2), cross(2, 0), cross(0, 1)], forward, floor: *self }
    }
}

/// Floor coordinates: x to the right, y forward (the principal direction along the floor), origin below the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FloorAxes {
    /// Unit vector to the right along the floor, in the camera frame, Q30.
    pub right: [i32; 3],
    /// Unit vector forward along the floor, in the camera frame, Q30.
    pub forward: [i32; 3],
    /// The plane.
    pub floor: Floor,
}

impl FloorAxes {
    /// Right, forward and height of a point of the camera frame, in 1/128 mm.
    pub fn to_floor(&self, p: [i32; 3]) -> [i32; 3] {
        [dot(self.right, p), dot(self.forward, p), self.floor.height_of(p)]
    }

    /// The point of the camera frame with these floor coordinates, in 1/128 mm.
    pub fn to_camera(&self, q: [i32; 3]) -> [i32; 3] {
        let up = q[2] - self.floor.height;
        core::array::from_fn(|i| {
            mul_q30(q[0], self.right[i]) + mul_q30(q[1], self.forward[i]) + mul_q30(up, self.floor.normal[i])
        })
    }
}

/// Scalar product of a unit vector in Q30 and a point, rounded to nearest. Below 2^62 for points within 8000 km.
#[inline(always)]
fn dot(a: [i32; 3], p: [i32; 3]) -> i32 {
    let sum: i64 = (0..3).map(|i| i64::from(a[i]) * i64::from(p[i])).sum();
    ((sum + (1 << 29)) >> 30) as i32
}

/// Where the floor comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FloorMode {
    /// The camera's pose is known, see [`Floor::from_pose`].
    Fixed(Floor),
    /// Found in each frame.
    Ransac(RansacParams),
}

impl FloorMode {
    /// The float mode, rounded.
    ///
    /// # Errors
    /// `OutOfRange` with what is wrong.
    pub const fn new(float: &super::FloorMode) -> Result<Self, Error> {
        match float {
            super::FloorMode::Fixed(floor) => match Floor::new(floor) {
                Ok(floor) => Ok(Self::Fixed(floor)),
                Err(error) => Err(error),
            },
            super::FloorMode::Ransac(params) => match RansacParams::new(params) {
                Ok(params) => Ok(Self::Ransac(params)),
                Err(error) => Err(error),
            },
        }
    }

    /// Checks numbers that were put together by hand.
    ///
    /// # Errors
    /// `OutOfRange` with what is wrong.
    pub const fn validate(&self) -> Result<(), Error> {
        match self {
            Self::Fixed(floor) => floor.validate(),
            Self::Ransac(params) => params.validate(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn planes_that_are_none_are_refused() {
        let good = Floor::from_pose(METRE, 1 << 26, 0).unwrap();
        assert_eq!(good.validate(), Ok(()));
        assert!(Floor { normal: [0; 3], ..good }.validate().is_err());
        assert!(Floor { height: 0, ..good }.validate().is_err());
        assert!(Floor::from_pose(METRE, i32::MAX, 0).is_err() && Floor::from_pose(11 * METRE, 0, 0).is_err());
        assert!(Floor::new(&crate::Floor { normal: [f32::NAN, -1.0, 0.0], height: 1.0 }).is_err());
    }

    proptest! {
        #[test]
        fn poses_and_coordinates_agree_with_floats(
            height in 0.2f32..2.5, pitch in -0.3f32..1.5, roll in -0.5f32..0.5, p in proptest::array::uniform3(-5.0f32..5.0),
        ) {
            let float = crate::Floor::from_pose(height, pitch, roll).unwrap();
            let q28 = |angle: f32| (f64::from(angle) * 268_435_456.0) as i32;
            let fixed = Floor::from_pose((height * 128_000.0) as i32, q28(pitch), q28(roll)).unwrap();
            for other in [fixed.to_float(), Floor::new(&float).unwrap().to_float()] {
                prop_assert!((0..3).all(|i| (other.normal[i] - float.normal[i]).abs() < 1e-6));
                prop_assert!((other.height - float.height).abs() < 1e-5);
            }
            let point = p.map(|v| (v * 128_000.0) as i32);
            let (a, b) = (float.axes().to_floor(p), fixed.axes().to_floor(point));
            for (a, b) in a.iter().zip(b) {
                prop_assert!((a - b as f32 / 128_000.0).abs() < 1e-4, "{a:?} {b:?}");
            }
            let back = fixed.axes().to_camera(b);
            prop_assert!(point.iter().zip(back).all(|(a, b)| a.abs_diff(b) <= 8), "{point:?} {back:?}");
        }
    }
}
