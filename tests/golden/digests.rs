//! The frames whose digests are golden, and the text that is committed: made by an example (optimised for speed) and by a
//! test (as tests are), compared byte for byte.

use std::fmt::Write as _;

use pldi_core::floor::FloorMode;
use pldi_core::pipeline::digest::{self, Digests, STAGES};
use pldi_core::pipeline::{FixedParams, Params, QvgaFixedPipeline, QvgaFixedWorkspace, QvgaPipeline, QvgaWorkspace};
use pldi_core::reconstruct::{FilterKind, FilterParams};
use pldi_core::templates::Templates;
use pldi_core::{Error, Floor, Frame, rays};
use pldi_host::input::reduce;
use pldi_host::templates::fixed_file;
use pldi_host::trial::Trial;

/// Rooms and the frames of their drives.
const FRAMES: [(u32, usize); 6] = [(0, 1), (0, 4), (1, 7), (2, 2), (3, 9), (4, 5)];

/// The text of the golden file.
///
/// # Panics
/// Where a frame fails: that would be a bug.
pub fn text() -> String {
    let mut text = String::from(
        "# CRC-32 of what each stage leaves behind, in both arithmetics, on generated frames.\n\
         # The same on every target and at every optimisation level. Renew with `cargo xtask golden`.\n#",
    );
    for stage in STAGES {
        let _ = write!(text, " {stage}");
    }
    text.push('\n');
    let bytes = include_bytes!("../../pldi-host/assets/furniture.pldt");
    let coded = fixed_file(bytes).expect("the embedded templates can be coded");
    let (templates, coded) = (Templates::parse(bytes).unwrap(), Templates::parse(&coded).unwrap());
    let (mut float, mut fixed) = (Box::new(QvgaWorkspace::new()), Box::new(QvgaFixedWorkspace::new()));
    let trial = Trial { rooms: 5, frames: 12, seed: 77 };
    for (name, params) in variants(&templates) {
        for (room, index) in FRAMES {
            let recording = trial.recording(room);
            let camera = recording.sensor.intrinsics.reduced(2).unwrap();
            let capture = recording.frames().nth(index).expect("twelve frames").capture;
            let (depth, colour) = reduce(&capture.depth, capture.colour, 2);
            let frame = Frame::new(&depth, Some(&colour)).unwrap();
            let mut line = |arithmetic: &str, sums: Result<Digests, Error>| {
                let _ = write!(text, "room {room} frame {index} {name} {arithmetic}");
                for sum in sums.unwrap() {
                    let _ = write!(text, " {sum:08x}");
                }
                text.push('\n');
            };
            let pipeline = QvgaPipeline::new(&params, &camera).unwrap();
            line("float", digest::run(&pipeline, &frame, &templates, &mut float));
            let camera = rays::fixed::Intrinsics::new(&camera).unwrap();
            let pipeline = QvgaFixedPipeline::new(&FixedParams::new(&params).unwrap(), &camera).unwrap();
            line("fixed", digest::run(&pipeline, &frame, &coded, &mut fixed));
        }
    }
    text
}

/// The defaults, and what the defaults do not run: a known pose, and the filter without colour.
fn variants(templates: &Templates<'_>) -> [(&'static str, Params); 2] {
    let defaults = Params { view: *templates.view_params(), ..Params::DEFAULT };
    let floor = FloorMode::Fixed(Floor::from_pose(1.2, 0.45, 0.02).unwrap());
    let filter = FilterParams { kind: FilterKind::Bilateral, iterations: 2, ..FilterParams::DEFAULT };
    [("default", defaults), ("pose", Params { floor, filter, ..defaults })]
}
