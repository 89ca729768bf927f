//! Frames and the camera that took them: intrinsics, the validity rule, back-projection.
//!
//! Conventions: pixel (0, 0) is the centre of the top-left pixel; the camera frame has x to the right, y down and
//! z forward, in metres; depth is z (not the distance along the ray), in millimetres, 0 where there is no reading
//! (ROS REP-118).

use crate::Error;

/// A row-major image of fixed size, `W` columns by `H` rows.
pub type Image<T, const W: usize, const H: usize> = [[T; W]; H];

/// Columns of a QVGA image.
pub const QVGA_WIDTH: usize = 320;
/// Rows of a QVGA image.
pub const QVGA_HEIGHT: usize = 240;

/// A pinhole camera: where the ray of each pixel goes. The size belongs to it, because the numbers mean nothing
/// without: intrinsics of another size are an error, never a guess.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Intrinsics {
    /// Image width in pixels.
    pub width: u16,
    /// Image height in pixels.
    pub height: u16,
    /// Focal length in pixels, horizontally.
    pub fx: f32,
    /// Focal length in pixels, vertically.
    pub fy: f32,
    /// Column of the principal point, in pixels from the centre of the leftmost column.
    pub cx: f32,
    /// Row of the principal point, in pixels from the centre of the topmost row.
    pub cy: f32,
}

impl Intrinsics {
    /// The Kinect v1's colour camera by its nominal calibration (f = 525 px at 640x480), reduced to QVGA.
    pub const KINECT_QVGA: Self = Self { width: 320, height: 240, fx: 262.5, fy: 262.5, cx: 159.5, cy: 119.5 };

    /// The PrimeSense depth camera's factory calibration at QVGA (f = 571.26 px at 640x480).
    pub const PRIMESENSE_QVGA: Self = Self { width: 320, height: 240, fx: 285.63, fy: 285.63, cx: 159.5, cy: 119.5 };

    /// The intrinsics of the image reduced by the whole factor `k` by taking each block's top-left pixel: f/k and c/k.
    ///
    /// # Errors
    /// `OutOfRange` where `k` is 0 or does not divide the size.
    pub fn reduced(self, k: u16) -> Result<Self, Error> {
        if k == 0 || !self.width.is_multiple_of(k) || !self.height.is_multiple_of(k) {
            return Err(Error::OutOfRange("reduction factor"));
        }
        let s = f32::from(k);
        Ok(Self {
            width: self.width / k,
            height: self.height / k,
            fx: self.fx / s,
            fy: self.fy / s,
            cx: self.cx / s,
            cy: self.cy / s,
        })
    }

    /// The intrinsics of the same view taken by a sensor that bins or interpolates to another size:
    /// centres go to (c + 0.5) s - 0.5.
    ///
    /// # Errors
    /// `OutOfRange` where a size is 0.
    pub fn resampled(self, width: u16, height: u16) -> Result<Self, Error> {
        if width == 0 || height == 0 || self.width == 0 || self.height == 0 {
            return Err(Error::OutOfRange("image size"));
        }
        let (sx, sy) = (f32::from(width) / f32::from(self.width), f32::from(height) / f32::from(self.height));
        Ok(Self {
            width,
            height,
            fx: self.fx * sx,
            fy: self.fy * sy,
            cx: (self.cx + 0.5) * sx - 0.5,
            cy: (self.cy + 0.5) * sy - 0.5,
        })
    }

    /// Checks that every number is usable: finite, focal lengths positive (0.1 to 100 widths), the principal point
    /// no further than one image outside of the image.
    ///
    /// # Errors
    /// `NotFinite` or `OutOfRange`, with the name of the number.
    pub fn validate(&self) -> Result<(), Error> {
        if self.width == 0 || self.height == 0 {
            return Err(Error::OutOfRange("intrinsics: image size"));
        }
        for (value, name) in [(self.fx, "fx"), (self.fy, "fy"), (self.cx, "cx"), (self.cy, "cy")] {
            if !value.is_finite() {
                return Err(Error::NotFinite(name));
            }
        }
        let (w, h) = (f32::from(self.width), f32::from(self.height));
        for (value, size, name) in [(self.fx, w, "fx"), (self.fy, h, "fy")] {
            if !(0.1 * size..=100.0 * size).contains(&value) {
                return Err(Error::OutOfRange(name));
            }
        }
        for (value, size, name) in [(self.cx, w, "cx"), (self.cy, h, "cy")] {
            if !(-size..=2.0 * size).contains(&value) {
                return Err(Error::OutOfRange(name));
            }
        }
        Ok(())
    }

    /// The point in the camera frame, in metres, seen at pixel (u, v) at depth `z` metres (paper, section 3:
    /// v = K^-1 [p_x, p_y, 1]^T z).
    #[inline]
    pub fn back_project(&self, u: f32, v: f32, z: f32) -> [f32; 3] {
        [(u - self.cx) / self.fx * z, (v - self.cy) / self.fy * z, z]
    }

    /// The pixel at which a point of the camera frame is seen; `None` for points not in front of the camera.
    #[inline]
    pub fn project(&self, p: [f32; 3]) -> Option<[f32; 2]> {
        (p[2] > 0.0).then(|| [p[0] / p[2] * self.fx + self.cx, p[1] / p[2] * self.fy + self.cy])
    }
}

/// Which depths are readings: `min <= d && d <= max`, everything else is "no reading".
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DepthRange {
    /// Smallest valid depth in mm, at least 1.
    pub min: u16,
    /// Largest valid depth in mm.
    pub max: u16,
}

impl DepthRange {
    /// What a Kinect v1 can report at all: 1 mm to 10 m. (It measures from about 0.5 m on, but the device itself
    /// withholds nearer readings; raw sentinels such as 65535 are out.)
    pub const KINECT: Self = Self { min: 1, max: 10_000 };

    /// The depth itself where it is valid, else 0.
    #[inline(always)]
    pub fn apply(self, depth: u16) -> u16 {
        if self.min <= depth && depth <= self.max { depth } else { 0 }
    }

    /// A depth in metres as some sources give it, turned into mm: NaN, infinities and what lies out of range become 0.
    #[inline]
    pub fn from_metres(self, depth: f32) -> u16 {
        let mm = depth * 1000.0;
        // Written so that NaN fails the test.
        if (0.5..=65_534.5).contains(&mm) { self.apply(crate::math::round(mm) as u16) } else { 0 }
    }
}

/// One RGB-D frame, borrowed: depth and, where there is one, the colour image registered to it.
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a, const W: usize, const H: usize> {
    /// Depth in mm, 0 = no reading.
    pub depth: &'a Image<u16, W, H>,
    /// Colour, 8 bits each of red, green, blue.
    pub colour: Option<&'a Image<[u8; 3], W, H>>,
}

impl<'a, const W: usize, const H: usize> Frame<'a, W, H> {
    /// A frame from flat buffers: `depth` holds W * H values row by row, `colour` 3 * W * H bytes (r, g, b).
    ///
    /// # Errors
    /// `PixelCount` where a buffer has another length.
    pub fn new(depth: &'a [u16], colour: Option<&'a [u8]>) -> Result<Self, Error> {
        let depth = image(depth, "depth")?;
        let colour = match colour {
            None => None,
            Some(bytes) => match bytes.as_chunks::<3>() {
                (pixels, []) if pixels.len() == W * H => Some(image(pixels, "colour")?),
                _ => return Err(Error::PixelCount { image: "colour", expected: 3 * W * H, found: bytes.len() }),
            },
        };
        Ok(Self { depth, colour })
    }
}

/// Views a flat, row-major slice as an image.
fn image<'a, T, const W: usize, const H: usize>(
    flat: &'a [T],
    name: &'static str,
) -> Result<&'a Image<T, W, H>, Error> {
    let (rows, rest) = flat.as_chunks::<W>();
    match rows.try_into() {
        Ok(image) if rest.is_empty() => Ok(image),
        _ => Err(Error::PixelCount { image: name, expected: W * H, found: flat.len() }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn buffers_of_another_size_are_refused_by_name() {
        let depth = [0u16; 12];
        assert!(Frame::<4, 3>::new(&depth, Some(&[0; 36])).is_ok());
        assert_eq!(
            Frame::<4, 3>::new(&depth[1..], None).unwrap_err(),
            Error::PixelCount { image: "depth", expected: 12, found: 11 }
        );
        assert_eq!(
            Frame::<4, 3>::new(&depth, Some(&[0; 37])).unwrap_err(),
            Error::PixelCount { image: "colour", expected: 36, found: 37 }
        );
    }

    #[test]
    fn sentinels_and_non_numbers_are_no_readings() {
        let range = DepthRange::KINECT;
        assert_eq!([0, 10_001, 65_535].map(|d| range.apply(d)), [0, 0, 0]);
        assert_eq!(range.apply(2047), 2047);
        for d in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, 70.0] {
            assert_eq!(range.from_metres(d), 0);
        }
        assert_eq!(range.from_metres(1.2344), 1234);
    }

    #[test]
    fn absurd_intrinsics_are_refused_by_name() {
        let good = Intrinsics::KINECT_QVGA;
        assert_eq!(good.validate(), Ok(()));
        assert_eq!(Intrinsics { fx: 0.0, ..good }.validate(), Err(Error::OutOfRange("fx")));
        assert_eq!(Intrinsics { fy: f32::NAN, ..good }.validate(), Err(Error::NotFinite("fy")));
        assert_eq!(Intrinsics { cx: 1e9, ..good }.validate(), Err(Error::OutOfRange("cx")));
    }

    proptest! {
        #[test]
        fn projection_undoes_back_projection(u in 0.0f32..320.0, v in 0.0f32..240.0, z in 0.3f32..8.0) {
            let k = Intrinsics::KINECT_QVGA;
            let [pu, pv] = k.project(k.back_project(u, v, z)).unwrap();
            prop_assert!((pu - u).abs() < 1e-3 && (pv - v).abs() < 1e-3);
        }

        #[test]
        fn a_reduced_image_sees_the_same_rays(u in 0u16..320, v in 0u16..240) {
            let full = Intrinsics { width: 640, height: 480, fx: 525.0, fy: 526.0, cx: 319.5, cy: 239.0 };
            let half = full.reduced(2).unwrap();
            let a = full.back_project(f32::from(2 * u), f32::from(2 * v), 1.0);
            let b = half.back_project(f32::from(u), f32::from(v), 1.0);
            prop_assert!((a[0] - b[0]).abs() < 1e-5 && (a[1] - b[1]).abs() < 1e-5);
        }
    }
}
