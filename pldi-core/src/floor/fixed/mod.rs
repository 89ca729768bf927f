//! The floor plane in integers, see the module above. Lengths in 1/128 mm, unit vectors in Q30, angles in Q28 radians.

mod params;
mod plane;
pub mod ransac;

use crate::Error;
use crate::array::transposed;
use crate::fixed::{METRE, mul_q30, quantise, sin_cos, unit};
pub use params::RansacParams;

/// Largest height of a camera: 10 m, in 1/128 mm.
pub(crate) const HIGHEST: i32 = 10 * METRE;

/// A quarter turn, Q28.
const QUARTER: i32 = 421_657_428;

/// The floor in the camera frame: points p with normal . p + height = 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Floor {
    /// Unit normal, pointing up (towards the camera), Q30.
    pub normal: [i32; 3],
    /// Height of the camera above the floor in 1/128 mm, positive.
    pub height: i32,
}

impl Floor {
    /// The floor seen by a camera `height` (1/128 mm) above it, looking down by `pitch` and turned clockwise about its
    /// axis by `roll` (both Q28 radians; a level camera has 0, 0).
    ///
    /// # Errors
    /// `OutOfRange` unless the height is 1 cm to 10 m and the angles lie within a quarter turn.
    pub const fn from_pose(height: i32, pitch: i32, roll: i32) -> Result<Self, Error> {
        if height < METRE / 100 || height > HIGHEST {
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

    /// The plane in integers, rounded to nearest; at compile time in a `const`.
    ///
    /// # Errors
    /// As [`crate::Floor::validate`].
    pub const fn new(float: &crate::Floor) -> Result<Self, Error> {
        const Q30: f64 = 1_073_741_824.0;
        let [x, y, z] = float.normal;
        let (Some(x), Some(y), Some(z)) =
            (quantise(x, -1.001, 1.001, Q30), quantise(y, -1.001, 1.001, Q30), quantise(z, -1.001, 1.001, Q30))
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

    /// Checks a plane that was put together by hand: a unit normal and a height as in [`Floor::from_pose`].
    ///
    /// # Errors
    /// `OutOfRange` with what is wrong.
    pub const fn validate(&self) -> Result<(), Error> {
        // Q28, so that the squares' sum fits: within a thousandth of 1.
        let [x, y, z] = [self.normal[0] as i64 >> 2, self.normal[1] as i64 >> 2, self.normal[2] as i64 >> 2];
        let excess = x * x + y * y + z * z - (1 << 56);
        if excess.abs() > (1 << 56) / 1000 {
            return Err(Error::OutOfRange("length of the floor's normal"));
        }
        if self.height < METRE / 100 || self.height > HIGHEST + 1 {
            return Err(Error::OutOfRange("camera height"));
        }
        Ok(())
    }

    /// Height of a point of the camera frame above the floor: all in 1/128 mm, rounded to nearest. For points of at most
    /// 2^29 (4 km) in each coordinate.
    #[inline(always)]
    pub const fn height_of(&self, p: [i32; 3]) -> i32 {
        along(self.normal, p) + self.height
    }

    /// The frame on the floor below the camera.
    pub fn axes(&self) -> FloorAxes {
        let n = self.normal;
        // The principal direction (0, 0, 1) without its part along the normal, see the float twin.
        let [x, y] = [-mul_q30(n[2], n[0]), -mul_q30(n[2], n[1])];
        let length2 = (1 << 30) - mul_q30(n[2], n[2]);
        let forward = if length2 < 1074 { None } else { unit([i64::from(x), i64::from(y), i64::from(length2)]) };
        let forward = forward.unwrap_or([0, -(1 << 30), 0]);
        let minor = |i: usize, j: usize| {
            let product = |a: i32, b: i32| i64::from(a) * i64::from(b);
            ((product(forward[i], n[j]) - product(forward[j], n[i]) + (1 << 29)) >> 30) as i32
        };
        FloorAxes { right: [minor(1, 2), minor(2, 0), minor(0, 1)], forward, floor: *self }
    }

    /// In floats, to be looked at.
    pub fn to_float(&self) -> crate::Floor {
        crate::Floor {
            normal: self.normal.map(|v| v as f32 / (1 << 30) as f32),
            height: self.height as f32 / METRE as f32,
        }
    }
}

/// Component of a point along a Q30 vector, rounded to nearest. Below 2^60.6 for points below 2^29 and vectors of length 1.
#[inline(always)]
const fn along(a: [i32; 3], p: [i32; 3]) -> i32 {
    let sum = a[0] as i64 * p[0] as i64 + a[1] as i64 * p[1] as i64 + a[2] as i64 * p[2] as i64;
    ((sum + (1 << 29)) >> 30) as i32
}

/// Floor coordinates: x to the right, y forward (the principal direction along the floor), origin below the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FloorAxes {
    /// Unit vector to the right along the floor, in the camera frame, Q30.
    pub right: [i32; 3],
    /// Unit vector forward along the floor, in the camera frame, Q30.
    pub forward: [i32; 3],
    /// The plane.
    pub floor: Floor,
}

impl FloorAxes {
    /// Right, forward and height of a point of the camera frame: all in 1/128 mm, rounded to nearest. For points of at most
    /// 2^29 in each coordinate.
    #[inline(always)]
    pub const fn to_floor(&self, p: [i32; 3]) -> [i32; 3] {
        [along(self.right, p), along(self.forward, p), self.floor.height_of(p)]
    }

    /// The point of the camera frame with these floor coordinates (right, forward, height), all in 1/128 mm, rounded to
    /// nearest. For coordinates of at most 2^29.
    #[inline]
    pub fn to_camera(&self, q: [i32; 3]) -> [i32; 3] {
        let q = [q[0], q[1], q[2] - self.floor.height];
        transposed([self.right, self.forward, self.floor.normal]).map(|row| along(row, q))
    }
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

    /// The mode in integers; at compile time in a `const`.
    ///
    /// # Errors
    /// As [`Floor::new`] and [`RansacParams::new`].
    pub const fn new(float: &crate::floor::FloorMode) -> Result<Self, Error> {
        match float {
            crate::floor::FloorMode::Fixed(floor) => match Floor::new(floor) {
                Ok(floor) => Ok(Self::Fixed(floor)),
                Err(error) => Err(error),
            },
            crate::floor::FloorMode::Ransac(params) => match RansacParams::new(params) {
                Ok(params) => Ok(Self::Ransac(params)),
                Err(error) => Err(error),
            },
        }
    }
}

impl Default for FloorMode {
    fn default() -> Self {
        Self::Ransac(RansacParams::DEFAULT)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const RADIAN: f64 = 268_435_456.0;

    #[test]
    fn planes_that_are_none_are_refused() {
        let good = Floor::from_pose(METRE, 80_000_000, 20_000_000).unwrap();
        assert_eq!(good.validate(), Ok(()));
        let normal = Err(Error::OutOfRange("length of the floor's normal"));
        assert_eq!(Floor { normal: [0; 3], ..good }.validate(), normal);
        assert_eq!(Floor { normal: [i32::MIN; 3], ..good }.validate(), normal);
        assert_eq!(Floor { height: 0, ..good }.validate(), Err(Error::OutOfRange("camera height")));
        assert!(Floor::from_pose(0, 0, 0).is_err() && Floor::from_pose(METRE, i32::MIN, 0).is_err());
        assert!(Floor::new(&crate::Floor { normal: [f32::NAN, 0.0, 1.0], height: 1.0 }).is_err());
        let ten = crate::Floor::from_pose(10.0, 0.4, 0.1).unwrap();
        assert_eq!(Floor::new(&ten).map(|floor| floor.height), Ok(10 * METRE));
    }

    #[test]
    fn a_camera_that_looks_straight_down_has_a_forward() {
        let axes = Floor::from_pose(METRE, QUARTER, 0).unwrap().axes();
        assert_eq!(axes.forward, [0, -(1 << 30), 0]);
    }

    proptest! {
        #[test]
        fn the_float_twin_agrees(
            height in 0.2f32..2.5, pitch in -1.5f32..1.5, roll in -0.5f32..0.5, p in proptest::array::uniform3(-8.0f32..8.0),
        ) {
            let float = crate::Floor::from_pose(height, pitch, roll).unwrap();
            let angle = |v: f32| (f64::from(v) * RADIAN).round() as i32;
            let fixed = Floor::from_pose((height * 128_000.0).round() as i32, angle(pitch), angle(roll)).unwrap();
            for floor in [fixed, Floor::new(&float).unwrap()] {
                prop_assert!(floor.validate().is_ok());
                prop_assert!((0..3).all(|i| (floor.to_float().normal[i] - float.normal[i]).abs() < 3e-7));
                let (a, b) = (floor.axes(), float.axes());
                let point = p.map(|v| (v * 128_000.0).round() as i32);
                let (q, truth) = (a.to_floor(point), b.to_floor(p));
                let slack = 0.02 + 2e-4 / libm::cos(f64::from(pitch));
                prop_assert!((0..3).all(|i| (f64::from(q[i]) / 128_000.0 - f64::from(truth[i])).abs() < slack * 1e-2));
                let back = a.to_camera(q);
                prop_assert!((0..3).all(|i| (back[i] - point[i]).abs() <= 8), "{back:?} {point:?}");
            }
        }
    }
}
