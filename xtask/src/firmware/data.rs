//! Frames and template sets for the images: made once a run.

use std::fs;
use std::path::PathBuf;
use std::sync::OnceLock;

use crate::process::{cargo, run as run_command, target_dir};
use crate::report::Outcome;

/// What the images read and include.
const FILES: [&str; 3] = ["frames.bin", "fixed.pldt", "float.pldt"];

/// The folder with the frames (`frames.bin`) and the template sets (`fixed.pldt`, `float.pldt`); makes them if this run has
/// not done so.
///
/// # Errors
/// The outcome of a step that needs them.
pub(crate) fn folder() -> Result<PathBuf, Outcome> {
    static MADE: OnceLock<Result<PathBuf, Outcome>> = OnceLock::new();
    MADE.get_or_init(make).clone()
}

fn make() -> Result<PathBuf, Outcome> {
    let (made, folder) = (target_dir().join("firmware/made"), target_dir().join("firmware/data"));
    let line = "run --release --quiet --locked -p pldi-host --example digests -- --frames";
    match run_command(cargo(line).arg(&made)) {
        Outcome::Passed => {}
        outcome => return Err(outcome),
    }
    let failed = |error: std::io::Error| Outcome::Failed(format!("{}: {error}", folder.display()));
    fs::create_dir_all(&folder).map_err(failed)?;
    for file in FILES {
        // A file that is as it was keeps its time: the images that include it need not be built again.
        let new = fs::read(made.join(file)).map_err(failed)?;
        let to = folder.join(file);
        if fs::read(&to).ok().as_ref() != Some(&new) {
            fs::write(&to, &new).map_err(failed)?;
        }
    }
    Ok(folder)
}
