//! `pldi trial`: generated recordings with truth, and how well they are understood.

use std::path::PathBuf;

use pldi_core::templates::Templates;
use pldi_host::Error;
use pldi_host::trial::Trial as Rooms;

use crate::args::{Processing, Threads};
use crate::templates;

/// Options of `pldi trial`.
#[derive(Debug, clap::Args)]
pub struct Trial {
    /// Template file [default: the embedded set]
    #[arg(long, value_name = "FILE")]
    templates: Option<PathBuf>,
    #[command(flatten)]
    processing: Processing,
    /// Rooms that are generated, each with held-out objects of its own
    #[arg(long, value_name = "N", default_value_t = 48, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    rooms: u32,
    /// Frames of each room's drive
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u16).range(1..=10_000))]
    frames: u16,
    /// Seed of rooms, paths and noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// List what went wrong
    #[arg(long)]
    list: bool,
    /// Write the recording of one room as a folder in place of the trial: to look at, and for pldi run
    #[arg(long, value_names = ["ROOM", "DIR"], num_args = 2)]
    write: Option<Vec<String>>,
    #[command(flatten)]
    threads: Threads,
}

impl Trial {
    /// Runs the command.
    pub fn run(&self) -> anyhow::Result<()> {
        let arithmetic = self.processing.arithmetic();
        let bytes = templates::read_for(self.templates.as_deref(), arithmetic)?;
        let set: Templates<'_> = templates::parse(self.templates.as_deref(), &bytes)?;
        let params = self.processing.params(*set.view_params());
        let rooms = Rooms { rooms: self.rooms, frames: usize::from(self.frames), seed: self.seed };
        if let Some([room, folder]) = self.write.as_deref() {
            let room: u32 = room.parse().map_err(|_| Error::Usage(format!("{room} is no number of a room")))?;
            let folder = PathBuf::from(folder);
            let written = pldi_fixtures::write_tum(&rooms.recording(room), &format!("room {room}"), &folder);
            return Ok(written.map_err(|cause| Error::Write { path: folder, cause })?);
        }
        let bar = crate::progress::bar(Some(self.rooms.into()));
        let outcome = rooms.run(arithmetic, &params, &set, self.threads.count(), || {
            bar.inc(1);
            !crate::progress::interrupted()
        })?;
        bar.finish_and_clear();
        let classes: Vec<String> = set.classes().map(str::to_owned).collect();
        if self.list {
            for s in &outcome.sightings {
                let taken = match (&s.verdict.answer, s.verdict.reason) {
                    (Some(_), _) if s.verdict.is_right() => continue,
                    (Some((class, score)), _) => format!("taken for {class} ({score:.2})"),
                    (None, Some(reason)) => format!("rejected: {reason}"),
                    (None, None) => "no cluster".to_owned(),
                };
                let (truth, distance) = (&s.verdict.truth, s.verdict.truth.distance);
                println!(
                    "room {} frame {}: {} {} at {distance:.2} m {taken}",
                    s.room, s.frame, truth.class, truth.object
                );
            }
        }
        println!("{}", outcome.confusion(&classes));
        println!(
            "{} frames, {} whole un-occluded objects within the sensory area: found {:.1} %, macro recall with the others counted as missed {:.1} %; {} candidates are no whole object",
            outcome.frames,
            outcome.sightings.len(),
            100.0 * outcome.found_share(),
            100.0 * outcome.strict_recall(&classes),
            outcome.strays
        );
        Ok(())
    }
}
