//! The bytes of a template file, for readers and writers.

use crate::crc::crc32;
use crate::descriptor::LENGTH;
use zerocopy::little_endian::{F32, U16, U32};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// The first four bytes of a template file.
pub const MAGIC: [u8; 4] = *b"PLDT";

/// Version of the format: 1 knew floats only. Files of floats are still written as version 1, so that their bytes stay.
pub const VERSION: u16 = 2;

/// How a file's descriptors are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Encoding {
    /// Numbers of 32 bits, [`Record`]: for the float pipeline.
    Float = 0,
    /// Codes of 16 bits, [`LogRecord`]: for the fixed-point pipeline. See [`crate::descriptor::fixed`].
    Logarithmic = 1,
}

impl Encoding {
    /// The encoding with this number, as template files record it.
    pub const fn from_number(number: u8) -> Option<Self> {
        match number {
            0 => Some(Self::Float),
            1 => Some(Self::Logarithmic),
            _ => None,
        }
    }

    /// What the numbers are, in words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Float => "32-bit floats",
            Self::Logarithmic => "16-bit logarithms",
        }
    }

    /// The version that files with this encoding are written as: the first that knows it.
    pub const fn version(self) -> u16 {
        match self {
            Self::Float => 1,
            Self::Logarithmic => 2,
        }
    }

    /// Bytes of a record.
    pub const fn record_size(self) -> usize {
        match self {
            Self::Float => size_of::<Record>(),
            Self::Logarithmic => size_of::<LogRecord>(),
        }
    }
}

/// Bytes of the checksum's field within the header.
const CHECKSUM: core::ops::Range<usize> = 12..16;

/// The first 48 bytes of a template file.
#[derive(Debug, Clone, Copy, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct Header {
    /// [`MAGIC`].
    pub magic: [u8; 4],
    /// [`Encoding::version`].
    pub version: U16,
    /// [`Encoding`] as a number; 0 in version 1.
    pub encoding: u8,
    /// 0.
    pub reserved: u8,
    /// Hash of the view parameters below, see [`crate::view::ViewParams::hash`].
    pub parameters: U32,
    /// CRC-32 of the whole file without these four bytes.
    pub checksum: U32,
    /// Number of [`Class`] entries.
    pub classes: U16,
    /// Number of [`Object`] entries.
    pub objects: U16,
    /// Number of [`Record`] or [`LogRecord`] entries.
    pub templates: U32,
    /// [`crate::descriptor::DescriptorKind`] as a number.
    pub descriptor: u8,
    /// 0 = `Fit`, 1 = `Metric`.
    pub framing: u8,
    /// 0.
    pub reserved2: U16,
    /// Side in metres of a `Metric` view, 0 for `Fit`.
    pub side: F32,
    /// Radius of the normals in metres.
    pub radius: F32,
    /// Horizontal distance of the camera from the objects in metres; information only.
    pub distance: F32,
    /// Height of the camera above the floor in metres; information only.
    pub height: F32,
    /// 0 = noise-free, 1 = through the sensor's simulation; information only.
    pub simulated: u8,
    /// 0.
    pub reserved3: [u8; 3],
}

/// A class.
#[derive(Debug, Clone, Copy, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct Class {
    /// Name, UTF-8, padded with zeros.
    pub name: [u8; 32],
}

/// An object.
#[derive(Debug, Clone, Copy, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct Object {
    /// Index of its class.
    pub class: U16,
    /// Name, UTF-8, padded with zeros.
    pub name: [u8; 38],
}

/// A template in a file of floats.
#[derive(Debug, Clone, Copy, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct Record {
    /// Index of its object.
    pub object: U16,
    /// Number of the view.
    pub view: U16,
    /// The descriptor.
    pub values: [F32; LENGTH],
}

/// A template in a file of logarithms.
#[derive(Debug, Clone, Copy, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct LogRecord {
    /// Index of its object.
    pub object: U16,
    /// Number of the view.
    pub view: U16,
    /// The descriptor, see [`crate::descriptor::fixed`].
    pub values: [U16; LENGTH],
}

const _: () = assert!(size_of::<Header>() == 48 && size_of::<Class>() == 32);
const _: () = assert!(size_of::<Object>() == 40 && size_of::<Record>() == 236);
const _: () = assert!(size_of::<LogRecord>() == 120);

/// Bytes of a file with so many entries; `None` where that does not fit a `usize`.
pub fn file_size(encoding: Encoding, classes: usize, objects: usize, templates: usize) -> Option<usize> {
    let classes = classes.checked_mul(size_of::<Class>())?;
    let objects = objects.checked_mul(size_of::<Object>())?;
    let templates = templates.checked_mul(encoding.record_size())?;
    size_of::<Header>().checked_add(classes)?.checked_add(objects)?.checked_add(templates)
}

/// The checksum of a complete file: CRC-32 of all bytes but the header's field for it.
pub fn checksum(file: &[u8]) -> u32 {
    let before = file.get(..CHECKSUM.start).unwrap_or(file);
    let behind = file.get(CHECKSUM.end..).unwrap_or(&[]);
    crc32(crc32(0, before), behind)
}

/// Writes the checksum of a complete file into its header.
pub fn seal(file: &mut [u8]) {
    let sum = checksum(file).to_le_bytes();
    for (to, from) in file.iter_mut().skip(CHECKSUM.start).zip(sum) {
        *to = from;
    }
}

/// A name as it stands in a file, cut at a character's border where it is too long.
pub fn padded<const N: usize>(name: &str) -> [u8; N] {
    let mut out = [0; N];
    let end = (0..=name.len().min(N)).rev().find(|&i| name.is_char_boundary(i)).unwrap_or(0);
    for (to, from) in out.iter_mut().zip(name.as_bytes().iter().take(end)) {
        *to = *from;
    }
    out
}

/// The text of a padded name; `None` where it is not UTF-8, or where something follows the padding.
pub fn text(name: &[u8]) -> Option<&str> {
    let end = name.iter().position(|b| *b == 0).unwrap_or(name.len());
    let (text, padding) = name.split_at_checked(end)?;
    if padding.iter().all(|b| *b == 0) { core::str::from_utf8(text).ok() } else { None }
}
