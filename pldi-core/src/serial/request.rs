//! What a host sends.

use super::packet::{self, Packet, Reject};
use super::wire::{FrameBegin, FrameEnd, GetClass, Hello, Ping, RowHeader};
use super::{colour, kind};
use zerocopy::little_endian::U16;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// A message to the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Request<'a> {
    /// Answered with [`super::Answer::Info`].
    Hello(Hello),
    /// Answered with [`super::Answer::Pong`].
    Ping(Ping),
    /// Answered with [`super::Answer::Class`].
    GetClass(GetClass),
    /// Answered only where something is wrong, with [`super::Answer::Status`].
    FrameBegin(FrameBegin),
    /// Not answered.
    Row(Row<'a>),
    /// Answered with [`super::Answer::Detections`] or [`super::Answer::Status`].
    FrameEnd(FrameEnd),
}

/// A row of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Row<'a> {
    /// The frame's number.
    pub frame: u32,
    /// The row's number, from 0.
    pub row: u16,
    /// Depth of each pixel in mm, 0 = no reading.
    pub depth: &'a [U16],
    /// Colour of each pixel.
    pub colour: Colour<'a>,
}

/// The colour of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Colour<'a> {
    /// No colour.
    None,
    /// Red in the upper five bits, green in the middle six, blue in the lower five.
    Rgb565(&'a [U16]),
    /// Red, green, blue.
    Rgb888(&'a [[u8; 3]]),
}

impl Colour<'_> {
    /// The format's number, of [`colour`].
    pub const fn format(&self) -> u8 {
        match self {
            Self::None => colour::NONE,
            Self::Rgb565(_) => colour::RGB565,
            Self::Rgb888(_) => colour::RGB888,
        }
    }
}

/// A payload that is one structure and nothing else.
pub(super) fn whole<T: FromBytes + KnownLayout + Immutable + Unaligned + Copy>(payload: &[u8]) -> Result<T, Reject> {
    T::ref_from_bytes(payload).copied().map_err(|_| Reject::Payload)
}

impl<'a> Request<'a> {
    /// The message of a packet.
    ///
    /// # Errors
    /// `Kind` for a packet that is no request, `Payload` for one of a wrong length or with an unknown format.
    pub fn parse(packet: &Packet<'a>) -> Result<Self, Reject> {
        let payload = packet.payload;
        Ok(match packet.kind {
            kind::HELLO => Self::Hello(whole(payload)?),
            kind::PING => Self::Ping(whole(payload)?),
            kind::GET_CLASS => Self::GetClass(whole(payload)?),
            kind::FRAME_BEGIN => Self::FrameBegin(whole(payload)?),
            kind::ROW => Self::Row(Row::parse(payload).ok_or(Reject::Payload)?),
            kind::FRAME_END => Self::FrameEnd(whole(payload)?),
            _ => return Err(Reject::Kind),
        })
    }

    /// Writes the message as a packet, in pieces.
    ///
    /// # Errors
    /// `Payload` for a row whose colour has another number of pixels than its depth, or that is too long for a packet.
    /// Then nothing was written.
    pub fn write(&self, sequence: u16, sink: &mut impl FnMut(&[u8])) -> Result<(), Reject> {
        match self {
            Self::Hello(message) => put(sink, kind::HELLO, sequence, message),
            Self::Ping(message) => put(sink, kind::PING, sequence, message),
            Self::GetClass(message) => put(sink, kind::GET_CLASS, sequence, message),
            Self::FrameBegin(message) => put(sink, kind::FRAME_BEGIN, sequence, message),
            Self::Row(row) => return row.write(sequence, sink),
            Self::FrameEnd(message) => put(sink, kind::FRAME_END, sequence, message),
        }
        Ok(())
    }
}

/// Writes a packet with one structure.
pub(super) fn put<T: IntoBytes + Immutable>(sink: &mut impl FnMut(&[u8]), kind: u8, sequence: u16, message: &T) {
    // All structures are shorter than a hundred bytes.
    packet::write(sink, kind, sequence, size_of::<T>() as u16, |body| body.put(message.as_bytes()));
}

impl<'a> Row<'a> {
    fn parse(payload: &'a [u8]) -> Option<Self> {
        let (header, pixels) = RowHeader::ref_from_prefix(payload).ok()?;
        let size = 2 + usize::from(colour::size(header.colour)?);
        if !pixels.len().is_multiple_of(size) {
            return None;
        }
        let (depth, rest) = <[U16]>::ref_from_prefix_with_elems(pixels, pixels.len() / size).ok()?;
        let colour = match header.colour {
            colour::RGB565 => Colour::Rgb565(<[U16]>::ref_from_bytes(rest).ok()?),
            colour::RGB888 => Colour::Rgb888(rest.as_chunks().0),
            _ => Colour::None,
        };
        Some(Self { frame: header.frame.get(), row: header.row.get(), depth, colour })
    }

    fn write(&self, sequence: u16, sink: &mut impl FnMut(&[u8])) -> Result<(), Reject> {
        let colour = match self.colour {
            Colour::None => &[],
            Colour::Rgb565(pixels) if pixels.len() == self.depth.len() => pixels.as_bytes(),
            Colour::Rgb888(pixels) if pixels.len() == self.depth.len() => pixels.as_flattened(),
            Colour::Rgb565(_) | Colour::Rgb888(_) => return Err(Reject::Payload),
        };
        let length = size_of::<RowHeader>() + size_of_val(self.depth) + colour.len();
        let length = u16::try_from(length).map_err(|_| Reject::Payload)?;
        let header =
            RowHeader { frame: self.frame.into(), row: self.row.into(), colour: self.colour.format(), reserved: 0 };
        packet::write(sink, kind::ROW, sequence, length, |body| {
            body.put(header.as_bytes());
            body.put(self.depth.as_bytes());
            body.put(colour);
        });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::serial::{DEVICE_BUFFER, Decoder};
    use proptest::prelude::*;

    fn wire(request: &Request<'_>, sequence: u16) -> Vec<u8> {
        let mut out = Vec::new();
        request.write(sequence, &mut |bytes| out.extend_from_slice(bytes)).unwrap();
        out
    }

    #[test]
    fn rows_of_two_lengths_are_not_written() {
        let depth = [U16::new(5); 3];
        let row = |colour| Request::Row(Row { frame: 1, row: 2, depth: &depth, colour });
        let mut written = 0;
        for colour in [Colour::Rgb565(&depth[1..]), Colour::Rgb888(&[[1; 3]; 4])] {
            assert_eq!(row(colour).write(0, &mut |_| written += 1), Err(Reject::Payload));
        }
        let long = vec![U16::ZERO; 32_764];
        let request = Request::Row(Row { frame: 1, row: 2, depth: &long, colour: Colour::None });
        assert_eq!(request.write(0, &mut |_| written += 1), Err(Reject::Payload));
        assert_eq!(written, 0);
    }

    #[test]
    fn senseless_payloads_are_told_from_unknown_kinds() {
        let parse = |kind, payload| Request::parse(&Packet { kind, sequence: 0, payload, checksum: 0 });
        assert_eq!(parse(kind::INFO, &[0; 36]), Err(Reject::Kind));
        assert_eq!(parse(kind::PING, &[0; 3]), Err(Reject::Payload));
        assert_eq!(parse(kind::PING, &[0; 5]), Err(Reject::Payload));
        assert_eq!(parse(kind::ROW, &[0; 7]), Err(Reject::Payload));
        assert_eq!(parse(kind::ROW, &[0; 9]), Err(Reject::Payload));
        // A colour format that does not exist.
        assert_eq!(parse(kind::ROW, &[0, 0, 0, 0, 0, 0, 9, 0, 1, 1]), Err(Reject::Payload));
        assert!(parse(kind::ROW, &[0; 8]).is_ok());
    }

    proptest! {
        #[test]
        fn what_was_written_is_read(
            frame in any::<u32>(), stamp in any::<u64>(), row in any::<u16>(), sequence in any::<u16>(),
            pixels in proptest::collection::vec(any::<(u16, u16, [u8; 3])>(), 0..=320), format in 0u8..3,
            piece in 1usize..700,
        ) {
            let depth: Vec<U16> = pixels.iter().map(|p| p.0.into()).collect();
            let (short, long): (Vec<U16>, Vec<[u8; 3]>) = pixels.iter().map(|p| (U16::new(p.1), p.2)).unzip();
            let colour = [Colour::None, Colour::Rgb565(&short), Colour::Rgb888(&long)][usize::from(format)];
            let begin = FrameBegin {
                frame: frame.into(), stamp: stamp.into(), width: row.into(), height: sequence.into(), depth: 0,
                colour: format, hypotheses: 1, options: 1,
            };
            let requests = [
                Request::Hello(Hello { session: frame.into() }),
                Request::Ping(Ping { token: frame.into() }),
                Request::GetClass(GetClass { class: row.into() }),
                Request::FrameBegin(begin),
                Request::Row(Row { frame, row, depth: &depth, colour }),
                Request::FrameEnd(FrameEnd { frame: frame.into() }),
            ];
            let stream: Vec<u8> = requests.iter().flat_map(|r| wire(r, sequence)).collect();
            let mut decoder = Decoder::<DEVICE_BUFFER>::new();
            let mut expected = requests.iter();
            for mut bytes in stream.chunks(piece) {
                while let Some(found) = decoder.feed(&mut bytes) {
                    let packet = found.unwrap();
                    prop_assert_eq!(packet.sequence, sequence);
                    prop_assert_eq!(Request::parse(&packet), Ok(*expected.next().unwrap()));
                }
            }
            prop_assert!(expected.next().is_none() && decoder.rejects().total() == 0);
        }
    }
}
