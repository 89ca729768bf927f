//! Packets: a header, a payload and a check sum, stuffed, with a zero before and behind.
//!
//! The zero in front is what makes a packet safe from its predecessor: whatever was cut, lost or garbled before, ends
//! there.

use super::cobs;
use super::wire::Header;
use crate::crc::crc32;
use core::fmt;
use zerocopy::{FromBytes, IntoBytes};

/// The version of the protocol. Another version's packets are rejected.
pub const VERSION: u8 = 1;

/// Between packets, and never within one.
pub const DELIMITER: u8 = 0;

/// Bytes of a packet besides the payload, before stuffing: header and check sum.
pub const OVERHEAD: usize = size_of::<Header>() + size_of::<u32>();

/// Bytes on the wire of a packet with a payload of `payload` bytes, at most: stuffing and both delimiters included.
pub const fn wire_size(payload: usize) -> usize {
    let plain = OVERHEAD + payload;
    plain + 1 + plain / 254 + 2
}

/// A packet that came in whole: version, length and check sum are right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Packet<'a> {
    /// What the payload is, see [`super::kind`].
    pub kind: u8,
    /// The sender's count, or in an answer that of the request.
    pub sequence: u16,
    /// The message.
    pub payload: &'a [u8],
    /// CRC-32 of header and payload: tells a repeated packet from another one with the same number.
    pub checksum: u32,
}

/// Why something between two delimiters was no packet, or a packet no message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reject {
    /// Longer than the decoder's buffer.
    TooLong,
    /// The delimiter came within a block of the stuffing: bytes were lost or changed.
    Stuffing,
    /// Shorter than a header and a check sum, or not as long as the header says.
    Length,
    /// The check sum does not fit.
    Checksum,
    /// Another version of the protocol.
    Version,
    /// A packet, but of a kind that is not known here.
    Kind,
    /// A packet of a known kind, but its payload makes no sense.
    Payload,
}

impl Reject {
    /// The name used in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::TooLong => "too long",
            Self::Stuffing => "broken stuffing",
            Self::Length => "wrong length",
            Self::Checksum => "wrong check sum",
            Self::Version => "another version",
            Self::Kind => "unknown kind",
            Self::Payload => "senseless payload",
        }
    }

    /// All reasons, in the order of [`Rejects::counts`].
    pub const ALL: [Self; 7] =
        [Self::TooLong, Self::Stuffing, Self::Length, Self::Checksum, Self::Version, Self::Kind, Self::Payload];
}

impl fmt::Display for Reject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// How many were rejected, and why. Counts stop at their largest value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Rejects {
    counts: [u32; Reject::ALL.len()],
}

impl Rejects {
    /// None yet.
    pub const fn new() -> Self {
        Self { counts: [0; Reject::ALL.len()] }
    }

    /// One more.
    pub fn count(&mut self, reason: Reject) {
        if let Some(count) = self.counts.get_mut(reason as usize) {
            *count = count.saturating_add(1);
        }
    }

    /// How many for each of [`Reject::ALL`].
    pub const fn counts(&self) -> [u32; Reject::ALL.len()] {
        self.counts
    }

    /// How many in all.
    pub fn total(&self) -> u32 {
        self.counts.iter().fold(0, |sum, count| sum.saturating_add(*count))
    }
}

/// The body of a packet on its way out.
#[derive(Debug)]
pub struct Body<'s, S: FnMut(&[u8])> {
    encoder: cobs::Encoder<'s, S>,
    checksum: u32,
}

impl<S: FnMut(&[u8])> Body<'_, S> {
    /// Appends some bytes.
    pub fn put(&mut self, bytes: &[u8]) {
        self.checksum = crc32(self.checksum, bytes);
        self.encoder.put(bytes);
    }
}

/// Writes a packet to a sink in pieces of at most 255 bytes. `payload` must put exactly `length` bytes, otherwise nobody
/// will accept the packet.
pub fn write<S: FnMut(&[u8])>(
    sink: &mut S,
    kind: u8,
    sequence: u16,
    length: u16,
    payload: impl FnOnce(&mut Body<'_, S>),
) {
    sink(&[DELIMITER]);
    let mut body = Body { encoder: cobs::Encoder::new(sink), checksum: 0 };
    body.put(Header { version: VERSION, kind, sequence: sequence.into(), length: length.into() }.as_bytes());
    payload(&mut body);
    let Body { mut encoder, checksum } = body;
    encoder.put(&checksum.to_le_bytes());
    encoder.finish();
    sink(&[DELIMITER]);
}

/// Finds packets in a stream of bytes. `N` bytes hold the longest packet before stuffing: [`OVERHEAD`] and the payload;
/// [`super::DEVICE_BUFFER`] and [`super::HOST_BUFFER`] are enough for each side.
#[derive(Debug, Clone)]
#[allow(missing_copy_implementations, reason = "a buffer with a state")]
pub struct Decoder<const N: usize> {
    bytes: [u8; N],
    len: usize,
    state: State,
    stuffing: cobs::Decoder,
    rejects: Rejects,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Before the first byte of a packet.
    Empty,
    /// Within a packet.
    Within,
    /// Within something that is longer than the buffer: to be skipped.
    TooLong,
}

impl<const N: usize> Default for Decoder<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Decoder<N> {
    /// Waits for a packet.
    pub const fn new() -> Self {
        Self { bytes: [0; N], len: 0, state: State::Empty, stuffing: cobs::Decoder::new(), rejects: Rejects::new() }
    }

    /// What was rejected so far.
    pub const fn rejects(&self) -> Rejects {
        self.rejects
    }

    /// Counts a packet that its receiver made no sense of.
    pub fn reject(&mut self, reason: Reject) {
        self.rejects.count(reason);
    }

    /// Takes the next byte: a packet where it ends one, or why what it ends was none.
    pub fn push(&mut self, byte: u8) -> Option<Result<Packet<'_>, Reject>> {
        self.feed(&mut &[byte][..])
    }

    /// Takes bytes off the front of `input` up to the end of a packet, or of something that was none. `None` where all were
    /// taken and the end did not come yet.
    pub fn feed(&mut self, input: &mut &[u8]) -> Option<Result<Packet<'_>, Reject>> {
        while let Some(step) = self.stuffing.step(input) {
            match step {
                cobs::Step::Bytes(bytes) => self.store(bytes),
                cobs::Step::Zero => self.store(&[0]),
                cobs::Step::Code => self.store(&[]),
                // Two delimiters in a row.
                cobs::Step::End(_) if self.state == State::Empty => {}
                cobs::Step::End(whole) => {
                    let (state, len) = (self.state, self.len);
                    (self.state, self.len) = (State::Empty, 0);
                    let found = match state {
                        State::TooLong => Err(Reject::TooLong),
                        _ if !whole => Err(Reject::Stuffing),
                        _ => check(self.bytes.get(..len).unwrap_or(&[])),
                    };
                    if let Err(reason) = &found {
                        self.rejects.count(*reason);
                    }
                    return Some(found);
                }
            }
        }
        None
    }

    fn store(&mut self, bytes: &[u8]) {
        if self.state == State::Empty {
            self.state = State::Within;
        }
        // `len` is N at most, and no run is longer than 254.
        match self.bytes.get_mut(self.len..self.len + bytes.len()) {
            Some(place) if self.state == State::Within => {
                place.copy_from_slice(bytes);
                self.len += bytes.len();
            }
            _ => self.state = State::TooLong,
        }
    }
}

/// The packet that some bytes are.
fn check(bytes: &[u8]) -> Result<Packet<'_>, Reject> {
    let (content, stored) = bytes.split_last_chunk().ok_or(Reject::Length)?;
    let (header, payload) = Header::ref_from_prefix(content).map_err(|_| Reject::Length)?;
    let checksum = crc32(0, content);
    // First of all: of a header that was changed, no field means anything.
    if checksum != u32::from_le_bytes(*stored) {
        return Err(Reject::Checksum);
    }
    if header.version != VERSION {
        return Err(Reject::Version);
    }
    if payload.len() != usize::from(header.length.get()) {
        return Err(Reject::Length);
    }
    Ok(Packet { kind: header.kind, sequence: header.sequence.get(), payload, checksum })
}
