//! Template sets: made from meshes, written, summarised, and tried on themselves.

pub mod build;
pub mod evaluate;
pub mod fixed;
pub mod write;

pub use build::{Builder, Look, ObjectMesh, procedural};
pub use evaluate::{Confusion, leave_one_object_out};
pub use fixed::{fixed_file, for_arithmetic};
pub use write::{TemplateSet, View};

/// The set that is built into the library: the procedural furniture, through the sensor's simulation, at default
/// parameters.
pub static EMBEDDED: &[u8] = include_bytes!("../../assets/furniture.pldt");
