//! What can happen to packets on a line, from seeds alone: bits, bursts, cuts, insertions, and packets that somebody else
//! might send.

use std::collections::HashSet;

use pldi_core::serial::packet::write;
use pldi_core::serial::{DEVICE_BUFFER, Reject, VERSION, cobs, kind};
use pldi_core::templates::crc32;
use pldi_fixtures::rng::Rng;

/// Packets between zeros, without them.
fn runs(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    bytes.split(|byte| *byte == 0).filter(|run| !run.is_empty())
}

/// Makes corrupted packets out of good ones.
#[derive(Debug, Clone)]
pub struct Corrupter {
    random: Rng,
    /// What must not come out: the packets that are sent as they are.
    good: HashSet<Vec<u8>>,
    /// How many of each kind were made.
    pub made: [u32; KINDS.len()],
}

/// What the line, or somebody, does to a packet.
pub const KINDS: [&str; 12] = [
    "bits flipped",
    "burst",
    "cut at the end",
    "cut at the beginning",
    "bytes lost within",
    "bytes inserted",
    "zero within",
    "parts swapped",
    "noise",
    "changed before the stuffing",
    "too long",
    "whole, but no message",
];

impl Corrupter {
    /// From a seed; `good` are all packets that are sent as they are.
    pub fn new<'a>(seed: u64, good: impl IntoIterator<Item = &'a Vec<u8>>) -> Self {
        let good = good.into_iter().flat_map(|packet| runs(packet)).map(<[u8]>::to_vec).collect();
        Self { random: Rng::new(seed), good, made: [0; KINDS.len()] }
    }

    /// A corrupted packet, made of a good one, with or without the zeros around it. `before` are the corrupted ones that
    /// it follows, with which it may run together.
    pub fn corrupt(&mut self, packet: &[u8], before: &[u8]) -> Vec<u8> {
        loop {
            let what = self.random.below(KINDS.len());
            let bytes = self.change(what, packet);
            let all = [before, &bytes].concat();
            // What happens to be whole would be a message; nothing but zeros is no corruption.
            if bytes.iter().any(|byte| *byte != 0) && runs(&all).all(|run| !self.good.contains(run)) {
                self.made[what] += 1;
                return bytes;
            }
        }
    }

    /// How many times a receiver must say that something is no message: once for each run of bytes between zeros.
    pub fn rejects(corrupted: &[u8]) -> u32 {
        runs(corrupted).count() as u32
    }

    fn change(&mut self, what: usize, packet: &[u8]) -> Vec<u8> {
        let random = &mut self.random;
        let (mut bytes, length) = (packet.to_vec(), packet.len());
        match what {
            0 => {
                for _ in 0..=random.below(8) {
                    bytes[random.below(length)] ^= 1 << random.below(8);
                }
            }
            1 => {
                let start = random.below(length);
                let end = (start + 1 + random.below(32)).min(length);
                bytes[start..end].fill_with(|| random.bits() as u8);
            }
            2 => bytes.truncate(random.below(length)),
            3 => drop(bytes.drain(..random.below(length))),
            4 => {
                let start = random.below(length);
                drop(bytes.drain(start..(start + 1 + random.below(200)).min(length)));
            }
            5 => {
                let inserted: Vec<u8> = (0..=random.below(40)).map(|_| random.bits() as u8).collect();
                let at = random.below(length);
                drop(bytes.splice(at..at, inserted));
            }
            6 => {
                let at = 1 + random.below(length - 2);
                bytes[at] = 0;
            }
            7 => {
                let (from, to) = (1 + random.below(length - 2), 1 + random.below(length - 2));
                let (from, to) = (from.min(to), from.max(to));
                bytes[1..to].rotate_left(from - 1);
            }
            8 => bytes = (0..=random.below(300)).map(|_| random.bits() as u8).collect(),
            9 => {
                let mut plain = unstuffed(packet);
                plain[random.below(length.min(60) - 4).min(9)] ^= 1 << random.below(8);
                bytes = stuffed(&plain);
            }
            10 => {
                let long: Vec<u8> = (0..DEVICE_BUFFER + random.below(2000)).map(|_| random.bits() as u8).collect();
                bytes = stuffed(&long);
            }
            _ => bytes = self.stranger(packet),
        }
        bytes
    }

    /// A packet whose check sum is right, but which is of another version, kind or length, or makes no sense.
    fn stranger(&mut self, packet: &[u8]) -> Vec<u8> {
        let mut plain = unstuffed(packet);
        let random = &mut self.random;
        match random.below(4) {
            0 => plain[0] = VERSION.wrapping_add(1 + (random.bits() % 255) as u8),
            1 => plain[1] = kind::STATUS.wrapping_add((random.bits() % 100) as u8),
            2 => plain[4] ^= 1 << random.below(8),
            _ => {
                // A row that is not as long as the frame is wide.
                let row: Vec<u8> = [&[0; 8][..], &vec![7; random.below(300)]].concat();
                let mut out = Vec::new();
                let mut sink = |bytes: &[u8]| out.extend_from_slice(bytes);
                write(&mut sink, kind::ROW, 9, row.len() as u16, |body| body.put(&row));
                return out;
            }
        }
        let end = plain.len() - 4;
        let sum = crc32(0, &plain[..end]).to_le_bytes();
        plain[end..].copy_from_slice(&sum);
        stuffed(&plain)
    }
}

fn stuffed(plain: &[u8]) -> Vec<u8> {
    let mut out = vec![0];
    let mut sink = |bytes: &[u8]| out.extend_from_slice(bytes);
    let mut encoder = cobs::Encoder::new(&mut sink);
    encoder.put(plain);
    encoder.finish();
    out.push(0);
    out
}

/// Header, payload and check sum of a good packet.
fn unstuffed(packet: &[u8]) -> Vec<u8> {
    let (mut plain, mut decoder) = (Vec::new(), cobs::Decoder::new());
    let mut input = &packet[1..];
    while let Some(step) = decoder.step(&mut input) {
        match step {
            cobs::Step::Bytes(bytes) => plain.extend_from_slice(bytes),
            cobs::Step::Zero => plain.push(0),
            cobs::Step::Code | cobs::Step::End(_) => {}
        }
    }
    plain
}

/// The names of the reasons with their counts.
pub fn told(counts: [u32; Reject::ALL.len()]) -> String {
    let told: Vec<String> = Reject::ALL.iter().zip(counts).map(|(reason, n)| format!("{n} {reason}")).collect();
    told.join(", ")
}
