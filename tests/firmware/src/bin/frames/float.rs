//! Frames come in whole.

use firmware::clock::Stage;
use firmware::failure::Failure;
use firmware::frames::{Frames, H, W};
use firmware::setup;
use pldi_core::Frame;
use pldi_core::pipeline::{QvgaPipeline, QvgaWorkspace};
use static_cell::{ConstStaticCell, StaticCell};

/// The arithmetic, as the golden digests call it.
pub(crate) const NAME: &str = "float";

static WORKSPACE: ConstStaticCell<QvgaWorkspace> = ConstStaticCell::new(QvgaWorkspace::new());
static FRAME: ConstStaticCell<([u16; W * H], [u8; W * H * 3])> = ConstStaticCell::new(([0; _], [0; _]));
static PIPELINE: StaticCell<QvgaPipeline> = StaticCell::new();

/// Memory for frames.
pub(crate) struct Intake {
    workspace: &'static mut QvgaWorkspace,
    frame: &'static mut ([u16; W * H], [u8; W * H * 3]),
    pipeline: Option<&'static mut QvgaPipeline>,
}

impl Intake {
    pub(crate) fn take() -> Self {
        Self { workspace: WORKSPACE.take(), frame: FRAME.take(), pipeline: None }
    }

    /// Reads a frame and reconstructs its depth.
    pub(crate) fn frame(
        &mut self,
        frames: &mut Frames,
        variant: usize,
        [_, filter]: &mut [Stage; 2],
    ) -> Result<(&QvgaPipeline, &mut QvgaWorkspace), Failure> {
        let params = setup::VARIANTS.get(variant).ok_or(Failure::Usage)?;
        let pipeline = QvgaPipeline::new(params, &setup::CAMERA)?;
        let pipeline = match self.pipeline.take() {
            Some(place) => {
                *place = pipeline;
                place
            }
            None => PIPELINE.init(pipeline),
        };
        let pipeline = self.pipeline.insert(pipeline);
        let (depth, colour) = &mut *self.frame;
        frames.rows(0, depth, colour)?;
        let frame = Frame::new(depth, Some(colour))?;
        filter.run(|| pipeline.reconstruct(&frame, self.workspace));
        Ok((pipeline, self.workspace))
    }
}
