//! Runs one golden frame and logs it through defmt: standard output is defmt's stream, for `tests/firmware/decode`.
//!
//! Argument: the file of frames.
#![no_std]
#![no_main]

use cortex_m as _;
use defmt_semihosting as _;
use firmware::failure::Failure;
use firmware::frames::{Frames, H, W};
use firmware::{TEMPLATES, board, files, setup};
use pldi_core::Error;
use pldi_core::pipeline::QvgaFixedWorkspace;
use pldi_core::reconstruct::fixed::{ColourRow, DepthRow};
use pldi_core::templates::Templates;
use semihosting::process::ExitCode;
use static_cell::ConstStaticCell;

static WORKSPACE: ConstStaticCell<QvgaFixedWorkspace> = ConstStaticCell::new(QvgaFixedWorkspace::new());

defmt::timestamp!("{=u64}", board::instructions());

#[firmware::board::entry]
fn main() -> ! {
    board::start();
    // Nothing is printed: text would lie between the stream's frames.
    match run() {
        Ok(()) => ExitCode::SUCCESS.exit_process(),
        Err(Failure::Core(error)) => defmt::error!("failed: {}", error),
        Err(Failure::Usage) => defmt::error!("usage: the file of frames"),
        Err(_) => defmt::error!("the file of frames cannot be read"),
    }
    ExitCode::FAILURE.exit_process()
}

fn run() -> Result<(), Failure> {
    let arguments = semihosting::experimental::env::args::<512>()?;
    let path = (&arguments).into_iter().nth(1).and_then(Result::ok).ok_or(Failure::Usage)?;
    let mut frames = files::open(path, Frames::open)?;
    let header = frames.header(0)?.ok_or(Failure::Cut)?;

    let templates = Templates::parse(TEMPLATES).map_err(Error::from)?;
    let pipeline = setup::FIXED.get(header.variant()).ok_or(Failure::Usage)?;
    let workspace = WORKSPACE.take();
    defmt::info!("{=str}: {=str}, {}", board::NAME, header.name(), templates);
    let (mut depth, mut colour) = ([0; W], [0; 3 * W]);
    pipeline.begin(workspace);
    for v in 0..H {
        frames.rows(v, &mut depth, &mut colour)?;
        pipeline.push(DepthRow::Millimetres(&depth), Some(ColourRow::Rgb888(&[&colour])), workspace)?;
    }
    pipeline.finish(workspace)?;
    pipeline.recognise(&templates, workspace)?;
    for detection in &workspace.report.detections {
        let class = detection.hypotheses.first().map_or("?", |best| templates.class_name(best.class));
        defmt::info!("found {=str}: {}", class, detection);
    }
    defmt::info!("{}", workspace.report);

    // A frame whose rows did not come: refused, and logged.
    pipeline.begin(workspace);
    pipeline.push(DepthRow::Millimetres(&depth), None, workspace)?;
    match pipeline.finish(workspace) {
        Err(Error::PixelCount { .. }) => Ok(()),
        other => other.map_err(Failure::Core),
    }
}
