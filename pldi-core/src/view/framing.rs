//! Which square of the frontal view becomes the 128x128 image.

use super::Homography;
use super::homography::FRONTAL_DISTANCE;
use crate::crc::crc32;
use crate::descriptor::DescriptorKind;
use crate::{Error, Image};

/// How the square is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Framing {
    /// Centred on the centroid of the object's pixels, half side a quarter beyond the farthest of them: size does not count.
    #[default]
    Fit,
    /// As large as a square of a fixed side on pi_f that stands on the floor before the object: size counts.
    Metric {
        /// Side in metres, 0.1 to 10.
        side: f32,
    },
}

/// What a descriptor's numbers depend on: templates and queries must agree in all of it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ViewParams {
    /// Which statistics describe the view. Default `Halves`.
    pub descriptor: DescriptorKind,
    /// Which square of the plane is the view. Default `Fit`.
    pub framing: Framing,
    /// Radius of the normals in metres, 0.005 to 0.5. Default 0.04 (Table II).
    pub radius: f32,
}

impl Default for ViewParams {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl ViewParams {
    /// The defaults.
    pub const DEFAULT: Self = Self { descriptor: DescriptorKind::Halves, framing: Framing::Fit, radius: 0.04 };

    /// Side in metres of a `Metric` view that takes in tall furniture.
    pub const METRIC_SIDE: f32 = 2.0;

    /// Checks every number against its stated range.
    ///
    /// # Errors
    /// `OutOfRange` with the parameter's name.
    pub fn validate(&self) -> Result<(), Error> {
        crate::error::within("normal radius", self.radius, 0.005, 0.5)?;
        match self.framing {
            Framing::Fit => Ok(()),
            Framing::Metric { side } => crate::error::within("view side", side, 0.1, 10.0),
        }
    }

    /// The number of the framing and its side in metres, as template files record them.
    pub const fn framing_fields(&self) -> (u8, f32) {
        match self.framing {
            Framing::Fit => (0, 0.0),
            Framing::Metric { side } => (1, side),
        }
    }

    /// CRC-32 of the parameters' bytes (descriptor, framing, side, radius; numbers little-endian) and of the fixed numbers
    /// that views depend on: templates of a version with others do not match.
    pub const fn hash(&self) -> u32 {
        let (framing, side) = self.framing_fields();
        let hash = crc32(0, &[self.descriptor as u8, framing]);
        let hash = crc32(hash, &side.to_le_bytes());
        let hash = crc32(hash, &self.radius.to_le_bytes());
        let hash = crc32(hash, &MARGIN.to_le_bytes());
        crc32(hash, &FRONTAL_DISTANCE.to_le_bytes())
    }
}

/// A frontal view of an object: which pixel each of its points comes from, and which square of it is the image.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Frontal {
    /// From view coordinates (image plane at unit distance, x right, y down) to the frame's pixels.
    pub to_image: Homography,
    /// Centre of the square in view coordinates.
    pub centre: [f32; 2],
    /// Half of its side in view coordinates.
    pub half: f32,
    /// First column, first row, last column, last row of the object's pixels.
    pub bbox: [u16; 4],
}

/// How much larger than the object a fitted square is. The wavelets are periodic: without a margin the object's top
/// would meet its feet across the border (measured: docs/decisions.md).
pub(super) const MARGIN: f32 = 1.25;

/// The frontal view of the pixels that carry `label` within `bbox` (first column, first row, last column, last row).
///
/// `plane_to_image` is the map of [`Homography::plane_to_image`], `height` the camera's in metres; `pixel` is the angle of a
/// pixel (radians), added to the half side of a fitted square so that the farthest pixel lies inside. `None` where no
/// pixel carries the label.
pub fn frontal<const W: usize, const H: usize>(
    framing: Framing,
    labels: &Image<u16, W, H>,
    label: u16,
    bbox: [u16; 4],
    plane_to_image: &Homography,
    height: f32,
    pixel: f32,
) -> Option<Frontal> {
    if let Framing::Metric { side } = framing {
        let view_to_plane = Homography::view_to_plane(height, 0.5 * side);
        let half = 0.5 * side / FRONTAL_DISTANCE;
        return Some(Frontal { to_image: plane_to_image.after(&view_to_plane), centre: [0.0; 2], half, bbox });
    }
    let pixels = Pixels { labels, label, bbox };
    let middle = pixels.mean(&plane_to_image.inverse()?)?;
    let to_image = plane_to_image.after(&Homography::view_to_plane(height, middle[1]));
    let to_view = to_image.inverse()?;
    let centre = pixels.mean(&to_view)?;
    let mut half = 0.0f32;
    pixels.each(&to_view, |p| half = half.max((p[0] - centre[0]).abs()).max((p[1] - centre[1]).abs()));
    Some(Frontal { to_image, centre, half: MARGIN * half + pixel, bbox })
}

/// The pixels of one object.
struct Pixels<'a, const W: usize, const H: usize> {
    labels: &'a Image<u16, W, H>,
    label: u16,
    bbox: [u16; 4],
}

impl<const W: usize, const H: usize> Pixels<'_, W, H> {
    /// Calls `f` with the image of each pixel under a map.
    fn each(&self, map: &Homography, mut f: impl FnMut([f32; 2])) {
        let [u0, v0, u1, v1] = self.bbox.map(usize::from);
        for (v, row) in self.labels.iter().enumerate().take(v1 + 1).skip(v0) {
            for (u, label) in row.iter().enumerate().take(u1 + 1).skip(u0) {
                if *label == self.label
                    && let Some(p) = map.apply(u as f32, v as f32)
                {
                    f(p);
                }
            }
        }
    }

    /// The mean of the pixels' images under a map; `None` without pixels.
    fn mean(&self, map: &Homography) -> Option<[f32; 2]> {
        let (mut count, mut sum) = (0.0f32, [0.0f32; 2]);
        self.each(map, |p| {
            count += 1.0;
            sum = [sum[0] + p[0], sum[1] + p[1]];
        });
        (count > 0.0).then(|| sum.map(|v| v / count))
    }
}
