//! `pldi inspect`: what a recording is like.

use std::io::IsTerminal;

use pldi_host::inspect;

use crate::args::Source;
use crate::{print, progress};

/// Options of `pldi inspect`.
#[derive(Debug, clap::Args)]
pub struct Inspect {
    #[command(flatten)]
    input: Source,
    /// Look at so many frames, evenly spread
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u16).range(1..))]
    frames: u16,
    /// JSON in place of a table
    #[arg(long)]
    json: bool,
}

impl Inspect {
    /// Runs the command.
    pub fn run(&self) -> anyhow::Result<()> {
        let input = self.input.open()?;
        let frames = usize::from(self.frames);
        let bar = std::io::stderr()
            .is_terminal()
            .then(|| progress::bar(Some(input.frames_left().map_or(frames, |n| n.min(frames)) as u64)));
        let each = || {
            if let Some(bar) = &bar {
                bar.inc(1);
            }
            !progress::interrupted()
        };
        let summary = inspect::inspect(input, frames, progress::stop(), each);
        if let Some(bar) = &bar {
            bar.finish_and_clear();
        }
        let summary = summary?;
        if self.json {
            print::line(serde_json::to_string(&summary)?)?;
        } else {
            print::line(summary.to_string().trim_end())?;
        }
        let failed = summary.unreadable.len();
        anyhow::ensure!(failed == 0, "{failed} of the {} frames looked at cannot be read", summary.looked_at);
        Ok(())
    }
}
