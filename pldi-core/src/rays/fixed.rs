//! The rays in fixed point: x and y of every pixel in Q26.

use crate::Error;
use crate::fixed::quantise;

/// A pinhole camera in integers, see [`crate::Intrinsics`]. All but the size in Q16.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Intrinsics {
    /// Image width in pixels.
    pub width: u16,
    /// Image height in pixels.
    pub height: u16,
    /// Focal length in pixels, horizontally, Q16.
    pub fx: i32,
    /// Focal length in pixels, vertically, Q16.
    pub fy: i32,
    /// Column of the principal point, Q16.
    pub cx: i32,
    /// Row of the principal point, Q16.
    pub cy: i32,
}

impl Intrinsics {
    /// The intrinsics rounded to 1/65536 pixel; at compile time in a `const`.
    ///
    /// # Errors
    /// `OutOfRange` with the name of the number, for ranges as in [`crate::Intrinsics::validate`].
    pub const fn new(float: &crate::Intrinsics) -> Result<Self, Error> {
        const Q16: f64 = 65_536.0;
        let (w, h) = (float.width as f32, float.height as f32);
        if float.width == 0 || float.height == 0 {
            return Err(Error::OutOfRange("intrinsics: image size"));
        }
        // Above 32,767 pixels nothing fits Q16.
        let (Some(fx), Some(cx)) =
            (quantise(float.fx, 0.1 * w, least(100.0 * w, 32_767.0), Q16), quantise(float.cx, -w, 2.0 * w, Q16))
        else {
            return Err(Error::OutOfRange("fx or cx"));
        };
        let (Some(fy), Some(cy)) =
            (quantise(float.fy, 0.1 * h, least(100.0 * h, 32_767.0), Q16), quantise(float.cy, -h, 2.0 * h, Q16))
        else {
            return Err(Error::OutOfRange("fy or cy"));
        };
        Ok(Self {
            width: float.width,
            height: float.height,
            fx: fx as i32,
            fy: fy as i32,
            cx: cx as i32,
            cy: cy as i32,
        })
    }

    /// Checks integers that were put together by hand, as [`crate::Intrinsics::validate`] does.
    ///
    /// # Errors
    /// `OutOfRange` with the name of the number.
    pub const fn validate(&self) -> Result<(), Error> {
        let (w, h) = ((self.width as i64) << 16, (self.height as i64) << 16);
        if w == 0 || h == 0 {
            return Err(Error::OutOfRange("intrinsics: image size"));
        }
        if 10 * (self.fx as i64) < w || (self.cx as i64) < -w || (self.cx as i64) > 2 * w {
            return Err(Error::OutOfRange("fx or cx"));
        }
        if 10 * (self.fy as i64) < h || (self.cy as i64) < -h || (self.cy as i64) > 2 * h {
            return Err(Error::OutOfRange("fy or cy"));
        }
        Ok(())
    }
}

const fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Directions K^-1 [u, v, 1]^T of every pixel, scaled so that z = 1: a column's x and a row's y in Q26.
#[derive(Debug, Clone)]
#[allow(missing_copy_implementations, reason = "tables")]
pub struct Rays<const W: usize, const H: usize> {
    intrinsics: Intrinsics,
    x: [i32; W],
    y: [i32; H],
}

/// (pixel - centre) / focal length in Q26, rounded to nearest.
const fn slope(pixel: usize, centre: i32, focal: i32) -> i32 {
    let offset = ((pixel as i64) << 16) - centre as i64;
    let focal = if focal < 1 { 1 } else { focal as i64 };
    ((offset << 26) + focal / 2).div_euclid(focal) as i32
}

impl<const W: usize, const H: usize> Rays<W, H> {
    /// The tables of a camera of the frame's size; at compile time in a `const` or `static`. Rounded to nearest;
    /// |x|, |y| < 32.
    ///
    /// # Errors
    /// `IntrinsicsSize` where the intrinsics are for another size than `W` x `H`; what [`Intrinsics::validate`] says.
    pub const fn new(intrinsics: &Intrinsics) -> Result<Self, Error> {
        if intrinsics.width as usize != W || intrinsics.height as usize != H {
            return Err(Error::IntrinsicsSize {
                intrinsics: (intrinsics.width, intrinsics.height),
                frame: (W as u16, H as u16),
            });
        }
        if let Err(error) = intrinsics.validate() {
            return Err(error);
        }
        let mut rays = Self { intrinsics: *intrinsics, x: [0; W], y: [0; H] };
        let mut u = 0;
        while u < W {
            rays.x[u] = slope(u, intrinsics.cx, intrinsics.fx);
            u += 1;
        }
        let mut v = 0;
        while v < H {
            rays.y[v] = slope(v, intrinsics.cy, intrinsics.fy);
            v += 1;
        }
        Ok(rays)
    }

    /// The camera that the tables are for.
    pub fn intrinsics(&self) -> &Intrinsics {
        &self.intrinsics
    }

    /// x of the rays of each column, Q26.
    #[inline(always)]
    pub fn x(&self) -> &[i32; W] {
        &self.x
    }

    /// y of the rays of each row, Q26.
    #[inline(always)]
    pub fn y(&self) -> &[i32; H] {
        &self.y
    }

    /// The point in the camera frame (1/128 mm) at column `u`, row `v` and depth `z` (1/8 mm), rounded to nearest; the
    /// origin where the pixel is outside of the image.
    #[inline(always)]
    pub fn point(&self, u: usize, v: usize, z: u16) -> [i32; 3] {
        let across = |slope: i32| ((i64::from(slope) * i64::from(z) + (1 << 21)) >> 22) as i32;
        match (self.x.get(u), self.y.get(v)) {
            (Some(x), Some(y)) => [across(*x), across(*y), i32::from(z) << 4],
            _ => [0; 3],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_agree_with_the_float_ones() {
        let camera = crate::Intrinsics::PRIMESENSE_QVGA;
        let float = crate::Rays::<320, 240>::new(&camera).unwrap();
        let fixed = Rays::<320, 240>::new(&Intrinsics::new(&camera).unwrap()).unwrap();
        for (u, v) in [(0, 0), (319, 239), (160, 77)] {
            let (a, b) = (float.point(u, v, 1.7), fixed.point(u, v, 13_600));
            assert!((0..3).all(|i| (a[i] * 128_000.0 - b[i] as f32).abs() < 0.6), "{a:?} {b:?}");
        }
    }

    #[test]
    fn the_widest_lens_fits() {
        let camera = crate::Intrinsics { fx: 32.0, fy: 24.0, cx: 640.0, cy: 480.0, ..crate::Intrinsics::KINECT_QVGA };
        let rays = Rays::<320, 240>::new(&Intrinsics::new(&camera).unwrap()).unwrap();
        assert_eq!((rays.x()[0], rays.y()[0]), (-20 << 26, -20 << 26));
        assert!(Intrinsics::new(&crate::Intrinsics { fx: f32::NAN, ..camera }).is_err());
    }
}
