//! The messages as they lie in a packet: little-endian, without gaps. The protocol's document has the same as tables.

use zerocopy::little_endian::{I32, U16, U32, U64};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// What every packet begins with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct Header {
    /// [`super::VERSION`].
    pub version: u8,
    /// What the payload is.
    pub kind: u8,
    /// The sender's count, one more from message to message; an answer carries that of its request.
    pub sequence: U16,
    /// Bytes of the payload.
    pub length: U16,
}

/// A session begins: the device forgets what it knew of frames, unless it knows the session already.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct Hello {
    /// Any number that the host's last session had not.
    pub session: U32,
}

/// Asks for the counters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct Ping {
    /// Comes back with the answer.
    pub token: U32,
}

/// Asks for a class' name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct GetClass {
    /// Index of the class.
    pub class: U16,
}

/// A frame begins; its rows follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct FrameBegin {
    /// The frame's number: higher than that of the frame before (differences below 2^31 count as higher).
    pub frame: U32,
    /// Time of the frame in microseconds, on the host's clock; comes back with the answer.
    pub stamp: U64,
    /// Pixels of a row.
    pub width: U16,
    /// Rows.
    pub height: U16,
    /// Format of the depth, see [`super::depth`].
    pub depth: u8,
    /// Format of the colour, see [`super::colour`].
    pub colour: u8,
    /// Most hypotheses that the answer gives for a detection; 0: all (there are 5 at most).
    pub hypotheses: u8,
    /// Bit 1: the answer lists the clusters that are no candidates. Other bits are 0.
    pub options: u8,
}

/// What a row of a frame begins with; depth and then colour of all pixels follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct RowHeader {
    /// The frame's number.
    pub frame: U32,
    /// The row's number, from 0. Rows come in their order.
    pub row: U16,
    /// Format of the colour, that of the frame.
    pub colour: u8,
    /// 0.
    pub reserved: u8,
}

/// All rows are sent: asks for the result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct FrameEnd {
    /// The frame's number.
    pub frame: U32,
}

/// What the device is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct Info {
    /// Comes from [`Hello`].
    pub session: U32,
    /// Version of the core library.
    pub version: [u8; 3],
    /// 0.
    pub reserved: u8,
    /// Pixels of a row that it takes.
    pub width: U16,
    /// Rows that it takes.
    pub height: U16,
    /// Bytes of its decoder's buffer: the longest packet before stuffing.
    pub buffer: U16,
    /// Number of classes.
    pub classes: U16,
    /// Number of templates.
    pub templates: U32,
    /// CRC-32 of the template file.
    pub templates_hash: U32,
    /// CRC-32 of all parameters; 0 where the firmware does not tell.
    pub params_hash: U32,
    /// Bytes of the pipeline's workspace.
    pub workspace: U32,
    /// Bytes of all static memory; 0 where the firmware does not tell.
    pub memory: U32,
}

/// How the device fares: counts since it started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct Pong {
    /// Comes from [`Ping`].
    pub token: U32,
    /// Packets that came in whole and made sense.
    pub accepted: U32,
    /// Of these, packets with number and content of the one before.
    pub repeated: U32,
    /// Of these, rows and frames that belonged to nothing: another frame's, or not the next row.
    pub strays: U32,
    /// Frames that were answered with detections.
    pub frames: U32,
    /// Frames that were answered with a status.
    pub failed: U32,
    /// What was rejected, in the order of [`super::Reject::ALL`].
    pub rejected: [U32; 7],
    /// Most bytes of stack that were ever in use; 0 where the firmware does not tell.
    pub stack: U32,
    /// Bytes of all static memory; 0 where the firmware does not tell.
    pub memory: U32,
    /// Time that the last frame took, in a unit of the firmware's choice (say, cycles); 0 where it does not tell.
    pub time: U32,
}

/// A class' name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct Class {
    /// Index of the class.
    pub class: U16,
    /// Number of classes; the index is not below it where there is no such class, and the name is empty.
    pub classes: U16,
    /// Name, UTF-8, padded with zeros.
    pub name: [u8; 32],
}

/// Why there is no result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct Status {
    /// The frame's number.
    pub frame: U32,
    /// What happened, see [`super::StatusCode`].
    pub code: u8,
    /// 0.
    pub reserved: u8,
    /// Rows that did not come in.
    pub missing: U16,
}

/// What the result of a frame begins with; detections follow, then the clusters that are none, where they were asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct FrameResult {
    /// The frame's number.
    pub frame: U32,
    /// Time of the frame, as it was sent.
    pub stamp: U64,
    /// CRC-32 of the template file.
    pub templates_hash: U32,
    /// CRC-32 of all parameters; 0 where the firmware does not tell.
    pub params_hash: U32,
    /// Version of the core library.
    pub version: [u8; 3],
    /// Bit 0: a floor was found. Bit 1: the clusters that are no candidates are listed. Other bits are 0.
    pub flags: u8,
    /// The floor's unit normal in the camera frame, pointing up, in units of 2^-30; 0 without a floor.
    pub normal: [I32; 3],
    /// Height of the camera above the floor in units of 1/128 mm; 0 without a floor.
    pub height: I32,
    /// Number of detections.
    pub detections: U16,
    /// Number of clusters that are no candidates.
    pub rejected: U16,
}

/// What a detection begins with; its hypotheses follow, best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct Detection {
    /// Number of its cluster within the frame, from 1.
    pub id: U16,
    /// Number of hypotheses.
    pub hypotheses: U16,
    /// Centre of its box in the camera frame (x right, y down, z forward) in units of 1/128 mm.
    pub centre: [I32; 3],
    /// Width, height and depth of its box in units of 1/128 mm.
    pub size: [I32; 3],
    /// First column, first row, last column, last row of its pixels.
    pub bbox: [U16; 4],
}

/// A possible class.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct Hypothesis {
    /// Index of the class.
    pub class: U16,
    /// Index of the object whose template is nearest.
    pub object: U16,
    /// View number of that template.
    pub view: U16,
    /// Distance to that template in units of 2^-16.
    pub distance: U32,
    /// Margin to the next class in units of 2^-16.
    pub score: U32,
}

/// A cluster that is no candidate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
pub struct Rejected {
    /// Number of the cluster within the frame, from 1.
    pub id: U16,
    /// Why: 0 no view, 1 noise, 2 at the border, 3 too small, 4 too large, 5 occluded.
    pub reason: u8,
    /// 0.
    pub reserved: u8,
    /// As a detection's.
    pub centre: [I32; 3],
    /// As a detection's.
    pub bbox: [U16; 4],
}

const _: () = assert!(size_of::<Header>() == 6 && size_of::<Hello>() == 4);
const _: () = assert!(size_of::<Ping>() == 4 && size_of::<GetClass>() == 2);
const _: () = assert!(size_of::<FrameBegin>() == 20 && size_of::<RowHeader>() == 8);
const _: () = assert!(size_of::<FrameEnd>() == 4 && size_of::<Info>() == 36);
const _: () = assert!(size_of::<Pong>() == 64 && size_of::<Class>() == 36);
const _: () = assert!(size_of::<Status>() == 8 && size_of::<FrameResult>() == 44);
const _: () = assert!(size_of::<Detection>() == 36 && size_of::<Hypothesis>() == 14);
const _: () = assert!(size_of::<Rejected>() == 24);
