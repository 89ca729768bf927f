//! The device's side: rows into the pipeline, answers out.

use super::answer::{self, Answer, Origin, StatusCode};
use super::packet::{Decoder, Packet, Reject, Rejects};
use super::request::{Colour, Request, Row};
use super::wire::{Class, FrameBegin, FrameEnd, Info, Pong, Status};
use super::{LIBRARY_VERSION, colour, depth};
use crate::Error;
use crate::frame::{QVGA_HEIGHT, QVGA_WIDTH};
use crate::pipeline::{Arithmetic, Fixed, Pipeline, Workspace};
use crate::reconstruct::fixed::{ColourRow, DepthRow};
use crate::templates::{Templates, layout};
use zerocopy::little_endian::U16;

/// What only the firmware knows; 0 where it does not tell. The device hands it on with its answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Telemetry {
    /// CRC-32 of all parameters ([`crate::Params::hash`]).
    pub params_hash: u32,
    /// Bytes of static memory.
    pub memory: u32,
    /// Most bytes of stack that were ever in use.
    pub stack: u32,
    /// Time that the last frame took, in a unit of the firmware's choice.
    pub time: u32,
}

/// A pipeline behind a serial line.
///
/// Everything large is borrowed: the tables from flash, workspace and decoder from wherever the firmware has them. `N`
/// is the decoder's size, [`super::DEVICE_BUFFER`] for QVGA.
///
/// A firmware's loop:
///
/// ```
/// # use pldi_core::pipeline::{FixedParams, Params, QvgaFixedPipeline, QvgaFixedWorkspace};
/// # use pldi_core::serial::{DEVICE_BUFFER, Decoder, Device};
/// # use pldi_core::templates::Templates;
/// # use pldi_core::{Error, Intrinsics, rays};
/// # fn firmware(templates: Templates<'_>, mut read: impl FnMut(&mut [u8]) -> usize, mut write: impl FnMut(&[u8])) -> Result<(), Error> {
/// # let pipeline = QvgaFixedPipeline::new(
/// #     &FixedParams::new(&Params::DEFAULT)?, &rays::fixed::Intrinsics::new(&Intrinsics::KINECT_QVGA)?)?;
/// # let mut workspace = Box::new(QvgaFixedWorkspace::new());
/// let mut decoder = Decoder::<DEVICE_BUFFER>::new();
/// let mut device = Device::new(&pipeline, templates, &mut workspace, &mut decoder)?;
/// let mut bytes = [0; 64];
/// loop {
///     let count = read(&mut bytes);
/// #   if count == 0 { return Ok(()) }
///     device.receive(&bytes[..count], &mut write);
/// }
/// # }
/// ```
#[derive(Debug)]
pub struct Device<'a, const N: usize, const W: usize = QVGA_WIDTH, const H: usize = QVGA_HEIGHT> {
    decoder: &'a mut Decoder<N>,
    session: Session<'a, W, H>,
}

/// Everything but the decoder.
#[derive(Debug)]
struct Session<'a, const W: usize, const H: usize> {
    pipeline: &'a Pipeline<Fixed, W, H>,
    templates: Templates<'a>,
    workspace: &'a mut Workspace<Fixed, W, H>,
    telemetry: Telemetry,
    buffer: u16,
    /// The host's session, once it said so.
    session: Option<u32>,
    /// The frame that comes in.
    coming: Option<FrameBegin>,
    /// The last frame that went through the pipeline, and how it went. The report is still there.
    done: Option<(FrameBegin, Result<(), StatusCode>)>,
    /// Number and check sum of the last accepted packet.
    last: Option<(u16, u32)>,
    counts: Counts,
}

/// Counts stop at their largest value.
#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    accepted: u32,
    repeated: u32,
    strays: u32,
    frames: u32,
    failed: u32,
}

fn increase(count: &mut u32) {
    *count = count.saturating_add(1);
}

impl<'a, const N: usize, const W: usize, const H: usize> Device<'a, N, W, H> {
    /// Waits for a host.
    ///
    /// # Errors
    /// `Templates` where the set was made with other view parameters, or for the other arithmetic; `Capacity` where the
    /// decoder's buffer is too short for a row, or longer than the protocol has numbers for.
    pub fn new(
        pipeline: &'a Pipeline<Fixed, W, H>,
        templates: Templates<'a>,
        workspace: &'a mut Workspace<Fixed, W, H>,
        decoder: &'a mut Decoder<N>,
    ) -> Result<Self, Error> {
        Fixed::require(pipeline.params(), &templates)?;
        let buffer = match u16::try_from(N) {
            Ok(buffer) if N >= super::device_buffer(W) => buffer,
            _ => return Err(Error::Capacity("decoder's buffer")),
        };
        let telemetry = Telemetry::default();
        let (counts, session, coming, done, last) = (Counts::default(), None, None, None, None);
        let session =
            Session { pipeline, templates, workspace, telemetry, buffer, session, coming, done, last, counts };
        Ok(Self { decoder, session })
    }

    /// What only the firmware knows: to be set whenever it changed.
    pub fn telemetry(&mut self) -> &mut Telemetry {
        &mut self.session.telemetry
    }

    /// What was rejected so far.
    pub fn rejects(&self) -> Rejects {
        self.decoder.rejects()
    }

    /// Takes bytes as they came from the host, as many as there are, and writes the answers of the messages that they
    /// complete, in pieces of at most 255 bytes. A frame is recognised when it ends: the call that takes its last byte
    /// returns when that is done.
    pub fn receive(&mut self, mut bytes: &[u8], sink: &mut impl FnMut(&[u8])) {
        loop {
            let rejects = self.decoder.rejects();
            let understood = match self.decoder.feed(&mut bytes) {
                None => return,
                Some(Ok(packet)) => self.session.take(&packet, &rejects, sink),
                // The decoder has counted it.
                Some(Err(_)) => Ok(()),
            };
            if let Err(reason) = understood {
                self.decoder.reject(reason);
            }
        }
    }
}

impl<const W: usize, const H: usize> Session<'_, W, H> {
    fn take(&mut self, packet: &Packet<'_>, rejects: &Rejects, sink: &mut impl FnMut(&[u8])) -> Result<(), Reject> {
        let request = Request::parse(packet)?;
        let sequence = packet.sequence;
        if let Request::Row(row) = &request
            && row.depth.len() != W
        {
            return Err(Reject::Payload);
        }
        increase(&mut self.counts.accepted);
        let repeated = self.last.replace((sequence, packet.checksum)) == Some((sequence, packet.checksum));
        if repeated {
            increase(&mut self.counts.repeated);
        }
        match request {
            // Whoever asks again has not got the answer: these change nothing the second time.
            Request::Hello(hello) => {
                if self.session.replace(hello.session.get()) != Some(hello.session.get()) {
                    (self.coming, self.done) = (None, None);
                }
                Answer::write_info(&self.info(hello.session.get()), sequence, sink);
            }
            Request::Ping(ping) => Answer::write_pong(&self.pong(ping.token.get(), rejects), sequence, sink),
            Request::GetClass(wanted) => Answer::write_class(&self.class(wanted.class.get()), sequence, sink),
            Request::FrameEnd(end) => self.end(end, sequence, sink),
            Request::FrameBegin(_) | Request::Row(_) if repeated => {}
            Request::FrameBegin(begin) => {
                if let Some(status) = self.begin(begin) {
                    Answer::write_status(&status, sequence, sink);
                }
            }
            Request::Row(row) => self.row(&row),
        }
        Ok(())
    }

    /// A frame begins; what is to be said about it, or about the one that it ends.
    fn begin(&mut self, begin: FrameBegin) -> Option<Status> {
        // The same again, after rows of it were lost: it goes on from the row that is missing.
        if self.coming == Some(begin) {
            increase(&mut self.counts.repeated);
            return None;
        }
        let frame = begin.frame.get();
        let above = |before: u32| (frame.wrapping_sub(before) as i32) > 0;
        let done = self.done.is_none_or(|(done, _)| above(done.frame.get()));
        let coming = self.coming.is_none_or(|coming| coming.frame == begin.frame || above(coming.frame.get()));
        if !(done && coming) {
            increase(&mut self.counts.strays);
            return Some(status(frame, StatusCode::Stale, 0));
        }
        let size = (usize::from(begin.width.get()), usize::from(begin.height.get()));
        if size != (W, H) || begin.depth != depth::MILLIMETRES || colour::size(begin.colour).is_none() {
            increase(&mut self.counts.failed);
            return Some(status(frame, StatusCode::Format, 0));
        }
        let missing = self.missing();
        let before = self.coming.replace(begin);
        self.pipeline.begin(self.workspace);
        before.map(|before| {
            increase(&mut self.counts.failed);
            status(before.frame.get(), StatusCode::Abandoned, missing)
        })
    }

    /// Rows that the frame still needs.
    fn missing(&self) -> u16 {
        // A height that is not a u16 is refused by `begin`.
        H.saturating_sub(self.workspace.images.rows()) as u16
    }

    fn row(&mut self, row: &Row<'_>) {
        let next = self.workspace.images.rows();
        let wanted = |coming: &FrameBegin| {
            coming.frame.get() == row.frame && coming.colour == row.colour.format() && usize::from(row.row) == next
        };
        if !self.coming.as_ref().is_some_and(wanted) || self.push(row).is_err() {
            increase(&mut self.counts.strays);
        }
    }

    fn push(&mut self, row: &Row<'_>) -> Result<(), Error> {
        let depth: [u16; W] = native(row.depth);
        let depth = DepthRow::Millimetres(&depth);
        match row.colour {
            Colour::None => self.pipeline.push(depth, None, self.workspace),
            Colour::Rgb565(pixels) => {
                let pixels: [u16; W] = native(pixels);
                self.pipeline.push(depth, Some(ColourRow::Rgb565(&[&pixels])), self.workspace)
            }
            Colour::Rgb888(pixels) => {
                let rows = [pixels.as_flattened()];
                self.pipeline.push(depth, Some(ColourRow::Rgb888(&rows)), self.workspace)
            }
        }
    }

    fn end(&mut self, end: FrameEnd, sequence: u16, sink: &mut impl FnMut(&[u8])) {
        let frame = end.frame.get();
        match self.coming.take_if(|coming| coming.frame == end.frame) {
            Some(_) if self.missing() > 0 => {
                increase(&mut self.counts.failed);
                return Answer::write_status(&status(frame, StatusCode::Incomplete, self.missing()), sequence, sink);
            }
            Some(begin) => {
                let outcome = self.recognise();
                increase(if outcome.is_ok() { &mut self.counts.frames } else { &mut self.counts.failed });
                self.done = Some((begin, outcome));
            }
            None => {}
        }
        // Also once more, for whoever did not get the answer: rows of the next frame do not touch the report.
        match &self.done {
            Some((begin, Ok(()))) if begin.frame == end.frame => {
                let (templates_hash, params_hash) = (self.templates.checksum(), self.telemetry.params_hash);
                let origin = Origin { templates_hash, params_hash };
                answer::write_result(&self.workspace.report, begin, origin, sequence, sink);
            }
            Some((begin, Err(code))) if begin.frame == end.frame => {
                Answer::write_status(&status(frame, *code, 0), sequence, sink);
            }
            _ => {
                increase(&mut self.counts.strays);
                Answer::write_status(&status(frame, StatusCode::NotBegun, H as u16), sequence, sink);
            }
        }
    }

    fn recognise(&mut self) -> Result<(), StatusCode> {
        let done = self.pipeline.finish(self.workspace);
        done.and_then(|()| self.pipeline.recognise(&self.templates, self.workspace)).map_err(|error| match error {
            Error::Capacity(_) => StatusCode::Capacity,
            _ => StatusCode::Refused,
        })
    }

    fn info(&self, session: u32) -> Info {
        Info {
            session: session.into(),
            version: LIBRARY_VERSION,
            reserved: 0,
            width: (W as u16).into(),
            height: (H as u16).into(),
            buffer: self.buffer.into(),
            classes: (self.templates.classes().len() as u16).into(),
            templates: (self.templates.len() as u32).into(),
            templates_hash: self.templates.checksum().into(),
            params_hash: self.telemetry.params_hash.into(),
            workspace: (size_of::<Workspace<Fixed, W, H>>() as u32).into(),
            memory: self.telemetry.memory.into(),
        }
    }

    fn pong(&self, token: u32, rejects: &Rejects) -> Pong {
        let Counts { accepted, repeated, strays, frames, failed } = self.counts;
        Pong {
            token: token.into(),
            accepted: accepted.into(),
            repeated: repeated.into(),
            strays: strays.into(),
            frames: frames.into(),
            failed: failed.into(),
            rejected: rejects.counts().map(Into::into),
            stack: self.telemetry.stack.into(),
            memory: self.telemetry.memory.into(),
            time: self.telemetry.time.into(),
        }
    }

    fn class(&self, class: u16) -> Class {
        let mut classes = self.templates.classes();
        let (count, name) = (classes.len() as u16, classes.nth(class.into()).unwrap_or(""));
        Class { class: class.into(), classes: count.into(), name: layout::padded(name) }
    }
}

fn status(frame: u32, code: StatusCode, missing: u16) -> Status {
    Status { frame: frame.into(), code: code as u8, reserved: 0, missing: missing.into() }
}

/// The numbers in the machine's order; what is missing is 0.
fn native<const W: usize>(numbers: &[U16]) -> [u16; W] {
    let mut out = [0; W];
    for (to, from) in out.iter_mut().zip(numbers) {
        *to = from.get();
    }
    out
}
