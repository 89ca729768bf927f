//! Packets of the serial protocol: found, or rejected with a reason, whatever the bytes around them.

mod common;

use common::{Random, packet};
use pldi_core::serial::packet::{DELIMITER, wire_size};
use pldi_core::serial::{Decoder, Packet, Reject, VERSION};

/// Kind, number and payload of a packet.
type Content = (u8, u16, Vec<u8>);

/// What a decoder makes of a stream: each packet, or why there is none.
fn decode<const N: usize>(stream: &[u8], piece: usize) -> Vec<Result<Content, Reject>> {
    let mut decoder = Decoder::<N>::new();
    let mut found = Vec::new();
    for mut bytes in stream.chunks(piece) {
        while let Some(result) = decoder.feed(&mut bytes) {
            found.push(result.map(|p: Packet<'_>| (p.kind, p.sequence, p.payload.to_vec())));
        }
    }
    let rejected = found.iter().filter(|f| f.is_err()).count();
    assert_eq!(decoder.rejects().total() as usize, rejected);
    found
}

#[test]
fn packets_are_found_in_pieces_of_any_length() {
    let mut random = Random(1);
    let payloads: Vec<Vec<u8>> = [0, 1, 2, 243, 244, 245, 246, 253, 254, 255, 256, 600]
        .map(|length| (0..length).map(|_| (random.bits() % 3) as u8 * 100).collect())
        .into();
    let stream: Vec<u8> = payloads.iter().zip(0..).flat_map(|(payload, i)| packet(9, i, payload)).collect();
    for piece in [1, 2, 3, 100, 255, 256, 10_000] {
        let found = decode::<700>(&stream, piece);
        assert_eq!(found.len(), payloads.len());
        for ((found, payload), i) in found.iter().zip(&payloads).zip(0..) {
            assert_eq!(found, &Ok((9, i, payload.clone())));
        }
    }
    // Byte by byte.
    let mut decoder = Decoder::<700>::new();
    assert_eq!(stream.iter().filter(|byte| decoder.push(**byte).is_some()).count(), payloads.len());
    assert!(payloads.iter().all(|p| packet(9, 0, p).len() <= wire_size(p.len())));
}

#[test]
fn each_reason_has_its_name() {
    let good = packet(9, 1, &[1, 2, 3]);
    let plain = |header: [u8; 6], payload: &[u8], flip: u32| {
        let content = [&header[..], payload].concat();
        let sum = pldi_core::templates::crc32(0, &content) ^ flip;
        let mut out = vec![DELIMITER];
        let mut sink = |bytes: &[u8]| out.extend_from_slice(bytes);
        let mut encoder = pldi_core::serial::cobs::Encoder::new(&mut sink);
        encoder.put(&content);
        encoder.put(&sum.to_le_bytes());
        encoder.finish();
        out.push(DELIMITER);
        out
    };
    assert_eq!(plain([VERSION, 9, 1, 0, 3, 0], &[1, 2, 3], 0), good);
    let cases = [
        (plain([VERSION, 9, 1, 0, 3, 0], &[1, 2, 3], 0x0100), Reject::Checksum),
        (plain([VERSION + 1, 9, 1, 0, 3, 0], &[1, 2, 3], 0), Reject::Version),
        (plain([VERSION, 9, 1, 0, 4, 0], &[1, 2, 3], 0), Reject::Length),
        (plain([VERSION, 9, 1, 0, 2, 0], &[1, 2, 3], 0), Reject::Length),
        (vec![0, 4, 1, 2, 3, 0], Reject::Length),
        ([&good[..good.len() - 2], &[0]].concat(), Reject::Stuffing),
        (packet(9, 0, &[7; 100]), Reject::TooLong),
        (packet(9, 0, &[0; 100]), Reject::TooLong),
    ];
    for (bytes, reason) in cases {
        for piece in [1, 1000] {
            let stream = [&good, &bytes, &good].map(|b| &b[..]).concat();
            let payload = || vec![1, 2, 3];
            assert_eq!(decode::<64>(&stream, piece), [Ok((9, 1, payload())), Err(reason), Ok((9, 1, payload()))]);
        }
    }
    // Without its last delimiter, a packet ends where the next one begins.
    let stream = [&good[..good.len() - 1], &good].concat();
    assert_eq!(decode::<64>(&stream, 3).len(), 2);
    // A buffer that is just long enough, and one that is not.
    let longest = packet(9, 0, &[5; 54]);
    assert!(decode::<64>(&longest, 7)[0].is_ok());
    assert_eq!(decode::<63>(&longest, 7), [Err(Reject::TooLong)]);
}

#[test]
fn a_stream_that_is_cut_anywhere_gives_whole_packets_or_none() {
    let (a, b) = (packet(1, 1, &[0, 1, 0, 0, 2]), packet(2, 2, &[9; 300]));
    for cut in 0..=a.len() {
        // Its last delimiter may be missing: the next packet brings one.
        let whole = cut >= a.len() - 1;
        let found = decode::<400>(&[&a[..cut], &b].concat(), 11);
        assert_eq!(found.last(), Some(&Ok((2, 2, vec![9; 300]))), "{cut}");
        assert_eq!(found.iter().filter(|f| f.is_ok()).count(), 1 + usize::from(whole), "{cut}");
        assert_eq!(found.len(), if cut <= 1 { 1 } else { 2 }, "{cut}");
        assert!(decode::<400>(&a[..cut], 11).len() <= usize::from(cut == a.len()));
    }
}
