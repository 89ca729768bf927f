//! Recordings written from any source, frame by frame: a TUM-style folder or an MCAP file.

mod folder;
mod mcap;

use std::path::Path;

use pldi_core::Intrinsics;

use crate::input::{Images, Input, RawFrame, Stamp, Stop, ahead};
use crate::{Error, parallel};

/// A frame to be kept, as it was taken.
#[derive(Debug, Clone, PartialEq)]
pub struct Taken {
    /// Time of the depth image.
    pub stamp: Stamp,
    /// Time of the colour image; that of the depth image where it has none of its own.
    pub colour_stamp: Stamp,
    /// Name of the depth camera's coordinate frame, where the source has one.
    pub frame_id: Option<String>,
    /// The camera, for the images' size; `None` where nobody knows it.
    pub camera: Option<Intrinsics>,
    /// The images.
    pub images: Images,
}

/// Writes a recording.
pub trait Recorder {
    /// Adds a frame.
    ///
    /// # Errors
    /// `Write`; the frames before stay as they are.
    fn frame(&mut self, frame: &Taken) -> Result<(), Error>;

    /// Ends the recording: only now it appears under its name.
    ///
    /// # Errors
    /// `Write`.
    fn finish(self: Box<Self>) -> Result<(), Error>;
}

/// Begins a recording: an MCAP file where the name ends in `.mcap`, a folder otherwise.
///
/// # Errors
/// `Write` where something of that name is there already, or the place cannot be written to.
pub fn create(path: &Path) -> Result<Box<dyn Recorder>, Error> {
    if path.exists() {
        let cause = std::io::Error::new(
            std::io::ErrorKind::AlreadyExists,
            "it is there already; give another name, or remove it",
        );
        return Err(Error::Write { path: path.to_owned(), cause });
    }
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mcap")) {
        return Ok(Box::new(mcap::McapRecorder::create(path)?));
    }
    Ok(Box::new(folder::FolderRecorder::create(path)?))
}

/// What became of a source's frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Frames in the recording.
    pub kept: u64,
    /// Frames that were lost before they came.
    pub dropped: u64,
    /// Frames that could not be read, or not be kept.
    pub failed: u64,
}

/// Keeps all frames of `input`. Images are decoded on `threads` threads, with one more that reads ahead; memory does not
/// grow with the number of frames. `counts` is kept up to date; `each` hears of every frame (`Ok`: kept; otherwise why not), and ends the recording by
/// returning false. Whatever ends it, `recorder` has finished when this returns, with all frames up to there.
///
/// # Errors
/// What ended the source early, behind what it gave; `Write`.
pub fn record(
    input: Input,
    mut recorder: Box<dyn Recorder>,
    threads: usize,
    stop: &Stop,
    counts: &mut Counts,
    mut each: impl FnMut(&Counts, Result<(), &Error>) -> bool,
) -> Result<(), Error> {
    let (source, preparation) = input.into_parts();
    let work = |(): &mut (), _, raw: Result<RawFrame, Error>| {
        // The source's own error ends it, a frame's does not.
        let raw = raw.map_err(|e| (e, true))?;
        let dropped = raw.dropped;
        preparation.taken(raw).map(|taken| (taken, dropped)).map_err(|e| (e, false))
    };
    let mut sink = |_, result: Result<(Taken, u64), (Error, bool)>| {
        let outcome = match result {
            Ok((taken, dropped)) => {
                counts.dropped += dropped;
                match recorder.frame(&taken) {
                    Err(error @ Error::Write { .. }) => return Err(error),
                    other => other,
                }
            }
            Err((error, true)) => return Err(error),
            Err((error, false)) => Err(error),
        };
        *(if outcome.is_ok() { &mut counts.kept } else { &mut counts.failed }) += 1;
        Ok(each(counts, outcome.as_ref().copied()))
    };
    let ended =
        ahead::with_frames(source, stop, |frames| parallel::for_each_ordered(frames, threads, || (), work, &mut sink))?;
    let finished = recorder.finish();
    ended.and(finished)
}
