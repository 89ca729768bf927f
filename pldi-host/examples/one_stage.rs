//! Runs one stage of the pipeline so many times, for counting instructions: `cargo xtask instructions` calls it.
//!
//!     one_stage prepare FILE                       writes a generated frame
//!     one_stage float|fixed STAGE TIMES FILE       runs a stage of it

use std::error::Error;
use std::hint::black_box;

use pldi_core::pipeline::{
    Arithmetic, Fixed, FixedParams, Float, Params, Pipeline, QvgaFixedWorkspace, QvgaWorkspace, Workspace,
};
use pldi_core::templates::Templates;
use pldi_core::{Frame, Intrinsics, rays};
use pldi_host::input::reduce;
use pldi_host::templates::fixed_file;
use pldi_host::trial::Trial;

/// Pixels of a frame.
const PIXELS: usize = 320 * 240;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let templates = include_bytes!("../assets/furniture.pldt");
    match arguments[..] {
        ["prepare", file] => prepare(file)?,
        ["float", stage, times, file] => {
            let bytes = std::fs::read(file)?;
            let camera = camera()?;
            let set = Templates::parse(templates)?;
            let params = Params { view: *set.view_params(), ..Params::DEFAULT };
            let pipeline = Pipeline::<Float>::new(&params, &camera)?;
            run(&pipeline, &set, &mut Box::new(QvgaWorkspace::new()), stage, times.parse()?, &bytes)?;
        }
        ["fixed", stage, times, file] => {
            let bytes = std::fs::read(file)?;
            let coded = fixed_file(templates)?;
            let set = Templates::parse(&coded)?;
            let params = FixedParams::new(&Params { view: *set.view_params(), ..Params::DEFAULT })?;
            let pipeline = Pipeline::<Fixed>::new(&params, &rays::fixed::Intrinsics::new(&camera()?)?)?;
            run(&pipeline, &set, &mut Box::new(QvgaFixedWorkspace::new()), stage, times.parse()?, &bytes)?;
        }
        _ => return Err("usage: one_stage prepare FILE | one_stage float|fixed STAGE TIMES FILE".into()),
    }
    Ok(())
}

fn camera() -> Result<Intrinsics, Box<dyn Error>> {
    Ok(Trial::default().recording(0).sensor.intrinsics.reduced(2)?)
}

/// Depth, then colour, of a generated frame with several candidates.
fn prepare(file: &str) -> Result<(), Box<dyn Error>> {
    let capture = Trial::default().recording(0).frames().nth(6).ok_or("no such frame")?.capture;
    let (depth, colour) = reduce(&capture.depth, &capture.colour, 2);
    let mut bytes: Vec<u8> = depth.iter().flat_map(|d| d.to_le_bytes()).collect();
    bytes.extend(colour);
    Ok(std::fs::write(file, bytes)?)
}

/// All stages up to `stage` once, and that stage `times` times more.
fn run<A: Arithmetic>(
    pipeline: &Pipeline<A>,
    templates: &Templates<'_>,
    workspace: &mut Workspace<A>,
    stage: &str,
    times: usize,
    bytes: &[u8],
) -> Result<(), Box<dyn Error>> {
    let (depth, colour) = bytes.split_at_checked(2 * PIXELS).ok_or("the frame is cut")?;
    let depth: Vec<u16> = depth.as_chunks().0.iter().map(|d| u16::from_le_bytes(*d)).collect();
    let frame = Frame::new(&depth, Some(colour))?;
    let again = |name: &str| if name == stage { times } else { 0 };
    for _ in 0..=again("reconstruct") {
        pipeline.reconstruct(&frame, workspace);
    }
    let mut floor = None;
    for _ in 0..=again("floor") {
        floor = black_box(pipeline.find_floor(workspace));
    }
    let floor = floor.ok_or("no floor")?;
    for _ in 0..=again("ground") {
        pipeline.find_candidates(&floor, workspace)?;
    }
    for _ in 0..=again("diffusion") {
        pipeline.diffuse_candidates(workspace);
    }
    let clusters = workspace.report.clusters.iter().enumerate();
    let candidates: Vec<usize> = clusters.filter(|(_, c)| c.rejection.is_none()).map(|(i, _)| i).collect();
    for _ in 0..=again("views") {
        for c in &candidates {
            black_box(pipeline.frame_view(*c, &floor, workspace));
        }
    }
    let mut descriptors = Vec::new();
    for _ in 0..=again("views and descriptors") {
        descriptors = candidates.iter().filter_map(|c| pipeline.describe(*c, &floor, workspace)).collect();
    }
    for _ in 0..=again("matching") {
        for descriptor in &descriptors {
            black_box(A::nearest(templates, descriptor)?);
        }
    }
    for _ in 0..again("whole frame") {
        pipeline.run(&frame, templates, workspace)?;
    }
    if times == 0 {
        let pixels: u32 = candidates.iter().map(|c| workspace.report.clusters[*c].pixels).sum();
        println!("{} candidates with {pixels} pixels, {} templates", candidates.len(), templates.len());
    }
    Ok(())
}
