//! The serial protocol: rows of frames to a device that runs the pipeline in integers, and its answers.
//!
//! A host sends the rows of a frame as [`Request`]s; [`Device`] pushes them into the pipeline as they come and answers with
//! the detections. Each message travels in a packet: a header with a sequence number, the payload and a CRC-32, stuffed so
//! that zeros stand between packets and nowhere else ([`packet`], [`cobs`]). What was corrupted, cut or repeated on the way is
//! noticed, counted and forgotten; the next whole packet is found whatever came before it.
//!
//! Memory is the caller's and of a fixed size. The format is that of the structures in [`wire`].
//!
//! ```
//! use pldi_core::serial::{DEVICE_BUFFER, Decoder, Request, wire};
//!
//! let mut line = Vec::new();
//! Request::Ping(wire::Ping { token: 7.into() }).write(1, &mut |bytes| line.extend_from_slice(bytes))?;
//!
//! let mut decoder = Decoder::<DEVICE_BUFFER>::new();
//! let mut bytes = &line[..];
//! let packet = decoder.feed(&mut bytes).expect("a packet")?;
//! assert_eq!(Request::parse(&packet), Ok(Request::Ping(wire::Ping { token: 7.into() })));
//! # Ok::<(), pldi_core::serial::Reject>(())
//! ```

pub mod answer;
pub mod cobs;
pub mod device;
pub mod packet;
pub mod request;
pub mod wire;

pub use answer::{Answer, Detections, LIST_REJECTED, StatusCode};
pub use device::{Device, Telemetry};
pub use packet::{Decoder, OVERHEAD, Packet, Reject, Rejects, VERSION};
pub use request::{Colour, Request, Row};

use crate::frame::QVGA_WIDTH;

/// What a packet's payload is. Numbers below 128 are requests, the others answers.
pub mod kind {
    /// [`Hello`](super::wire::Hello)
    pub const HELLO: u8 = 1;
    /// [`Ping`](super::wire::Ping)
    pub const PING: u8 = 2;
    /// [`GetClass`](super::wire::GetClass)
    pub const GET_CLASS: u8 = 3;
    /// [`FrameBegin`](super::wire::FrameBegin)
    pub const FRAME_BEGIN: u8 = 16;
    /// [`RowHeader`](super::wire::RowHeader), depth, colour
    pub const ROW: u8 = 17;
    /// [`FrameEnd`](super::wire::FrameEnd)
    pub const FRAME_END: u8 = 18;
    /// [`Info`](super::wire::Info)
    pub const INFO: u8 = 129;
    /// [`Pong`](super::wire::Pong)
    pub const PONG: u8 = 130;
    /// [`Class`](super::wire::Class)
    pub const CLASS: u8 = 131;
    /// [`FrameResult`](super::wire::FrameResult), detections, rejected clusters
    pub const DETECTIONS: u8 = 144;
    /// [`Status`](super::wire::Status)
    pub const STATUS: u8 = 145;
}

/// Formats of a row's depth.
pub mod depth {
    /// 16 bits, mm, 0 = no reading.
    pub const MILLIMETRES: u8 = 0;
}

/// Formats of a row's colour.
pub mod colour {
    /// There is no colour.
    pub const NONE: u8 = 0;
    /// 16 bits: red in the upper five, green in the middle six, blue in the lower five.
    pub const RGB565: u8 = 1;
    /// Three bytes: red, green, blue.
    pub const RGB888: u8 = 2;

    /// Bytes of a pixel; `None` for an unknown format.
    pub const fn size(format: u8) -> Option<u8> {
        match format {
            NONE => Some(0),
            RGB565 => Some(2),
            RGB888 => Some(3),
            _ => None,
        }
    }
}

/// Bytes of the longest packet to a device that takes rows of `width` pixels, before stuffing.
pub const fn device_buffer(width: usize) -> usize {
    OVERHEAD + size_of::<wire::RowHeader>() + width * (2 + 3)
}

/// What the decoder of a device for QVGA frames must hold.
pub const DEVICE_BUFFER: usize = device_buffer(QVGA_WIDTH);

/// What a host's decoder must hold.
pub const HOST_BUFFER: usize = OVERHEAD + answer::LONGEST_RESULT;

const _: () = assert!(HOST_BUFFER <= u16::MAX as usize);

/// The version of this library: major, minor, patch.
pub const LIBRARY_VERSION: [u8; 3] = [
    number(env!("CARGO_PKG_VERSION_MAJOR")),
    number(env!("CARGO_PKG_VERSION_MINOR")),
    number(env!("CARGO_PKG_VERSION_PATCH")),
];

/// A decimal number; too large ones become 255.
const fn number(text: &str) -> u8 {
    let (mut value, mut rest) = (0u32, text.as_bytes());
    while let [digit, behind @ ..] = rest {
        value = value * 10 + (*digit - b'0') as u32;
        value = if value > 255 { 255 } else { value };
        rest = behind;
    }
    value as u8
}
