//! Bags of ROS 1 (format 2.0), read from the beginning to the end: with or without an index, finished or cut.
//!
//! A record is a header of named fields and data, each with its length in four bytes before it. Messages and what
//! declares their connections lie in chunks; a recorder that was killed leaves them outside where they were not compressed.

use std::collections::HashMap;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use super::ros::Fields;
use super::ros::chunk::{Compression, Place, Span};
use super::ros::log::{Channels, Container, Message};
use super::ros::records::{Fault, Record, Records, begins, skip, take};
use super::ros::ros1::Ros1;
use super::ros::source;
use super::ros::topics::Channel;
use super::{OpenOptions, Source};
use crate::Error;
use crate::error::excerpt;

/// The first line of a bag.
const MAGIC: &[u8; 13] = b"#ROSBAG V2.0\n";
/// Longest header of a record.
const MAX_HEADER: u64 = 1 << 20;
/// Longest data of a message that is taken, and of another record.
const MAX_MESSAGE: u64 = 256 << 20;
const MAX_DATA: u64 = 16 << 20;

/// Kinds of records.
mod op {
    pub(super) const MESSAGE: u8 = 2;
    pub(super) const BAG: u8 = 3;
    pub(super) const INDEX: u8 = 4;
    pub(super) const CHUNK: u8 = 5;
    pub(super) const CHUNK_INFO: u8 = 6;
    pub(super) const CONNECTION: u8 = 7;
}

/// Whether the file is called so, or begins so.
pub(super) fn claims(uri: &str) -> bool {
    super::open::ends_with(uri, "bag") || begins(uri, MAGIC)
}

/// Opens a recording.
///
/// # Errors
/// Where it cannot be read, is no bag, or has not the topics that are needed.
pub(super) fn open(uri: &str, options: &OpenOptions) -> Result<Box<dyn Source>, Error> {
    source::open(Box::new(Bag::open(Path::new(uri))?), options)
}

/// A bag that is read from its beginning to its end.
#[derive(Debug)]
struct Bag {
    records: Records,
    /// Where the index begins, if there is one.
    index: Option<u64>,
    channels: Channels,
}

/// The fields of a record's header.
struct Header(Vec<u8>);

impl Header {
    fn read(reader: &mut impl Read) -> Result<Self, Fault> {
        let length = read_length(reader)?;
        Ok(Self(take(reader, length, MAX_HEADER)?))
    }

    /// Bytes that it takes in the file, with its own length and that of the data.
    fn length(&self) -> u64 {
        8 + self.0.len() as u64
    }

    /// The kind of the record.
    fn kind(&self) -> Result<u8, Fault> {
        let [kind] = self.bytes("op")?;
        Ok(kind)
    }

    /// The value of a field.
    fn field(&self, name: &str) -> Result<Option<&[u8]>, Fault> {
        let mut fields = Ros1::new(&self.0);
        while !fields.rest().is_empty() {
            let field = fields.bytes()?;
            let equals = field.iter().position(|b| *b == b'=');
            let (key, value) = field.split_at(equals.ok_or_else(|| Fault::Damaged("a field without name".to_owned()))?);
            if key == name.as_bytes() {
                return Ok(value.get(1..));
            }
        }
        Ok(None)
    }

    /// The value of a field that has N bytes.
    fn bytes<const N: usize>(&self, name: &str) -> Result<[u8; N], Fault> {
        let value = self.field(name)?.and_then(|value| value.try_into().ok());
        value.ok_or_else(|| Fault::Damaged(format!("a record without {name}")))
    }

    fn u32(&self, name: &str) -> Result<u32, Fault> {
        self.bytes(name).map(u32::from_le_bytes)
    }

    fn text(&self, name: &str) -> Result<String, Fault> {
        Ok(String::from_utf8_lossy(self.field(name)?.unwrap_or_default()).into_owned())
    }
}

impl Bag {
    fn open(path: &Path) -> Result<Self, Error> {
        let mut records = Records::open(path, "bag of format 2.0", MAGIC)?;
        let (at, size) = (records.at, records.size);
        let index = file_header(&mut records.reader).ok().filter(|index| (at..size).contains(index));
        records.go_to(at);
        Ok(Self { records, index, channels: Channels::default() })
    }
}

impl Container for Bag {
    fn records(&self) -> &Records {
        &self.records
    }

    fn records_mut(&mut self) -> &mut Records {
        &mut self.records
    }

    fn channels(&self) -> &Channels {
        &self.channels
    }

    fn forget(&mut self) {
        self.channels = Channels::default();
    }

    fn record(&mut self, wanted: &dyn Fn(&Channel) -> bool) -> Result<Record, Fault> {
        let Self { records, index, channels } = self;
        let in_chunk = records.in_chunk(|chunk| {
            let header = Header::read(chunk)?;
            let length = read_length(chunk)?;
            if length > chunk.left() { Err(Fault::Cut) } else { read_data(chunk, &header, length, channels, wanted) }
        });
        if let Some(record) = in_chunk {
            return record;
        }
        let start = records.at;
        // Behind the chunks an index says once more what they hold.
        if index.is_some_and(|index| start >= index) {
            return Ok(Record::DataEnd);
        }
        let header = Header::read(&mut records.reader)?;
        let length = read_length(&mut records.reader)?;
        let at = start + header.length();
        let end = at + length;
        if header.kind()? == op::CHUNK {
            let name = header.field("compression")?.unwrap_or_default();
            let compression = Compression::named(name).filter(|c| *c != Compression::Zstd);
            // A recorder fills the lengths in when the chunk is complete; before that its records follow.
            if length == 0 && compression == Some(Compression::None) {
                records.at = end;
                return Ok(Record::Other);
            }
            let size = header.u32("size")?.into();
            let place = match compression {
                None => Err(format!("compression {:?} is not known", excerpt(&String::from_utf8_lossy(name)))),
                Some(compression) => Ok(Place { at, end, compression, size, crc: 0 }),
            };
            records.enter(start, end, place);
            return Ok(Record::Other);
        }
        if end > records.size {
            return Err(Fault::Cut);
        }
        let record = read_data(&mut records.reader, &header, length, channels, wanted)?;
        records.at = end;
        Ok(record)
    }

    fn summary(&self) -> Result<Vec<(Channel, u64)>, Fault> {
        let (mut at, size) = (self.index.ok_or(Fault::Cut)?, self.records.size);
        let mut reader = Span::new(&self.records.file, at, size);
        let (mut channels, mut counts) = (Channels::default(), HashMap::<u32, u64>::new());
        while at < size {
            let header = Header::read(&mut reader)?;
            let length = read_length(&mut reader)?;
            at += header.length() + length;
            if header.kind()? == op::CHUNK_INFO {
                let data = take(&mut reader, length, MAX_DATA)?;
                let mut fields = Ros1::new(&data);
                while !fields.rest().is_empty() {
                    let (id, count) = (fields.u32()?, fields.u32()?);
                    *counts.entry(id).or_default() += u64::from(count);
                }
            } else {
                read_data(&mut reader, &header, length, &mut channels, &|_| false)?;
            }
        }
        let count = |id: u32| counts.get(&id).copied().unwrap_or(0);
        Ok(channels.numbered().map(|(id, channel)| (channel.clone(), count(id))).collect())
    }
}

/// Where the index begins, by the record at the file's beginning; 0 where there is none.
fn file_header(reader: &mut impl Read) -> Result<u64, Fault> {
    let header = Header::read(reader)?;
    if header.kind()? != op::BAG {
        return Err(Fault::Cut);
    }
    header.bytes("index_pos").map(u64::from_le_bytes)
}

fn read_length(reader: &mut impl Read) -> Result<u64, Fault> {
    let mut length = [0; 4];
    reader.read_exact(&mut length)?;
    Ok(u32::from_le_bytes(length).into())
}

/// Reads a record's data, or passes over it; a message if its connection is wanted.
fn read_data(
    reader: &mut impl Read,
    header: &Header,
    length: u64,
    channels: &mut Channels,
    wanted: &dyn Fn(&Channel) -> bool,
) -> Result<Record, Fault> {
    match header.kind()? {
        op::MESSAGE => {
            if let Some(channel) = channels.count(header.u32("conn")?).filter(|channel| wanted(channel)) {
                let mut time = Ros1::new(header.field("time")?.unwrap_or_default());
                let time = i64::from(time.u32()?) * 1_000_000_000 + i64::from(time.u32()?);
                let channel = Arc::clone(channel);
                return Ok(Record::Message(Message { channel, time, data: take(reader, length, MAX_MESSAGE)? }));
            }
            skip(reader, length)?;
        }
        op::CONNECTION => {
            let data = Header(take(reader, length, MAX_DATA)?);
            let (topic, type_name) = (header.text("topic")?, data.text("type")?);
            channels.declare(header.u32("conn")?, Channel { topic, type_name, encoding: "ros1".to_owned() });
        }
        op::BAG | op::INDEX | op::CHUNK_INFO => skip(reader, length)?,
        other => return Err(Fault::Damaged(format!("a record of kind {other}"))),
    }
    Ok(Record::Other)
}

#[cfg(test)]
mod tests;
