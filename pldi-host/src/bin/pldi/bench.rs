//! `pldi bench`: how long each stage takes, on one thread.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use pldi_core::descriptor::{self, DescriptorKind};
use pldi_core::floor::FloorMode;
use pldi_core::pipeline::{QvgaPipeline, QvgaWorkspace};
use pldi_core::{Params, matching, wavelet};
use pldi_fixtures::Recording as Generated;
use pldi_host::Error;
use pldi_host::input::{DepthScale, FrameSource, OpenOptions, QvgaFrame, Recording, reduce};

use crate::{print, templates};

/// Options of `pldi bench`.
#[derive(Debug, clap::Args)]
pub struct Bench {
    /// A recording's folder [default: the generated demo recording]
    input: Option<PathBuf>,
    /// Number of the frame [default: the demo's frame with the most candidates, or 0]
    #[arg(long, value_name = "K")]
    frame: Option<usize>,
    /// Unit of the depth images
    #[arg(long, value_name = "SCALE", default_value = "mm")]
    depth_scale: DepthScale,
    /// Time to spend on each stage, in seconds
    #[arg(long, value_name = "S", default_value_t = 1.0)]
    budget: f64,
}

/// Samples of one stage.
struct Stage {
    name: &'static str,
    times: Vec<Duration>,
}

impl Bench {
    /// Runs the command.
    pub fn run(&self) -> anyhow::Result<()> {
        anyhow::ensure!(
            (0.01..=60.0).contains(&self.budget),
            Error::Usage("--budget must lie between 0.01 and 60 s".to_owned())
        );
        let bytes = templates::read(None)?;
        let set = templates::parse(None, &bytes)?;
        let params = Params { view: *set.view_params(), ..Params::DEFAULT };
        let mut ws = Box::new(QvgaWorkspace::new());
        let frame = self.frame(&params, &set, &mut ws)?;
        let pipeline = QvgaPipeline::new(&params, &frame.intrinsics).map_err(Error::core)?;
        let input = frame.as_frame().map_err(Error::core)?;
        pipeline.run(&input, &set, &mut ws).map_err(Error::core)?;
        let floor =
            ws.report.floor.ok_or_else(|| Error::Usage("no floor in this frame: take another one".to_owned()))?;
        let candidates: Vec<usize> = ws.report.detections.iter().map(|d| usize::from(d.cluster)).collect();
        let pixels: u32 = candidates.iter().map(|c| ws.report.clusters[*c].pixels).sum();
        let (name, count) = (&frame.name, candidates.len());
        print::line(format_args!("{name}: {count} candidates with {pixels} pixels, {} templates", set.len()))?;

        let mut stages = Vec::new();
        let mut time = |name, work: &mut dyn FnMut()| stages.push(self.time(name, work));
        time("reconstruct", &mut || pipeline.reconstruct(&input, &mut ws));
        if matches!(params.floor, FloorMode::Ransac(_)) {
            time("floor", &mut || {
                std::hint::black_box(pipeline.find_floor(&mut ws));
            });
        }
        let mut failure = None;
        time("ground map", &mut || failure = pipeline.find_candidates(&floor, &mut ws).err());
        time("diffusion of the candidates", &mut || pipeline.diffuse_candidates(&mut ws));
        time("views", &mut || {
            for c in &candidates {
                std::hint::black_box(pipeline.frame_view(*c, &floor, &mut ws));
            }
        });
        let view = ws.images.view;
        let mut plane = Box::new([[0.0; wavelet::SIZE]; wavelet::SIZE]);
        let kind: DescriptorKind = params.view.descriptor;
        time("wavelets and descriptors", &mut || {
            for _ in &candidates {
                std::hint::black_box(descriptor::describe(&view, kind, &mut plane));
            }
        });
        let numbers = descriptor::describe(&view, kind, &mut plane);
        time("nearest templates", &mut || {
            for _ in &candidates {
                let _ = std::hint::black_box(matching::nearest(&set, &numbers));
            }
        });
        time("whole frame", &mut || failure = pipeline.run(&input, &set, &mut ws).err());
        time("(diffusion of the whole image)", &mut || pipeline.diffuse_all(&mut ws));
        time("(one wavelet transform)", &mut || wavelet::transform(&mut plane));
        if let Some(error) = failure {
            return Err(Error::core(error).into());
        }
        print::line(format_args!("{:32}{:>10}{:>10}", "stage, ms on one thread", "best", "median"))?;
        for Stage { name, times } in &mut stages {
            times.sort();
            let ms = |i: usize| times[i].as_secs_f64() * 1e3;
            print::line(format_args!("{name:32}{:10.3}{:10.3}", ms(0), ms(times.len() / 2)))?;
        }
        Ok(())
    }

    /// Repeats some work until the budget is used up, three times at least.
    fn time(&self, name: &'static str, work: &mut dyn FnMut()) -> Stage {
        let start = Instant::now();
        let mut times = Vec::new();
        work();
        while times.len() < 3 || start.elapsed().as_secs_f64() < self.budget {
            let before = Instant::now();
            work();
            times.push(before.elapsed());
        }
        Stage { name, times }
    }

    /// The frame to work on.
    fn frame(
        &self,
        params: &Params,
        set: &pldi_core::templates::Templates<'_>,
        ws: &mut QvgaWorkspace,
    ) -> anyhow::Result<QvgaFrame> {
        if let Some(input) = &self.input {
            let options = OpenOptions { depth_scale: self.depth_scale, ..OpenOptions::default() };
            return Ok(Recording::open(input, &options)?.frame(self.frame.unwrap_or(0))?);
        }
        let recording = Generated::demo();
        let mut best: Option<(usize, QvgaFrame)> = None;
        for i in self.frame.map_or(0..recording.len(), |k| k..k + 1) {
            let Some(generated) = recording.frame(i) else { continue };
            let (depth, colour) = reduce(&generated.capture.depth, generated.capture.colour, 2);
            let frame = QvgaFrame {
                index: i,
                stamp: generated.stamp,
                name: format!("generated demo recording, frame {i}"),
                depth,
                colour: Some(colour),
                intrinsics: recording.sensor.intrinsics.reduced(2).map_err(Error::core)?,
                factor: 2,
                original_size: (640, 480),
            };
            let pipeline = QvgaPipeline::new(params, &frame.intrinsics).map_err(Error::core)?;
            pipeline.run(&frame.as_frame().map_err(Error::core)?, set, ws).map_err(Error::core)?;
            let found = ws.report.detections.len();
            if best.as_ref().is_none_or(|(most, _)| found > *most) {
                best = Some((found, frame));
            }
        }
        best.map(|(_, frame)| frame)
            .ok_or_else(|| Error::FrameIndex { index: self.frame.unwrap_or(0), len: recording.len() }.into())
    }
}
