//! Runs golden frames through the pipeline: prints what was found in each, the digests of all stages, and what it took.
//!
//! Arguments: the file of frames, and which of them: numbers from 0 on, separated by commas, or `all`.
#![no_std]
#![no_main]

use firmware::clock::{Stage, calibrate};
use firmware::failure::{Failure, end};
use firmware::frames::Frames;
use firmware::{TEMPLATES, board, files, setup};
use pldi_core::Error;
use pldi_core::pipeline::{Arithmetic, Pipeline, Workspace, digest};
use pldi_core::templates::Templates;
use semihosting::println;

#[cfg(feature = "float")]
#[path = "frames/float.rs"]
mod arithmetic;
#[cfg(not(feature = "float"))]
#[path = "frames/fixed.rs"]
mod arithmetic;
use arithmetic::{Intake, NAME};

#[firmware::board::entry]
fn main() -> ! {
    board::start();
    end(run())
}

fn run() -> Result<(), Failure> {
    println!("board {}, {NAME}", board::NAME);
    calibrate();
    let arguments = semihosting::experimental::env::args::<512>()?;
    let mut arguments = (&arguments).into_iter().skip(1);
    let mut argument = || arguments.next().and_then(Result::ok).ok_or(Failure::Usage);
    let (path, wanted) = (argument()?, argument()?);

    let mut frames = files::open(path, Frames::open)?;
    let templates = Templates::parse(TEMPLATES).map_err(Error::from)?;
    let mut intake = Intake::take();
    let (mut index, mut numbers) = (0, wanted.split(','));
    loop {
        if wanted != "all" {
            let Some(number) = numbers.next() else { break };
            index = number.parse().map_err(|_| Failure::Usage)?;
        }
        let Some(header) = frames.header(index)? else { break };
        index += 1;
        let camera = setup::CAMERA;
        if header.camera() != [camera.fx, camera.fy, camera.cx, camera.cy] {
            return Err(Failure::Camera(header.camera()));
        }
        let mut stages = Stages::new();
        let (pipeline, workspace) = intake.frame(&mut frames, header.variant(), &mut stages.reconstruct)?;
        println!("\n{} {NAME}", header.name());
        stages.run(pipeline, &templates, workspace)?;
        stages.print();
    }
    println!("budget stack: {}", board::stack_used());
    Ok(())
}

/// What each stage took in one frame.
struct Stages {
    reconstruct: [Stage; 2],
    recognise: Stage,
    parts: [Stage; 6],
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

    fn print(&self) {
        self.reconstruct.iter().chain([&self.recognise]).chain(&self.parts).for_each(Stage::print);
    }
}
