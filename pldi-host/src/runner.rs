//! A source's frames through the pipeline, on several threads, with the results in order.

use pldi_core::Intrinsics;
use pldi_core::pipeline::{Params, QvgaPipeline, QvgaWorkspace};
use pldi_core::templates::{Encoding, Templates};

use crate::Error;
use crate::input::{FrameSource, QvgaFrame};
use crate::parallel;
use crate::report::FrameReport;

/// The result of a frame, and what the caller wanted besides.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameResult<T> {
    /// What was recognised.
    pub report: FrameReport,
    /// What `look` made of the frame.
    pub extra: T,
}

/// A frame that went through the pipeline, with everything the stages left behind.
#[derive(Debug, Clone, Copy)]
pub struct Processed<'a> {
    /// The frame.
    pub frame: &'a QvgaFrame,
    /// What it went through.
    pub pipeline: &'a QvgaPipeline,
    /// What the stages left, the core's report included.
    pub workspace: &'a QvgaWorkspace,
    /// What is reported.
    pub report: &'a FrameReport,
}

/// What a worker keeps from frame to frame: its memory, and the tables for the last frame's camera.
struct Worker {
    pipeline: Option<(Intrinsics, QvgaPipeline)>,
    workspace: Box<QvgaWorkspace>,
}

/// Takes all frames of `source` through the pipeline on `threads` threads. `look` sees each processed frame on its
/// worker's thread (`|_| Ok(())` where the report is enough); `sink` gets the results on the calling thread, in the frames'
/// order, whatever the number of threads, and ends the work early by returning `Ok(false)`. A frame that fails hands its
/// error to the sink, which decides whether to go on. Memory does not grow with the number of frames.
///
/// # Errors
/// `Core` where a parameter is out of range or the templates were made with other view parameters, before any frame is
/// read; and what `sink` returns.
pub fn run<T: Send, E: From<Error>>(
    source: &dyn FrameSource,
    params: &Params,
    templates: &Templates<'_>,
    threads: usize,
    look: impl Fn(&Processed<'_>) -> Result<T, Error> + Sync,
    sink: impl FnMut(usize, Result<FrameResult<T>, Error>) -> Result<bool, E>,
) -> Result<(), E> {
    params.validate().map_err(Error::core)?;
    templates.require(params.view.hash(), Encoding::Float).map_err(|e| Error::core(e.into()))?;
    let state = || Worker { pipeline: None, workspace: Box::new(QvgaWorkspace::new()) };
    let work = |worker: &mut Worker, index: usize| {
        let frame = source.frame(index)?;
        let (pipeline, workspace) = worker.process(&frame, params, templates)?;
        let report = FrameReport::new(&frame, &workspace.report, params, templates);
        let extra = look(&Processed { frame: &frame, pipeline, workspace, report: &report })?;
        Ok(FrameResult { report, extra })
    };
    parallel::for_each_ordered(source.len(), threads, state, work, sink)
}

impl Worker {
    fn process(
        &mut self,
        frame: &QvgaFrame,
        params: &Params,
        templates: &Templates<'_>,
    ) -> Result<(&QvgaPipeline, &QvgaWorkspace), Error> {
        let pipeline = match self.pipeline.take() {
            Some((intrinsics, pipeline)) if intrinsics == frame.intrinsics => pipeline,
            _ => QvgaPipeline::new(params, &frame.intrinsics).map_err(Error::core)?,
        };
        let (_, pipeline) = self.pipeline.insert((frame.intrinsics, pipeline));
        pipeline.run(&frame.as_frame().map_err(Error::core)?, templates, &mut self.workspace).map_err(Error::core)?;
        Ok((pipeline, &self.workspace))
    }
}
