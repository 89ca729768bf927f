//! The frames whose digests are golden, and what is made of them: the text that is committed (written by an example, which
//! is optimised for speed, and by a test, compared byte for byte), and the file that firmware images read.

use std::fmt::Write as _;

use pldi_core::floor::FloorMode;
use pldi_core::pipeline::digest::{self, Digests, STAGES};
use pldi_core::pipeline::{FixedParams, Params, QvgaFixedPipeline, QvgaFixedWorkspace, QvgaPipeline, QvgaWorkspace};
use pldi_core::reconstruct::{FilterKind, FilterParams};
use pldi_core::templates::Templates;
use pldi_core::{Error, Floor, Frame, Intrinsics, rays};
use pldi_host::input::reduce;
use pldi_host::templates::fixed_file;
use pldi_host::trial::Trial;

/// Generated drives: five rooms.
const TRIAL: Trial = Trial { rooms: 5, frames: 12, seed: 77 };

/// Room and frame of the default trial with three candidates: what budgets are measured on.
const THREE_CANDIDATES: (u32, usize) = (6, 4);

/// Rooms and the frames of their drives, run with the defaults.
const DEFAULT: [(u32, usize); 20] = [
    (0, 1),
    (0, 4),
    (0, 6),
    (0, 11),
    (1, 0),
    (1, 3),
    (1, 7),
    (1, 10),
    (2, 2),
    (2, 5),
    (2, 8),
    (2, 11),
    (3, 1),
    (3, 4),
    (3, 6),
    (3, 9),
    (4, 0),
    (4, 3),
    (4, 5),
    (4, 9),
];

/// Those that are run with what the defaults leave out.
const POSE: [(u32, usize); 6] = [(0, 1), (0, 4), (1, 7), (2, 2), (3, 9), (4, 5)];

/// A frame and how it is run.
pub struct Golden {
    pub name: String,
    pub variant: usize,
    pub depth: Vec<u16>,
    pub colour: Vec<u8>,
    pub camera: Intrinsics,
}

/// All golden frames, each made when it is asked for.
pub fn frames() -> impl Iterator<Item = Golden> {
    let name = |(room, index), variant| format!("room {room} frame {index} {variant}");
    let three = (Trial::default(), THREE_CANDIDATES, 0, "three candidates".to_owned());
    let default = DEFAULT.iter().map(move |at| (TRIAL, *at, 0, name(*at, "default")));
    let pose = POSE.iter().map(move |at| (TRIAL, *at, 1, name(*at, "pose")));
    [three].into_iter().chain(default).chain(pose).map(|(trial, (room, index), variant, name)| {
        let recording = trial.recording(room);
        let camera = recording.sensor.intrinsics.reduced(2).unwrap();
        let capture = recording.frame(index).expect("twelve frames").capture;
        let (depth, colour) = reduce(&capture.depth, &capture.colour, 2);
        Golden { name, variant, depth, colour: colour.to_vec(), camera }
    })
}

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
    let variants = variants(&templates);
    for Golden { name, variant, depth, colour, camera } in frames() {
        let frame = Frame::new(&depth, Some(&colour)).unwrap();
        let params = &variants[variant];
        let mut line = |arithmetic: &str, sums: Result<Digests, Error>| {
            let _ = write!(text, "{name} {arithmetic}");
            for sum in sums.unwrap() {
                let _ = write!(text, " {sum:08x}");
            }
            text.push('\n');
        };
        let pipeline = QvgaPipeline::new(params, &camera).unwrap();
        line("float", digest::run(&pipeline, &frame, &templates, &mut float));
        let camera = rays::fixed::Intrinsics::new(&camera).unwrap();
        let pipeline = QvgaFixedPipeline::new(&FixedParams::new(params).unwrap(), &camera).unwrap();
        line("fixed", digest::run(&pipeline, &frame, &coded, &mut fixed));
    }
    text
}

/// The defaults, and what the defaults do not run: a known pose, and the filter without colour.
fn variants(templates: &Templates<'_>) -> [Params; 2] {
    let defaults = Params { view: *templates.view_params(), ..Params::DEFAULT };
    let floor = FloorMode::Fixed(Floor::from_pose(1.2, 0.45, 0.02).unwrap());
    let filter = FilterParams { kind: FilterKind::Bilateral, iterations: 2, ..FilterParams::DEFAULT };
    [defaults, Params { floor, filter, ..defaults }]
}
