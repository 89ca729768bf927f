//! `pldi bench`: how long each stage takes, on one thread, in floats and in integers.

mod subject;

use std::time::{Duration, Instant};

use pldi_core::Params;
use pldi_core::pipeline::{Fixed, Float};
use pldi_core::templates::Templates;
use pldi_fixtures::Recording as Generated;
use pldi_host::input::{self, DepthScale, OpenOptions, QvgaFrame, reduce};
use pldi_host::{ArithmeticKind, Engine, Error, Numbers};

use crate::{print, progress, templates};
use subject::{Stage, Subject, Timed};

/// The two arithmetics take turns so often on each stage, so that a change of the machine's load meets both.
const TURNS: u32 = 8;

/// Options of `pldi bench`.
///
/// Float and fixed-point arithmetic stand side by side; the ratio is fixed/float, of the best times.
#[derive(Debug, clap::Args)]
pub struct Bench {
    /// A recording's folder [default: the generated demo recording]
    input: Option<String>,
    /// Number of the frame [default: the demo's frame with the most candidates, or 0]
    #[arg(long, value_name = "K")]
    frame: Option<usize>,
    /// Unit of the depth images
    #[arg(long, value_name = "SCALE", default_value = "mm")]
    depth_scale: DepthScale,
    /// Time to spend on each stage in each arithmetic, in seconds
    #[arg(long, value_name = "S", default_value_t = 1.0)]
    budget: f64,
}

impl Bench {
    /// Runs the command.
    pub fn run(&self) -> anyhow::Result<()> {
        anyhow::ensure!(
            (0.01..=60.0).contains(&self.budget),
            Error::Usage("--budget must lie between 0.01 and 60 s".to_owned())
        );
        let bytes = templates::read(None)?;
        let codes = templates::read_for(None, ArithmeticKind::Fixed)?;
        let (set, coded) = (templates::parse(None, &bytes)?, templates::parse(None, &codes)?);
        let params = Params { view: *set.view_params(), ..Params::DEFAULT };
        let frame = self.frame(&params, &set)?;
        let input = frame.as_frame().map_err(Error::core)?;
        let mut float = Subject::<Float>::new(&params, &frame.intrinsics, input, set)?;
        let mut fixed = Subject::<Fixed>::new(&params, &frame.intrinsics, input, coded)?;
        print::line(format_args!(
            "{}: {} candidates with {} pixels (fixed: {} with {}), {} templates",
            frame.name,
            float.candidates(),
            float.pixels,
            fixed.candidates(),
            fixed.pixels,
            set.len()
        ))?;
        print::line(format_args!("{:32}{:^20}{:^20}{:>10}", "", "float", "fixed", "fixed"))?;
        let (name, columns) = ("stage, ms on one thread", ["best", "median", "best", "median", "/float"]);
        let [a, b, c, d, e] = columns;
        print::line(format_args!("{name:32}{a:>10}{b:>10}{c:>10}{d:>10}{e:>10}"))?;
        for stage in Stage::ALL {
            let (a, b) = self.compare(stage, &mut float, &mut fixed)?;
            let ratio = b.best / a.best;
            print::line(format_args!(
                "{:32}{:10.3}{:10.3}{:10.3}{:10.3}{ratio:10.2}",
                stage.name(),
                a.best,
                a.median,
                b.best,
                b.median
            ))?;
        }
        Ok(())
    }

    /// Times a stage in both arithmetics, in turns.
    fn compare<A: Timed, B: Timed>(
        &self,
        stage: Stage,
        a: &mut Subject<'_, A>,
        b: &mut Subject<'_, B>,
    ) -> Result<(Times, Times), Error> {
        let (mut times_a, mut times_b) = (Vec::new(), Vec::new());
        for _ in 0..TURNS {
            self.turn(stage, a, &mut times_a)?;
            self.turn(stage, b, &mut times_b)?;
        }
        Ok((Times::new(times_a), Times::new(times_b)))
    }

    /// Repeats a stage until the turn's share of the budget is used up, once at least.
    fn turn<A: Timed>(
        &self,
        stage: Stage,
        subject: &mut Subject<'_, A>,
        times: &mut Vec<Duration>,
    ) -> Result<(), Error> {
        // The other arithmetic has filled the caches.
        subject.time(stage)?;
        let start = Instant::now();
        loop {
            times.push(subject.time(stage)?);
            if start.elapsed().as_secs_f64() >= self.budget / f64::from(TURNS) {
                return Ok(());
            }
        }
    }

    /// The frame to work on.
    fn frame(&self, params: &Params, set: &Templates<'_>) -> anyhow::Result<QvgaFrame> {
        if let Some(input) = &self.input {
            let options = OpenOptions { depth_scale: self.depth_scale, ..OpenOptions::default() };
            return Ok(input::open(input, &options)?.frame(self.frame.unwrap_or(0), progress::stop())?.qvga);
        }
        let recording = Generated::demo();
        let intrinsics = recording.sensor.intrinsics.reduced(2).map_err(Error::core)?;
        let mut engine = Engine::new(ArithmeticKind::Float, params, &intrinsics)?;
        let mut workspace = Float::workspace();
        let mut best: Option<(usize, QvgaFrame)> = None;
        for i in self.frame.map_or(0..recording.len(), |k| k..k + 1) {
            let Some(generated) = recording.frame(i) else { continue };
            let (depth, colour) = reduce(&generated.capture.depth, &generated.capture.colour, 2);
            let frame = QvgaFrame {
                index: i,
                stamp: generated.stamp,
                name: format!("generated demo recording, frame {i}"),
                depth,
                colour: Some(colour),
                intrinsics,
                factor: 2,
                original_size: (640, 480),
            };
            engine.run(&frame.as_frame().map_err(Error::core)?, set, &mut workspace)?;
            let found = workspace.report.detections.len();
            if best.as_ref().is_none_or(|(most, _)| found > *most) {
                best = Some((found, frame));
            }
        }
        best.map(|(_, frame)| frame)
            .ok_or_else(|| Error::FrameIndex { index: self.frame.unwrap_or(0), len: recording.len() }.into())
    }
}

/// What is told of a stage's times, in ms.
struct Times {
    best: f64,
    median: f64,
}

impl Times {
    fn new(mut times: Vec<Duration>) -> Self {
        times.sort();
        let ms = |i: usize| times.get(i).map_or(0.0, |t| t.as_secs_f64() * 1e3);
        Self { best: ms(0), median: ms(times.len() / 2) }
    }
}
