//! Writing results to stdout: what cannot be written is an error, where `println!` would panic (a closed pipe, a full
//! disk).

use std::fmt::Display;
use std::io::Write;

use anyhow::Context;

/// Writes a text and a line feed at once, so that whoever reads along (or looks after an interrupt) never sees half of it.
pub fn line(text: impl Display) -> anyhow::Result<()> {
    let text = format!("{text}\n");
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).context("cannot write to stdout")
}
