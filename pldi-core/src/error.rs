//! What can be wrong with an input: small, `Copy`, naming the culprit.

use crate::templates::Encoding;
use core::fmt;

/// The reason a call was refused. A frame in which nothing is found is not an error.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Error {
    /// An image has another number of pixels than its size says.
    PixelCount {
        /// Which image ("depth", "colour").
        image: &'static str,
        /// Pixels that the size asks for.
        expected: usize,
        /// Pixels (or bytes, for colour) that were given.
        found: usize,
    },
    /// The intrinsics belong to images of another size than the frame's.
    IntrinsicsSize {
        /// Width and height in pixels that the intrinsics were calibrated for.
        intrinsics: (u16, u16),
        /// Width and height in pixels of the frame.
        frame: (u16, u16),
    },
    /// A parameter is not a finite number.
    NotFinite(&'static str),
    /// A parameter lies outside of its stated range.
    OutOfRange(&'static str),
    /// A fixed capacity was too small; the name says which.
    Capacity(&'static str),
    /// A template file was refused.
    Templates(TemplateError),
}

/// Why a template file was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TemplateError {
    /// The file is shorter than its header says (or than a header is).
    Cut {
        /// Bytes that the header asks for.
        expected: usize,
        /// Bytes that are there.
        found: usize,
    },
    /// The file does not begin with the magic bytes of a template file.
    NotTemplates,
    /// The file has a version of the format that this library does not read.
    Version(u16),
    /// The checksum does not fit: some byte was changed.
    Checksum {
        /// CRC-32 in the header.
        stored: u32,
        /// CRC-32 of the content.
        computed: u32,
    },
    /// A field of the header or of a record is out of range; the name says which.
    Field(&'static str),
    /// The templates were computed with another descriptor, framing or radius than the pipeline's.
    Parameters {
        /// Hash of the view parameters in the file.
        file: u32,
        /// Hash of the pipeline's view parameters.
        pipeline: u32,
    },
    /// The templates are written as floats where codes are needed, or the other way round.
    Encoding {
        /// How they are written.
        file: Encoding,
        /// How they should be.
        needed: Encoding,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::PixelCount { image, expected, found } => {
                write!(f, "the {image} image has {found} values, its size asks for {expected}")
            }
            Self::IntrinsicsSize { intrinsics: (iw, ih), frame: (w, h) } => {
                write!(
                    f,
                    "the intrinsics are for {iw}x{ih} images, the frame is {w}x{h}: scale them (Intrinsics::reduced)"
                )
            }
            Self::NotFinite(name) => write!(f, "{name} is not a finite number"),
            Self::OutOfRange(name) => write!(f, "{name} is out of range"),
            Self::Capacity(name) => write!(f, "the fixed capacity for {name} is used up"),
            Self::Templates(e) => e.fmt(f),
        }
    }
}

impl fmt::Display for TemplateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Cut { expected, found } => write!(f, "the template file is cut: {found} bytes of {expected}"),
            Self::NotTemplates => write!(f, "not a template file (it does not begin with PLDT)"),
            Self::Version(v) => {
                write!(
                    f,
                    "template file of format version {v}, this library reads versions 1 to {}",
                    crate::templates::VERSION
                )
            }
            Self::Checksum { stored, computed } => {
                write!(f, "the template file is damaged: CRC-32 {computed:08x}, its header says {stored:08x}")
            }
            Self::Field(name) => write!(f, "the template file's {name} is out of range"),
            Self::Parameters { file, pipeline } => write!(
                f,
                "the templates were built with other view parameters ({file:08x}) than the pipeline's ({pipeline:08x}): \
                 use the same descriptor, framing and radius, or build the templates again"
            ),
            Self::Encoding { file, needed } => {
                let remedy = match needed {
                    Encoding::Float => "take the float set that they were made from",
                    Encoding::Logarithmic => "convert them (pldi templates convert)",
                };
                write!(f, "the templates hold {}, {} are needed here: {remedy}", file.name(), needed.name())
            }
        }
    }
}

/// Checks `min <= value && value <= max`; NaN is out of every range.
///
/// By their bits, which stand in the numbers' order: a pipeline in integers reads view parameters out of template files, and
/// must not need the software floating point for that.
pub(crate) const fn within(name: &'static str, value: f32, min: f32, max: f32) -> Result<(), Error> {
    let (value, min, max) = (rank(value), rank(min), rank(max));
    if min <= value && value <= max { Ok(()) } else { Err(Error::OutOfRange(name)) }
}

/// Whether a number is neither infinite nor NaN, without float instructions.
pub(crate) const fn is_finite(value: f32) -> bool {
    value.to_bits() & 0x7F80_0000 != 0x7F80_0000
}

/// An integer in the order of the numbers: -0 and 0 are the same, NaN of either sign lies beyond all.
const fn rank(value: f32) -> i32 {
    let bits = value.to_bits() as i32;
    let magnitude = bits & i32::MAX;
    if magnitude > 0x7F80_0000 {
        // Above the largest limit, which is no NaN.
        i32::MAX
    } else if bits < 0 {
        -magnitude
    } else {
        magnitude
    }
}

impl core::error::Error for Error {}
impl core::error::Error for TemplateError {}

impl From<TemplateError> for Error {
    fn from(e: TemplateError) -> Self {
        Self::Templates(e)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn ranges_by_bits_are_ranges_of_numbers(value in any::<f32>(), a in any::<f32>(), b in -10.0f32..10.0) {
            for (min, max) in [(a, b), (b, a), (-b, b), (0.0, b)] {
                prop_assume!(!max.is_nan());
                let inside = min <= value && value <= max;
                prop_assert_eq!(within("value", value, min, max).is_ok(), inside, "{} {} {}", value, min, max);
            }
            prop_assert_eq!(is_finite(value), value.is_finite());
        }
    }

    #[test]
    fn nan_and_zeros() {
        assert!(within("value", f32::NAN, -1.0, f32::INFINITY).is_err());
        assert!(within("value", -f32::NAN, f32::NEG_INFINITY, 1.0).is_err());
        assert!(within("value", -0.0, 0.0, 1.0).is_ok() && within("value", 0.0, -1.0, -0.0).is_ok());
    }
}
