//! Requests into a stream of bytes.

use std::io::{self, Write};

use pldi_core::frame::{QVGA_HEIGHT, QVGA_WIDTH};
use pldi_core::serial::wire::{FrameBegin, FrameEnd, GetClass, Hello, Ping};
use pldi_core::serial::{Colour, LIST_REJECTED, Request, Row, colour, depth};
use zerocopy::little_endian::U16;

/// A QVGA frame to be sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outgoing<'a> {
    /// Its number, higher than that of the frame before.
    pub number: u32,
    /// Its time in microseconds; comes back with the answer.
    pub stamp: u64,
    /// Depth in mm, 0 = no reading, 320 x 240 values row by row.
    pub depth: &'a [u16],
    /// Colour, 8 bits each of red, green and blue, 320 x 240 x 3 values row by row.
    pub colour: Option<&'a [u8]>,
}

/// How a frame is sent, and what is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameOptions {
    /// Colour in 16 bits a pixel in place of 24. Results may differ: colour guides the reconstruction of the depth.
    pub rgb565: bool,
    /// Most hypotheses for a detection; 0: all.
    pub hypotheses: u8,
    /// Whether the clusters that are no candidates are listed.
    pub list_rejected: bool,
}

impl Default for FrameOptions {
    /// Everything that there is.
    fn default() -> Self {
        Self { rgb565: false, hypotheses: 0, list_rejected: true }
    }
}

/// The bytes of a message on the wire.
///
/// # Errors
/// `InvalidInput` for a row whose colour has another number of pixels than its depth, or that is too long.
pub fn packet(request: &Request<'_>, sequence: u16) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let written = request.write(sequence, &mut |piece| bytes.extend_from_slice(piece));
    written.map_err(|reason| io::Error::new(io::ErrorKind::InvalidInput, reason.name()))?;
    Ok(bytes)
}

/// The packets of a frame: beginning, rows, end; numbered from `sequence` on.
///
/// # Errors
/// `InvalidInput` for images of another size than QVGA.
pub fn frame_packets(frame: &Outgoing<'_>, options: FrameOptions, sequence: u16) -> io::Result<Vec<Vec<u8>>> {
    let (width, height) = (QVGA_WIDTH, QVGA_HEIGHT);
    let pixels = width * height;
    if frame.depth.len() != pixels || frame.colour.is_some_and(|colour| colour.len() != 3 * pixels) {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "frames are sent at 320x240"));
    }
    let format = match frame.colour {
        None => colour::NONE,
        Some(_) if options.rgb565 => colour::RGB565,
        Some(_) => colour::RGB888,
    };
    let begin = FrameBegin {
        frame: frame.number.into(),
        stamp: frame.stamp.into(),
        width: (width as u16).into(),
        height: (height as u16).into(),
        depth: depth::MILLIMETRES,
        colour: format,
        hypotheses: options.hypotheses,
        options: if options.list_rejected { LIST_REJECTED } else { 0 },
    };
    let mut packets = vec![packet(&Request::FrameBegin(begin), sequence)?];
    for (i, depth) in frame.depth.chunks_exact(width).enumerate() {
        let depth: Vec<U16> = depth.iter().map(|value| U16::new(*value)).collect();
        let rgb = frame.colour.map_or(&[][..], |colour| colour[3 * width * i..][..3 * width].as_chunks().0);
        let short: Vec<U16>;
        let colour = match format {
            colour::NONE => Colour::None,
            colour::RGB888 => Colour::Rgb888(rgb),
            _ => {
                short = rgb.iter().map(|pixel| U16::new(rgb565(*pixel))).collect();
                Colour::Rgb565(&short)
            }
        };
        let row = Row { frame: frame.number, row: i as u16, depth: &depth, colour };
        packets.push(packet(&Request::Row(row), sequence.wrapping_add(packets.len() as u16))?);
    }
    let end = Request::FrameEnd(FrameEnd { frame: frame.number.into() });
    packets.push(packet(&end, sequence.wrapping_add(packets.len() as u16))?);
    Ok(packets)
}

/// Five bits of red, six of green, five of blue.
fn rgb565([r, g, b]: [u8; 3]) -> u16 {
    u16::from(r >> 3) << 11 | u16::from(g >> 2) << 5 | u16::from(b >> 3)
}

/// Writes requests, numbered one after the other.
#[derive(Debug)]
pub struct Sender<W> {
    writer: W,
    sequence: u16,
}

impl<W: Write> Sender<W> {
    /// Nothing is sent yet.
    pub const fn new(writer: W) -> Self {
        Self { writer, sequence: 0 }
    }

    /// Sends a message, and returns its number, which the answer will have.
    ///
    /// # Errors
    /// As [`packet`]; what the writer says.
    pub fn send(&mut self, request: &Request<'_>) -> io::Result<u16> {
        let sequence = self.sequence;
        self.writer.write_all(&packet(request, sequence)?)?;
        self.writer.flush()?;
        self.sequence = sequence.wrapping_add(1);
        Ok(sequence)
    }

    /// Begins a session: numbers of frames may begin anew where `session` is another number than the last one's.
    ///
    /// # Errors
    /// What the writer says.
    pub fn hello(&mut self, session: u32) -> io::Result<u16> {
        self.send(&Request::Hello(Hello { session: session.into() }))
    }

    /// Asks for the counters.
    ///
    /// # Errors
    /// What the writer says.
    pub fn ping(&mut self, token: u32) -> io::Result<u16> {
        self.send(&Request::Ping(Ping { token: token.into() }))
    }

    /// Asks for a class' name.
    ///
    /// # Errors
    /// What the writer says.
    pub fn get_class(&mut self, class: u16) -> io::Result<u16> {
        self.send(&Request::GetClass(GetClass { class: class.into() }))
    }

    /// Sends a whole frame, and returns the number of its end, which the answer will have.
    ///
    /// # Errors
    /// `InvalidInput` for images of another size than QVGA; what the writer says.
    pub fn frame(&mut self, frame: &Outgoing<'_>, options: FrameOptions) -> io::Result<u16> {
        let packets = frame_packets(frame, options, self.sequence)?;
        self.sequence = self.sequence.wrapping_add(packets.len() as u16);
        self.writer.write_all(&packets.concat())?;
        self.writer.flush()?;
        Ok(self.sequence.wrapping_sub(1))
    }

    /// The writer.
    pub fn get_mut(&mut self) -> &mut W {
        &mut self.writer
    }
}
