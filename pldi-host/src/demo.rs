//! The recording that the project shows itself with: made, written as a folder, read back and recognised.

use std::path::Path;

use pldi_core::Params;
use pldi_core::pipeline::QvgaWorkspace;
use pldi_core::templates::Templates;
use pldi_fixtures::{Recording as Generated, TumWriter};

use crate::input::{Frame, Input};
use crate::overlay::{self, Canvas};
use crate::report::FrameReport;
use crate::runner::{self, Job, Processed};
use crate::trial::{FrameTruth, Verdict, judge};
use crate::{ArithmeticKind, Engine, Error, parallel};

/// The name in the recording's files.
const NAME: &str = "pldi demo";

/// What a frame of the demo gave.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// What `pldi run` would print.
    pub report: FrameReport,
    /// What became of each object in view.
    pub verdicts: Vec<Verdict>,
    /// The frame's picture, as a PNG file.
    pub picture: Vec<u8>,
}

/// Makes the recording and writes its folder, `done` is called after each frame (from several threads) and stops the
/// work by returning `false`. What is there already and the same stays as it is. Returns the truth about each frame.
///
/// # Errors
/// `Write`; `Interrupted`.
pub fn write(folder: &Path, threads: usize, done: impl Fn() -> bool + Sync) -> Result<Vec<FrameTruth>, Error> {
    let recording = Generated::demo();
    let fails = |cause| Error::Write { path: folder.to_owned(), cause };
    let writer = TumWriter::new(&recording, NAME, folder).map_err(fails)?;
    let frames = parallel::map_ordered(
        recording.len(),
        threads,
        || (),
        |(), i| {
            let frame = writer.frame(i).map_err(fails)?;
            if done() { Ok(frame) } else { Err(Error::Interrupted) }
        },
    )?;
    writer.finish(&frames).map_err(fails)?;
    let truth = |f: pldi_fixtures::TumFrame| {
        let factor = f.frame.capture.width / 320;
        FrameTruth::new(f.frame.truth, f.frame.camera, &f.frame.capture, factor)
    };
    Ok(frames.into_iter().map(truth).collect())
}

/// Takes the written recording through the pipeline as [`runner::run`] does with any, and compares with the truth.
/// `sink` gets the frames in order and ends the work early by returning `Ok(false)`.
///
/// # Errors
/// As [`runner::run`]; the first frame's that fails.
pub fn recognise<E: From<Error>>(
    input: Input,
    truth: &[FrameTruth],
    job: &Job<'_>,
    mut sink: impl FnMut(usize, Shown) -> Result<bool, E>,
) -> Result<(), E> {
    let look = |seen: &mut Processed<'_>| {
        let (templates, frame) = (job.templates, &seen.frame.qvga);
        let picture = overlay::draw(seen, templates).to_png()?;
        let verdicts = match truth.get(frame.index) {
            Some(truth) => judge(truth, &frame.depth, seen.engine, templates, seen.workspace),
            None => Ok(Default::default()),
        };
        Ok((verdicts.map_err(Error::core)?.0, picture))
    };
    runner::run(input, job, look, |i, result| {
        let runner::FrameResult { report, extra: (verdicts, picture), .. } = result?;
        sink(i, Shown { report, verdicts, picture })
    })
}

/// One frame as a composite picture: colour above N of the whole image to the left, the overlay to the right. The
/// photographs are without their noise, which nobody misses and which makes the file large.
///
/// # Errors
/// What the core says.
pub fn composite(
    mut frame: Frame,
    arithmetic: ArithmeticKind,
    params: &Params,
    templates: &Templates<'_>,
) -> Result<Canvas, Error> {
    let qvga = &frame.qvga;
    let mut engine = Engine::new(arithmetic, params, &qvga.intrinsics)?;
    let mut workspace = Box::new(QvgaWorkspace::new());
    engine.run(&qvga.as_frame().map_err(Error::core)?, templates, &mut workspace)?;
    let report = FrameReport::new(qvga, &workspace.report, &engine, templates);
    let images = &mut frame.images;
    images.colour = images.colour.take().map(|rgb| calm(&rgb, images.size.0.into()));
    let seen = Processed { frame: &frame, engine: &mut engine, workspace: &mut workspace, report: &report };
    let right = overlay::draw(&seen, templates);
    engine.diffuse_all(&mut workspace);
    let (width, height) = right.dimensions();
    let mut canvas = Canvas::new(320 + width, height);
    let colour = frame.qvga.colour.as_deref().map(|rgb| calm(rgb, 320)).unwrap_or_default();
    for (i, pixel) in colour.as_chunks::<3>().0.iter().enumerate() {
        canvas.set((i % 320) as i32, (i / 320) as i32, *pixel);
    }
    for (i, n) in workspace.images.n.as_flattened().iter().enumerate() {
        // 16 bits to 8; N is never finer in print.
        canvas.set((i % 320) as i32, 240 + (i / 320) as i32, [(n >> 8) as u8; 3]);
    }
    for (i, pixel) in right.pixels().as_chunks::<3>().0.iter().enumerate() {
        canvas.set(320 + (i as u32 % width) as i32, (i as u32 / width) as i32, *pixel);
    }
    Ok(canvas)
}

/// A colour image of rows of `width` pixels without its noise: each value is the mean of those values around it (5x5) that
/// differ little, rounded to one of 64 steps.
fn calm(values: &[u8], width: usize) -> Vec<u8> {
    let height = values.len() / (3 * width).max(1);
    let around = |i: usize, end: usize| i.saturating_sub(2)..(i + 3).min(end);
    let mut out = Vec::with_capacity(values.len());
    for y in 0..height {
        for x in 0..width {
            for c in 0..3 {
                let at = |x: usize, y: usize| values[3 * (y * width + x) + c];
                let centre = at(x, y);
                let (mut sum, mut count) = (0u32, 0u32);
                for (u, v) in around(y, height).flat_map(|v| around(x, width).map(move |u| (u, v))) {
                    if at(u, v).abs_diff(centre) <= 12 {
                        sum += u32::from(at(u, v));
                        count += 1;
                    }
                }
                out.push((sum / count.max(1)) as u8 & 0xfc);
            }
        }
    }
    out
}
