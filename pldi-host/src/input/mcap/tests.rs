use std::io::Write;

use proptest::prelude::*;

use super::super::ros::log::Log;
use super::super::ros::log::testing::{messages, read_twice, saved};
use super::*;

fn record(kind: u8, body: &[u8]) -> Vec<u8> {
    [&[kind][..], &(body.len() as u64).to_le_bytes(), body].concat()
}

fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat()
}

fn schema(id: u16, name: &str) -> Vec<u8> {
    record(kind::SCHEMA, &[&id.to_le_bytes()[..], &text(name), &text("ros2msg"), &text("uint8 x")].concat())
}

fn channel(id: u16, schema: u16, topic: &str) -> Vec<u8> {
    let (id, schema) = (id.to_le_bytes(), schema.to_le_bytes());
    record(kind::CHANNEL, &[&id[..], &schema, &text(topic), &text("cdr"), &0u32.to_le_bytes()].concat())
}

fn message(channel: u16, time: u64, data: &[u8]) -> Vec<u8> {
    let time = time.to_le_bytes();
    record(kind::MESSAGE, &[&channel.to_le_bytes()[..], &[0; 4], &time, &time, data].concat())
}

fn chunk(compression: &str, records: &[u8]) -> Vec<u8> {
    let packed = match compression {
        "zstd" => zstd::encode_all(records, 1).unwrap(),
        "lz4" => {
            let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
            encoder.write_all(records).unwrap();
            encoder.finish().unwrap()
        }
        _ => records.to_vec(),
    };
    let (size, crc) = ((records.len() as u64).to_le_bytes(), crc32fast::hash(records).to_le_bytes());
    let length = (packed.len() as u64).to_le_bytes();
    record(kind::CHUNK, &[&[0; 16][..], &size, &crc, &text(compression), &length, &packed].concat())
}

/// Three messages of two topics, one of them outside of chunks, and an attachment.
fn data(compression: &str) -> Vec<u8> {
    let declared =
        [schema(1, "sensor_msgs/msg/Image"), schema(2, "x"), channel(3, 1, "/a"), channel(4, 2, "/b")].concat();
    let first = [declared, message(3, 10, b"one"), message(4, 20, &[7; 300])].concat();
    let attachment = record(kind::ATTACHMENT, &[9; 100]);
    let (first, third) = (chunk(compression, &first), chunk(compression, &message(3, 30, b"three")));
    [&MAGIC[..], &record(kind::HEADER, &[0; 8]), &first, &attachment, &message(3, 25, b"two"), &third].concat()
}

/// The end of a finished file of these data: with a summary or without.
fn finished(mut data: Vec<u8>, summary: bool) -> Vec<u8> {
    data.extend(record(kind::DATA_END, &[0; 4]));
    let start = if summary { data.len() as u64 } else { 0 };
    if summary {
        let counts = [&3u16.to_le_bytes()[..], &3u64.to_le_bytes(), &4u16.to_le_bytes(), &1u64.to_le_bytes()].concat();
        let statistics = [&[0; 42][..], &(counts.len() as u32).to_le_bytes(), &counts].concat();
        data.extend([schema(1, "sensor_msgs/msg/Image"), channel(3, 1, "/a"), channel(4, 2, "/b")].concat());
        data.extend(record(kind::STATISTICS, &statistics));
    }
    data.extend(record(kind::FOOTER, &[&start.to_le_bytes()[..], &[0; 12]].concat()));
    data.extend(MAGIC);
    data
}

fn all(bytes: &[u8]) -> Vec<(String, i64, Vec<u8>)> {
    messages(&mut Mcap::open(saved(bytes).path()).unwrap(), &|_| true)
}

fn expected() -> Vec<(String, i64, Vec<u8>)> {
    let of = |topic: &str, time, data: &[u8]| (topic.to_owned(), time, data.to_owned());
    vec![of("/a", 10, b"one"), of("/b", 20, &[7; 300]), of("/a", 25, b"two"), of("/a", 30, b"three")]
}

#[test]
fn every_compression_with_and_without_a_summary() {
    for compression in ["", "zstd", "lz4"] {
        for summary in [false, true] {
            let file = saved(&finished(data(compression), summary));
            let mut log = Mcap::open(file.path()).unwrap();
            read_twice(&mut log, summary, [3, 1], &expected());
        }
    }
}

#[test]
fn a_cut_file_is_read_as_far_as_it_goes() {
    for compression in ["", "zstd", "lz4"] {
        let whole = finished(data(compression), true);
        let mut before = 0;
        for cut in MAGIC.len()..whole.len() {
            let got = all(&whole[..cut]);
            assert!(expected().starts_with(&got) && got.len() >= before, "{cut}");
            before = got.len();
        }
        assert_eq!(before, 4);
    }
}

#[test]
fn a_damaged_chunk_is_left_out_and_what_is_behind_it_is_read() {
    for compression in ["", "zstd", "lz4"] {
        let whole = finished(data(compression), false);
        let mut damaged = whole.clone();
        let at = MAGIC.len() + HEAD as usize + 8 + HEAD as usize + 60 + compression.len();
        damaged[at] ^= 0xff;
        assert_eq!(all(&damaged).len(), 0, "{compression}: nothing is declared without the first chunk");
        // The last chunk.
        let mut damaged = data(compression);
        let at = damaged.len() - 8;
        damaged[at] ^= 0xff;
        assert_eq!(all(&finished(damaged, false)), expected()[..3], "{compression}");
    }
    let unknown = [data(""), chunk("xz", b""), message(4, 40, b"four")].concat();
    assert_eq!(all(&finished(unknown, false)).len(), 5);
}

#[test]
fn records_that_lie_about_their_length_are_refused() {
    // A message in a chunk that goes beyond it.
    let mut long = message(3, 40, b"x");
    long[1] = 200;
    let file = [data(""), chunk("", &long), message(3, 50, b"behind")].concat();
    assert_eq!(all(&finished(file, false)).len(), 5);
    // Outside of chunks nothing behind it can be found.
    for length in [1u64 << 40, u64::MAX] {
        let mut absurd = message(3, 40, b"x");
        absurd[1..9].copy_from_slice(&length.to_le_bytes());
        assert_eq!(all(&[data(""), absurd, message(3, 50, b"behind")].concat()), expected());
    }
    assert_eq!(all(&[data(""), record(0, b""), message(3, 50, b"behind")].concat()), expected());
    assert_eq!(all(&[data(""), record(0x90, b"foreign"), message(3, 50, b"behind")].concat()).len(), 5);
}

#[test]
fn as_many_topics_as_there_can_be_take_no_longer_each() {
    let mut file = [&MAGIC[..], &schema(1, "sensor_msgs/msg/Image")].concat();
    let topics = 0..=u16::MAX;
    file.extend(topics.clone().flat_map(|id| channel(id, 1, &format!("/{id}/rgb"))));
    file.extend(topics.flat_map(|id| message(id, 1, b"")));
    let error = source::open(Box::new(Mcap::open(saved(&file).path()).unwrap()), &OpenOptions::default());
    let error = error.err().unwrap().to_string();
    assert!(error.contains("no depth topic") && error.contains("and 65496 more"), "{error}");
}

#[test]
fn absurd_numbers_of_messages_are_only_announced() {
    let counts: Vec<u8> = (1..=2u16).flat_map(|id| [&id.to_le_bytes()[..], &[0xff; 8]].concat()).collect();
    let statistics = [&[0; 42][..], &(counts.len() as u32).to_le_bytes(), &counts].concat();
    let declared = [schema(1, "sensor_msgs/msg/Image"), channel(1, 1, "/depth"), channel(2, 1, "/depth")].concat();
    let start = MAGIC.len() as u64;
    let footer = record(kind::FOOTER, &[&start.to_le_bytes()[..], &[0; 12]].concat());
    let file = [&MAGIC[..], &declared, &record(kind::STATISTICS, &statistics), &footer, &MAGIC].concat();
    let frames = source::open(Box::new(Mcap::open(saved(&file).path()).unwrap()), &OpenOptions::default()).unwrap();
    assert_eq!(frames.frames(), usize::try_from(u64::MAX).ok());
}

#[test]
fn what_is_no_mcap_is_said() {
    let refused = |bytes: &[u8]| Mcap::open(saved(bytes).path()).unwrap_err().to_string();
    assert!(refused(b"").contains("0 bytes"));
    assert!(refused(b"\x89MCAP").contains("does not begin as one"));
    assert!(refused(b"#ROSBAG V2.0\n").contains("no MCAP"));
    assert!(claims("nowhere.MCAP") && !claims("nowhere.bag"));
    assert!(claims(saved(&data("")).path().to_str().unwrap()));
    let missing = Mcap::open(Path::new("nowhere.mcap")).unwrap_err().to_string();
    assert!(missing.contains("cannot read nowhere.mcap"), "{missing}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn no_bytes_panic(
        compression in prop_oneof![Just(""), Just("zstd"), Just("lz4")],
        changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12),
    ) {
        let mut bytes = finished(data(compression), true);
        for (at, value) in changes {
            let at = at.index(bytes.len() - MAGIC.len()) + MAGIC.len();
            bytes[at] = value;
        }
        let file = saved(&bytes);
        let mut log = Mcap::open(file.path()).unwrap();
        let _ = log.index();
        prop_assert!(messages(&mut log, &|_| true).len() < 100);
    }
}
