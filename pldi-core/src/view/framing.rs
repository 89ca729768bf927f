//! Which square of the frontal plane becomes the view.

use super::Homography;
use crate::descriptor::DescriptorKind;
use crate::templates::{crc32, layout::Header};
use crate::{Error, Image, TemplateError};

/// How the square of the plane is chosen (coordinates s, t of [`super::homography`], in metres).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Framing {
    /// Centred on the centroid of the object's pixels, half side to the farthest of them: size does not count.
    #[default]
    Fit,
    /// A fixed side in metres, standing on the floor, centred on the object: size counts.
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
    pub fn framing_fields(&self) -> (u8, f32) {
        match self.framing {
            Framing::Fit => (0, 0.0),
            Framing::Metric { side } => (1, side),
        }
    }

    /// CRC-32 of the parameters' bytes (descriptor, framing, side, radius; numbers little-endian).
    pub fn hash(&self) -> u32 {
        let (framing, side) = self.framing_fields();
        let head = crc32(0, &[self.descriptor as u8, framing]);
        crc32(crc32(head, &side.to_le_bytes()), &self.radius.to_le_bytes())
    }

    pub(crate) fn from_header(header: &Header) -> Result<Self, TemplateError> {
        let framing = match (header.framing, header.side.get()) {
            (0, _) => Framing::Fit,
            (1, side) => Framing::Metric { side },
            _ => return Err(TemplateError::Field("framing")),
        };
        let descriptor =
            DescriptorKind::from_number(header.descriptor).ok_or(TemplateError::Field("kind of descriptor"))?;
        let view = Self { descriptor, framing, radius: header.radius.get() };
        view.validate().map_err(|_| TemplateError::Field("view parameters"))?;
        Ok(view)
    }
}

/// A square on the plane: centre (s, t) and half of its side, in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Square {
    /// Centre: metres right of the centroid, metres above the floor.
    pub centre: [f32; 2],
    /// Half of the side in metres.
    pub half: f32,
}

/// The square for the pixels that carry `label` within `bbox` (first column, first row, last column, last row).
///
/// `to_plane` takes pixels to (s, t); `pixel` is the size of a pixel on the plane in metres, added to the half side of
/// a fitted square so that the farthest pixel lies inside. `None` where no pixel carries the label.
pub fn square<const W: usize, const H: usize>(
    framing: Framing,
    labels: &Image<u16, W, H>,
    label: u16,
    bbox: [u16; 4],
    to_plane: &Homography,
    pixel: f32,
) -> Option<Square> {
    if let Framing::Metric { side } = framing {
        return Some(Square { centre: [0.0, 0.5 * side], half: 0.5 * side });
    }
    let [u0, v0, u1, v1] = bbox.map(usize::from);
    let each = |f: &mut dyn FnMut([f32; 2])| {
        for (v, row) in labels.iter().enumerate().take(v1 + 1).skip(v0) {
            for (u, _) in row.iter().enumerate().take(u1 + 1).skip(u0).filter(|(_, l)| **l == label) {
                if let Some(p) = to_plane.apply(u as f32, v as f32) {
                    f(p);
                }
            }
        }
    };
    let (mut count, mut sum) = (0.0f32, [0.0f32; 2]);
    each(&mut |p| {
        count += 1.0;
        sum = [sum[0] + p[0], sum[1] + p[1]];
    });
    if !(count > 0.0) {
        return None;
    }
    let centre = sum.map(|v| v / count);
    let mut half = 0.0f32;
    each(&mut |p| half = half.max((p[0] - centre[0]).abs()).max((p[1] - centre[1]).abs()));
    Some(Square { centre, half: half + pixel })
}
