//! Each stage of the core beside its truth, and its fixed-point twin beside it, on the same input.

pub mod clusters;
pub mod fixed;
pub mod frame;
pub mod ground;
pub mod numbers;
pub mod object;
pub mod twin_object;
pub mod twins;

use std::sync::LazyLock;

use pldi_core::floor::FloorAxes;
use pldi_core::pipeline::{QvgaFixedWorkspace, QvgaPipeline, QvgaWorkspace};
use pldi_core::reconstruct::{FilterKind, FilterParams};
use pldi_core::templates::Templates;
use pldi_core::{Floor, Image, Intrinsics, Params};

use pldi_host::templates::{EMBEDDED, fixed_file};

use crate::oracle::geometry::Pose;

/// An image on the heap.
pub fn boxed<T: Copy, const X: usize, const Y: usize>(value: T) -> Box<Image<T, X, Y>> {
    vec![[value; X]; Y].into_boxed_slice().try_into().unwrap_or_else(|_| unreachable!())
}

/// What a worker keeps from job to job.
pub struct Tools {
    /// The float stages' memory.
    pub workspace: Box<QvgaWorkspace>,
    /// The fixed-point stages'.
    pub fixed: Box<QvgaFixedWorkspace>,
    /// The embedded templates.
    pub templates: Templates<'static>,
    /// The same for the fixed-point pipeline.
    pub codes: Templates<'static>,
}

/// The bytes of the templates for the fixed-point pipeline.
static CODES: LazyLock<Vec<u8>> = LazyLock::new(|| fixed_file(EMBEDDED).expect("the embedded templates"));

impl Tools {
    /// Empty memory.
    pub fn new() -> Self {
        let parse = |bytes| Templates::parse(bytes).expect("the embedded templates");
        Self {
            workspace: Box::new(QvgaWorkspace::new()),
            fixed: Box::new(QvgaFixedWorkspace::new()),
            templates: parse(EMBEDDED),
            codes: parse(&CODES),
        }
    }
}

/// The pipeline with one of the filters.
pub fn pipeline(kind: FilterKind, camera: &Intrinsics) -> QvgaPipeline {
    let params = Params { filter: FilterParams { kind, ..FilterParams::DEFAULT }, ..Params::DEFAULT };
    QvgaPipeline::new(&params, camera).expect("a camera within the ranges")
}

/// A pose as the core has it, and its truth.
pub fn pose(height: f32, pitch: f32, roll: f32) -> (FloorAxes, Pose) {
    let axes = Floor::from_pose(height, pitch, roll).expect("a pose within the ranges").axes();
    (axes, Pose::new(f64::from(height), f64::from(pitch), f64::from(roll)))
}
