//! Images built for a board.

use std::fs;
use std::path::PathBuf;

use super::board::Board;
use super::data;
use crate::nostd::{self, Toolchain};
use crate::process::{run as run_command, target_dir};
use crate::report::Outcome;
use crate::symbols::rust_lld;

/// Builds a program of `tests/firmware` (`bin`) with some of its features (separated by commas, maybe none) for a board;
/// returns the image's path.
///
/// # Errors
/// The outcome of a step that needs the image.
pub(crate) fn build(board: Board, features: &str, bin: &str) -> Result<PathBuf, Outcome> {
    let Some(toolchain) = nostd::toolchain(board.target) else { return Err(nostd::missing(board.target)) };
    let data = data::folder()?;
    let line = format!(
        "build --release --locked --manifest-path tests/firmware/Cargo.toml --target {} --bin {bin} --features {},{features}",
        board.target, board.name
    );
    let line = line.trim_end_matches(',');
    // One folder for all: what runs on this machine (macros, build scripts) is built once. Flags are part of the names that
    // cargo gives its files, so that two boards of one target leave each other's alone.
    let folder = target_dir().join("firmware");
    let mut command = nostd::cargo_for(toolchain, line, &folder);
    // Without it, the image `log` would hold no events but errors.
    command.env("PLDI_FIRMWARE_DATA", data).env("DEFMT_LOG", "trace");
    let variable = format!("CARGO_TARGET_{}", board.target.to_uppercase().replace(['-', '.'], "_"));
    if !board.cpu.is_empty() {
        command.env(format!("{variable}_RUSTFLAGS"), format!("-Ctarget-cpu={}", board.cpu));
    }
    // Debian's compiler comes without a linker of its own.
    if let (Toolchain::Debian, Some(linker)) = (toolchain, rust_lld()) {
        command.env(format!("{variable}_LINKER"), linker);
    }
    match run_command(&mut command) {
        Outcome::Passed => {}
        outcome => return Err(outcome),
    }
    // The next image of the same target takes this one's place.
    let made = folder.join(board.target).join("release").join(bin);
    let features = features.replace(',', "-");
    let image = folder.join("images").join(format!("{bin}-{}-{features}", board.name).trim_end_matches('-'));
    let copied = fs::create_dir_all(folder.join("images")).and_then(|()| fs::copy(&made, &image));
    match copied {
        Ok(_) => Ok(image),
        Err(error) => Err(Outcome::Failed(format!("{}: {error}", image.display()))),
    }
}
