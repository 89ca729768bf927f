//! The serial protocol with the host's side: a bad line, and `pldi run --from-serial`.

mod common;
#[path = "serial/format.rs"]
mod format;
mod robot;

use std::io::{Cursor, Read, Write};
use std::path::Path;
use std::process::Stdio;

use common::{command, folder, pldi, recording};
use pldi_core::pipeline::{Fixed, FixedParams, Params, QvgaFixedPipeline, QvgaFixedWorkspace, Report};
use pldi_core::serial::{self, DEVICE_BUFFER, Decoder, Device, wire};
use pldi_core::templates::{Templates, layout};
use pldi_core::{Intrinsics, rays};
use pldi_fixtures::rng::Rng;
use pldi_host::input::{self, OpenOptions, QvgaFrame};
use pldi_host::serial::{Answer, Detections, FrameOptions, Outgoing, Receiver, Sender, Traffic, frame_packets, packet};
use pldi_host::templates::{EMBEDDED, fixed_file};
use robot::corrupt::{Corrupter, KINDS, told};
use robot::stream::Stream;
use serde_json::Value;
use zerocopy::{FromBytes, IntoBytes};

/// The recording's frames.
fn frames() -> Vec<QvgaFrame> {
    let mut recording = input::open(recording().to_str().unwrap(), &OpenOptions::default()).unwrap();
    recording.frames().map(|frame| frame.unwrap().qvga).collect()
}

fn stamp(frame: &QvgaFrame) -> u64 {
    (frame.stamp * 1e6).round() as u64
}

fn outgoing(frame: &QvgaFrame, number: u32) -> Outgoing<'_> {
    Outgoing { number, stamp: stamp(frame), depth: &frame.depth, colour: frame.colour.as_deref() }
}

/// What a device in this process says to some bytes, and to a last question for its counters.
struct Bench {
    pipeline: QvgaFixedPipeline,
    templates: Vec<u8>,
    params: Params,
}

impl Bench {
    fn new(camera: &Intrinsics) -> Self {
        let templates = fixed_file(EMBEDDED).unwrap();
        let params = Params { view: *Templates::parse(&templates).unwrap().view_params(), ..Params::DEFAULT };
        let camera = rays::fixed::Intrinsics::new(camera).unwrap();
        let pipeline = QvgaFixedPipeline::new(&FixedParams::new(&params).unwrap(), &camera).unwrap();
        Self { pipeline, templates, params }
    }

    fn answers<'a>(&self, pieces: impl IntoIterator<Item = &'a [u8]>) -> Vec<u8> {
        let (mut workspace, mut decoder) = (Box::new(QvgaFixedWorkspace::new()), Decoder::<DEVICE_BUFFER>::new());
        let templates = Templates::parse(&self.templates).unwrap();
        let mut device = Device::new(&self.pipeline, templates, &mut workspace, &mut decoder).unwrap();
        device.telemetry().params_hash = self.params.hash();
        let mut out = Vec::new();
        pieces.into_iter().for_each(|piece| device.receive(piece, &mut |bytes| out.extend_from_slice(bytes)));
        out
    }

    /// What the pipeline itself says.
    fn report(&self, frame: &QvgaFrame) -> Report<Fixed> {
        let mut workspace = Box::new(QvgaFixedWorkspace::new());
        let templates = Templates::parse(&self.templates).unwrap();
        self.pipeline.run(&frame.as_frame().unwrap(), &templates, &mut workspace).unwrap();
        workspace.report
    }
}

fn read_all(bytes: &[u8]) -> (Vec<(u16, Answer)>, Traffic) {
    let mut receiver = Receiver::new(Cursor::new(bytes.to_vec()));
    let mut answers = Vec::new();
    while let Some(received) = receiver.next().unwrap() {
        answers.push((received.sequence, received.answer));
    }
    (answers, receiver.traffic())
}

/// Every number of a result is that of the report.
fn same(found: &Detections, report: &Report<Fixed>) {
    let floor = report.floor.expect("a floor");
    assert_eq!((found.result.normal.map(|v| v.get()), found.result.height.get()), (floor.normal, floor.height));
    assert_eq!(found.detections.len(), report.detections.len());
    for (found, truth) in found.detections.iter().zip(&report.detections) {
        let cluster = &report.clusters[usize::from(truth.cluster)];
        assert_eq!(found.place.centre.map(|v| v.get()), cluster.center);
        assert_eq!(found.place.size.map(|v| v.get()), cluster.size);
        assert_eq!(found.place.bbox.map(|v| v.get()), cluster.bbox);
        assert_eq!(found.hypotheses.len(), truth.hypotheses.len());
        for (a, b) in found.hypotheses.iter().zip(&truth.hypotheses) {
            assert_eq!((a.class.get(), a.object.get(), a.view.get()), (b.class, b.object, b.view));
            assert_eq!((a.distance.get(), a.score.get()), (b.distance, b.score));
        }
    }
}

/// Ten thousand corrupted packets among forty frames: none is taken for a message, and every frame is answered as if they
/// were not there.
#[test]
fn a_bad_line() {
    const FRAMES: u32 = 40;
    const CORRUPTED: usize = 250;
    let frames = frames();
    let bench = Bench::new(&frames[0].intrinsics);
    let truth: Vec<Report<Fixed>> = frames.iter().map(|frame| bench.report(frame)).collect();
    assert!(truth.iter().all(|report| !report.detections.is_empty()));

    let (mut random, mut stream, mut made) = (Rng::new(2), Stream::default(), [0; KINDS.len()]);
    let mut sequence = 0u16;
    for number in 0..FRAMES {
        let options = FrameOptions { list_rejected: number % 2 == 0, ..FrameOptions::default() };
        let packets = frame_packets(&outgoing(&frames[number as usize % 3], number), options, sequence).unwrap();
        sequence = sequence.wrapping_add(packets.len() as u16);
        let mut corrupter = Corrupter::new(u64::from(number), &packets);
        let part = Stream::new(&packets, CORRUPTED, 20, &mut corrupter, &mut random);
        stream.bytes.extend(part.bytes);
        stream.accepted += part.accepted;
        stream.repeated += part.repeated;
        stream.corrupted += part.corrupted;
        stream.rejects += part.rejects;
        made.iter_mut().zip(corrupter.made).for_each(|(sum, count)| *sum += count);
    }
    assert_eq!(stream.corrupted, 10_000);
    assert!(made.iter().all(|count| *count > 500), "{made:?}");
    let mut ping = Sender::new(&mut stream.bytes);
    ping.ping(1).unwrap();

    // In pieces as they come from a line.
    let mut pieces = Vec::new();
    let mut rest = &stream.bytes[..];
    while !rest.is_empty() {
        let (piece, behind) = rest.split_at((1 + random.below(3000)).min(rest.len()));
        pieces.push(piece);
        rest = behind;
    }
    let (mut answers, traffic) = read_all(&bench.answers(pieces));
    let Some((0, Answer::Pong(pong))) = answers.pop() else { panic!("no counters") };
    let rejected: u32 = pong.rejected.iter().map(|n| n.get()).sum();
    let reasons = told(pong.rejected.map(|n| n.get()));
    assert_eq!((pong.accepted.get(), rejected), (stream.accepted + 1, stream.rejects), "{reasons}");
    assert_eq!((pong.frames.get(), pong.failed.get()), (FRAMES, 0), "{reasons}");
    assert!(pong.rejected.iter().all(|count| count.get() > 50), "{reasons}");
    assert_eq!(traffic.rejects.total(), 0);

    assert_eq!(answers.len(), FRAMES as usize);
    for ((_, answer), number) in answers.iter().zip(0..) {
        let Answer::Detections(found) = answer else { panic!("{answer:?}") };
        assert_eq!(found.result.frame.get(), number);
        same(found, &truth[number as usize % 3]);
        let listed = if number % 2 == 0 { found.result.rejected.get() } else { 0 };
        assert_eq!(found.rejected.len(), usize::from(listed));
    }
}

/// The other way: results on a bad line.
#[test]
fn a_bad_line_back() {
    let frames = frames();
    let bench = Bench::new(&frames[0].intrinsics);
    let mut line = Sender::new(Vec::new());
    line.hello(5).unwrap();
    for (frame, number) in frames.iter().zip(0..) {
        line.frame(&outgoing(frame, number), FrameOptions::default()).unwrap();
        line.ping(number).unwrap();
    }
    line.get_class(3).unwrap();
    let answers = bench.answers([&line.get_mut()[..]]);
    let packets: Vec<Vec<u8>> =
        answers.split(|byte| *byte == 0).filter(|run| !run.is_empty()).map(|run| [&[0], run, &[0]].concat()).collect();
    let (good, _) = read_all(&answers);
    assert_eq!((packets.len(), good.len()), (8, 8));
    let (mut corrupter, mut random) = (Corrupter::new(9, &packets), Rng::new(3));
    for _ in 0..20 {
        let stream = Stream::new(&packets, 100, 0, &mut corrupter, &mut random);
        let (found, traffic) = read_all(&stream.bytes);
        assert_eq!(found, good);
        // Strangers that are too long for a device are not for a host: they are rejected for another reason.
        assert_eq!(traffic.rejects.total(), stream.rejects);
    }
}

/// What a device answered to the recording, with a question for its name, as it was captured.
fn captured() -> Vec<u8> {
    let frames = frames();
    let mut line = Sender::new(Vec::new());
    line.hello(5).unwrap();
    for (frame, number) in frames.iter().zip(0..) {
        line.frame(&outgoing(frame, number), FrameOptions::default()).unwrap();
    }
    Bench::new(&frames[0].intrinsics).answers([&line.get_mut()[..]])
}

fn file(folder: &Path, bytes: &[u8]) -> std::path::PathBuf {
    let path = folder.join("received.bin");
    std::fs::write(&path, bytes).unwrap();
    path
}

/// The line that `pldi run` prints for the same frame: boxes there are in pixels of the recording.
fn as_run(mut line: Value) -> Value {
    let object = line.as_object_mut().unwrap();
    assert_eq!(object.remove("source").unwrap(), "serial");
    let count = object.remove("rejected_count").unwrap();
    assert_eq!(count, line["rejected"].as_array().unwrap().len());
    for list in ["detections", "rejected"] {
        for item in line[list].as_array_mut().unwrap() {
            let bbox = item["bbox"].as_array_mut().unwrap();
            for (i, value) in bbox.iter_mut().enumerate() {
                *value = (2 * value.as_u64().unwrap() + u64::from(i >= 2)).into();
            }
        }
    }
    line
}

#[test]
fn a_captured_stream_gives_the_lines_of_the_recording() {
    let folder = folder();
    let path = file(folder.path(), &captured());
    let expected = pldi(arguments!["run", *recording(), "--arithmetic", "fixed"]).ok().lines();
    let outcome = pldi(arguments!["run", "--from-serial", path]).ok();
    assert_eq!(outcome.stderr, "");
    assert_eq!(outcome.lines().into_iter().map(as_run).collect::<Vec<_>>(), expected);
    // From stdin, behind noise, with a corrupted answer.
    let mut bytes = captured();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    let mut child = command();
    child.args(["run", "--from-serial", "-"]).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = child.spawn().unwrap();
    child.stdin.take().unwrap().write_all(&[&[7, 7, 7, 0, 1, 2, 3], &bytes[..]].concat()).unwrap();
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{stderr}");
    assert_eq!(stderr, "pldi: 3 packets rejected: 1 broken stuffing, 1 wrong length, 1 wrong check sum\n");
    let lines: Vec<Value> = common::lines(&output.stdout).into_iter().map(as_run).collect();
    assert_eq!(lines, [expected[0].clone(), expected[2].clone()]);
}

#[test]
fn other_templates_are_told_and_classes_keep_their_numbers() {
    let folder = folder();
    // Another camera's height, which means nothing, and so another check sum.
    let mut templates = EMBEDDED.to_vec();
    layout::Header::mut_from_prefix(&mut templates).unwrap().0.height = 1.25.into();
    layout::seal(&mut templates);
    let other = folder.path().join("other.pldt");
    std::fs::write(&other, templates).unwrap();
    let path = file(folder.path(), &captured());
    let outcome = pldi(arguments!["run", "--from-serial", path, "--templates", other]).ok();
    assert!(outcome.stderr.contains("other templates") && outcome.stderr.lines().count() == 1, "{}", outcome.stderr);
    let class = outcome.lines()[0]["detections"][0]["results"][0]["class_id"].as_str().unwrap().to_owned();
    assert!(class.starts_with("class "), "{class}");
}

#[test]
fn frames_without_a_result_are_told() {
    let frames = frames();
    let mut bytes = Vec::new();
    for (number, lost) in [(0, 0), (1, 100), (2, 0)] {
        let mut packets = frame_packets(&outgoing(&frames[0], number), FrameOptions::default(), 0).unwrap();
        packets.drain(100..100 + lost);
        bytes.extend(packets.concat());
    }
    let answers = Bench::new(&frames[0].intrinsics).answers([&bytes[..]]);
    let folder = folder();
    let outcome = pldi(arguments!["run", "--from-serial", file(folder.path(), &answers)]).ok();
    assert_eq!(outcome.stderr, "pldi: frame 1: incomplete, 141 rows missing\npldi: 1 frames without a result\n");
    assert_eq!(outcome.lines().iter().map(|l| l["frame"].as_u64().unwrap()).collect::<Vec<_>>(), [0, 2]);
}

#[test]
fn what_is_no_device_is_told() {
    let folder = folder();
    let path = file(folder.path(), b"a text, and no zeros");
    let outcome = pldi(arguments!["run", "--from-serial", path]);
    assert!(
        outcome.code == Some(1) && outcome.stderr.contains("no answer of a device in 20 bytes"),
        "{}",
        outcome.stderr
    );
    let outcome = pldi(arguments!["run", "--from-serial", folder.path().join("missing")]);
    assert!(outcome.code == Some(1) && outcome.stderr.contains("missing"), "{}", outcome.stderr);
    for more in [&["x"][..], &["--threads", "2"], &["--overlay", "o"], &["--intrinsics", "1,1,1,1"]] {
        let outcome = pldi([&["run", "--from-serial", "-"], more].concat());
        assert!(outcome.code == Some(2) && outcome.stderr.contains("cannot be used with"), "{}", outcome.stderr);
    }
    let outcome = pldi(["run"]);
    assert!(outcome.code == Some(2) && outcome.stderr.contains("<SOURCE>"), "{}", outcome.stderr);
    // Nothing came: no frame, and nothing wrong.
    assert_eq!(pldi(arguments!["run", "--from-serial", file(folder.path(), b"")]).ok().stdout, b"");
}

#[cfg(unix)]
#[test]
fn an_interrupt_leaves_what_was_printed() {
    use std::io::BufRead;
    let folder = folder();
    let fifo = folder.path().join("line");
    assert!(std::process::Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    let mut child = command();
    child.args(arguments!["run", "--from-serial", fifo]).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = child.spawn().unwrap();
    let mut line = std::fs::OpenOptions::new().write(true).open(&fifo).unwrap();
    line.write_all(&captured()).unwrap();
    let mut out = std::io::BufReader::new(child.stdout.take().unwrap());
    let mut first = String::new();
    out.read_line(&mut first).unwrap();
    // The FIFO stays open: without the interrupt, it would wait for ever.
    let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
    let mut rest = String::new();
    out.read_to_string(&mut rest).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{output:?}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("interrupted"));
    assert!(!common::lines((first + &rest).as_bytes()).is_empty());
}

/// A pair of pseudo-terminals: what one end writes, the other reads as a serial port.
#[cfg(unix)]
#[test]
fn a_serial_port_is_raw() {
    use serialport::SerialPort;
    let (mut robot, port) = serialport::TTYPort::pair().unwrap();
    let mut child = command();
    child.args(["run", "--from-serial", &port.name().unwrap(), "--baud", "921600"]);
    let mut child = child.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut out = std::io::BufReader::new(child.stdout.take().unwrap());
    // Bytes that a terminal would take for line ends and signals are among these.
    let (sent, bytes) = (std::sync::atomic::AtomicBool::new(false), captured());
    let lines = std::thread::scope(|scope| {
        scope.spawn(|| {
            // The port is set up first: what came before would be lost.
            std::thread::sleep(std::time::Duration::from_millis(1500));
            bytes.chunks(512).for_each(|piece| robot.write_all(piece).unwrap());
            sent.store(true, std::sync::atomic::Ordering::SeqCst);
        });
        let mut lines = String::new();
        for _ in 0..3 {
            std::io::BufRead::read_line(&mut out, &mut lines).unwrap();
        }
        lines
    });
    let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!((output.status.code(), &*stderr), (Some(130), "pldi: interrupted\n"));
    let expected = pldi(arguments!["run", *recording(), "--arithmetic", "fixed"]).ok().lines();
    assert_eq!(common::lines(lines.as_bytes()).into_iter().map(as_run).collect::<Vec<_>>(), expected);
}
