//! `pldi run --rerun`: frames shown in the rerun viewer.

use pldi_host::Error;
use pldi_host::input::Stop;
use pldi_host::runner::Processed;
use pldi_host::viewer::{Scene, Target, Viewer};

/// Where frames are to be shown.
#[derive(Debug, clap::Args)]
pub struct Rerun {
    /// Show each frame in the rerun viewer: spawn starts one, an address (127.0.0.1:9876, or
    /// rerun+http://127.0.0.1:9876/proxy) reaches one that runs, FILE.rrd keeps the frames for one
    #[arg(id = "rerun", long = "rerun", value_name = "TARGET", conflicts_with = "path")]
    target: Option<Target>,
}

impl Rerun {
    /// The viewer, where one is wanted; `recording` is the name that the frames have there.
    pub fn open(&self, recording: &str, stop: &Stop) -> Result<Stream, Error> {
        self.target.as_ref().map(|target| Viewer::open(target, recording, stop)).transpose().map(Stream)
    }

    /// What is shown of a frame.
    pub fn scene(&self, seen: &mut Processed<'_>) -> Result<Shown, Error> {
        self.target.as_ref().map(|_| Scene::new(seen)).transpose()
    }
}

/// What is shown of a frame, if anything.
pub type Shown = Option<Scene>;

/// Where it is shown.
#[derive(Debug)]
pub struct Stream(Option<Viewer>);

impl Stream {
    /// Shows a frame.
    pub fn show(&mut self, shown: Shown, stop: &Stop) -> Result<(), Error> {
        match (&mut self.0, shown) {
            (Some(viewer), Some(scene)) => viewer.show(scene, stop),
            _ => Ok(()),
        }
    }

    /// Ends the stream; `done` tells whether all went well.
    pub fn end(self, done: bool) -> Result<(), Error> {
        self.0.map_or(Ok(()), |viewer| viewer.end(done))
    }
}
