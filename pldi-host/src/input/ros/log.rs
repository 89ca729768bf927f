//! A recording's messages, read from its beginning to its end: what the containers have in common.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use super::records::{Fault, Record, Records};
use super::topics::Channel;
use crate::Error;

/// Letters of a topic's or type's name that are kept; none is as long.
const MAX_NAME: usize = 250;

/// A message that was asked for.
#[derive(Debug, Clone)]
pub(in crate::input) struct Message {
    pub(in crate::input) channel: Arc<Channel>,
    /// When it was recorded, in nanoseconds.
    pub(in crate::input) time: i64,
    pub(in crate::input) data: Vec<u8>,
}

/// What reading on came to.
#[derive(Debug)]
pub(in crate::input) enum Step {
    Message(Message),
    /// Nothing that was asked for up to the given byte.
    Nothing,
    End,
}

/// A container of messages, read from its beginning to its end.
pub(in crate::input) trait Log: Send {
    /// The file.
    fn path(&self) -> &Path;

    /// The next message that is `wanted`, reading not much beyond the byte `until`.
    ///
    /// # Errors
    /// Where the file cannot be read at all; damage is warned about, and what can be read behind it is.
    fn next(&mut self, until: u64, wanted: &dyn Fn(&Channel) -> bool) -> Result<Step, Error>;

    /// The byte up to which the file has been read.
    fn position(&self) -> u64;

    /// Goes back to the beginning; warnings, held back before, are given from now on.
    fn rewind(&mut self);

    /// All channels with their numbers of messages, where the file has an index.
    fn index(&mut self) -> Option<Vec<(Channel, u64)>>;

    /// The channels found so far, with the numbers of their messages.
    fn seen(&self) -> Vec<(Channel, u64)>;
}

/// The channels of a file by their numbers, with counts of messages.
#[derive(Debug, Default)]
pub(in crate::input) struct Channels {
    by_id: HashMap<u32, (Arc<Channel>, u64)>,
    /// Number of messages of all.
    total: u64,
}

impl Channels {
    /// Adds a channel, its names fit for messages; a repeated declaration changes nothing.
    pub(in crate::input) fn declare(&mut self, id: u32, channel: Channel) {
        let clean = |text: String| {
            let printed =
                text.chars().take(MAX_NAME).map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c });
            printed.collect()
        };
        let Channel { topic, type_name, encoding } = channel;
        let channel = Channel { topic: clean(topic), type_name: clean(type_name), encoding: clean(encoding) };
        self.by_id.entry(id).or_insert_with(|| (Arc::new(channel), 0));
    }

    /// Counts a message; its channel, if that was declared.
    pub(in crate::input) fn count(&mut self, id: u32) -> Option<&Arc<Channel>> {
        let (channel, count) = self.by_id.get_mut(&id)?;
        *count += 1;
        self.total += 1;
        Some(channel)
    }

    /// Number of messages.
    pub(in crate::input) fn total(&self) -> u64 {
        self.total
    }

    /// Channels and their numbers.
    pub(in crate::input) fn numbered(&self) -> impl Iterator<Item = (u32, &Channel)> {
        self.by_id.iter().map(|(id, (channel, _))| (*id, &**channel))
    }

    /// Channels and counts.
    pub(in crate::input) fn list(&self) -> Vec<(Channel, u64)> {
        self.by_id.values().map(|(channel, count)| (Channel::clone(channel), *count)).collect()
    }
}

/// A container of records, in which messages are. Reading on, warnings and counts are the same for all.
pub(in crate::input) trait Container: Send {
    /// The file, and how far it has been read.
    fn records(&self) -> &Records;

    /// The same, to read on.
    fn records_mut(&mut self) -> &mut Records;

    /// What has been declared so far.
    fn channels(&self) -> &Channels;

    /// Forgets what has been declared: reading begins anew.
    fn forget(&mut self);

    /// Reads the next record, of the chunk where one is open; the data of messages only where they are `wanted`.
    ///
    /// # Errors
    /// Where it is cut, damaged, or cannot be read.
    fn record(&mut self, wanted: &dyn Fn(&Channel) -> bool) -> Result<Record, Fault>;

    /// The channels and their counts by the index at the file's end.
    ///
    /// # Errors
    /// Where there is none, or it is damaged.
    fn summary(&self) -> Result<Vec<(Channel, u64)>, Fault>;
}

impl<C: Container> Log for C {
    fn path(&self) -> &Path {
        &self.records().path
    }

    fn next(&mut self, until: u64, wanted: &dyn Fn(&Channel) -> bool) -> Result<Step, Error> {
        while !self.records().has_ended() {
            let record = self.record(wanted);
            let count = self.channels().total();
            match self.records_mut().step(record, count)? {
                Step::Nothing if !self.records().is_beyond(until) => {}
                step => return Ok(step),
            }
        }
        Ok(Step::End)
    }

    fn position(&self) -> u64 {
        self.records().at
    }

    fn rewind(&mut self) {
        self.records_mut().rewind();
        self.forget();
    }

    fn index(&mut self) -> Option<Vec<(Channel, u64)>> {
        self.summary().ok().filter(|channels| !channels.is_empty())
    }

    fn seen(&self) -> Vec<(Channel, u64)> {
        self.channels().list()
    }
}

/// What the containers' tests have in common.
#[cfg(test)]
pub(in crate::input) mod testing {
    use std::io::Write;

    use tempfile::NamedTempFile;

    use super::*;

    pub(in crate::input) fn saved(bytes: &[u8]) -> NamedTempFile {
        let mut file = NamedTempFile::new().unwrap();
        file.write_all(bytes).unwrap();
        file
    }

    /// Topics, times and data of what is wanted.
    pub(in crate::input) fn messages(
        log: &mut dyn Log,
        wanted: &dyn Fn(&Channel) -> bool,
    ) -> Vec<(String, i64, Vec<u8>)> {
        let mut found = Vec::new();
        loop {
            match log.next(u64::MAX, wanted).unwrap() {
                Step::Message(m) => found.push((m.channel.topic.clone(), m.time, m.data)),
                Step::Nothing => {}
                Step::End => return found,
            }
        }
    }

    /// Reads twice, with and without a choice: `counts` of the topics /a (images) and /b are in the index, where it is
    /// `indexed`, and in what was seen.
    pub(in crate::input) fn read_twice(
        log: &mut dyn Log,
        indexed: bool,
        counts: [u64; 2],
        expected: &[(String, i64, Vec<u8>)],
    ) {
        let sorted = |mut channels: Vec<(Channel, u64)>| {
            channels.sort();
            channels
        };
        let index = sorted(log.index().unwrap_or_default());
        let index: Vec<(&str, u64)> = index.iter().map(|(c, count)| (c.topic.as_str(), *count)).collect();
        assert_eq!(index, if indexed { vec![("/a", counts[0]), ("/b", counts[1])] } else { vec![] });
        assert_eq!(messages(log, &|_| true), expected);
        log.rewind();
        assert_eq!(messages(log, &|c| c.topic == "/b"), expected[1..2]);
        let seen = sorted(log.seen());
        assert_eq!(seen[0].0.readable().unwrap().0.name(), "Image");
        assert_eq!((seen[0].1, seen[1].1, seen[1].0.readable()), (counts[0], counts[1], None));
    }
}
