//! `pldi stages`: one frame, stage by stage.

use std::path::PathBuf;

use pldi_core::pipeline::QvgaWorkspace;
use pldi_core::view::ViewParams;
use pldi_host::{Engine, Error, stages};

use crate::args::{Processing, Source};
use crate::progress;

/// Options of `pldi stages`.
#[derive(Debug, clap::Args)]
pub struct Stages {
    #[command(flatten)]
    input: Source,
    #[command(flatten)]
    processing: Processing,
    /// Number of the frame, from 0
    #[arg(long, value_name = "K", default_value_t = 0)]
    frame: usize,
    /// Folder for the files; made where it is missing
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

impl Stages {
    /// Runs the command.
    pub fn run(&self) -> anyhow::Result<()> {
        let frame = self.input.open()?.frame(self.frame, progress::stop())?.qvga;
        let params = self.processing.params(ViewParams::DEFAULT);
        let mut engine = Engine::new(self.processing.arithmetic(), &params, &frame.intrinsics)?;
        std::fs::create_dir_all(&self.out).map_err(|cause| Error::Write { path: self.out.clone(), cause })?;
        let mut workspace = Box::new(QvgaWorkspace::new());
        stages::write(&mut engine, &frame.as_frame().map_err(Error::core)?, &mut workspace, &self.out)?;
        Ok(())
    }
}
