//! Frames kept in a file (`.rrd`) for the viewer to open later.

use std::any::Any;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use re_sdk::external::re_log_encoding::{EncodeError, Encoder, EncodingOptions};
use re_sdk::log::LogMsg;
use re_sdk::sink::{LogSink, SinkFlushError};

use crate::Error;
use crate::output::atomic::Pending;

/// A file that is being written. Clones are one and the same: one of them belongs to the stream.
///
/// The SDK's own file sink tells of errors only in its log, and writes under the file's final name.
#[derive(Clone)]
pub(super) struct RrdFile {
    path: PathBuf,
    state: Arc<Mutex<State>>,
}

struct State {
    encoder: Encoder<BufWriter<Pending>>,
    /// What went wrong first; nothing is written from there on.
    failed: Option<io::Error>,
}

impl std::fmt::Debug for RrdFile {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RrdFile").field("path", &self.path).finish_non_exhaustive()
    }
}

impl RrdFile {
    /// Begins a file.
    pub(super) fn create(path: &Path) -> Result<Self, Error> {
        let out = BufWriter::new(Pending::create(path)?);
        let (version, options) = (re_sdk::build_info().version, EncodingOptions::PROTOBUF_COMPRESSED);
        let encoder = Encoder::new_eager(version, options, out)
            .map_err(|e| Error::Write { path: path.to_owned(), cause: io_error(e) })?;
        Ok(Self { path: path.to_owned(), state: Arc::new(Mutex::new(State { encoder, failed: None })) })
    }

    /// The error that stands behind a flush that failed because of `reason`.
    pub(super) fn error(&self, reason: String) -> Error {
        let cause = self.lock().failed.take().unwrap_or_else(|| io::Error::other(reason));
        Error::Write { path: self.path.clone(), cause }
    }

    /// Lets the file appear under its name. Where the disk was full, say, it holds what was written before.
    pub(super) fn finish(self) -> Result<(), Error> {
        let fails = |cause| Error::Write { path: self.path.clone(), cause };
        let Some(state) = Arc::into_inner(self.state) else {
            return Err(fails(io::Error::other("it is still being written")));
        };
        let mut encoder = state.into_inner().unwrap_or_else(PoisonError::into_inner).encoder;
        let ended = encoder.finish().and_then(|()| encoder.flush_blocking()).map_err(io_error);
        let out = encoder.into_inner().map_err(|e| fails(io_error(e)))?;
        // Taken apart without writing again what could not be written.
        let (pending, _) = out.into_parts();
        pending.keep()?;
        ended.map_err(fails)
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn io_error(error: EncodeError) -> io::Error {
    match error {
        EncodeError::Write(cause) => cause,
        other => io::Error::other(other.to_string()),
    }
}

impl LogSink for RrdFile {
    fn send(&self, message: LogMsg) {
        let mut state = self.lock();
        if state.failed.is_none() {
            state.failed = state.encoder.append(&message).err().map(io_error);
        }
    }

    fn flush_blocking(&self, _: Duration) -> Result<(), SinkFlushError> {
        let mut state = self.lock();
        if state.failed.is_none() {
            state.failed = state.encoder.flush_blocking().err().map(io_error);
        }
        match &state.failed {
            Some(error) => Err(SinkFlushError::failed(error.to_string())),
            None => Ok(()),
        }
    }

    fn as_any(&self) -> &dyn Any {
        self
    }
}
