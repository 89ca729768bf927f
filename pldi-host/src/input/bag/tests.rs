use std::io::Write;

use proptest::prelude::*;

use super::super::ros::log::Log;
use super::super::ros::log::testing::{messages, read_twice, saved};
use super::*;

fn header(fields: &[(&str, &[u8])]) -> Vec<u8> {
    let field = |(name, value): &(&str, &[u8])| {
        let length = (name.len() + 1 + value.len()) as u32;
        [&length.to_le_bytes(), name.as_bytes(), b"=", value].concat()
    };
    fields.iter().flat_map(field).collect()
}

fn record(fields: &[(&str, &[u8])], data: &[u8]) -> Vec<u8> {
    let header = header(fields);
    let (h, d) = ((header.len() as u32).to_le_bytes(), (data.len() as u32).to_le_bytes());
    [&h, header.as_slice(), &d, data].concat()
}

fn connection(id: u32, topic: &str, type_name: &str) -> Vec<u8> {
    let data = header(&[("topic", topic.as_bytes()), ("type", type_name.as_bytes()), ("md5sum", b"*")]);
    record(&[("conn", &id.to_le_bytes()), ("op", &[op::CONNECTION]), ("topic", topic.as_bytes())], &data)
}

fn message(id: u32, seconds: u32, data: &[u8]) -> Vec<u8> {
    let time = [seconds.to_le_bytes(), 5u32.to_le_bytes()].concat();
    record(&[("op", &[op::MESSAGE]), ("conn", &id.to_le_bytes()), ("time", &time)], data)
}

fn chunk(compression: &str, records: &[u8]) -> Vec<u8> {
    let packed = match compression {
        "bz2" => {
            let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
            encoder.write_all(records).unwrap();
            encoder.finish().unwrap()
        }
        "lz4" => {
            let checked = lz4_flex::frame::FrameInfo::new().content_checksum(true);
            let mut encoder = lz4_flex::frame::FrameEncoder::with_frame_info(checked, Vec::new());
            encoder.write_all(records).unwrap();
            encoder.finish().unwrap()
        }
        _ => records.to_vec(),
    };
    let size = (records.len() as u32).to_le_bytes();
    record(&[("op", &[op::CHUNK]), ("compression", compression.as_bytes()), ("size", &size)], &packed)
}

/// Three messages of two topics in two chunks; the file's header says where the index is.
fn data(compression: &str, index: u64) -> Vec<u8> {
    let connections = [connection(0, "/a", "sensor_msgs/Image"), connection(1, "/b", "x")].concat();
    let first = [connections, message(0, 1, b"one"), message(1, 2, &[7; 300])].concat();
    let counts = [&[0u8; 4][..], &1u32.to_le_bytes()].concat();
    let file = record(
        &[("op", &[op::BAG]), ("index_pos", &index.to_le_bytes()), ("conn_count", &[0; 4]), ("chunk_count", &[0; 4])],
        &[b' '; 200],
    );
    let index = record(&[("op", &[op::INDEX]), ("ver", &[1, 0, 0, 0]), ("conn", &[0; 4])], &counts);
    let (first, third) = (chunk(compression, &first), chunk(compression, &message(0, 3, b"three")));
    [&MAGIC[..], &file, &first, &index, &third].concat()
}

/// A finished bag.
fn finished(compression: &str) -> Vec<u8> {
    let data = data(compression, data(compression, 0).len() as u64);
    let info = |counts: &[[u32; 2]]| {
        let counts: Vec<u8> = counts.as_flattened().iter().flat_map(|n| n.to_le_bytes()).collect();
        record(&[("op", &[op::CHUNK_INFO]), ("ver", &[1, 0, 0, 0])], &counts)
    };
    let connections = [connection(0, "/a", "sensor_msgs/Image"), connection(1, "/b", "x")].concat();
    [data, connections, info(&[[0, 1], [1, 1]]), info(&[[0, 1]])].concat()
}

fn all(bytes: &[u8]) -> Vec<(String, i64, Vec<u8>)> {
    messages(&mut Bag::open(saved(bytes).path()).unwrap(), &|_| true)
}

fn expected() -> Vec<(String, i64, Vec<u8>)> {
    let of = |topic: &str, time: i64, data: &[u8]| (topic.to_owned(), time * 1_000_000_000 + 5, data.to_owned());
    vec![of("/a", 1, b"one"), of("/b", 2, &[7; 300]), of("/a", 3, b"three")]
}

#[test]
fn every_compression_with_and_without_an_index() {
    for compression in ["none", "lz4", "bz2"] {
        for (bytes, indexed) in [(finished(compression), true), (data(compression, 0), false)] {
            let file = saved(&bytes);
            let mut log = Bag::open(file.path()).unwrap();
            read_twice(&mut log, indexed, [2, 1], &expected());
        }
    }
}

#[test]
fn a_cut_bag_is_read_as_far_as_it_goes() {
    for compression in ["none", "lz4", "bz2"] {
        let whole = finished(compression);
        let mut before = 0;
        for cut in MAGIC.len()..whole.len() {
            let got = all(&whole[..cut]);
            assert!(expected().starts_with(&got) && got.len() >= before, "{cut}");
            before = got.len();
        }
        assert_eq!(before, 3);
    }
}

#[test]
fn a_chunk_that_was_never_completed_is_read() {
    // As it is on the disk while a recorder works: the lengths are filled in later.
    let open = record(&[("op", &[op::CHUNK]), ("compression", b"none"), ("size", &[0; 4])], b"");
    let file = [data("none", 0), open, message(0, 4, b"four"), message(1, 5, b"cut")[..20].to_vec()].concat();
    let got = all(&file);
    assert_eq!((got.len(), got[3].2.as_slice()), (4, &b"four"[..]));
}

#[test]
fn a_damaged_chunk_is_left_out_and_what_is_behind_it_is_read() {
    for compression in ["lz4", "bz2"] {
        let mut damaged = data(compression, 0);
        let at = damaged.len() - 8;
        damaged[at] ^= 0xff;
        damaged.extend(chunk(compression, &message(0, 4, b"four")));
        let got = all(&damaged);
        assert_eq!((&got[..2], got[2].2.as_slice()), (&expected()[..2], &b"four"[..]), "{compression}");
    }
    let unknown = [data("none", 0), chunk("xz", b""), message(1, 4, b"four")].concat();
    assert_eq!(all(&unknown).len(), 4);
    let mut long = message(0, 4, b"x");
    let at = long.len() - 5;
    long[at] = 200;
    assert_eq!(all(&[data("none", 0), chunk("none", &long), message(1, 5, b"behind")].concat()).len(), 4);
    assert_eq!(all(&[data("none", 0), long, message(1, 5, b"behind")].concat()).len(), 3);
}

#[test]
fn what_is_no_bag_is_said() {
    let refused = |bytes: &[u8]| Bag::open(saved(bytes).path()).unwrap_err().to_string();
    assert!(refused(b"").contains("0 bytes"));
    assert!(refused(b"#ROSBAG V1.2\nxxxxxxxx").contains("no bag of format 2.0"));
    assert!(claims("nowhere.BAG") && claims(saved(&finished("none")).path().to_str().unwrap()) && !claims("x.mcap"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn no_bytes_panic(
        compression in prop_oneof![Just("none"), Just("bz2"), Just("lz4")],
        changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12),
    ) {
        let mut bytes = finished(compression);
        for (at, value) in changes {
            let at = at.index(bytes.len() - MAGIC.len()) + MAGIC.len();
            bytes[at] = value;
        }
        let file = saved(&bytes);
        let mut log = Bag::open(file.path()).unwrap();
        let _ = log.index();
        prop_assert!(messages(&mut log, &|_| true).len() < 100);
    }
}
