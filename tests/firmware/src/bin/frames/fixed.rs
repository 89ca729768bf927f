//! Frames come in row by row, as a sensor gives them: two line buffers are all that there is of the input.

use firmware::clock::Stage;
use firmware::failure::Failure;
use firmware::frames::{Frames, H, W};
use firmware::setup;
use pldi_core::pipeline::{QvgaFixedPipeline, QvgaFixedWorkspace};
use pldi_core::reconstruct::fixed::{ColourRow, DepthRow};
use static_cell::ConstStaticCell;

/// The arithmetic, as the golden digests call it.
pub(crate) const NAME: &str = "fixed";

static WORKSPACE: ConstStaticCell<QvgaFixedWorkspace> = ConstStaticCell::new(QvgaFixedWorkspace::new());

/// Memory for frames.
pub(crate) struct Intake {
    workspace: &'static mut QvgaFixedWorkspace,
}

impl Intake {
    pub(crate) fn take() -> Self {
        Self { workspace: WORKSPACE.take() }
    }

    /// Reads the rows of a frame and reconstructs its depth.
    pub(crate) fn frame(
        &mut self,
        frames: &mut Frames,
        variant: usize,
        [rows, filter]: &mut [Stage; 2],
    ) -> Result<(&'static QvgaFixedPipeline, &mut QvgaFixedWorkspace), Failure> {
        let pipeline = setup::FIXED.get(variant).ok_or(Failure::Usage)?;
        let (mut depth, mut colour) = ([0; W], [0; 3 * W]);
        pipeline.begin(self.workspace);
        for v in 0..H {
            frames.rows(v, &mut depth, &mut colour)?;
            let (depth, colour) = (DepthRow::Millimetres(&depth), ColourRow::Rgb888(&[&colour]));
            rows.run(|| pipeline.push(depth, Some(colour), self.workspace))?;
        }
        filter.run(|| pipeline.finish(self.workspace))?;
        Ok((pipeline, self.workspace))
    }
}
