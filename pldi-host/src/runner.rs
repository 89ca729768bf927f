//! A source's frames through the pipeline, on several threads, with the results in order.

use std::sync::mpsc::Receiver;

use pldi_core::pipeline::{Params, QvgaWorkspace};
use pldi_core::templates::Templates;

use crate::input::{Frame, Input, RawFrame, Stop, ahead};
use crate::parallel;
use crate::report::FrameReport;
use crate::{ArithmeticKind, Engine, Error};

/// How frames are processed.
#[derive(Debug, Clone, Copy)]
pub struct Job<'a> {
    /// In floats or integers.
    pub arithmetic: ArithmeticKind,
    /// All parameters of the pipeline.
    pub params: &'a Params,
    /// What candidates are compared with.
    pub templates: &'a Templates<'a>,
    /// Number of threads that compute.
    pub threads: usize,
    /// Ends the waiting for a source.
    pub stop: &'a Stop,
}

/// The result of a frame, and what the caller wanted besides.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameResult<T> {
    /// What was recognised.
    pub report: FrameReport,
    /// Frames lost between this and the one before.
    pub dropped: u64,
    /// What `look` made of the frame.
    pub extra: T,
}

/// A frame that went through the pipeline, with everything the stages left behind.
#[derive(Debug)]
pub struct Processed<'a> {
    /// The frame.
    pub frame: &'a Frame,
    /// What it went through.
    pub engine: &'a mut Engine,
    /// What the stages left, the core's report included.
    pub workspace: &'a mut QvgaWorkspace,
    /// What is reported.
    pub report: &'a FrameReport,
}

impl Processed<'_> {
    /// N of the whole image, 65535 = 1, in place of the candidates' in the workspace; nothing else there changes. It
    /// takes longer than all of the candidates.
    pub fn whole_n(&mut self) -> &[u16] {
        self.engine.diffuse_all(self.workspace);
        self.workspace.images.n.as_flattened()
    }
}

/// What a worker keeps from frame to frame: its memory, and the tables for the last frame's camera.
struct Worker {
    engine: Option<Engine>,
    workspace: Box<QvgaWorkspace>,
}

/// Takes all frames of `input` through the pipeline, with a thread more that reads ahead. `look` sees each processed frame on its worker's thread (`|_| Ok(())` where the report is enough); `sink` gets the
/// results on the calling thread, in the frames' order, whatever the number of threads, and ends the work early by
/// returning `Ok(false)`. A frame that fails hands its error to the sink, which decides whether to go on; behind an error of
/// the source itself nothing comes. Memory does not grow with the number of frames.
///
/// # Errors
/// `Core` where a parameter is out of range or the templates were made with other view parameters or for the other
/// arithmetic, `Usage` where the arithmetic lacks the filter, before any frame is read; and what `sink` returns.
pub fn run<T: Send, E: From<Error>>(
    input: Input,
    job: &Job<'_>,
    look: impl Fn(&mut Processed<'_>) -> Result<T, Error> + Sync,
    sink: impl FnMut(usize, Result<FrameResult<T>, Error>) -> Result<bool, E>,
) -> Result<(), E> {
    let Job { arithmetic, params, templates, threads, stop } = *job;
    Engine::check(arithmetic, params)?;
    templates.require(params.view.hash(), arithmetic.encoding()).map_err(|e| Error::core(e.into()))?;
    let (source, preparation) = input.into_parts();
    let state = || Worker { engine: None, workspace: Box::new(QvgaWorkspace::new()) };
    let work = |worker: &mut Worker, index: usize, raw: Result<RawFrame, Error>| {
        let frame = preparation.frame(index, raw?)?;
        let engine = match worker.engine.take() {
            Some(engine) if *engine.intrinsics() == frame.qvga.intrinsics => engine,
            _ => Engine::new(arithmetic, params, &frame.qvga.intrinsics)?,
        };
        let (engine, workspace) = (worker.engine.insert(engine), &mut worker.workspace);
        engine.run(&frame.qvga.as_frame().map_err(Error::core)?, templates, workspace)?;
        let report = FrameReport::new(&frame.qvga, &workspace.report, engine, templates);
        let extra = look(&mut Processed { frame: &frame, engine, workspace, report: &report })?;
        Ok(FrameResult { report, dropped: frame.dropped, extra })
    };
    let take = |frames: Receiver<_>| parallel::for_each_ordered(frames, threads, state, work, sink);
    ahead::with_frames(source, stop, take)?
}
