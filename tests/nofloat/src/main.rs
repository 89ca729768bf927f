//! Everything that a firmware calls of the pipeline in integers, linked for a core without FPU.
//!
//! Nothing of it is ever run. What the linker keeps is what the calls below need; a float operation would leave the
//! compiler's software floating point (`__aeabi_fadd`, `__addsf3`, ...) among the symbols.
#![no_std]
#![no_main]

use core::panic::PanicInfo;
use pldi_core::pipeline::{FixedParams, Params, QvgaFixedPipeline, QvgaFixedWorkspace};
use pldi_core::reconstruct::fixed::{ColourRow, DepthRow, Disparity};
use pldi_core::templates::Templates;
use pldi_core::{Error, Frame, Intrinsics, rays};

/// All parameters are turned into integers by the compiler.
const PARAMS: FixedParams = match FixedParams::new(&Params::DEFAULT) {
    Ok(params) => params,
    Err(_) => panic!("a parameter is out of range"),
};
const CAMERA: rays::fixed::Intrinsics = match rays::fixed::Intrinsics::new(&Intrinsics::KINECT_QVGA) {
    Ok(camera) => camera,
    Err(_) => panic!("the intrinsics are out of range"),
};

/// In flash, tables and all.
static PIPELINE: QvgaFixedPipeline = match QvgaFixedPipeline::constant(&PARAMS, &CAMERA) {
    Ok(pipeline) => pipeline,
    Err(_) => panic!("a parameter is out of range"),
};

/// Rows of a sensor, the template file, and memory: what comes from outside, so that the compiler knows nothing about it.
#[repr(C)]
pub struct Outside<'a> {
    depth: &'a [[u16; 320]; 240],
    colour: &'a [[[u8; 3]; 320]; 240],
    yuyv: &'a [[u8; 640]; 240],
    templates: &'a [u8],
    workspace: &'a mut QvgaFixedWorkspace,
}

/// A whole frame, a frame in rows of both kinds, and N of a whole image.
#[unsafe(no_mangle)]
pub extern "C" fn entry(outside: &mut Outside<'_>) -> usize {
    frames(outside).unwrap_or(usize::MAX)
}

fn frames(outside: &mut Outside<'_>) -> Result<usize, Error> {
    let Outside { depth, colour, yuyv, templates, workspace } = outside;
    let pipeline = QvgaFixedPipeline::new(&PARAMS, &CAMERA)?;
    let templates = Templates::parse(templates)?;
    pipeline.run(&Frame { depth, colour: Some(colour) }, &templates, workspace)?;
    let mut found = workspace.report.detections.len();
    // The second frame with the tables in flash.
    let pipeline = &PIPELINE;
    pipeline.begin(workspace);
    for (v, (depth, colour)) in depth.iter().zip(yuyv.iter()).enumerate() {
        let row = if v % 2 == 0 { DepthRow::Millimetres(depth) } else { DepthRow::Raw(depth, Disparity::KINECT) };
        pipeline.push(row, Some(ColourRow::Yuyv(&[colour])), workspace)?;
    }
    pipeline.finish(workspace)?;
    pipeline.recognise(&templates, workspace)?;
    for detection in &workspace.report.detections {
        found += detection.hypotheses.first().map_or(0, |h| h.distance as usize);
    }
    pipeline.diffuse_all(workspace);
    found += workspace.images.views().map_or(0, |views| usize::from(views.n[9][9]));
    #[cfg(feature = "float")]
    {
        found += (f32::from(depth[7][7]) * core::hint::black_box(1.5)) as usize;
    }
    Ok(found)
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {}
}
