//! The device's side of the serial protocol: what it answers to whom.

mod common;

use common::{Random, packet, pldt};
use pldi_core::pipeline::{Fixed, FixedParams, Pipeline, Workspace};
use pldi_core::serial::wire::{FrameBegin, FrameEnd, GetClass, Hello, Ping, Pong, Status};
use pldi_core::serial::{
    Answer, Colour, DEVICE_BUFFER, Decoder, Device, HOST_BUFFER, Request, Row, StatusCode, colour, depth, kind,
};
use pldi_core::templates::{Encoding, Templates};
use pldi_core::{Error, Intrinsics, Params, TemplateError, rays};
use zerocopy::little_endian::U16;

const W: usize = 320;
const H: usize = 240;

/// Messages of a frame, and the number of its end where its beginning has 0.
const MESSAGES: usize = H + 2;
const END: u16 = H as u16 + 1;

/// A frame's pixels.
fn pixels(seed: u64) -> Vec<([U16; W], [[u8; 3]; W])> {
    let mut random = Random(seed);
    let mut row = || {
        let depth = core::array::from_fn(|_| U16::new(1500 + (random.bits() % 900) as u16));
        (depth, core::array::from_fn(|_| (random.bits() as u32).to_le_bytes()[..3].try_into().unwrap()))
    };
    (0..H).map(|_| row()).collect()
}

fn begin(frame: u32) -> FrameBegin {
    FrameBegin {
        frame: frame.into(),
        stamp: (1000 + u64::from(frame)).into(),
        width: (W as u16).into(),
        height: (H as u16).into(),
        depth: depth::MILLIMETRES,
        colour: colour::RGB888,
        hypotheses: 0,
        options: 0,
    }
}

/// The packets of a frame: its beginning, its rows and its end, numbered from `sequence` on.
fn frame(number: u32, sequence: u16) -> Vec<Vec<u8>> {
    let rows = pixels(number.into());
    let mut requests = vec![Request::FrameBegin(begin(number))];
    for (row, (depth, colour)) in rows.iter().enumerate() {
        requests.push(Request::Row(Row { frame: number, row: row as u16, depth, colour: Colour::Rgb888(colour) }));
    }
    requests.push(Request::FrameEnd(FrameEnd { frame: number.into() }));
    requests.iter().zip(0..).map(|(request, i)| bytes(request, sequence.wrapping_add(i))).collect()
}

fn bytes(request: &Request<'_>, sequence: u16) -> Vec<u8> {
    let mut out = Vec::new();
    request.write(sequence, &mut |bytes| out.extend_from_slice(bytes)).unwrap();
    out
}

/// What the device said.
#[derive(Debug, Clone, PartialEq)]
enum Said {
    Result(u32),
    Status(u32, StatusCode, u16),
    Pong(Pong),
    Other,
}

type Answers = Vec<(u16, Said)>;

fn heard(stream: &[u8]) -> Answers {
    let mut decoder = Box::new(Decoder::<HOST_BUFFER>::new());
    let (mut stream, mut answers) = (stream, Vec::new());
    while let Some(found) = decoder.feed(&mut stream) {
        let packet = found.expect("the device's packets are whole");
        let said = match Answer::parse(&packet).expect("an answer") {
            Answer::Detections(found) => Said::Result(found.result.frame.get()),
            Answer::Status(Status { frame, code, missing, .. }) => {
                Said::Status(frame.get(), StatusCode::from_number(code).expect("a code"), missing.get())
            }
            Answer::Pong(pong) => Said::Pong(pong),
            Answer::Info(_) | Answer::Class(_) => Said::Other,
        };
        answers.push((packet.sequence, said));
    }
    answers
}

/// Runs a device on a small camera: `talk` gets a function that sends bytes and returns the answers' bytes.
fn device(talk: impl FnOnce(&mut dyn FnMut(&[u8]) -> Vec<u8>)) {
    let camera = rays::fixed::Intrinsics::new(&Intrinsics::KINECT_QVGA).unwrap();
    let params = Params::DEFAULT;
    let pipeline = Pipeline::<Fixed, W, H>::new(&FixedParams::new(&params).unwrap(), &camera).unwrap();
    let set = pldt::Set { classes: &["chair", "t\u{e4}ble"], objects: &[], templates: &[] };
    let file = set.file(&params.view, Encoding::Logarithmic);
    let mut workspace = Box::new(Workspace::<Fixed, W, H>::new());
    let mut decoder = Decoder::<DEVICE_BUFFER>::new();
    let templates = Templates::parse(&file).unwrap();
    let mut device = Device::new(&pipeline, templates, &mut workspace, &mut decoder).unwrap();
    talk(&mut |bytes| {
        let mut out = Vec::new();
        device.receive(bytes, &mut |bytes| out.extend_from_slice(bytes));
        out
    });
}

/// The answers to some packets, each sent in a call of its own.
fn answers(packets: &[Vec<u8>]) -> Answers {
    let mut all = Vec::new();
    device(|send| all = packets.iter().flat_map(|packet| heard(&send(packet))).collect());
    all
}

fn counters(send: &mut dyn FnMut(&[u8]) -> Vec<u8>) -> Pong {
    match &heard(&send(&bytes(&Request::Ping(Ping { token: 77.into() }), 60_000)))[..] {
        [(60_000, Said::Pong(pong))] => *pong,
        other => panic!("{other:?}"),
    }
}

#[test]
fn frames_are_answered_with_the_number_of_the_request() {
    // The numbers go around.
    let mut packets = frame(1, 65_500);
    packets.extend(frame(2, 65_500u16.wrapping_add(END + 1)));
    let first = 65_500u16.wrapping_add(END);
    let expected = [(first, Said::Result(1)), (first + 1 + END, Said::Result(2))];
    assert_eq!(answers(&packets), expected);
    // All at once, or in pieces that end anywhere.
    let stream = packets.concat();
    for piece in [7, 1000, stream.len()] {
        device(|send| {
            let out: Vec<u8> = stream.chunks(piece).flat_map(&mut *send).collect();
            assert_eq!(heard(&out), expected);
            let pong = counters(send);
            assert_eq!((pong.token.get(), pong.accepted.get(), pong.frames.get()), (77, 2 * MESSAGES as u32 + 1, 2));
            assert_eq!((pong.repeated.get(), pong.strays.get(), pong.failed.get()), (0, 0, 0));
        });
    }
}

#[test]
fn repeated_messages_change_nothing() {
    let (first, second) = (frame(1, 0), frame(2, 1000));
    let plain: Vec<u8> = {
        let mut out = Vec::new();
        device(|send| out = first.iter().chain(&second).flat_map(|p| send(p)).collect());
        out
    };
    let mut random = Random(5);
    device(|send| {
        let (mut out, mut again, mut late) = (Vec::new(), 0, 0);
        let sent: Vec<&Vec<u8>> = first.iter().chain(&second).collect();
        for (i, packet) in sent.iter().enumerate() {
            out.extend(send(packet));
            for _ in 0..random.bits() % 3 {
                // Once more; the ends are answered once more, with the same bytes.
                let answer = send(packet);
                assert!(answer.is_empty() || (i % MESSAGES == END.into() && out.ends_with(&answer)), "{i}");
                again += 1;
            }
            if random.bits().is_multiple_of(2) {
                // Any message of before: whatever is answered is about a frame of before.
                let old = random.bits() as usize % (i + 1);
                let answer = heard(&send(sent[old]));
                assert!(answer.iter().all(|(_, said)| match said {
                    Said::Status(1, StatusCode::Stale, 0) => old == 0,
                    Said::Status(2, StatusCode::Stale, 0) => old == MESSAGES && i + 1 == 2 * MESSAGES,
                    Said::Result(1) => old == END.into(),
                    Said::Result(2) => old + 1 == 2 * MESSAGES,
                    _ => false,
                }));
                late += 1;
            }
        }
        assert!(again > 400 && late > 200 && out == plain);
        let pong = counters(send);
        assert_eq!(
            (pong.frames.get(), pong.failed.get(), pong.accepted.get()),
            (2, 0, 2 * MESSAGES as u32 + 1 + again + late)
        );
        assert!(pong.repeated.get() >= again && pong.repeated.get() + pong.strays.get() <= again + late);
    });
}

#[test]
fn a_frame_without_one_of_its_messages_is_none_and_the_next_one_is() {
    for lost in (0..MESSAGES).step_by(20).chain([1, MESSAGES - 2, MESSAGES - 1]) {
        let mut packets = frame(1, 0);
        packets.remove(lost);
        packets.extend(frame(2, 1000));
        let first = match lost {
            0 => (END, Said::Status(1, StatusCode::NotBegun, 240)),
            241 => (1000, Said::Status(1, StatusCode::Abandoned, 0)),
            _ => (END, Said::Status(1, StatusCode::Incomplete, END - lost as u16)),
        };
        assert_eq!(answers(&packets), [first, (1000 + END, Said::Result(2))], "{lost}");
    }
}

#[test]
fn rows_in_another_order_are_no_frame() {
    let mut packets = frame(1, 0);
    packets.swap(20, 21);
    packets.extend(frame(2, 1000));
    // Row 20 comes before row 19, which then is the last one that counts: 20 to 239 are missing.
    assert_eq!(answers(&packets), [(END, Said::Status(1, StatusCode::Incomplete, 220)), (1000 + END, Said::Result(2))]);
}

#[test]
fn a_frame_may_be_sent_again_from_any_row_on() {
    let whole = frame(1, 0);
    // Row 30 was lost; the host notices at the end, or before it, and begins again.
    for noticed in [32, 45, MESSAGES] {
        let mut packets: Vec<Vec<u8>> = whole[..noticed].to_vec();
        packets.remove(31);
        packets.extend(frame(1, 300));
        let answers = answers(&packets);
        assert_eq!(answers.last(), Some(&(300 + END, Said::Result(1))));
        assert_eq!(answers.len(), if noticed == MESSAGES { 2 } else { 1 });
    }
    // With the rows from the missing one on, while the frame has not ended.
    let mut packets = whole[..40].to_vec();
    packets.remove(31);
    packets.extend_from_slice(&whole[31..]);
    assert_eq!(answers(&packets), [(END, Said::Result(1))]);
}

#[test]
fn sizes_formats_and_numbers_that_do_not_fit_are_told() {
    let wrong = |change: fn(&mut FrameBegin)| {
        let mut begin = begin(7);
        change(&mut begin);
        let answers = answers(&[bytes(&Request::FrameBegin(begin), 3)]);
        assert_eq!(answers, [(3, Said::Status(7, StatusCode::Format, 0))]);
    };
    wrong(|b| b.width = 321.into());
    wrong(|b| b.height = 239.into());
    wrong(|b| b.depth = 1);
    wrong(|b| b.colour = 3);
    // Rows of another format than the frame's, or another length.
    let depth = [U16::ZERO; W];
    let row = |depth| Request::Row(Row { frame: 1, row: 0, depth, colour: Colour::None });
    device(|send| {
        let out = [begin(1)].map(|b| send(&bytes(&Request::FrameBegin(b), 0)));
        assert!(out[0].is_empty() && send(&bytes(&row(&depth), 1)).is_empty());
        assert!(send(&bytes(&row(&depth[1..]), 2)).is_empty());
        assert!(send(&packet(kind::INFO, 3, &[0; 36])).is_empty() && send(&packet(kind::PING, 3, &[0])).is_empty());
        let pong = counters(send);
        assert_eq!((pong.accepted.get(), pong.strays.get()), (3, 1));
        assert_eq!(pong.rejected.map(|n| n.get()), [0, 0, 0, 0, 0, 1, 2]);
    });
    // A number that is not above: of before, also across the end of the numbers.
    let mut packets = frame(u32::MAX, 0);
    packets.extend(frame(3, 1000));
    packets.push(bytes(&Request::FrameBegin(begin(u32::MAX)), 2000));
    packets.push(bytes(&Request::FrameBegin(begin(3)), 2001));
    let stale = |n| Said::Status(n, StatusCode::Stale, 0);
    let results = [(END, Said::Result(u32::MAX)), (1000 + END, Said::Result(3))];
    let late = [(2000, stale(u32::MAX)), (2001, stale(3))];
    assert_eq!(answers(&packets), [results, late].concat());
}

#[test]
fn a_new_session_may_count_from_the_beginning() {
    let hello = |session: u32, sequence| bytes(&Request::Hello(Hello { session: session.into() }), sequence);
    let mut packets = vec![hello(1, 0)];
    packets.extend(frame(9, 1));
    // The same session changes nothing, a new one everything.
    packets.push(hello(1, 300));
    packets.push(bytes(&Request::FrameBegin(begin(1)), 301));
    packets.push(hello(2, 302));
    packets.extend(frame(1, 303));
    let expected = [
        (0, Said::Other),
        (1 + END, Said::Result(9)),
        (300, Said::Other),
        (301, Said::Status(1, StatusCode::Stale, 0)),
        (302, Said::Other),
        (303 + END, Said::Result(1)),
    ];
    assert_eq!(answers(&packets), expected);
}

#[test]
fn a_device_says_what_it_is() {
    device(|send| {
        let mut decoder = Box::new(Decoder::<HOST_BUFFER>::new());
        let mut ask = |request: Request<'_>| {
            let out = send(&bytes(&request, 5));
            let packet = decoder.feed(&mut &out[..]).unwrap().unwrap();
            match Answer::parse(&packet).unwrap() {
                Answer::Info(info) => (Some(info), None),
                Answer::Class(class) => (None, Some(class)),
                other => panic!("{other:?}"),
            }
        };
        let info = ask(Request::Hello(Hello { session: 12.into() })).0.unwrap();
        assert_eq!((info.session.get(), info.width.get(), info.height.get()), (12, 320, 240));
        assert_eq!((info.classes.get(), info.templates.get()), (2, 0));
        assert_eq!(usize::from(info.buffer.get()), DEVICE_BUFFER);
        assert_eq!(info.workspace.get() as usize, size_of::<Workspace<Fixed, W, H>>());
        for (i, name) in ["chair", "t\u{e4}ble", ""].iter().enumerate() {
            let class = ask(Request::GetClass(GetClass { class: (i as u16).into() })).1.unwrap();
            assert_eq!((class.class.get(), class.classes.get()), (i as u16, 2));
            assert_eq!(core::str::from_utf8(&class.name).unwrap().trim_end_matches('\0'), *name);
        }
    });
}

#[test]
fn what_cannot_work_is_refused_at_once() {
    let camera = rays::fixed::Intrinsics::new(&Intrinsics::KINECT_QVGA).unwrap();
    let params = Params::DEFAULT;
    let pipeline = Pipeline::<Fixed, 320, 240>::new(&FixedParams::new(&params).unwrap(), &camera).unwrap();
    let mut workspace = Box::new(Workspace::<Fixed, 320, 240>::new());
    let file = |encoding| pldt::Set { classes: &[], objects: &[], templates: &[] }.file(&params.view, encoding);
    let codes = file(Encoding::Logarithmic);
    let templates = Templates::parse(&codes).unwrap();
    let mut short = Decoder::<{ DEVICE_BUFFER - 1 }>::new();
    let refused = Device::new(&pipeline, templates, &mut workspace, &mut short);
    assert_eq!(refused.unwrap_err(), Error::Capacity("decoder's buffer"));
    let floats = file(Encoding::Float);
    let mut decoder = Decoder::<DEVICE_BUFFER>::new();
    let refused = Device::new(&pipeline, Templates::parse(&floats).unwrap(), &mut workspace, &mut decoder);
    assert!(matches!(refused, Err(Error::Templates(TemplateError::Encoding { .. }))));
}
