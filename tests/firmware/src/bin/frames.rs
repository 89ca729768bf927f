//! Runs the golden frames through the pipeline: prints what was found, the digests of all stages, and what it took.
//!
//! Arguments: the file of frames, and the step from one frame to the next.
#![no_std]
#![no_main]

use firmware::clock::{Stage, calibrate};
use firmware::frames::Frames;
use firmware::{TEMPLATES, board, setup};
use pldi_core::Error;
use pldi_core::pipeline::{Arithmetic, Pipeline, Workspace, digest};
use pldi_core::templates::Templates;
use semihosting::process::ExitCode;
use semihosting::{io, println};

#[cfg(feature = "float")]
#[path = "frames/float.rs"]
mod arithmetic;
#[cfg(not(feature = "float"))]
#[path = "frames/fixed.rs"]
mod arithmetic;
use arithmetic::{Intake, NAME};

/// What can go wrong.
#[derive(Debug)]
#[allow(dead_code, reason = "what is in them is printed")]
enum Failure {
    /// The host's files.
    Host(io::Error),
    /// The pipeline's.
    Core(Error),
    /// The frames were made for another camera.
    Camera([f32; 4]),
    /// The command line.
    Usage,
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::Host(error)
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Core(error)
    }
}

#[firmware::board::entry]
fn main() -> ! {
    board::start();
    match run() {
        Ok(()) => ExitCode::SUCCESS.exit_process(),
        Err(failure) => {
            println!("failed: {failure:?}");
            ExitCode::FAILURE.exit_process()
        }
    }
}

fn run() -> Result<(), Failure> {
    println!("board {}, {NAME}", board::NAME);
    calibrate();
    let arguments = semihosting::experimental::env::args::<512>()?;
    let mut arguments = (&arguments).into_iter().skip(1);
    let mut argument = || arguments.next().and_then(Result::ok).ok_or(Failure::Usage);
    let (path, step) = (argument()?, argument()?);
    let step: usize = step.parse().map_err(|_| Failure::Usage)?;
    let mut name = [0; 400];
    name.get_mut(..path.len()).ok_or(Failure::Usage)?.copy_from_slice(path.as_bytes());
    let path = core::ffi::CStr::from_bytes_until_nul(&name).map_err(|_| Failure::Usage)?;

    let mut frames = Frames::open(path)?;
    let templates = Templates::parse(TEMPLATES).map_err(Error::from)?;
    let mut intake = Intake::take();
    let mut stages = Stages::new();
    let mut done = 0;
    while let Some(header) = frames.header(done * step)? {
        let camera = setup::CAMERA;
        if header.camera() != [camera.fx, camera.fy, camera.cx, camera.cy] {
            return Err(Failure::Camera(header.camera()));
        }
        let (pipeline, workspace) = intake.frame(&mut frames, header.variant(), &mut stages.reconstruct)?;
        println!("\n{} {NAME}", header.name());
        stages.run(pipeline, &templates, workspace)?;
        done += 1;
    }
    println!();
    stages.print(done);
    println!("budget stack: {}", board::stack_used());
    Ok(())
}

/// What each stage took.
struct Stages {
    reconstruct: [Stage; 2],
    recognise: Stage,
    parts: [Stage; 6],
    candidates: usize,
}

impl Stages {
    const fn new() -> Self {
        let [floor, ground, diffusion] = [Stage::new("floor"), Stage::new("ground"), Stage::new("N")];
        let [view, descriptor, nearest] =
            [Stage::new("views"), Stage::new("wavelets and descriptors"), Stage::new("nearest")];
        Self {
            reconstruct: [Stage::new("rows"), Stage::new("filter")],
            recognise: Stage::new("recognise"),
            parts: [floor, ground, diffusion, view, descriptor, nearest],
            candidates: 0,
        }
    }

    /// The stages after the first: all at once, then one by one, then their digests.
    fn run<A: Arithmetic>(
        &mut self,
        pipeline: &Pipeline<A>,
        templates: &Templates<'_>,
        workspace: &mut Workspace<A>,
    ) -> Result<(), Error> {
        self.recognise.run(|| pipeline.recognise(templates, workspace))?;
        for detection in &workspace.report.detections {
            for hypothesis in detection.hypotheses.iter().take(1) {
                let (class, distance) = (templates.class_name(hypothesis.class), hypothesis.distance);
                println!(
                    "found {class}: template {} of object {}, distance {distance:?}",
                    hypothesis.view, hypothesis.object
                );
            }
        }
        self.candidates += workspace.report.detections.len();
        self.one_by_one(pipeline, templates, workspace)?;
        let digests = digest::recognise(pipeline, templates, workspace)?;
        for (stage, digest) in digest::STAGES.iter().zip(digests) {
            println!("digest {stage} {digest:08x}");
        }
        Ok(())
    }

    fn one_by_one<A: Arithmetic>(
        &mut self,
        pipeline: &Pipeline<A>,
        templates: &Templates<'_>,
        workspace: &mut Workspace<A>,
    ) -> Result<(), Error> {
        let [floor_stage, ground, diffusion, view, descriptor, nearest] = &mut self.parts;
        let Some(floor) = floor_stage.run(|| pipeline.find_floor(workspace)) else { return Ok(()) };
        ground.run(|| pipeline.find_candidates(&floor, workspace))?;
        diffusion.run(|| pipeline.diffuse_candidates(workspace));
        for i in 0..workspace.report.clusters.len() {
            if workspace.report.clusters.get(i).is_none_or(|cluster| cluster.rejection.is_some()) {
                continue;
            }
            if view.run(|| pipeline.frame_view(i, &floor, workspace)).is_none() {
                continue;
            }
            let numbers = descriptor.run(|| pipeline.describe_view(workspace));
            nearest.run(|| A::nearest(templates, &numbers))?;
        }
        Ok(())
    }

    fn print(&self, frames: usize) {
        println!("budget frames: {frames}");
        println!("budget candidates: {}", self.candidates);
        self.reconstruct.iter().chain([&self.recognise]).chain(&self.parts).for_each(|stage| stage.print(frames));
    }
}
