//! A frame in one arithmetic, with each stage to be timed.

use std::hint::black_box;
use std::time::{Duration, Instant};

use pldi_core::pipeline::{Fixed, Float, Pipeline, Workspace};
use pldi_core::templates::Templates;
use pldi_core::wavelet::{self, SIZE};
use pldi_core::{Frame, Intrinsics, Params};
use pldi_host::{Error, Numbers};

/// What is timed, in the order of the table. Those that are no part of a frame are in brackets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    Reconstruct,
    Floor,
    GroundMap,
    Diffusion,
    Views,
    Descriptors,
    Nearest,
    Whole,
    DiffusionOfAll,
    Wavelet,
}

impl Stage {
    pub const ALL: [Self; 10] = [
        Self::Reconstruct,
        Self::Floor,
        Self::GroundMap,
        Self::Diffusion,
        Self::Views,
        Self::Descriptors,
        Self::Nearest,
        Self::Whole,
        Self::DiffusionOfAll,
        Self::Wavelet,
    ];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Reconstruct => "reconstruct",
            Self::Floor => "floor",
            Self::GroundMap => "ground map",
            Self::Diffusion => "diffusion of the candidates",
            Self::Views => "views",
            Self::Descriptors => "wavelets and descriptors",
            Self::Nearest => "nearest templates",
            Self::Whole => "whole frame",
            Self::DiffusionOfAll => "(diffusion of the whole image)",
            Self::Wavelet => "(one wavelet transform)",
        }
    }
}

/// An arithmetic with its wavelet transform.
pub trait Timed: Numbers {
    /// The time of one transform.
    fn transform() -> Duration;
}

impl Timed for Float {
    fn transform() -> Duration {
        let mut plane = plane(|n| n as f32);
        timed(|| wavelet::transform(black_box(&mut plane)))
    }
}

impl Timed for Fixed {
    fn transform() -> Duration {
        let mut plane = plane(|n| i32::from(n) << 7);
        timed(|| wavelet::fixed::transform(black_box(&mut plane)))
    }
}

/// Something like a view: smooth, with edges.
fn plane<T>(number: impl Fn(u16) -> T) -> Box<[[T; SIZE]; SIZE]> {
    let value = |i: usize, j: usize| if (i / 24 + j / 40).is_multiple_of(3) { 0 } else { 30_000 + 150 * i + 80 * j };
    Box::new(std::array::from_fn(|i| std::array::from_fn(|j| number(value(i, j) as u16))))
}

fn timed<T>(work: impl FnOnce() -> T) -> Duration {
    let start = Instant::now();
    black_box(work());
    start.elapsed()
}

/// A frame in one arithmetic.
pub struct Subject<'a, A: Numbers> {
    pipeline: Pipeline<A>,
    workspace: Box<Workspace<A>>,
    frame: Frame<'a, 320, 240>,
    templates: Templates<'a>,
    floor: A::Floor,
    /// Clusters that are candidates, with their descriptors.
    candidates: Vec<(usize, A::Descriptor)>,
    /// The candidates' pixels.
    pub pixels: u32,
}

impl<'a, A: Timed> Subject<'a, A> {
    /// Takes the frame through the pipeline once.
    pub fn new(
        params: &Params,
        intrinsics: &Intrinsics,
        frame: Frame<'a, 320, 240>,
        templates: Templates<'a>,
    ) -> Result<Self, Error> {
        let pipeline = Pipeline::<A>::new(&A::params(params)?, &A::intrinsics(intrinsics)?).map_err(Error::core)?;
        let mut workspace = A::workspace();
        pipeline.run(&frame, &templates, &mut workspace).map_err(Error::core)?;
        let report = &workspace.report;
        let floor = report.floor.ok_or_else(|| Error::Usage("no floor in this frame: take another one".to_owned()))?;
        let candidates: Vec<_> = report.detections.iter().map(|d| (usize::from(d.cluster), d.descriptor)).collect();
        let pixels = candidates.iter().filter_map(|(c, _)| report.clusters.get(*c)).map(|c| c.pixels).sum();
        Ok(Self { pipeline, workspace, frame, templates, floor, candidates, pixels })
    }

    /// Number of candidates.
    pub fn candidates(&self) -> usize {
        self.candidates.len()
    }

    /// Runs a stage once. Those before it must have been run.
    pub fn time(&mut self, stage: Stage) -> Result<Duration, Error> {
        let Self { pipeline, workspace: ws, frame, templates, floor, candidates, .. } = self;
        let mut outcome = Ok(());
        let time = match stage {
            Stage::Reconstruct => timed(|| pipeline.reconstruct(frame, ws)),
            Stage::Floor => timed(|| pipeline.find_floor(ws)),
            Stage::GroundMap => timed(|| outcome = pipeline.find_candidates(floor, ws)),
            Stage::Diffusion => timed(|| pipeline.diffuse_candidates(ws)),
            Stage::Views => timed(|| {
                for (c, _) in candidates {
                    black_box(pipeline.frame_view(*c, floor, ws));
                }
            }),
            Stage::Descriptors => {
                let mut sum = Duration::ZERO;
                for (c, _) in candidates {
                    pipeline.frame_view(*c, floor, ws);
                    sum += timed(|| pipeline.describe_view(ws));
                }
                sum
            }
            Stage::Nearest => timed(|| {
                for (_, descriptor) in candidates {
                    outcome = outcome.and(A::nearest(templates, descriptor).map(|h| drop(black_box(h))));
                }
            }),
            Stage::Whole => timed(|| outcome = pipeline.run(frame, templates, ws)),
            Stage::DiffusionOfAll => timed(|| pipeline.diffuse_all(ws)),
            Stage::Wavelet => A::transform(),
        };
        outcome.map_err(Error::core)?;
        Ok(time)
    }
}
