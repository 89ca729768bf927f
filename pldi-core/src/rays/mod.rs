//! The rays of all pixels, computed once for a camera: back-projection without divisions.

pub mod fixed;

use crate::{Error, Intrinsics};

/// Directions K^-1 [u, v, 1]^T of every pixel, scaled so that z = 1: a column's x and a row's y.
#[derive(Debug, Clone)]
#[allow(missing_copy_implementations, reason = "tables")]
pub struct Rays<const W: usize, const H: usize> {
    intrinsics: Intrinsics,
    x: [f32; W],
    y: [f32; H],
}

impl<const W: usize, const H: usize> Rays<W, H> {
    /// The tables of a camera of the frame's size.
    ///
    /// # Errors
    /// `IntrinsicsSize` where the intrinsics are for another size than `W` x `H`; what [`Intrinsics::validate`] says.
    pub fn new(intrinsics: &Intrinsics) -> Result<Self, Error> {
        if (usize::from(intrinsics.width), usize::from(intrinsics.height)) != (W, H) {
            return Err(Error::IntrinsicsSize {
                intrinsics: (intrinsics.width, intrinsics.height),
                frame: (W as u16, H as u16),
            });
        }
        intrinsics.validate()?;
        Ok(Self {
            intrinsics: *intrinsics,
            x: core::array::from_fn(|u| (u as f32 - intrinsics.cx) / intrinsics.fx),
            y: core::array::from_fn(|v| (v as f32 - intrinsics.cy) / intrinsics.fy),
        })
    }

    /// The camera that the tables are for.
    pub fn intrinsics(&self) -> &Intrinsics {
        &self.intrinsics
    }

    /// x of the rays of each column, per metre of depth.
    #[inline(always)]
    pub fn x(&self) -> &[f32; W] {
        &self.x
    }

    /// y of the rays of each row, per metre of depth.
    #[inline(always)]
    pub fn y(&self) -> &[f32; H] {
        &self.y
    }

    /// The point in the camera frame (metres) at column `u`, row `v` and depth `z` metres; the origin where the pixel
    /// is outside of the image.
    #[inline(always)]
    pub fn point(&self, u: usize, v: usize, z: f32) -> [f32; 3] {
        match (self.x.get(u), self.y.get(v)) {
            (Some(x), Some(y)) => [x * z, y * z, z],
            _ => [0.0; 3],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_agree_with_the_intrinsics() {
        let k = Intrinsics::PRIMESENSE_QVGA;
        let rays = Rays::<320, 240>::new(&k).unwrap();
        for (u, v) in [(0, 0), (319, 239), (160, 77)] {
            let (a, b) = (rays.point(u, v, 1.7), k.back_project(u as f32, v as f32, 1.7));
            assert!((0..3).all(|i| (a[i] - b[i]).abs() < 1e-6));
        }
    }

    #[test]
    fn another_size_is_an_error_that_names_both() {
        assert_eq!(
            Rays::<640, 480>::new(&Intrinsics::KINECT_QVGA).unwrap_err(),
            Error::IntrinsicsSize { intrinsics: (320, 240), frame: (640, 480) }
        );
    }
}
