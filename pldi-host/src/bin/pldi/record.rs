//! `pldi record`: a source's frames, kept.

use std::io::IsTerminal;
use std::path::PathBuf;

use pldi_host::Error;
use pldi_host::record::{self, Counts};

use crate::args::{Limit, Source, Threads};
use crate::progress;

/// Options of `pldi record`.
///
/// The recording appears under its name when it is finished. An interrupt (Ctrl-C, termination) finishes it with the
/// frames up to there; the exit code is 130 then, for a sensor that would go on for ever as well.
#[derive(Debug, clap::Args)]
pub struct Record {
    #[command(flatten)]
    source: Source,
    /// Where to: a folder, or a file whose name ends in .mcap; it must not be there yet
    #[arg(short, long, value_name = "DIR|FILE")]
    out: PathBuf,
    #[command(flatten)]
    limit: Limit,
    #[command(flatten)]
    threads: Threads,
}

impl Record {
    /// Runs the command.
    pub fn run(&self) -> anyhow::Result<()> {
        let input = self.limit.apply(self.source.open()?);
        let count = input.frames_left().map(|count| count as u64);
        let recorder = record::create(&self.out)?;
        let bar = std::io::stderr().is_terminal().then(|| progress::bar(count));
        let each = |counts: &Counts, frame: Result<(), &Error>| {
            if let Err(error) = frame {
                let tell = || eprintln!("pldi: frame {} is left out: {error}", counts.kept + counts.failed - 1);
                bar.as_ref().map_or_else(tell, |bar| bar.suspend(tell));
            }
            if let Some(bar) = &bar {
                bar.inc(1);
                if counts.dropped > 0 {
                    bar.set_message(format!("{} lost", counts.dropped));
                }
            }
            !progress::interrupted()
        };
        let mut counts = Counts::default();
        let result = record::record(input, recorder, self.threads.count(), progress::stop(), &mut counts, each);
        if let Some(bar) = &bar {
            bar.finish_and_clear();
        }
        tell(&counts, &self.out);
        result?;
        anyhow::ensure!(!progress::interrupted(), Error::Interrupted);
        anyhow::ensure!(counts.failed == 0, "{} of {} frames failed", counts.failed, counts.kept + counts.failed);
        anyhow::ensure!(counts.kept > 0, "no frame came: nothing was recorded");
        Ok(())
    }
}

/// What became of the frames; a recording takes minutes, and its end is worth a line.
fn tell(counts: &Counts, out: &std::path::Path) {
    let Counts { kept, dropped, failed: _ } = counts;
    if *kept > 0 {
        eprintln!("{kept} frames in {}, {dropped} lost before they came", out.display());
    }
}
