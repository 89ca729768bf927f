//! Both ends of the serial protocol.
//!
//! An input is what is on the line; or, where its first byte is odd, a script that says what is put there: random bytes
//! hardly ever have the right check sum, and a whole frame is long.

use std::io::{self, Read};
use std::sync::OnceLock;

use pldi_core::frame::{QVGA_HEIGHT, QVGA_WIDTH};
use pldi_core::pipeline::{FixedParams, QvgaFixedPipeline, QvgaFixedWorkspace};
use pldi_core::serial::wire::{FrameBegin, FrameEnd, Ping};
use pldi_core::serial::{Colour, DEVICE_BUFFER, Decoder, Device, Request, Row, Telemetry, colour, depth, packet};
use pldi_core::templates::Templates;
use pldi_core::{Intrinsics, Params, rays};
use pldi_host::serial::{Answer, Names, Receiver, SerialReport};
use pldi_host::templates::{EMBEDDED, fixed_file};
use zerocopy::IntoBytes;
use zerocopy::little_endian::U16;

/// Takes bytes off the front; where too few are left, all of them.
fn take<'a>(script: &mut &'a [u8], count: usize) -> &'a [u8] {
    let (taken, rest) = script.split_at(count.min(script.len()));
    *script = rest;
    taken
}

fn number(script: &mut &[u8]) -> u8 {
    take(script, 1).first().copied().unwrap_or_default()
}

/// What is on the line.
pub fn line(bytes: &[u8]) -> Vec<u8> {
    let Some((1, mut script)) = bytes.split_first().map(|(first, rest)| (first % 2, rest)) else {
        return bytes.to_vec();
    };
    let mut line = Vec::new();
    while !script.is_empty() {
        let mut sink = |bytes: &[u8]| line.extend_from_slice(bytes);
        match number(&mut script) % 3 {
            // Anything.
            0 => {
                let count = number(&mut script);
                sink(take(&mut script, count.into()));
            }
            // A packet with any content.
            1 => {
                let [kind, sequence, low, high] = [(); 4].map(|()| number(&mut script));
                let payload = take(&mut script, usize::from(u16::from_le_bytes([low, high % 8])));
                let length = payload.len() as u16;
                packet::write(&mut sink, kind, sequence.into(), length, |body| body.put(payload));
            }
            _ => frame(&mut script, &mut sink),
        }
        // A script may say more than is good for anybody's time.
        if line.len() > 1 << 19 {
            break;
        }
    }
    line
}

/// A frame, or a part of one: a floor, boxes that stand on it or float, and a pattern of noise.
fn frame(script: &mut &[u8], sink: &mut impl FnMut(&[u8])) {
    let [frame, format, options, rows, ends, horizon, boxes, length] = [(); 8].map(|()| number(script));
    let boxes: Vec<[u8; 6]> = (0..boxes % 16).map(|_| [(); 6].map(|()| number(script))).collect();
    let pattern = take(script, length.into());
    let frame = u32::from(frame);
    let mut sequence = 0;
    let mut say = |request: &Request<'_>| {
        sequence += 1;
        // Rows of one length and colour: nothing is refused.
        request.write(sequence, sink).expect("a request");
    };
    if ends & 1 == 0 {
        say(&Request::FrameBegin(FrameBegin {
            frame: frame.into(),
            stamp: u64::MAX.into(),
            width: (QVGA_WIDTH as u16).into(),
            height: (QVGA_HEIGHT as u16).into(),
            depth: depth::MILLIMETRES,
            colour: format % 3,
            hypotheses: options >> 2,
            options: options & 3,
        }));
    }
    for y in 0..u16::from(rows) {
        let pixel = |x: usize| {
            let noise = pattern.get((usize::from(y) * 31 + x) % pattern.len().max(1)).copied().map_or(0, u16::from);
            // A camera 1.2 m above the floor.
            let floor = (262 * 1200 / (u32::from(y) + 1).saturating_sub(horizon.into()).max(1)).min(65_535) as u16;
            let (mut depth, mut colour) = (floor, 90);
            for &[left, width, top, height, z, c] in &boxes {
                // In steps of 2 pixels and 16 mm.
                let (left, width, z) = (usize::from(left) * 2, usize::from(width) * 2, u16::from(z) * 16);
                let inside =
                    (left..left + width).contains(&x) && y >= u16::from(top) && y - u16::from(top) < u16::from(height);
                if inside && z < depth {
                    (depth, colour) = (z, c);
                }
            }
            (depth.wrapping_add(noise), colour)
        };
        let pixels: [(u16, u8); QVGA_WIDTH] = std::array::from_fn(pixel);
        let depth = pixels.map(|(depth, _)| U16::new(depth));
        let rgb565 = pixels.map(|(_, c)| U16::new(u16::from(c) * 257));
        let rgb888 = pixels.map(|(_, c)| [c, c / 2, 255 - c]);
        let colour = match format % 3 {
            colour::RGB565 => Colour::Rgb565(&rgb565),
            colour::RGB888 => Colour::Rgb888(&rgb888),
            _ => Colour::None,
        };
        say(&Request::Row(Row { frame, row: y, depth: &depth, colour }));
    }
    if ends & 2 == 0 {
        say(&Request::FrameEnd(FrameEnd { frame: frame.into() }));
    }
}

/// Pipeline and templates of a device: made once.
fn tables() -> &'static (QvgaFixedPipeline, Templates<'static>) {
    static TABLES: OnceLock<(QvgaFixedPipeline, Templates<'static>)> = OnceLock::new();
    TABLES.get_or_init(|| {
        let params = FixedParams::new(&Params::DEFAULT).unwrap();
        let camera = rays::fixed::Intrinsics::new(&Intrinsics::KINECT_QVGA).unwrap();
        let coded = fixed_file(EMBEDDED).unwrap().leak();
        (QvgaFixedPipeline::new(&params, &camera).unwrap(), Templates::parse(coded).unwrap())
    })
}

/// The templates of a host: read once.
fn set() -> Templates<'static> {
    static SET: OnceLock<Templates<'static>> = OnceLock::new();
    *SET.get_or_init(|| Templates::parse(EMBEDDED).unwrap())
}

/// A device; whatever it hears, all that it says is understood, and it still answers in the end.
pub fn serial_device(bytes: &[u8]) {
    let line = line(bytes);
    let said = device(&line);
    let mut receiver = Receiver::new(&said[..]);
    let mut last = None;
    while let Some(received) = receiver.next().unwrap() {
        if let Answer::Detections(found) = &received.answer {
            assert!(found.result.detections.get() as usize == found.detections.len());
        }
        last = Some(received.answer);
    }
    assert_eq!(receiver.traffic().rejects.total(), 0);
    let Some(Answer::Pong(pong)) = last else { panic!("no answer to the last ping, but {last:?}") };
    assert_eq!(pong.token.get(), 0x1234_5678);
    assert!(pong.accepted.get() >= 1 && pong.repeated <= pong.accepted);
}

/// What a device says to the bytes on a line, and to a ping behind them.
pub fn device(line: &[u8]) -> Vec<u8> {
    let (pipeline, templates) = tables();
    let mut workspace = Box::new(QvgaFixedWorkspace::new());
    let mut decoder = Decoder::<DEVICE_BUFFER>::new();
    let mut device = Device::new(pipeline, *templates, &mut workspace, &mut decoder).unwrap();
    *device.telemetry() = Telemetry { params_hash: 1, memory: 2, stack: 3, time: 4 };
    let mut said = Vec::new();
    let mut sink = |bytes: &[u8]| {
        assert!(bytes.len() <= 255);
        said.extend_from_slice(bytes);
    };
    // In pieces that end anywhere.
    for piece in line.chunks(61) {
        device.receive(piece, &mut sink);
    }
    let ping = Request::Ping(Ping { token: 0x1234_5678.into() });
    let mut bytes = Vec::new();
    ping.write(0, &mut |piece| bytes.extend_from_slice(piece)).unwrap();
    device.receive(&bytes, &mut sink);
    said
}

/// A line that is slow.
struct Pieces<'a>(&'a [u8]);

impl Read for Pieces<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let piece = take(&mut self.0, buffer.len().min(47));
        buffer[..piece.len()].copy_from_slice(piece);
        Ok(piece.len())
    }
}

/// A host; what it understands becomes lines of a report.
pub fn serial_host(bytes: &[u8]) {
    let line = line(bytes);
    let mut receiver = Receiver::new(Pieces(&line));
    let mut names = [Names::new(None), Names::new(Some(set()))];
    let mut answers = 0;
    while let Some(received) = receiver.next().unwrap() {
        answers += 1;
        match received.answer {
            Answer::Class(class) => names.iter_mut().for_each(|names| names.learn(&class)),
            Answer::Detections(found) => {
                for names in &names {
                    let _ = names.known(found.result.templates_hash.get());
                    let report = SerialReport::new(&found, names);
                    assert_eq!(report.report.detections.len(), found.detections.len());
                    serde_json::to_string(&report).unwrap();
                }
                assert_eq!(found.result.as_bytes().len(), 44);
            }
            Answer::Info(_) | Answer::Pong(_) | Answer::Status(_) => {}
        }
    }
    let traffic = receiver.traffic();
    assert_eq!((traffic.bytes, traffic.answers), (line.len() as u64, answers));
}
