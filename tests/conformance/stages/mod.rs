//! Each stage of the core beside its truth, and its fixed-point twin beside it, on the same input.

pub mod filter;
pub mod fixed;
pub mod frame;
pub mod ground;
pub mod numbers;
pub mod object;

use pldi_core::floor::FloorAxes;
use pldi_core::pipeline::{QvgaPipeline, QvgaWorkspace};
use pldi_core::reconstruct::{FilterKind, FilterParams};
use pldi_core::{Floor, Image, Intrinsics, Params};

use crate::oracle::geometry::Pose;

/// An image on the heap.
pub fn boxed<T: Copy, const X: usize, const Y: usize>(value: T) -> Box<Image<T, X, Y>> {
    vec![[value; X]; Y].into_boxed_slice().try_into().unwrap_or_else(|_| unreachable!())
}

/// What a worker keeps from job to job.
pub struct Tools {
    /// The float stages' memory.
    pub workspace: Box<QvgaWorkspace>,
    /// The fixed-point filter's.
    pub filter: Box<filter::Memory>,
}

impl Tools {
    /// Empty memory.
    pub fn new() -> Self {
        Self { workspace: Box::new(QvgaWorkspace::new()), filter: Box::new(filter::Memory::new()) }
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
