//! The library behind the command `pldi`: RGB-D recordings in, templates from meshes, files out.
//!
//! Everything that decides what is recognised lives in `pldi_core`; this crate brings frames to it and results away.

pub mod demo;
pub mod error;
pub mod input;
pub mod inspect;
pub mod mesh;
pub mod output;
pub mod overlay;
pub mod parallel;
pub mod report;
pub mod runner;
pub mod stages;
pub mod templates;
pub mod trial;

pub use error::Error;
