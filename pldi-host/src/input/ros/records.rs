//! What the containers have in common: records one behind the other, most of them in chunks, read from the file's
//! beginning to its end with memory for one record and one chunk.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::Malformed;
use super::chunk::{Chunk, Place, Span};
use super::log::{Message, Step};
use crate::Error;

/// Why a record could not be read.
#[derive(Debug)]
pub(in crate::input) enum Fault {
    /// The bytes end within it.
    Cut,
    /// What it says makes no sense; nothing behind it can be found.
    Damaged(String),
    /// The system's word.
    Io(io::Error),
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::UnexpectedEof { Self::Cut } else { Self::Io(error) }
    }
}

impl From<Malformed> for Fault {
    fn from(cause: Malformed) -> Self {
        Self::Damaged(cause.to_string())
    }
}

/// A record that was read.
#[derive(Debug)]
pub(in crate::input) enum Record {
    Message(Message),
    /// Nothing that was asked for.
    Other,
    /// The end of what messages may be in.
    DataEnd,
}

/// A file of records, and how far it has been read.
#[derive(Debug)]
pub(in crate::input) struct Records {
    pub(in crate::input) path: PathBuf,
    pub(in crate::input) file: Arc<File>,
    pub(in crate::input) size: u64,
    /// The file from the byte `at` on.
    pub(in crate::input) reader: BufReader<Span>,
    pub(in crate::input) at: u64,
    /// The chunk that is being read, and where its record begins.
    chunk: Option<(u64, Chunk)>,
    /// Where the first record is.
    first: u64,
    ended: bool,
    quiet: bool,
}

/// Whether a file begins so.
pub(in crate::input) fn begins(uri: &str, magic: &[u8]) -> bool {
    let mut bytes = Vec::new();
    let path = Path::new(uri);
    // A pipe would be emptied by looking.
    path.is_file()
        && File::open(path).and_then(|file| file.take(magic.len() as u64).read_to_end(&mut bytes)).is_ok()
        && bytes == magic
}

impl Records {
    /// Opens a file that must begin with `magic`; `what` it then is, is for messages.
    pub(in crate::input) fn open(path: &Path, what: &str, magic: &[u8]) -> Result<Self, Error> {
        let failed = |cause| Error::Read { path: path.to_owned(), cause };
        let no = |reason: String| Error::Content { path: path.to_owned(), reason };
        let file = File::open(path).map_err(failed)?;
        let metadata = file.metadata().map_err(failed)?;
        if !metadata.is_file() {
            return Err(no(format!("no {what}: not a file")));
        }
        let (size, first) = (metadata.len(), magic.len() as u64);
        if size == 0 {
            return Err(Error::EmptyFile(path.to_owned()));
        }
        let file = Arc::new(file);
        let mut begin = Vec::new();
        Span::new(&file, 0, first.min(size)).read_to_end(&mut begin).map_err(failed)?;
        if begin != magic {
            return Err(no(format!("no {what}: it does not begin as one")));
        }
        let (path, reader) = (path.to_owned(), Span::new(&file, first, size));
        Ok(Self { path, file, size, reader, at: first, chunk: None, first, ended: false, quiet: true })
    }

    /// Goes on reading at the byte `at`.
    pub(in crate::input) fn go_to(&mut self, at: u64) {
        self.at = at;
        self.reader = Span::new(&self.file, at, self.size);
    }

    /// Goes back to the first record; warnings are given from now on.
    pub(in crate::input) fn rewind(&mut self) {
        self.go_to(self.first);
        (self.chunk, self.ended, self.quiet) = (None, false, false);
    }

    /// Opens the chunk whose record begins at the byte `start` and ends before `end`, or says why that cannot be.
    pub(in crate::input) fn enter(&mut self, start: u64, end: u64, place: Result<Place, String>) {
        self.go_to(end.min(self.size));
        let open = |place| Chunk::open(&self.file, self.size, place).map_err(|error| error.to_string());
        match place.and_then(open) {
            Ok(chunk) => self.chunk = Some((start, chunk)),
            Err(cause) => self.skipped(start, &cause),
        }
    }

    /// Reads the next record of the open chunk by `read`; none where there is no chunk. Damage is told and ends the
    /// chunk alone.
    pub(in crate::input) fn in_chunk(
        &mut self,
        read: impl FnOnce(&mut Chunk) -> Result<Record, Fault>,
    ) -> Option<Result<Record, Fault>> {
        let (start, chunk) = self.chunk.as_mut()?;
        let start = *start;
        if chunk.left() == 0 {
            self.chunk = None;
            return Some(Ok(Record::Other));
        }
        let cause = match read(chunk) {
            Ok(Record::DataEnd) => "it holds the end of the file".to_owned(),
            Ok(record) => return Some(Ok(record)),
            Err(Fault::Cut) => "a record goes beyond its end".to_owned(),
            Err(Fault::Damaged(reason)) => reason,
            Err(Fault::Io(error)) => error.to_string(),
        };
        self.chunk = None;
        // The last chunk of a cut file is cut: that is told at the end.
        if self.at < self.size {
            self.skipped(start, &cause);
        }
        Some(Ok(Record::Other))
    }

    fn skipped(&self, start: u64, cause: &str) {
        if !self.quiet {
            let path = self.path.display();
            tracing::warn!(
                "{path}: the chunk at byte {start} is damaged ({cause}); what cannot be read of it is left out"
            );
        }
    }

    /// What reading a record came to; `count` messages have been read so far.
    pub(in crate::input) fn step(&mut self, record: Result<Record, Fault>, count: u64) -> Result<Step, Error> {
        let fault = match record {
            Ok(Record::Message(message)) => return Ok(Step::Message(message)),
            Ok(Record::Other) => return Ok(Step::Nothing),
            Ok(Record::DataEnd) => None,
            Err(Fault::Io(cause)) => return Err(Error::Read { path: self.path.clone(), cause }),
            Err(fault) => Some(fault),
        };
        self.ended = true;
        let (path, at, size) = (self.path.display(), self.at, self.size);
        match fault.filter(|_| !self.quiet) {
            None => {}
            Some(Fault::Damaged(reason)) => {
                tracing::warn!(
                    "{path}: damaged at byte {at} of {size} ({reason}); the {count} messages before it were read"
                );
            }
            Some(_) => tracing::warn!(
                "{path}: ends at byte {size} in the midst, as where the recorder was killed; the {count} messages before \
                 that were read"
            ),
        }
        Ok(Step::End)
    }

    /// Whether there is nothing more to read.
    pub(in crate::input) fn has_ended(&self) -> bool {
        self.ended
    }

    /// Whether a record beyond the byte `until` is the next.
    pub(in crate::input) fn is_beyond(&self, until: u64) -> bool {
        self.chunk.is_none() && self.at > until
    }
}

/// Takes `length` bytes; memory grows with what is there.
pub(in crate::input) fn take(reader: &mut impl Read, length: u64, limit: u64) -> Result<Vec<u8>, Fault> {
    if length > limit {
        return Err(Fault::Damaged(format!("a record of {length} bytes")));
    }
    let mut bytes = Vec::new();
    reader.by_ref().take(length).read_to_end(&mut bytes)?;
    if bytes.len() as u64 == length { Ok(bytes) } else { Err(Fault::Cut) }
}

/// Passes over `length` bytes.
pub(in crate::input) fn skip(reader: &mut impl Read, length: u64) -> Result<(), Fault> {
    let skipped = io::copy(&mut reader.by_ref().take(length), &mut io::sink())?;
    if skipped == length { Ok(()) } else { Err(Fault::Cut) }
}
