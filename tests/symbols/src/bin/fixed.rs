//! Everything that a firmware calls of the pipeline in integers.
//!
//! Nothing of it is ever run. What the linker keeps is what the calls below need: a float operation on a core without FPU
//! would leave the compiler's software floating point among the symbols, a panic would leave `core::panicking`.
#![no_std]
#![no_main]

use core::panic::PanicInfo;
use pldi_core::pipeline::{FixedParams, Params, QvgaFixedPipeline, QvgaFixedWorkspace, Report, digest, plan};
use pldi_core::reconstruct::fixed::{Bayer, ColourRow, DepthRow, Disparity};
use pldi_core::serial::{Answer, DEVICE_BUFFER, Decoder, Device, HOST_BUFFER, Request};
use pldi_core::templates::Templates;
use pldi_core::{Error, Fixed, Frame, Intrinsics, floor, matching, rays, templates};

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

/// Rows of a sensor, parameters, the template file, and memory: what comes from outside, so that the compiler knows
/// nothing about it.
#[repr(C)]
pub struct Outside<'a> {
    depth: &'a [[u16; 320]; 240],
    colour: &'a [[[u8; 3]; 320]; 240],
    flat_depth: &'a [u16],
    flat_colour: &'a [u8],
    depth_rows: &'a [&'a [u16]],
    byte_rows: &'a [&'a [&'a [u8]]],
    word_rows: &'a [&'a [&'a [u16]]],
    pattern: Bayer,
    disparity: Disparity,
    templates: &'a [u8],
    params: &'a FixedParams,
    camera: &'a rays::fixed::Intrinsics,
    pose: [i32; 3],
    workspace: &'a mut QvgaFixedWorkspace,
    decoders: (&'a mut Decoder<DEVICE_BUFFER>, &'a mut Decoder<HOST_BUFFER>),
    indices: [usize; 2],
}

/// All of it, one after the other, as sums of what it gave.
#[unsafe(no_mangle)]
pub extern "C" fn entry(outside: &mut Outside<'_>) -> usize {
    let mut sum = 0usize;
    for part in [whole_frames, rows, stages, template_file, serial_line] {
        sum = sum.wrapping_add(part(outside).unwrap_or(usize::MAX));
    }
    sum
}

/// Frames in one piece, with the tables in RAM.
fn whole_frames(outside: &mut Outside<'_>) -> Result<usize, Error> {
    let Outside { depth, colour, flat_depth, flat_colour, templates, params, camera, workspace, .. } = outside;
    let pipeline = QvgaFixedPipeline::new(params, camera)?;
    let templates = Templates::parse(templates)?;
    pipeline.run(&Frame { depth, colour: Some(colour) }, &templates, workspace)?;
    let mut sum = read(&workspace.report);
    pipeline.run(&Frame::new(flat_depth, Some(flat_colour))?, &templates, workspace)?;
    sum = sum.wrapping_add(read(&workspace.report));
    let digests = digest::run(&pipeline, &Frame { depth, colour: None }, &templates, workspace)?;
    #[cfg(feature = "float")]
    {
        sum += (f32::from(depth[7][7]) * core::hint::black_box(1.5)) as usize;
    }
    #[cfg(feature = "panic")]
    {
        sum += usize::from(flat_depth[outside.indices[0]]);
    }
    Ok(digests.iter().fold(sum, |sum, digest| sum.wrapping_add(*digest as usize)))
}

/// Frames row by row in all formats, with the tables in flash.
fn rows(outside: &mut Outside<'_>) -> Result<usize, Error> {
    let Outside { depth_rows, byte_rows, word_rows, pattern, disparity, templates, workspace, .. } = outside;
    let templates = Templates::parse(templates)?;
    let pipeline = &PIPELINE;
    pipeline.begin(workspace);
    for (v, depth) in depth_rows.iter().enumerate() {
        let depth = if v % 2 == 0 { DepthRow::Millimetres(depth) } else { DepthRow::Raw(depth, *disparity) };
        let (bytes, words) = (byte_rows.get(v), word_rows.get(v));
        let colour = match v % 5 {
            0 => bytes.map(|rows| ColourRow::Rgb888(rows)),
            1 => words.map(|rows| ColourRow::Rgb565(rows)),
            2 => bytes.map(|rows| ColourRow::Yuyv(rows)),
            3 => bytes.map(|rows| ColourRow::Bayer(rows, *pattern)),
            _ => None,
        };
        pipeline.push(depth, colour, workspace)?;
    }
    pipeline.finish(workspace)?;
    pipeline.recognise(&templates, workspace)?;
    Ok(read(&workspace.report))
}

/// The stages one by one, the images between them, and objects that are known.
fn stages(outside: &mut Outside<'_>) -> Result<usize, Error> {
    let Outside { depth, camera, pose: [height, pitch, roll], workspace, templates, indices, .. } = outside;
    camera.validate()?;
    let pipeline = &PIPELINE;
    let [column, row] = *indices;
    let mut sum = 0usize;
    pipeline.reconstruct(&Frame { depth, colour: None }, workspace);
    if let Some(floor) = pipeline.find_floor(workspace) {
        pipeline.find_candidates(&floor, workspace)?;
        if let Some(ground) = workspace.images.ground() {
            sum += ground.map_labels.get(row).and_then(|line| line.get(column)).map_or(0, |label| usize::from(*label));
            sum += ground.density.get(row).and_then(|line| line.get(column)).map_or(0, |count| usize::from(*count));
            sum += workspace.report.contours.iter().map(|contour| contour.of(ground.points).len()).sum::<usize>();
        }
        pipeline.diffuse_candidates(workspace);
        pipeline.frame_view(row, &floor, workspace);
        sum += pipeline.describe_view(workspace).map(usize::from).iter().sum::<usize>();
        pipeline.classify(&floor, &Templates::parse(templates)?, workspace)?;
    }
    let floor = floor::fixed::Floor::from_pose(*height, *pitch, *roll)?;
    floor.validate()?;
    workspace.images.set_depth(|u, v| depth.get(v).and_then(|line| line.get(u)).copied().unwrap_or(0));
    for code in pipeline.describe_mask(&floor, |u, v| u > column && v < row, workspace).into_iter().flatten() {
        sum += usize::from(code);
    }
    pipeline.diffuse_all(workspace);
    if let Some(views) = workspace.images.views() {
        sum += views.n.get(row).and_then(|line| line.get(column)).map_or(0, |n| usize::from(*n));
        sum += views.plane.get(row).and_then(|line| line.get(column)).map_or(0, |c| c.unsigned_abs() as usize);
    }
    let labels = workspace.images.labels();
    sum += labels.and_then(|labels| labels.get(row)?.get(column)).map_or(0, |label| usize::from(*label));
    sum += workspace.images.rows() + plan::BUFFERS.len();
    Ok(sum.wrapping_add(pipeline.rays().point(column, row, 2000)[0] as usize))
}

/// What is in a template file.
fn template_file(outside: &mut Outside<'_>) -> Result<usize, Error> {
    let bytes = outside.templates;
    let templates = Templates::parse(bytes)?;
    templates.require(outside.params.view.hash, templates::Encoding::Logarithmic)?;
    let mut sum = templates.len() + templates.checksum() as usize + templates.encoding().name().len();
    sum += templates.kind().name().len() + templates.classes().map(str::len).sum::<usize>();
    sum += templates.objects().map(|(class, name)| usize::from(class) + name.len()).sum::<usize>();
    sum += templates.class_name(bytes.len() as u16).len() + templates.object_name(bytes.len() as u16).len();
    for template in templates.iter() {
        let codes = template.codes();
        sum = sum.wrapping_add(usize::from(template.class() ^ template.object() ^ template.view()));
        sum = sum.wrapping_add(matching::fixed::canberra(&codes, &[7; 58]) as usize);
        for hypothesis in matching::fixed::nearest(&templates, &codes)? {
            sum = sum.wrapping_add(hypothesis.score as usize);
        }
    }
    Ok(sum)
}

/// A device on a line, and the other end of the line.
fn serial_line(outside: &mut Outside<'_>) -> Result<usize, Error> {
    let Outside { flat_colour, workspace, decoders: (requests, answers), templates, indices, .. } = outside;
    let mut sum = 0usize;
    let mut sink = |bytes: &[u8]| sum = sum.wrapping_add(bytes.iter().map(|byte| usize::from(*byte)).sum());
    let mut bytes = *flat_colour;
    while let Some(found) = answers.feed(&mut bytes) {
        let Ok(packet) = found else { continue };
        if let Ok(request) = Request::parse(&packet) {
            let _ = request.write(indices[0] as u16, &mut sink);
        }
        if let Ok(Answer::Detections(found)) = Answer::parse(&packet) {
            let hypotheses = found.iter().map(|(_, hypotheses)| hypotheses.len()).sum::<usize>();
            sink(&[hypotheses as u8, found.rejected().len() as u8]);
        }
    }
    let mut device = Device::new(&PIPELINE, Templates::parse(templates)?, workspace, requests)?;
    device.telemetry().stack = indices[1] as u32;
    device.receive(flat_colour, &mut sink);
    sink(device.rejects().total().to_le_bytes().as_slice());
    Ok(sum)
}

/// Everything that a report says.
fn read(report: &Report<Fixed>) -> usize {
    let mut sum = report.floor.map_or(0, |floor| floor.height) as usize;
    for cluster in &report.clusters {
        sum = sum.wrapping_add(cluster.top as usize ^ cluster.pixels as usize);
        sum = sum.wrapping_add(cluster.rejection.map_or(0, |reason| reason.name().len()));
        sum = sum.wrapping_add(usize::from(cluster.is_noise()));
    }
    for detection in &report.detections {
        sum = sum.wrapping_add(usize::from(detection.descriptor[0]));
        sum = sum.wrapping_add(report.clusters.get(usize::from(detection.cluster)).map_or(0, |c| c.size[0] as usize));
        for hypothesis in &detection.hypotheses {
            sum = sum.wrapping_add(hypothesis.distance as usize ^ usize::from(hypothesis.class));
        }
    }
    sum
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    // Otherwise the ways to panic are all the same to the compiler, and it leaves one name of them.
    core::hint::black_box(info);
    loop {}
}
