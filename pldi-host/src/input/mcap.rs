//! MCAP, the container of ROS 2's recordings: with or without an index, finished or cut.
//!
//! A record is one byte for its kind, eight for its length, and the content; its fields are packed as those of ROS 1 are.

use std::collections::HashMap;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use super::ros::chunk::{Compression, Place, Span};
use super::ros::log::{Channels, Container, Message};
use super::ros::records::{Fault, Record, Records, begins, skip, take};
use super::ros::ros1::Ros1;
use super::ros::source;
use super::ros::topics::Channel;
use super::ros::{Fields, Malformed};
use super::{OpenOptions, Source};
use crate::Error;
use crate::error::excerpt;

/// At the beginning and at the end of a finished file.
const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";
/// Kind and length of a record.
const HEAD: u64 = 9;
/// Length of a message's fields before its data.
const MESSAGE_HEAD: u64 = 22;
/// Longest message that is taken; the largest frame accepted is smaller.
const MAX_MESSAGE: u64 = 256 << 20;
/// Longest record of another kind that is taken, such as a schema.
const MAX_RECORD: u64 = 16 << 20;
/// Length of the footer's content, and of all that stands at the end.
const FOOTER: u64 = 20;
const TAIL: u64 = HEAD + FOOTER + MAGIC.len() as u64;

/// Kinds of records.
mod kind {
    pub(super) const HEADER: u8 = 0x01;
    pub(super) const FOOTER: u8 = 0x02;
    pub(super) const SCHEMA: u8 = 0x03;
    pub(super) const CHANNEL: u8 = 0x04;
    pub(super) const MESSAGE: u8 = 0x05;
    pub(super) const CHUNK: u8 = 0x06;
    pub(super) const ATTACHMENT: u8 = 0x09;
    pub(super) const STATISTICS: u8 = 0x0b;
    pub(super) const DATA_END: u8 = 0x0f;
    /// Kinds from here on are other programs'.
    pub(super) const PRIVATE: u8 = 0x80;
}

/// Whether the file is called so, or begins so.
pub(super) fn claims(uri: &str) -> bool {
    super::open::ends_with(uri, "mcap") || begins(uri, &MAGIC)
}

/// Opens a recording.
///
/// # Errors
/// Where it cannot be read, is no MCAP, or has not the topics that are needed.
pub(super) fn open(uri: &str, options: &OpenOptions) -> Result<Box<dyn Source>, Error> {
    source::open(Box::new(Mcap::open(Path::new(uri))?), options)
}

/// An MCAP file that is read from its beginning to its end.
#[derive(Debug)]
struct Mcap {
    records: Records,
    declared: Declared,
}

/// What the records read so far declare.
#[derive(Debug, Default)]
struct Declared {
    /// Types' names by their numbers.
    schemas: HashMap<u16, String>,
    channels: Channels,
}

impl Mcap {
    fn open(path: &Path) -> Result<Self, Error> {
        Ok(Self { records: Records::open(path, "MCAP file", &MAGIC)?, declared: Declared::default() })
    }

    /// Opens the chunk of `length` bytes whose head has been read and which ends before the byte `end`.
    fn enter(&mut self, length: u64, end: u64) -> Result<Record, Fault> {
        let Records { at: start, size: file_size, .. } = self.records;
        // Two times, size, checksum, the compression's name and the content's length; the name is short.
        let mut bytes = Vec::new();
        self.records.reader.by_ref().take(length.min(1024)).read_to_end(&mut bytes)?;
        let mut fields = Ros1::new(&bytes);
        let mut header = || {
            fields.u64()?;
            fields.u64()?;
            Ok::<_, Malformed>((fields.u64()?, fields.u32()?, fields.bytes()?, fields.u64()?))
        };
        let header = header();
        if header.is_err() && end > file_size {
            return Err(Fault::Cut);
        }
        let at = start + HEAD + (bytes.len() - fields.rest().len()) as u64;
        let place = header.map_err(|cause| cause.to_string()).and_then(|(size, crc, name, content)| {
            let content_end = at.saturating_add(content);
            match Compression::named(name).filter(|c| *c != Compression::Bzip2) {
                None => Err(format!("compression {:?} is not known", excerpt(&String::from_utf8_lossy(name)))),
                Some(_) if content_end > end => Err(format!("{content} bytes do not fit into {length}")),
                Some(compression) => Ok(Place { at, end: content_end, compression, size, crc }),
            }
        });
        self.records.enter(start, end, place);
        Ok(Record::Other)
    }
}

impl Container for Mcap {
    fn records(&self) -> &Records {
        &self.records
    }

    fn records_mut(&mut self) -> &mut Records {
        &mut self.records
    }

    fn channels(&self) -> &Channels {
        &self.declared.channels
    }

    fn forget(&mut self) {
        self.declared = Declared::default();
    }

    fn record(&mut self, wanted: &dyn Fn(&Channel) -> bool) -> Result<Record, Fault> {
        let Self { records, declared } = self;
        let in_chunk = records.in_chunk(|chunk| {
            let (kind, length) = read_head(chunk)?;
            if length > chunk.left() { Err(Fault::Cut) } else { read_body(chunk, kind, length, declared, wanted) }
        });
        if let Some(record) = in_chunk {
            return record;
        }
        let (kind, length) = read_head(&mut records.reader)?;
        let end = records.at.saturating_add(HEAD).saturating_add(length);
        if kind == kind::CHUNK {
            return self.enter(length, end);
        }
        if end > records.size {
            return Err(Fault::Cut);
        }
        if kind == kind::ATTACHMENT {
            records.go_to(end);
            return Ok(Record::Other);
        }
        let record = read_body(&mut records.reader, kind, length, declared, wanted)?;
        records.at = end;
        Ok(record)
    }

    fn summary(&self) -> Result<Vec<(Channel, u64)>, Fault> {
        let Records { file, size, .. } = &self.records;
        let tail = size.checked_sub(TAIL).ok_or(Fault::Cut)?;
        let mut reader = Span::new(file, tail, *size);
        let mut footer = [0; FOOTER as usize + MAGIC.len()];
        let head = read_head(&mut reader)?;
        reader.read_exact(&mut footer)?;
        let mut at = Ros1::new(&footer).u64()?;
        if head != (kind::FOOTER, FOOTER) || !footer.ends_with(&MAGIC) || at == 0 {
            return Err(Fault::Cut);
        }
        let (mut reader, mut declared, mut counts) = (Span::new(file, at, tail), Declared::default(), None);
        while at < tail {
            let (kind, length) = read_head(&mut reader)?;
            at = at.saturating_add(HEAD).saturating_add(length);
            if kind == kind::STATISTICS {
                counts = Some(statistics(&take(&mut reader, length, MAX_RECORD)?)?);
            } else {
                read_body(&mut reader, kind, length, &mut declared, &|_| false)?;
            }
        }
        let counts = counts.ok_or(Fault::Cut)?;
        let count = |id: u32| counts.get(&id).copied().unwrap_or(0);
        Ok(declared.channels.numbered().map(|(id, channel)| (channel.clone(), count(id))).collect())
    }
}

/// Kind and length of the next record.
fn read_head(reader: &mut impl Read) -> Result<(u8, u64), Fault> {
    let mut head = [0; HEAD as usize];
    reader.read_exact(&mut head)?;
    let [kind, length @ ..] = head;
    Ok((kind, u64::from_le_bytes(length)))
}

/// Reads a record's content, or passes over it.
fn read_body(
    reader: &mut impl Read,
    kind: u8,
    length: u64,
    declared: &mut Declared,
    wanted: &dyn Fn(&Channel) -> bool,
) -> Result<Record, Fault> {
    match kind {
        kind::SCHEMA => {
            let bytes = take(reader, length, MAX_RECORD)?;
            let mut fields = Ros1::new(&bytes);
            declared.schemas.insert(fields.u16()?, fields.text()?.to_owned());
        }
        kind::CHANNEL => {
            let bytes = take(reader, length, MAX_RECORD)?;
            let mut fields = Ros1::new(&bytes);
            let (id, schema) = (fields.u16()?, fields.u16()?);
            let (topic, encoding) = (fields.text()?.to_owned(), fields.text()?.to_owned());
            let type_name = declared.schemas.get(&schema).cloned().unwrap_or_default();
            declared.channels.declare(id.into(), Channel { topic, type_name, encoding });
        }
        kind::MESSAGE => return read_message(reader, length, declared, wanted),
        kind::DATA_END | kind::FOOTER => return Ok(Record::DataEnd),
        // All others that there are, and those of other programs.
        kind::HEADER..=kind::DATA_END | kind::PRIVATE.. if kind != kind::CHUNK => skip(reader, length)?,
        _ => return Err(Fault::Damaged(format!("a record of kind {kind:#04x}"))),
    }
    Ok(Record::Other)
}

/// Reads a message if its channel is wanted.
fn read_message(
    reader: &mut impl Read,
    length: u64,
    declared: &mut Declared,
    wanted: &dyn Fn(&Channel) -> bool,
) -> Result<Record, Fault> {
    let Some(data) = length.checked_sub(MESSAGE_HEAD) else {
        return Err(Fault::Damaged(format!("a message of {length} bytes")));
    };
    let mut head = [0; MESSAGE_HEAD as usize];
    reader.read_exact(&mut head)?;
    let mut fields = Ros1::new(&head);
    let (id, _, time) = (fields.u16()?, fields.u32()?, fields.u64()?);
    if let Some(channel) = declared.channels.count(id.into()).filter(|channel| wanted(channel)) {
        let (channel, time) = (Arc::clone(channel), time.try_into().unwrap_or(i64::MAX));
        return Ok(Record::Message(Message { channel, time, data: take(reader, data, MAX_MESSAGE)? }));
    }
    skip(reader, data)?;
    Ok(Record::Other)
}

/// The numbers of messages by their channels.
fn statistics(bytes: &[u8]) -> Result<HashMap<u32, u64>, Malformed> {
    let mut fields = Ros1::new(bytes);
    // Numbers of messages and schemas; of channels, attachments, pieces of metadata and chunks; the first and the last time.
    fields.u64()?;
    fields.u16()?;
    for _ in 0..4 {
        fields.u32()?;
    }
    fields.u64()?;
    fields.u64()?;
    let mut fields = Ros1::new(fields.bytes()?);
    let mut counts = HashMap::new();
    while !fields.rest().is_empty() {
        counts.insert(fields.u16()?.into(), fields.u64()?);
    }
    Ok(counts)
}

#[cfg(test)]
mod tests;
