//! The host of a robot's co-processor on a bad line: sends frames with corrupted and repeated packets between theirs, some
//! frames with a packet lost, and checks every answer against the pipeline here, bit for bit. `cargo xtask robot` runs it
//! against a device in an emulator.
//!
//! Arguments: number of frames, corrupted packets for each, the FIFO to write to, the FIFO to read from.

#[path = "../../tests/robot/mod.rs"]
mod robot;

use std::fs::{File, OpenOptions};
use std::io::Write;
use std::sync::mpsc::{self, Receiver as Queue};
use std::time::{Duration, Instant};

use anyhow::{Context, bail, ensure};
use pldi_core::pipeline::{Fixed, FixedParams, Params, QvgaFixedPipeline, QvgaFixedWorkspace, Report};
use pldi_core::serial::wire::Pong;
use pldi_core::serial::{Request, StatusCode, wire};
use pldi_core::templates::Templates;
use pldi_core::{Frame, rays};
use pldi_fixtures::rng::Rng;
use pldi_host::input::reduce;
use pldi_host::serial::{Answer, Detections, FrameOptions, Outgoing, Receiver, frame_packets, packet};
use pldi_host::templates::{EMBEDDED, fixed_file};
use pldi_host::trial::Trial;
use robot::corrupt::{Corrupter, told};
use robot::stream::Stream;

/// Different frames; they come again and again.
const SCENES: usize = 10;

/// Repeated packets of each frame.
const REPEATED: usize = 10;

/// A packet of every so many frames' is lost, before a whole frame is sent.
const LOSSES: u32 = 10;

/// Longer than a frame takes in any emulator.
const PATIENCE: Duration = Duration::from_secs(120);

/// A frame and what the pipeline says about it.
struct Scene {
    depth: Vec<u16>,
    colour: Vec<u8>,
    report: Report<Fixed>,
}

fn scenes() -> anyhow::Result<Vec<Scene>> {
    let coded = fixed_file(EMBEDDED)?;
    let templates = Templates::parse(&coded).map_err(pldi_core::Error::from)?;
    let params = FixedParams::new(&Params { view: *templates.view_params(), ..Params::DEFAULT })?;
    let trial = Trial { rooms: 1, frames: SCENES, seed: 77 };
    let recording = trial.recording(0);
    let camera = rays::fixed::Intrinsics::new(&recording.sensor.intrinsics.reduced(2)?)?;
    let pipeline = QvgaFixedPipeline::new(&params, &camera)?;
    let mut workspace = Box::new(QvgaFixedWorkspace::new());
    let scene = |frame: pldi_fixtures::RecordedFrame| {
        let (depth, colour) = reduce(&frame.capture.depth, &frame.capture.colour, 2);
        pipeline.run(&Frame::new(&depth, Some(&colour))?, &templates, &mut workspace)?;
        Ok(Scene { depth, colour, report: workspace.report.clone() })
    };
    recording.frames().map(scene).collect()
}

/// Both ends of the line.
struct Line {
    writer: File,
    answers: Queue<Answer>,
    sequence: u16,
}

impl Line {
    fn open(to: String, from: String) -> anyhow::Result<Self> {
        let (sender, answers) = mpsc::channel();
        let (opened, line) = mpsc::channel();
        // FIFOs are waited for until the device opens them, and reading has no time-out.
        std::thread::spawn(move || -> anyhow::Result<()> {
            opened.send(OpenOptions::new().write(true).open(to)?)?;
            let mut receiver = Receiver::new(File::open(from)?);
            while let Some(received) = receiver.next()? {
                sender.send(received.answer)?;
            }
            Ok(())
        });
        let writer = line.recv_timeout(PATIENCE).context("the device does not open the line")?;
        Ok(Self { writer, answers, sequence: 0 })
    }

    fn next(&mut self) -> anyhow::Result<Answer> {
        self.answers.recv_timeout(PATIENCE).context("the device does not answer")
    }

    fn ask(&mut self, request: &Request<'_>) -> anyhow::Result<Answer> {
        self.writer.write_all(&packet(request, self.sequence)?)?;
        self.sequence = self.sequence.wrapping_add(1);
        self.next()
    }
}

/// What the device must have counted.
#[derive(Debug, Default)]
struct Expected {
    accepted: u32,
    rejects: u32,
    corrupted: u32,
    repeated: u32,
    frames: u32,
    failed: u32,
    losses: u32,
}

impl Expected {
    fn check(&self, pong: &Pong) -> anyhow::Result<()> {
        let rejected: u32 = pong.rejected.iter().map(|n| n.get()).sum();
        let counted = [pong.accepted.get(), rejected, pong.frames.get(), pong.failed.get()];
        let expected = [self.accepted, self.rejects, self.frames, self.failed];
        ensure!(counted == expected, "accepted, rejected, frames, failed: counted {counted:?}, expected {expected:?}");
        Ok(())
    }
}

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [frames, corrupted, to, from] = &arguments[..] else { bail!("give FRAMES CORRUPTED TO FROM") };
    let (frames, corrupted): (u32, usize) = (frames.parse()?, corrupted.parse()?);
    let scenes = scenes()?;
    let detections: usize = scenes.iter().map(|scene| scene.report.detections.len()).sum();
    ensure!(detections >= SCENES, "the frames show too little: {detections} objects");

    let mut line = Line::open(to.clone(), from.clone())?;
    let start = Instant::now();
    let Answer::Info(info) = line.ask(&Request::Hello(wire::Hello { session: 1.into() }))? else {
        bail!("no answer to the greeting")
    };
    let mut expected = Expected { accepted: 1, ..Expected::default() };
    let (mut random, mut number, mut stacks, mut memory) = (Rng::new(1), 0, Vec::new(), Vec::new());
    let mut counts = [0; 7];
    for i in 0..frames {
        let scene = &scenes[i as usize % SCENES];
        let lost = (i % LOSSES == LOSSES - 1).then(|| lose(&mut line, scene, &mut number, &mut random, &mut expected));
        let lost = lost.transpose()?.flatten();
        let outgoing = outgoing(scene, number);
        let packets = frame_packets(&outgoing, FrameOptions::default(), line.sequence)?;
        line.sequence = line.sequence.wrapping_add(packets.len() as u16);
        let mut corrupter = Corrupter::new(u64::from(i), &packets);
        let stream = Stream::new(&packets, corrupted, REPEATED, &mut corrupter, &mut random);
        line.writer.write_all(&stream.bytes)?;
        expected.accepted += stream.accepted;
        expected.rejects += stream.rejects;
        expected.corrupted += stream.corrupted;
        expected.repeated += stream.repeated;
        expected.frames += 1;
        let mut answer = line.next()?;
        if let Some(lost) = lost {
            status(&answer, lost, StatusCode::Abandoned)?;
            answer = line.next()?;
        }
        let Answer::Detections(found) = answer else { bail!("frame {number}: {answer:?}") };
        ensure!(found.result.frame.get() == number && same(&found, &scene.report), "frame {number}: {found:?}");
        number += 1;

        expected.accepted += 1;
        let Answer::Pong(pong) = line.ask(&Request::Ping(wire::Ping { token: i.into() }))? else {
            bail!("frame {number}: no counters")
        };
        expected.check(&pong).with_context(|| format!("behind frame {number}"))?;
        counts = pong.rejected.map(|n| n.get());
        stacks.push(pong.stack.get());
        memory.push(pong.memory.get());
    }
    let settled = &stacks[stacks.len().min(SCENES) - 1..];
    ensure!(settled.iter().all(|stack| *stack == settled[0]), "the stack grows: {stacks:?}");
    ensure!(memory.iter().all(|bytes| *bytes == info.memory.get()), "the memory grows: {memory:?}");
    let Expected { accepted, rejects, corrupted, repeated, losses, .. } = expected;
    println!(
        "{frames} whole frames, {losses} without one of their packets, {corrupted} packets corrupted, {repeated} repeated"
    );
    println!("accepted {accepted}, as sent; rejected {rejects} ({})", told(counts));
    println!(
        "every whole frame answered with this machine's bits ({detections} detections in {SCENES} different frames)"
    );
    println!(
        "static memory {} bytes, stack {} bytes behind the first frame, {} behind the last",
        info.memory, stacks[0], settled[0]
    );
    println!("{:.2} s a frame", start.elapsed().as_secs_f64() / f64::from(frames));
    Ok(())
}

fn outgoing(scene: &Scene, number: u32) -> Outgoing<'_> {
    Outgoing { number, stamp: u64::from(number) * 33_333, depth: &scene.depth, colour: Some(&scene.colour) }
}

/// Sends a frame without one of its packets, and checks that the device says so; the frame's number where it only can when
/// the next one begins.
fn lose(
    line: &mut Line,
    scene: &Scene,
    number: &mut u32,
    random: &mut Rng,
    expected: &mut Expected,
) -> anyhow::Result<Option<u32>> {
    let mut packets = frame_packets(&outgoing(scene, *number), FrameOptions::default(), line.sequence)?;
    line.sequence = line.sequence.wrapping_add(packets.len() as u16);
    let end = packets.len() - 1;
    let lost = [0, 1 + random.below(end - 1), end][random.below(3)];
    packets.remove(lost);
    line.writer.write_all(&packets.concat())?;
    expected.accepted += packets.len() as u32;
    expected.losses += 1;
    // A frame whose beginning was lost never began.
    expected.failed += u32::from(lost != 0);
    let this = *number;
    *number += 1;
    if lost == end {
        return Ok(Some(this));
    }
    let code = if lost == 0 { StatusCode::NotBegun } else { StatusCode::Incomplete };
    status(&line.next()?, this, code).map(|()| None)
}

fn status(answer: &Answer, frame: u32, code: StatusCode) -> anyhow::Result<()> {
    match answer {
        Answer::Status(status) if status.frame.get() == frame && status.code == code as u8 => Ok(()),
        other => bail!("frame {frame} should be {}: {other:?}", code.name()),
    }
}

/// Whether every number of a result is that of the report.
fn same(found: &Detections, report: &Report<Fixed>) -> bool {
    let floor = report.floor.map(|floor| (floor.normal, floor.height));
    let places = report.detections.iter().zip(&found.detections).all(|(truth, found)| {
        let hypotheses = truth.hypotheses.iter().zip(&found.hypotheses).all(|(a, b)| {
            (a.class, a.object, a.view) == (b.class.get(), b.object.get(), b.view.get())
                && (a.distance, a.score) == (b.distance.get(), b.score.get())
        });
        let cluster = &report.clusters[usize::from(truth.cluster)];
        hypotheses
            && truth.hypotheses.len() == found.hypotheses.len()
            && truth.cluster + 1 == found.place.id.get()
            && cluster.center == found.place.centre.map(|v| v.get())
            && cluster.size == found.place.size.map(|v| v.get())
            && cluster.bbox == found.place.bbox.map(|v| v.get())
    });
    places
        && report.detections.len() == found.detections.len()
        && floor.unwrap_or_default() == (found.result.normal.map(|v| v.get()), found.result.height.get())
        && found.rejected.iter().all(|rejected| {
            let cluster = &report.clusters[usize::from(rejected.id.get()) - 1];
            cluster.center == rejected.centre.map(|v| v.get()) && cluster.bbox == rejected.bbox.map(|v| v.get())
        })
}
