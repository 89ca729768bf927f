//! Which square of the frontal view becomes the 128x128 image, in fixed point.

use super::Homography;
use super::homography::{Along, FRONTAL_DISTANCE};
use crate::descriptor::DescriptorKind;
use crate::fixed::{METRE, METRE_OF_DEPTH, quantise};
use crate::rays::fixed::Rays;
use crate::view::framing::MARGIN;
use crate::{Error, Image};

/// How the square is chosen, see [`crate::view::Framing`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Framing {
    /// Centred on the centroid of the object's pixels, half side a quarter beyond the farthest of them.
    Fit,
    /// As large as a square of a fixed side on pi_f that stands on the floor before the object.
    Metric {
        /// Side in 1/128 mm.
        side: i32,
    },
}

/// What a descriptor's numbers depend on, see [`crate::view::ViewParams`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ViewParams {
    /// Which statistics describe the view.
    pub descriptor: DescriptorKind,
    /// Which square of the plane is the view.
    pub framing: Framing,
    /// Radius of the normals in 1/8 mm.
    pub radius: u16,
    /// The hash of the float parameters: templates know them by it.
    pub hash: u32,
}

impl ViewParams {
    /// The parameters rounded to their units; at compile time in a `const`.
    ///
    /// # Errors
    /// `OutOfRange` with the parameter's name, for ranges as in [`crate::view::ViewParams::validate`].
    pub const fn new(float: &crate::view::ViewParams) -> Result<Self, Error> {
        let Some(radius) = quantise(float.radius, 0.005, 0.5, METRE_OF_DEPTH as f64) else {
            return Err(Error::OutOfRange("normal radius"));
        };
        let framing = match float.framing {
            crate::view::Framing::Fit => Framing::Fit,
            crate::view::Framing::Metric { side } => match quantise(side, 0.1, 10.0, METRE as f64) {
                Some(side) => Framing::Metric { side: side as i32 },
                None => return Err(Error::OutOfRange("view side")),
            },
        };
        Ok(Self { descriptor: float.descriptor, framing, radius: radius as u16, hash: float.hash() })
    }

    /// Checks numbers that were put together by hand.
    ///
    /// # Errors
    /// `OutOfRange` with the parameter's name, for ranges as in [`crate::view::ViewParams::validate`].
    pub const fn validate(&self) -> Result<(), Error> {
        if self.radius < METRE_OF_DEPTH as u16 / 200 || self.radius > METRE_OF_DEPTH as u16 / 2 {
            return Err(Error::OutOfRange("normal radius"));
        }
        match self.framing {
            Framing::Metric { side } if side < METRE / 10 || side > 10 * METRE => Err(Error::OutOfRange("view side")),
            _ => Ok(()),
        }
    }
}

/// A frontal view of an object: which pixel each of its points comes from, and which square of it is the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Frontal {
    /// From view coordinates to the frame's pixels.
    pub to_image: Homography,
    /// Centre of the square in view coordinates, Q26.
    pub centre: [i32; 2],
    /// Half of its side in view coordinates, Q26; positive.
    pub half: i32,
    /// First column, first row, last column, last row of the object's pixels.
    pub bbox: [u16; 4],
}

/// The margin of fitted squares in Q8.
const MARGIN_Q8: i64 = match quantise(MARGIN, 1.0, 4.0, 256.0) {
    Some(margin) => margin,
    None => panic!("a margin around the object"),
};

/// The frontal view of the pixels that carry `label` within `bbox` (first column, first row, last column, last row).
///
/// `plane_to_rays` is the map of [`Homography::plane_to_rays`], `height` the camera's in 1/128 mm. `None` where no pixel
/// carries the label, or the plane is seen from its edge.
pub fn frontal<const W: usize, const H: usize>(
    framing: Framing,
    labels: &Image<u8, W, H>,
    label: u8,
    bbox: [u16; 4],
    rays: &Rays<W, H>,
    plane_to_rays: &Homography,
    height: i32,
) -> Option<Frontal> {
    let camera = rays.intrinsics();
    if let Framing::Metric { side } = framing {
        let to_image = plane_to_rays.after(&Homography::view_to_plane(height, side / 2)).to_pixels(camera);
        // Half the side over the distance, Q26; in range for all sides of the parameters.
        let half = (i64::from(side) << 25) / i64::from(FRONTAL_DISTANCE);
        return Some(Frontal { to_image, centre: [0; 2], half: i32::try_from(half).ok()?.max(1), bbox });
    }
    let pixels = Pixels { labels, label, bbox, rays };
    let middle = pixels.mean_height(&plane_to_rays.inverse()?)?;
    let to_rays = plane_to_rays.after(&Homography::view_to_plane(height, middle));
    let (centre, farthest) = pixels.extent(&to_rays.inverse()?)?;
    // A pixel's angle is added, so that the farthest pixel lies inside.
    let pixel = (1i64 << 42) / i64::from(camera.fx.max(1));
    let half = ((farthest * MARGIN_Q8) >> 8) + pixel;
    Some(Frontal { to_image: to_rays.to_pixels(camera), centre, half: i32::try_from(half).ok()?, bbox })
}

/// The pixels of one object.
struct Pixels<'a, const W: usize, const H: usize> {
    labels: &'a Image<u8, W, H>,
    label: u8,
    bbox: [u16; 4],
    rays: &'a Rays<W, H>,
}

impl<const W: usize, const H: usize> Pixels<'_, W, H> {
    /// Calls `f` with each pixel's x and what a map makes of its row.
    #[inline(always)]
    fn each(&self, map: &Homography, mut f: impl FnMut(i32, &Along)) {
        let [u0, v0, u1, v1] = self.bbox.map(usize::from);
        let inside = u0..W.min(u1 + 1);
        let Some(columns) = self.rays.x().get(inside.clone()) else { return };
        for (line, y) in self.labels.iter().zip(self.rays.y()).take(v1 + 1).skip(v0) {
            let along = map.along(*y);
            let Some(line) = line.get(inside.clone()) else { return };
            for (label, x) in line.iter().zip(columns) {
                if *label == self.label {
                    f(*x, &along);
                }
            }
        }
    }

    /// The mean height of the pixels' images under a map to the plane, in 1/128 mm; `None` without pixels.
    fn mean_height(&self, map: &Homography) -> Option<i32> {
        let (mut count, mut sum) = (0i64, 0i64);
        self.each(map, |x, along| {
            if let Some(t) = along.last(x).and_then(|w| w.under(along.at(1, x))) {
                count += 1;
                sum += i64::from(t);
            }
        });
        // Below 32 m in Q26.
        (count > 0).then(|| (((sum / count) * 1000) >> 19) as i32)
    }

    /// The mean of the pixels' images under a map to the view, and the farthest of them in either direction, Q26; `None`
    /// without pixels.
    fn extent(&self, map: &Homography) -> Option<([i32; 2], i64)> {
        let (mut count, mut sum) = (0i64, [0i64; 2]);
        let (mut low, mut high) = ([i32::MAX; 2], [i32::MIN; 2]);
        self.each(map, |x, along| {
            let Some(w) = along.last(x) else { return };
            let (Some(x), Some(y)) = (w.under(along.at(0, x)), w.under(along.at(1, x))) else { return };
            count += 1;
            for (k, p) in [x, y].into_iter().enumerate() {
                sum[k] += i64::from(p);
                low[k] = low[k].min(p);
                high[k] = high[k].max(p);
            }
        });
        if count < 1 {
            return None;
        }
        let centre = sum.map(|v| (v / count) as i32);
        let reach = |k: usize| {
            let centre = i64::from(centre[k]);
            (i64::from(high[k]) - centre).max(centre - i64::from(low[k]))
        };
        Some((centre, reach(0).max(reach(1))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view;

    #[test]
    fn parameters_keep_their_hash_and_their_ranges() {
        const DEFAULT: ViewParams = match ViewParams::new(&view::ViewParams::DEFAULT) {
            Ok(params) => params,
            Err(_) => panic!("the defaults are valid"),
        };
        assert_eq!((DEFAULT.hash, DEFAULT.radius), (view::ViewParams::DEFAULT.hash(), 320));
        let metric = view::ViewParams { framing: view::Framing::Metric { side: 2.0 }, ..view::ViewParams::DEFAULT };
        assert_eq!(ViewParams::new(&metric).unwrap().framing, Framing::Metric { side: 256_000 });
        let bad = view::ViewParams { framing: view::Framing::Metric { side: 11.0 }, ..metric };
        assert_eq!(ViewParams::new(&bad), Err(Error::OutOfRange("view side")));
        let bad = view::ViewParams { radius: 0.6, ..metric };
        assert_eq!(ViewParams::new(&bad), Err(Error::OutOfRange("normal radius")));
    }

    #[test]
    fn an_object_without_pixels_has_no_view() {
        let camera = crate::rays::fixed::Intrinsics::new(&crate::Intrinsics::KINECT_QVGA).unwrap();
        let rays = Rays::<320, 240>::new(&camera).unwrap();
        let axes = super::super::homography::tests::axes(0.3, 0.0).1;
        let map = Homography::plane_to_rays(&axes, [0, 256_000]).unwrap();
        let labels: Box<Image<u8, 320, 240>> = vec![[0; 320]; 240].into_boxed_slice().try_into().unwrap();
        assert_eq!(frontal(Framing::Fit, &labels, 1, [0, 0, 319, 239], &rays, &map, 153_600), None);
    }
}
