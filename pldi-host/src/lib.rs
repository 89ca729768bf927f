//! The library behind the command `pldi`: RGB-D recordings in, templates from meshes, files out.
//!
//! Everything that decides what is recognised lives in `pldi_core`; this crate brings frames to it and results away.

pub mod error;
pub mod input;
pub mod mesh;
pub mod output;
pub mod parallel;
pub mod stages;
pub mod templates;

pub use error::Error;
