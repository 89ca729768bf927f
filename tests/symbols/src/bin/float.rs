//! Everything of the pipeline in single precision, and what turns floats into integers at run time; see `fixed.rs`.
#![no_std]
#![no_main]

use core::panic::PanicInfo;
use pldi_core::pipeline::{FixedParams, Params, QvgaFixedWorkspace, QvgaPipeline, QvgaWorkspace, Report, digest, mix};
use pldi_core::templates::{Encoding, Templates};
use pldi_core::{Error, Float, Floor, Frame, Intrinsics, descriptor, matching, rays, reconstruct};

/// What comes from outside, so that the compiler knows nothing about it.
#[repr(C)]
pub struct Outside<'a> {
    depth: &'a [[u16; 320]; 240],
    colour: &'a [[[u8; 3]; 320]; 240],
    flat_depth: &'a [u16],
    flat_colour: &'a [u8],
    metres: &'a [f32],
    templates: &'a [u8],
    params: &'a Params,
    camera: &'a Intrinsics,
    pose: [f32; 3],
    workspace: &'a mut QvgaWorkspace,
    fixed: &'a mut QvgaFixedWorkspace,
    exact: &'a mut [[f32; 320]; 240],
    indices: [usize; 2],
}

/// All of it, one after the other, as sums of what it gave.
#[unsafe(no_mangle)]
pub extern "C" fn entry(outside: &mut Outside<'_>) -> f32 {
    let mut sum = 0.0;
    for part in [frames, stages, numbers] {
        sum += part(outside).unwrap_or(-1.0);
    }
    sum
}

fn frames(outside: &mut Outside<'_>) -> Result<f32, Error> {
    let Outside { depth, colour, flat_depth, flat_colour, templates, params, camera, workspace, .. } = outside;
    params.validate()?;
    let pipeline = QvgaPipeline::new(params, camera)?;
    let templates = Templates::parse(templates)?;
    pipeline.run(&Frame { depth, colour: Some(colour) }, &templates, workspace)?;
    let mut sum = read(&workspace.report);
    pipeline.run(&Frame::new(flat_depth, Some(flat_colour))?, &templates, workspace)?;
    sum += read(&workspace.report);
    let digests = digest::run(&pipeline, &Frame { depth, colour: None }, &templates, workspace)?;
    #[cfg(feature = "panic")]
    {
        sum += f32::from(flat_depth[outside.indices[0]]);
    }
    Ok(digests.iter().fold(sum, |sum, digest| sum + *digest as f32))
}

/// The stages one by one, the images between them, and objects that are known.
fn stages(outside: &mut Outside<'_>) -> Result<f32, Error> {
    let Outside { depth, colour, params, camera, pose: [height, pitch, roll], workspace, .. } = outside;
    let Outside { fixed, exact, templates, indices: [column, row], .. } = outside;
    let pipeline = QvgaPipeline::new(params, camera)?;
    let mut sum = 0.0;
    pipeline.reconstruct(&Frame { depth, colour: None }, workspace);
    if let Some(floor) = pipeline.find_floor(workspace) {
        pipeline.find_candidates(&floor, workspace)?;
        let points = &workspace.images.points;
        sum += workspace.report.contours.iter().map(|contour| contour.of(points).len() as f32).sum::<f32>();
        pipeline.diffuse_candidates(workspace);
        pipeline.frame_view(*row, &floor, workspace);
        sum += pipeline.describe_view(workspace).iter().sum::<f32>();
        pipeline.classify(&floor, &Templates::parse(templates)?, workspace)?;
        sum += floor.pitch() + floor.roll();
    }
    let floor = Floor::from_pose(*height, *pitch, *roll)?;
    sum += pipeline.describe_mask(&floor, |u, v| u > *column && v < *row, workspace).into_iter().flatten().sum::<f32>();
    pipeline.diffuse_all(workspace);
    mix::depth_to_fixed(&workspace.images, &mut fixed.images);
    mix::views_to_fixed(&workspace.images, &mut fixed.images);
    mix::images_to_float(&fixed.images, &mut workspace.images);
    mix::report_to_float(&fixed.report, &mut workspace.report);
    reconstruct::exact::exact(&Frame { depth, colour: Some(colour) }, params.range, &params.filter, exact);
    Ok(sum + pipeline.rays().point(*column, *row, 2.0)[0])
}

/// Parameters and numbers, from floats to integers and back.
fn numbers(outside: &mut Outside<'_>) -> Result<f32, Error> {
    let Outside { params, camera, metres, templates, indices: [column, row], .. } = outside;
    let fixed = FixedParams::new(params)?;
    let reduced = camera.reduced(*column as u16)?.resampled(*row as u16, *column as u16)?;
    let lens = rays::fixed::Intrinsics::new(&reduced)?;
    let mut sum = f32::from(fixed.view.radius) + lens.fx as f32;
    for metres in *metres {
        sum += f32::from(params.range.from_metres(*metres));
        sum += descriptor::fixed::decode(descriptor::fixed::encode(*metres));
    }
    let templates = Templates::parse(templates)?;
    templates.require(params.hash(), Encoding::Float)?;
    for template in templates.iter() {
        let descriptor = template.descriptor();
        sum += matching::canberra(&descriptor, &[0.5; 58]);
        for hypothesis in matching::nearest(&templates, &descriptor)? {
            sum += hypothesis.score;
        }
    }
    let [x, y, z] = camera.back_project(sum, sum, sum);
    Ok(camera.project([x, y, z]).map_or(sum, |[u, v]| u + v))
}

/// Everything that a report says.
fn read(report: &Report<Float>) -> f32 {
    let mut sum = report.floor.map_or(0.0, |floor| floor.height);
    for cluster in &report.clusters {
        sum += cluster.top + cluster.rejection.map_or(0.0, |reason| reason.name().len() as f32);
    }
    for detection in &report.detections {
        sum += report.clusters.get(usize::from(detection.cluster)).map_or(detection.descriptor[0], |c| c.size[0]);
        sum += detection.hypotheses.iter().map(|hypothesis| hypothesis.distance).sum::<f32>();
    }
    sum
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    // Otherwise the ways to panic are all the same to the compiler, and it leaves one name of them.
    core::hint::black_box(info);
    loop {}
}
