//! `pldi run`: a source's frames, one JSON line each.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use indicatif::ProgressBar;
use pldi_core::templates::Templates;
use pldi_host::output::atomic;
use pldi_host::output::mcap::{FrameMessages, Results};
use pldi_host::overlay;
use pldi_host::runner::{self, FrameResult, Job, Processed};
use pldi_host::{ArithmeticKind, Engine, Error};

use crate::args::{Limit, Processing, Source, Threads};
use crate::rerun::{self, Rerun};
use crate::serial::FromSerial;
use crate::{print, progress, templates};

/// Options of `pldi run`.
///
/// On an interrupt (Ctrl-C, termination) the frames that are done stay written and the exit code is 130.
#[derive(Debug, clap::Args)]
#[command(mut_arg("input", |input| input.required(false).required_unless_present("path")))]
pub struct Run {
    #[command(flatten)]
    input: Option<Source>,
    #[command(flatten)]
    limit: Limit,
    #[command(flatten)]
    serial: FromSerial,
    /// The template file [default: the embedded set]
    #[arg(long, value_name = "FILE")]
    templates: Option<PathBuf>,
    #[command(flatten)]
    processing: Processing,
    /// Folder for a picture of each frame (NNNN.png: candidates' outlines, their classes, the map of the floor); made
    /// where it is missing
    #[arg(long, value_name = "DIR")]
    overlay: Option<PathBuf>,
    /// MCAP file (ROS 2) of the results, for a viewer to show beside the recording: the candidates as detections and as
    /// markers, and the light-diffusion image of each frame
    #[arg(long, value_name = "FILE")]
    mcap: Option<PathBuf>,
    #[command(flatten)]
    rerun: Rerun,
    /// Leave out frames that fail and go on; the exit code is still 1
    #[arg(long)]
    keep_going: bool,
    #[command(flatten)]
    threads: Threads,
}

impl Run {
    /// Runs the command.
    pub fn run(&self) -> anyhow::Result<()> {
        let file = self.templates.as_deref();
        if let Some(path) = self.serial.path() {
            let bytes = templates::read_for(file, ArithmeticKind::Fixed)?;
            return self.serial.listen(path, templates::parse(file, &bytes)?);
        }
        // Without it there is a path: the parser sees to that.
        let Some(input) = &self.input else { return Err(Error::Usage("which recording?".to_owned()).into()) };
        let arithmetic = self.processing.arithmetic();
        let bytes = templates::read_for(file, arithmetic)?;
        let set = templates::parse(file, &bytes)?;
        let params = self.processing.params(*set.view_params());
        Engine::check(arithmetic, &params)?;
        set.require(params.view.hash(), arithmetic.encoding()).map_err(|cause| {
            let name = file.map_or("the embedded templates".to_owned(), |f| f.display().to_string());
            Error::Usage(format!("{name}: {cause}"))
        })?;
        let (threads, stop, name) = (self.threads.count(), progress::stop(), input.name());
        let input = self.limit.apply(input.open()?);
        if let Some(folder) = &self.overlay {
            std::fs::create_dir_all(folder).map_err(|cause| Error::Write { path: folder.clone(), cause })?;
        }
        let mcap = self.mcap.as_deref().map(Results::create).transpose()?;
        let viewer = self.rerun.open(name, stop)?;
        let mut sink = Sink {
            keep_going: self.keep_going,
            overlay: self.overlay.as_deref(),
            mcap,
            viewer,
            frames: 0,
            failed: 0,
            dropped: 0,
            bar: None,
        };
        if std::io::stderr().is_terminal() {
            sink.bar = Some(progress::bar(input.frames_left().map(|count| count as u64)));
        }
        let look = |processed: &mut Processed<'_>| self.show(&set, processed);
        let job = Job { arithmetic, params: &params, templates: &set, threads, stop };
        let result = runner::run(input, &job, look, |i, r| sink.take(i, r));
        if let Some(bar) = &sink.bar {
            bar.finish_and_clear();
        }
        if sink.dropped > 0 {
            eprintln!("pldi: {} frames were lost between the {} that came", sink.dropped, sink.frames);
        }
        let finished = sink.mcap.map_or(Ok(()), |file| file.end(result.is_ok()));
        let shown = sink.viewer.end(result.is_ok());
        result?;
        finished?;
        shown?;
        // The source gave up waiting.
        anyhow::ensure!(!progress::interrupted(), Error::Interrupted);
        let (failed, count) = (sink.failed, sink.frames);
        anyhow::ensure!(failed == 0, "{failed} of {count} frames failed");
        Ok(())
    }

    /// What is shown of a frame beside its line.
    fn show(&self, set: &Templates<'_>, seen: &mut Processed<'_>) -> Result<Shown, Error> {
        let picture = self.overlay.as_ref().map(|_| overlay::draw(seen, set).to_png()).transpose()?;
        let messages = self.mcap.as_ref().map(|_| FrameMessages::new(seen)).transpose()?;
        Ok(Shown { picture, messages, scene: self.rerun.scene(seen)? })
    }
}

/// What is shown of a frame, as far as it is wanted.
struct Shown {
    /// A PNG file.
    picture: Option<Vec<u8>>,
    messages: Option<FrameMessages>,
    scene: rerun::Shown,
}

/// Where the results go.
struct Sink<'a> {
    keep_going: bool,
    overlay: Option<&'a Path>,
    mcap: Option<Results>,
    viewer: rerun::Stream,
    /// Number of frames that came.
    frames: usize,
    /// Number of them that failed.
    failed: usize,
    /// Number of frames that were lost before they came.
    dropped: u64,
    /// Only on a terminal.
    bar: Option<ProgressBar>,
}

impl Sink<'_> {
    /// Takes the result of frame `index`; whether to go on.
    fn take(&mut self, index: usize, result: Result<FrameResult<Shown>, Error>) -> anyhow::Result<bool> {
        self.frames += 1;
        match result {
            Ok(FrameResult { report, dropped, extra }) => {
                self.dropped += dropped;
                if let (Some(folder), Some(png)) = (self.overlay, extra.picture) {
                    atomic::write_bytes(&folder.join(format!("{index:04}.png")), &png)?;
                }
                if let (Some(file), Some(messages)) = (&mut self.mcap, extra.messages) {
                    file.add(&messages)?;
                }
                let line = serde_json::to_string(&report)?;
                self.say(|| print::line(line))?;
                self.viewer.show(extra.scene, progress::stop())?;
            }
            // What is wrong with the call is wrong with every frame.
            Err(error) if self.keep_going && !error.is_usage() => {
                self.failed += 1;
                self.say(|| eprintln!("pldi: frame {index}: {error}"));
            }
            Err(error) => return Err(anyhow::Error::from(error).context(format!("frame {index}"))),
        }
        if let Some(bar) = &self.bar {
            bar.inc(1);
        }
        if progress::interrupted() { Err(Error::Interrupted.into()) } else { Ok(true) }
    }

    /// Writes something that must not land in the middle of the progress bar.
    fn say<T>(&self, write: impl FnOnce() -> T) -> T {
        match &self.bar {
            Some(bar) => bar.suspend(write),
            None => write(),
        }
    }
}
