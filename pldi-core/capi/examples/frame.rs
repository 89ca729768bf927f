//! Writes what the firmware example runs on to the folder named on the command line: `frame.depth` (uint16_t, mm), `frame.rgb`,
//! `templates.pldt`, and `expected.out`, which the pipeline makes of them when it is called from Rust. `cargo xtask capi` calls it.

use pldi_core::pipeline::{FixedParams, Params, QvgaFixedPipeline, QvgaFixedWorkspace};
use pldi_core::templates::Templates;
use pldi_core::{Frame, rays};
use pldi_host::input::reduce;
use pldi_host::templates::fixed_file;
use pldi_host::trial::Trial;
use std::fmt::Write as _;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = PathBuf::from(std::env::args_os().nth(1).ok_or("usage: frame FOLDER")?);
    std::fs::create_dir_all(&folder)?;
    let bytes = fixed_file(include_bytes!("../../../pldi-host/assets/furniture.pldt"))?;
    let recording = Trial { rooms: 5, frames: 12, seed: 77 }.recording(2);
    let capture = recording.frames().nth(2).ok_or("twelve frames")?.capture;
    let (depth, colour) = reduce(&capture.depth, &capture.colour, 2);
    std::fs::write(folder.join("templates.pldt"), &bytes)?;
    std::fs::write(folder.join("frame.depth"), depth.iter().flat_map(|d| d.to_le_bytes()).collect::<Vec<_>>())?;
    std::fs::write(folder.join("frame.rgb"), &colour)?;
    std::fs::write(folder.join("expected.out"), expected(&bytes, &depth, &colour).map_err(|error| error.to_string())?)?;
    Ok(())
}

/// What `main.c` prints, from the Rust pipeline. The recording's camera is the default one.
fn expected(templates: &[u8], depth: &[u16], colour: &[u8]) -> Result<String, pldi_core::Error> {
    let templates = Templates::parse(templates)?;
    let camera = rays::fixed::Intrinsics::new(&pldi_core::Intrinsics::KINECT_QVGA)?;
    let pipeline = QvgaFixedPipeline::new(&FixedParams::new(&Params::DEFAULT)?, &camera)?;
    let mut workspace = Box::new(QvgaFixedWorkspace::new());
    pipeline.run(&Frame::new(depth, Some(colour))?, &templates, &mut workspace)?;
    let report = &workspace.report;
    let mm = |length: i32| (length + 64) >> 7;
    let mut text = String::new();
    let height = report.floor.map_or(0, |floor| mm(floor.height));
    let _ = writeln!(text, "pldi {}, {} templates", env!("CARGO_PKG_VERSION"), templates.len());
    let _ = writeln!(text, "floor: {height} mm below the camera");
    for detection in &report.detections {
        let (Some(best), Some(cluster)) =
            (detection.hypotheses.first(), report.clusters.get(usize::from(detection.cluster)))
        else {
            continue;
        };
        let ([x, y, z], [u0, v0, u1, v1]) = (cluster.center.map(mm), cluster.bbox);
        let _ = writeln!(
            text,
            "{} ({}): score {}/65536, distance {}/65536, at {x} {y} {z} mm, pixels {u0} {v0} {u1} {v1}",
            templates.class_name(best.class),
            templates.object_name(best.object),
            best.score,
            best.distance
        );
    }
    for cluster in &report.clusters {
        if let Some(rejection) = cluster.rejection {
            let _ = writeln!(text, "rejected, {}: {} pixels", rejection.name(), cluster.pixels);
        }
    }
    Ok(text)
}
