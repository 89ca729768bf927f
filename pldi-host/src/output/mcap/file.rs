//! The file that messages go into.

use std::collections::BTreeMap;
use std::fmt;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{Compression, McapError, WriteOptions, Writer};

use super::schemas;
use crate::Error;
use crate::input::Stamp;
use crate::output::atomic::Pending;

/// A chunk ends behind so many bytes (before compression): that much memory is taken, that much is lost to those who are
/// killed, and so much is read to show one moment.
const CHUNK: u64 = 2 << 20;

/// Level of compression: the fastest. Levels above gain a few per cent on images with noise and cost several times as
/// much.
const LEVEL: u32 = 1;

/// Longest message: readers have limits, that of this crate as well.
const LONGEST: usize = 256 << 20;

/// A stream of messages of one kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Topic {
    /// Its name.
    pub(crate) name: &'static str,
    /// Package and name of its messages.
    pub(crate) message: &'static str,
}

/// An MCAP file of the profile `ros2`, compressed and indexed. It appears under its name when it is finished, or
/// dropped with messages in it: what was written is not lost. Memory grows by some hundred bytes per chunk, for the index.
pub(crate) struct McapFile {
    path: PathBuf,
    /// `None` when it is closed.
    writer: Option<Writer<NoSeek<BufWriter<Pending>>>>,
    /// Topics so far, with their numbers in the file and the number of messages.
    channels: Vec<(Topic, u16, u32)>,
}

impl fmt::Debug for McapFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("McapFile").field("path", &self.path).field("channels", &self.channels).finish_non_exhaustive()
    }
}

impl McapFile {
    /// Begins a file.
    ///
    /// # Errors
    /// `Write`.
    pub(crate) fn create(path: &Path) -> Result<Self, Error> {
        let file = NoSeek::new(BufWriter::new(Pending::create(path)?));
        let options = WriteOptions::new()
            .profile("ros2")
            .library(concat!("pldi ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Zstd))
            .compression_level(LEVEL)
            .compression_threads(0)
            .chunk_size(Some(CHUNK))
            // Chunks are written whole, and pipes will do.
            .disable_seeking(true);
        let writer = options.create(file).map_err(|e| failed(path, e))?;
        Ok(Self { path: path.to_owned(), writer: Some(writer), channels: Vec::new() })
    }

    /// Adds a message that was made at `stamp`.
    ///
    /// # Errors
    /// `Write`. Nothing can be written behind an error.
    pub(crate) fn message(&mut self, topic: Topic, stamp: Stamp, bytes: &[u8]) -> Result<(), Error> {
        let Self { path, writer, channels } = self;
        let fails = |e| failed(path, e);
        let gone = || McapError::Io(io::ErrorKind::BrokenPipe.into());
        let writer = writer.as_mut().ok_or_else(|| fails(gone()))?;
        if bytes.len() > LONGEST {
            let text = format!("a message of {} bytes on {}: at most {LONGEST} are written", bytes.len(), topic.name);
            return Err(fails(McapError::Io(io::Error::new(io::ErrorKind::FileTooLarge, text))));
        }
        let known = channels.iter().position(|(known, ..)| *known == topic);
        let at = match known {
            Some(at) => at,
            None => {
                let channel = add_topic(writer, topic).map_err(fails)?;
                channels.push((topic, channel, 0));
                channels.len() - 1
            }
        };
        let Some((_, channel_id, count)) = channels.get_mut(at) else { return Err(fails(gone())) };
        let time = u64::try_from(stamp.0).unwrap_or(0);
        let header = MessageHeader { channel_id: *channel_id, sequence: *count, log_time: time, publish_time: time };
        *count = count.wrapping_add(1);
        writer.write_to_known_channel(&header, bytes).map_err(fails)
    }

    /// Whether no message was added.
    pub(crate) fn is_empty(&self) -> bool {
        self.channels.is_empty()
    }

    /// Ends the file, which appears under its name.
    ///
    /// # Errors
    /// `Write`. Even then the file is there, without its index or its last messages: it can be read up to there.
    pub(crate) fn finish(mut self) -> Result<(), Error> {
        self.close()
    }

    fn close(&mut self) -> Result<(), Error> {
        let Some(mut writer) = self.writer.take() else { return Ok(()) };
        let finished = writer.finish().map(drop).map_err(|e| failed(&self.path, e));
        let (pending, flushed) = match writer.into_inner().into_inner().into_inner() {
            Ok(pending) => (pending, Ok(())),
            Err(e) => {
                let (cause, buffered) = e.into_parts();
                (buffered.into_parts().0, Err(Error::Write { path: self.path.clone(), cause }))
            }
        };
        let kept = pending.keep();
        finished.and(flushed).and(kept)
    }
}

impl Drop for McapFile {
    fn drop(&mut self) {
        if self.is_empty() {
            self.writer = None;
        }
        if let Err(error) = self.close() {
            tracing::warn!("{error}");
        }
    }
}

fn add_topic<W: io::Write + io::Seek>(writer: &mut Writer<W>, topic: Topic) -> Result<u16, McapError> {
    let definition = schemas::definition(topic.message);
    let name = topic.message.replace('/', "/msg/");
    let schema = writer.add_schema(&name, "ros2msg", definition.as_bytes())?;
    writer.add_channel(schema, topic.name, "cdr", &BTreeMap::new())
}

fn failed(path: &Path, error: McapError) -> Error {
    let cause = match error {
        McapError::Io(cause) => cause,
        other => io::Error::other(other),
    };
    Error::Write { path: path.to_owned(), cause }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: Topic = Topic { name: "/a", message: "sensor_msgs/Image" };
    const B: Topic = Topic { name: "/b", message: "sensor_msgs/Image" };

    #[test]
    fn a_file_has_profile_index_and_chunks_of_bounded_size() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("out.mcap");
        let mut file = McapFile::create(&path).unwrap();
        let noise: Vec<u8> = (0..600_000u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        for i in 0..20 {
            file.message(if i % 2 == 0 { A } else { B }, Stamp(i * 100), &noise).unwrap();
        }
        file.finish().unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let summary = mcap::Summary::read(&bytes).unwrap().expect("a summary");
        let stats = summary.stats.expect("statistics");
        assert_eq!((stats.message_count, stats.channel_count, stats.message_end_time), (20, 2, 1900));
        assert_eq!(stats.schema_count, 1, "both topics share their definition");
        assert!(summary.chunk_indexes.len() >= 5);
        for chunk in &summary.chunk_indexes {
            assert!(chunk.uncompressed_size < CHUNK + 700_000 && chunk.compression == "zstd", "{chunk:?}");
        }
        let messages: Vec<_> = mcap::MessageStream::new(&bytes).unwrap().map(|m| m.unwrap()).collect();
        assert!(messages.iter().enumerate().all(|(i, m)| (m.sequence, m.log_time) == (i as u32 / 2, i as u64 * 100)));
        let channel = &messages[0].channel;
        let schema = channel.schema.as_ref().unwrap();
        assert_eq!((channel.message_encoding.as_str(), schema.encoding.as_str()), ("cdr", "ros2msg"));
        assert_eq!(schema.name, "sensor_msgs/msg/Image");
        let mut reader = mcap::read::LinearReader::new(&bytes).unwrap();
        let Some(Ok(mcap::records::Record::Header(header))) = reader.next() else { panic!("no header") };
        assert_eq!((header.profile.as_str(), header.library.split(' ').next()), ("ros2", Some("pldi")));
    }

    #[test]
    fn what_was_there_goes_only_for_something() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("out.mcap");
        std::fs::write(&path, "old").unwrap();
        drop(McapFile::create(&path).unwrap());
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        let mut file = McapFile::create(&path).unwrap();
        file.message(A, Stamp(-5), b"\0\x01\0\0").unwrap();
        drop(file);
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(mcap::MessageStream::new(&bytes).unwrap().filter(|m| m.as_ref().unwrap().log_time == 0).count(), 1);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_said_and_nothing_panics() {
        let mut file = McapFile::create(Path::new("/dev/full")).unwrap();
        let noise: Vec<u8> = (0..600_000u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        let failed = (0..10).find_map(|i| file.message(A, Stamp(i), &noise).err()).expect("it cannot be written");
        assert!(failed.to_string().contains("/dev/full"), "{failed}");
        assert!(file.message(A, Stamp(11), &noise).is_err());
        assert!(file.finish().is_err());
    }
}
