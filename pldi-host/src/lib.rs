//! The library behind the command `pldi`: RGB-D recordings in, templates from meshes, files out.
//!
//! Everything that decides what is recognised lives in `pldi_core`; this crate brings frames to it and results away.
//!
//! ```
//! use pldi_core::Params;
//! use pldi_core::templates::Templates;
//! use pldi_host::input::{self, OpenOptions, Stop};
//! use pldi_host::runner::{self, Job};
//! use pldi_host::{ArithmeticKind, templates};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # let folder = folder.path();
//! // A recording as users have them: here two frames of the generated one.
//! let mut generated = pldi_fixtures::Recording::demo();
//! generated.path.truncate(2);
//! pldi_fixtures::write_tum(&generated, "demo", folder)?;
//!
//! // A folder, a bag or a device.
//! let uri = folder.to_str().ok_or("a name in UTF-8")?;
//! let recording = input::open(uri, &OpenOptions::default())?;
//! let set = Templates::parse(templates::EMBEDDED)?;
//! let params = Params { view: *set.view_params(), ..Params::DEFAULT };
//! let mut found = 0;
//! let (arithmetic, stop) = (ArithmeticKind::Float, Stop::default());
//! let job = Job { arithmetic, params: &params, templates: &set, threads: 1, stop: &stop };
//! runner::run::<_, pldi_host::Error>(recording, &job, |_| Ok(()), |index, result| {
//!     for detection in &result?.report.detections {
//!         println!("frame {index}: {} at {:?}", detection.results[0].class_id, detection.center);
//!         found += 1;
//!     }
//!     Ok(true)
//! })?;
//! assert!(found >= 2);
//! # Ok(())
//! # }
//! ```

pub mod demo;
pub mod engine;
pub mod error;
pub mod input;
pub mod inspect;
pub mod mesh;
pub mod numbers;
pub mod output;
pub mod overlay;
pub mod parallel;
pub mod record;
pub mod report;
pub mod runner;
pub mod serial;
pub mod stages;
pub mod templates;
pub mod trial;
#[cfg(feature = "rerun")]
pub mod viewer;

pub use engine::Engine;
pub use error::Error;
pub use numbers::{ArithmeticKind, Numbers};
