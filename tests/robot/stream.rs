//! A frame's packets with everything between them that a bad line, or a host that is not sure, puts there.

use super::corrupt::Corrupter;
use pldi_fixtures::rng::Rng;

/// What was put together, and what a device must count of it.
#[derive(Debug, Clone, Default)]
pub struct Stream {
    /// The bytes.
    pub bytes: Vec<u8>,
    /// Packets that are to be accepted, repeated ones included.
    pub accepted: u32,
    /// Repeated packets among them.
    pub repeated: u32,
    /// Packets that were corrupted.
    pub corrupted: u32,
    /// Rejections that these ask for.
    pub rejects: u32,
}

impl Stream {
    /// The packets in their order, with `corrupted` corrupted ones before some of them, and some sent again: at once, or
    /// later within the frame.
    pub fn new(
        packets: &[Vec<u8>],
        corrupted: usize,
        repeated: usize,
        corrupter: &mut Corrupter,
        random: &mut Rng,
    ) -> Self {
        let mut stream = Self::default();
        let mut share = |count: usize| -> Vec<usize> {
            let mut at = vec![0; packets.len()];
            (0..count).for_each(|_| at[random.below(packets.len())] += 1);
            at
        };
        let (corrupted, repeated) = (share(corrupted), share(repeated));
        for (i, packet) in packets.iter().enumerate() {
            let mut between: Vec<u8> = Vec::new();
            for _ in 0..corrupted[i] {
                // The packet itself before it comes whole, one of the frame's others, and what was left of them runs
                // together.
                let other = if random.below(2) == 0 { packet } else { &packets[random.below(packets.len())] };
                between.extend(corrupter.corrupt(other, &between));
                stream.corrupted += 1;
            }
            stream.rejects += Corrupter::rejects(&between);
            stream.bytes.extend(between);
            stream.bytes.extend(packet);
            stream.accepted += 1;
            for _ in 0..repeated[i] {
                let again = if random.below(2) == 0 { i } else { random.below(i + 1) };
                stream.bytes.extend(&packets[again]);
                stream.accepted += 1;
                stream.repeated += 1;
            }
        }
        stream
    }
}
