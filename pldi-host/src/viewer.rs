//! Frames shown in the rerun viewer, as a stream to one that runs or as a file for later.
//!
//! What is shown has its place in one of three spaces. `world` has the floor as its plane z = 0, with its origin below
//! the camera, x to the right, y forward and z up, in metres:
//!
//! - `world/floor`: the sensory area's outline, and a line across it for each metre from the camera;
//! - `world/camera`: the camera's pose; level and at the origin where a frame has no floor;
//! - `world/camera/colour`: the colour image as it was taken (JPEG), and its camera;
//! - `world/camera/colour/candidates`: boxes around the candidates' pixels, with number, best class and score;
//! - `world/camera/depth`: the filtered depth in metres, and its camera;
//! - `world/candidates`: the candidates' boxes, upright on the floor, labelled and coloured alike;
//! - `n`: N of the whole image, 16 bits, 65535 = 1.
//!
//! There are two timelines: `frame`, the frame's number, and `stamp`, the time of its depth image on the source's clock.

mod file;
mod process;
mod scene;
mod target;

use std::path::{Path, PathBuf};
use std::time::Duration;

use re_sdk::log::PendingRow;
use re_sdk::sink::{GrpcSink, LogSink, SinkFlushError};
use re_sdk::time::{TimeInt, TimePoint, Timeline};
use re_sdk::{RecordingStream, RecordingStreamBuilder};
use re_types::AsComponents;
use re_types::archetypes::ViewCoordinates;

pub use scene::Scene;
pub use target::Target;

use crate::Error;
use crate::input::{Stamp, Stop};
use file::RrdFile;

/// Stamps from here on are shown as dates: a clock that counts from 1970 and stands behind September 2001.
const DATES: Stamp = Stamp(1_000_000_000_000_000_000);

/// For how long nobody looks at the stop while a frame is handed over.
const PATIENCE: Duration = Duration::from_millis(200);

/// A viewer, or a file that one will open.
#[derive(Debug)]
pub struct Viewer {
    stream: RecordingStream,
    /// Names it in messages.
    name: PathBuf,
    file: Option<RrdFile>,
    /// The timeline of stamps, known from the first frame on.
    clock: Option<Timeline>,
    frames: usize,
}

impl Viewer {
    /// Reaches a viewer, starts one or begins a file; `recording` is the name that the frames have in the viewer.
    ///
    /// # Errors
    /// `Content` where no viewer is there or can be started, `Write` for a file, `Interrupted`.
    pub fn open(target: &Target, recording: &str, stop: &Stop) -> Result<Self, Error> {
        let name = PathBuf::from(target.to_string());
        match target {
            Target::File(path) => {
                let file = RrdFile::create(path)?;
                let sink = Box::new(file.clone());
                Self::new(sink, name, recording, Some(file))
            }
            Target::Address(uri) => {
                // A viewer that is not there is told before frames are computed for it.
                process::reach(&uri.origin.host.to_string(), uri.origin.port)
                    .map_err(|cause| gone(&name, &cause.to_string()))?;
                let viewer = Self::new(Box::new(GrpcSink::new(uri.clone())), name, recording, None)?;
                viewer.flush(stop)?;
                Ok(viewer)
            }
            Target::Spawn => {
                process::start("rerun", process::PORT, stop)?;
                Self::open(&Target::local(process::PORT)?, recording, stop)
            }
        }
    }

    fn new(sink: Box<dyn LogSink>, name: PathBuf, recording: &str, file: Option<RrdFile>) -> Result<Self, Error> {
        let fails = |e: re_sdk::RecordingStreamError| Error::Content { path: name.clone(), reason: e.to_string() };
        // Whatever the environment says: the user asked for it.
        let builder = RecordingStreamBuilder::new("pldi").recording_name(recording).enabled(true);
        let (_, info, properties, batches, hooks) = builder.into_args();
        let stream = RecordingStream::new(info, properties, batches, hooks, sink).map_err(fails)?;
        stream.log_static("world", &ViewCoordinates::RIGHT_HAND_Z_UP()).map_err(fails)?;
        Ok(Self { stream, name, file, clock: None, frames: 0 })
    }

    /// Shows a frame, and waits until it is handed over: memory does not grow where the viewer or the disk is slow.
    /// Frames are expected in their order, which is what viewers and files are laid out for.
    ///
    /// # Errors
    /// `Content` where the viewer is gone, `Write` for a file, `Interrupted`.
    pub fn show(&mut self, scene: Scene, stop: &Stop) -> Result<(), Error> {
        let Scene { index, stamp, entities } = scene;
        let clock = *self.clock.get_or_insert_with(|| {
            if stamp >= DATES { Timeline::new_timestamp("stamp") } else { Timeline::new_duration("stamp") }
        });
        let index = i64::try_from(index).unwrap_or(i64::MAX);
        let time = TimePoint::default()
            .with(Timeline::new_sequence("frame"), TimeInt::new_temporal(index))
            .with(clock, TimeInt::new_temporal(stamp.0));
        for (path, components) in entities {
            let row = PendingRow::from_iter(time.clone(), components.as_serialized_batches());
            // The frame's times alone: when and in which order it was handed over tells nothing about it.
            self.stream.record_row(path.into(), row, false);
        }
        self.flush(stop)?;
        self.frames += 1;
        Ok(())
    }

    /// Ends the stream; only now a file appears under its name, with all frames up to here. One without frames appears
    /// only where the work was `done`.
    ///
    /// # Errors
    /// `Write`.
    pub fn end(self, done: bool) -> Result<(), Error> {
        let Self { stream, file, frames, .. } = self;
        // Its last words go into the file.
        drop(stream);
        match file {
            Some(file) if done || frames > 0 => file.finish(),
            _ => Ok(()),
        }
    }

    /// Waits until all is handed over.
    fn flush(&self, stop: &Stop) -> Result<(), Error> {
        loop {
            let reason = match self.stream.flush_with_timeout(PATIENCE) {
                Ok(()) => return Ok(()),
                // A disk will be done some time; of a viewer nobody knows.
                Err(SinkFlushError::Timeout) if self.file.is_some() || !stop.is_raised() => continue,
                Err(SinkFlushError::Timeout) => {
                    // A last owner that goes would wait for the viewer for ever.
                    std::mem::forget(self.stream.clone());
                    return Err(Error::Interrupted);
                }
                Err(SinkFlushError::Failed { message }) => message,
            };
            if let Some(file) = &self.file {
                return Err(file.error(reason));
            }
            return Err(gone(&self.name, &reason));
        }
    }
}

/// The error for a viewer that cannot be reached.
fn gone(viewer: &Path, reason: &str) -> Error {
    let reason = format!("{reason} (does a viewer run there? --rerun spawn starts one here)");
    Error::Content { path: viewer.to_owned(), reason }
}

#[cfg(test)]
mod tests;
