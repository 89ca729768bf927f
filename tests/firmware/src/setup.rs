//! Camera and parameters of the golden frames, as constants: nothing of it is computed on the board.

use pldi_core::floor::{FloorMode, RansacParams};
use pldi_core::pipeline::{FixedParams, Params, QvgaFixedPipeline};
use pldi_core::reconstruct::{FilterKind, FilterParams};
use pldi_core::{Floor, Intrinsics, rays};

/// The generated recordings' camera.
pub const CAMERA: Intrinsics = Intrinsics { width: 320, height: 240, fx: 285.63, fy: 285.63, cx: 159.75, cy: 119.75 };

/// The pose's normal as [`Floor::from_pose`] gives it, which is no constant function.
const POSE: [f32; 3] = [-0.018_007_742, -0.900_267_06, -0.434_965_52];

/// The defaults, and what the defaults do not run: a known pose (1.2 m, pitch 0.45 rad, roll 0.02 rad), and the filter
/// without colour.
pub const VARIANTS: [Params; 2] = [
    Params { floor: FloorMode::Ransac(RansacParams::DEFAULT), ..Params::DEFAULT },
    Params {
        floor: FloorMode::Fixed(Floor { normal: POSE, height: 1.2 }),
        filter: FilterParams { kind: FilterKind::Bilateral, iterations: 2, ..FilterParams::DEFAULT },
        ..Params::DEFAULT
    },
];

/// The pipelines in integers: they lie in flash.
pub static FIXED: [QvgaFixedPipeline; 2] = [fixed(&VARIANTS[0]), fixed(&VARIANTS[1])];

const fn fixed(params: &Params) -> QvgaFixedPipeline {
    let (Ok(params), Ok(camera)) = (FixedParams::new(params), rays::fixed::Intrinsics::new(&CAMERA)) else {
        panic!("a parameter is out of range");
    };
    match QvgaFixedPipeline::constant(&params, &camera) {
        Ok(pipeline) => pipeline,
        Err(_) => panic!("a parameter is out of range"),
    }
}
