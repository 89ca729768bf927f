//! A recording of OpenNI2's own, played as fast as its frames are taken and without leaving any out.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::clock::Clock;
use super::facts::Frame;
use super::gaps::Gaps;
use super::library::Library;
use super::session::{Kind, Session};
use super::sys;
use crate::Error;
use crate::input::pair::Pairer;
use crate::input::{RawFrame, Source, Stop};

/// How long to wait for a frame before looking whether to give up.
const GLANCE: Duration = Duration::from_millis(100);
/// A file that gives nothing for so long gives nothing more: it was cut, or it is damaged here.
const SILENT: Duration = Duration::from_secs(3);
/// Images of a stream that wait for one of the other. Recorders write what comes, so that they lie near each other.
const WAITING: usize = 32;

/// A file's frames.
pub(super) struct Film {
    path: String,
    session: Session,
    pairer: Pairer<Frame, Frame>,
    clock: Clock,
    /// Images of each stream that the file says it has, and that have come.
    expected: [u64; 2],
    come: [u64; 2],
    gaps: Gaps,
    left_out: u64,
    given: usize,
    /// When the last image came.
    heard: Instant,
    ended: bool,
}

impl Film {
    /// Opens a file.
    pub(super) fn open(library: &Arc<Library>, path: &str) -> Result<Self, Error> {
        // OpenNI2 does not say why a file cannot be opened.
        let read = |cause| Error::Read { path: path.into(), cause };
        let bytes = std::fs::File::open(path).and_then(|file| file.metadata()).map_err(read)?.len();
        if bytes == 0 {
            return Err(Error::EmptyFile(path.into()));
        }
        let session = Session::file(library, path)?;
        let expected = [Kind::Depth, Kind::Colour].map(|kind| {
            let count: i32 = session.property(kind, sys::STREAM_NUMBER_OF_FRAMES).unwrap_or(0);
            u64::try_from(count).unwrap_or(0)
        });
        let pairer = if session.has_colour() { Pairer::new(WAITING) } else { Pairer::depth_only() };
        Ok(Self {
            path: path.to_owned(),
            session,
            pairer,
            clock: Clock::default(),
            expected,
            come: [0; 2],
            gaps: Gaps::default(),
            left_out: 0,
            given: 0,
            heard: Instant::now(),
            ended: false,
        })
    }

    /// Takes an image if one comes soon.
    fn take(&mut self) -> Result<(), Error> {
        let all = self.expected[0] > 0 && (0..2).all(|kind| self.come[kind] >= self.expected[kind]);
        let at_end = self.session.heard().1 > 0;
        if all {
            self.end(None);
            return Ok(());
        }
        let read = self.session.read(if at_end { Duration::ZERO } else { GLANCE });
        let damaged = |failure| Error::Content {
            path: self.path.as_str().into(),
            reason: format!("cannot be read on after {} frames: {failure}", self.given),
        };
        match read.map_err(damaged)? {
            Some((kind, frame)) => {
                self.heard = Instant::now();
                self.come[kind as usize] += 1;
                let stamp = self.clock.stamp(frame.microseconds, Duration::ZERO);
                match kind {
                    Kind::Colour => self.pairer.push_colour(stamp, frame),
                    Kind::Depth => {
                        self.gaps.next(frame.index);
                        self.pairer.push_depth(stamp, frame);
                    }
                }
            }
            None if at_end => self.end(Some("ends")),
            None if self.heard.elapsed() > SILENT => self.end(Some("cannot be read on")),
            None => {}
        }
        Ok(())
    }

    /// There are no more images; says why if some were expected.
    fn end(&mut self, why: Option<&str>) {
        self.ended = true;
        self.pairer.end();
        self.left_out += self.pairer.take_left_out().depth;
        let ([depth, colour], [all_depth, all_colour]) = (self.come, self.expected);
        let path = Path::new(&self.path).display();
        if let Some(why) = why.filter(|_| depth < all_depth || colour < all_colour) {
            tracing::warn!(
                "{path} {why} after {depth} of {all_depth} depth and {colour} of {all_colour} colour images"
            );
        }
        if self.left_out > 0 {
            tracing::warn!(
                "{path}: {} depth images have no colour image of their time and are left out",
                self.left_out
            );
        }
    }
}

impl Source for Film {
    fn next(&mut self, stop: &Stop) -> Result<Option<RawFrame>, Error> {
        loop {
            if stop.is_raised() {
                return Ok(None);
            }
            self.left_out += self.pairer.take_left_out().depth;
            if let Some(pair) = self.pairer.pop() {
                let name = format!("{} frame {}", self.path, self.given);
                self.given += 1;
                return Ok(Some(self.session.frame(name, pair, self.gaps.take())));
            }
            if self.ended {
                return Ok(None);
            }
            self.take()?;
        }
    }

    fn frames(&self) -> Option<usize> {
        let depth = usize::try_from(self.expected[0]).ok().filter(|&count| count > 0)?;
        Some(depth.saturating_sub(self.given))
    }
}
