//! `pldi demo`: a recording made on the spot, and what is recognised in it beside the truth.

use std::fmt::Write as _;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;
use pldi_host::input::{self, OpenOptions};
use pldi_host::output::{atomic, png};
use pldi_host::runner::Job;
use pldi_host::trial::{Standing, Verdict};
use pldi_host::{Engine, Error, demo};

use crate::args::{Processing, Threads};
use crate::{progress, templates};

/// The frame that `--picture` shows.
const PICTURED: usize = 10;

/// Options of `pldi demo`.
#[derive(Debug, clap::Args)]
pub struct Demo {
    /// Folder for the recording, the results and the pictures; made where it is missing
    #[arg(long, value_name = "DIR", default_value = "pldi-demo")]
    out: PathBuf,
    /// Also write one frame as a single picture: colour, N, candidates and the map of the floor
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    #[command(flatten)]
    processing: Processing,
    #[command(flatten)]
    threads: Threads,
}

impl Demo {
    /// Runs the command.
    pub fn run(&self) -> anyhow::Result<()> {
        let arithmetic = self.processing.arithmetic();
        let bytes = templates::read_for(None, arithmetic)?;
        let set = templates::parse(None, &bytes)?;
        let params = self.processing.params(*set.view_params());
        Engine::check(arithmetic, &params)?;
        let (folder, pictures) = (self.out.join("recording"), self.out.join("overlay"));
        std::fs::create_dir_all(&pictures).map_err(|cause| Error::Write { path: pictures.clone(), cause })?;
        let bar = std::io::stderr().is_terminal().then(|| progress::bar(Some(0)));
        let step = || {
            if let Some(bar) = &bar {
                bar.inc(1);
            }
            !progress::interrupted()
        };
        let frames = pldi_fixtures::Recording::demo().len();
        if let Some(bar) = &bar {
            bar.set_length(2 * frames as u64);
        }
        let truth = demo::write(&folder, self.threads.count(), step)?;
        let uri = folder.to_str().context("the folder's name is not UTF-8")?;
        let open = || input::open(uri, &OpenOptions::default());
        let (threads, stop) = (self.threads.count(), progress::stop());
        let job = Job { arithmetic, params: &params, templates: &set, threads, stop };
        let (mut lines, mut shown) = (Vec::new(), Vec::new());
        demo::recognise(open()?, &truth, &job, |i, frame| {
            atomic::write_bytes(&pictures.join(format!("{i:04}.png")), &frame.picture)?;
            serde_json::to_writer(&mut lines, &frame.report)?;
            lines.push(b'\n');
            shown.push(frame.verdicts);
            if step() { Ok(true) } else { Err(anyhow::Error::from(Error::Interrupted)) }
        })?;
        if let Some(bar) = &bar {
            bar.finish_and_clear();
        }
        let results = self.out.join("detections.jsonl");
        atomic::write_bytes(&results, &lines)?;
        if let Some(file) = &self.picture {
            let canvas = demo::composite(open()?.frame(PICTURED, stop)?, arithmetic, &params, &set)?;
            png::write_rgb8(file, canvas.dimensions(), canvas.pixels())?;
        }
        let text = table(&shown) + &summary(&shown, &folder, &results, &pictures);
        let mut out = std::io::stdout().lock();
        out.write_all(text.as_bytes()).and_then(|()| out.flush()).context("cannot write to stdout")
    }
}

/// A row for each object in each frame.
fn table(shown: &[Vec<Verdict>]) -> String {
    let mut text = "frame  object         distance  answer         score\n".to_owned();
    for (i, verdicts) in shown.iter().enumerate() {
        for v in verdicts {
            let (class, score) = match &v.answer {
                Some((class, score)) => (class.as_str(), format!("{score:.2}")),
                None => ("-", String::new()),
            };
            let (object, distance) = (&v.truth.class, v.truth.distance);
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{i:>5}  {object:13} {distance:>7.2} m  {class:13} {score:>6}  {}", outcome(v));
        }
    }
    text
}

/// What to think of an answer.
fn outcome(v: &Verdict) -> String {
    match (v.standing, &v.answer, v.reason) {
        (Standing::Whole, Some(_), _) if v.is_right() => "right".to_owned(),
        (Standing::Whole, Some(_), _) => "wrong".to_owned(),
        (Standing::Whole, None, Some(reason)) => format!("missed: {reason}"),
        (Standing::Whole, None, None) => "missed".to_owned(),
        (standing, ..) => standing.name().to_owned(),
    }
}

/// Counts, and where everything is.
fn summary(shown: &[Vec<Verdict>], recording: &Path, results: &Path, pictures: &Path) -> String {
    let all: Vec<&Verdict> = shown.iter().flatten().collect();
    let whole: Vec<&&Verdict> = all.iter().filter(|v| v.standing == Standing::Whole).collect();
    let right = whole.iter().filter(|v| v.is_right()).count();
    let missed = whole.iter().filter(|v| v.answer.is_none()).count();
    format!(
        "\n{right} of {} whole, unoccluded objects in {} frames are right, {} wrong, {missed} missed; {} more are occluded, \
         cut by the image or outside the sensory area\nrecording: {}\nresults:   {}\npictures:  {}\n",
        whole.len(),
        shown.len(),
        whole.len() - right - missed,
        all.len() - whole.len(),
        recording.display(),
        results.display(),
        pictures.display()
    )
}
