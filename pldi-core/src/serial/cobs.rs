//! Consistent Overhead Byte Stuffing (Cheshire and Baker 1999): any bytes become bytes other than 0, so that 0 can stand
//! between packets and nowhere else. It costs one byte, and one more for each 254.

/// Stuffs bytes as they come, and hands blocks of up to 255 to a sink.
#[derive(Debug)]
pub struct Encoder<'s, S: FnMut(&[u8])> {
    sink: &'s mut S,
    /// The code that tells the block's length, and the bytes behind it.
    block: [u8; 255],
    /// Bytes in the block, the code included: 1..=255.
    len: u8,
}

impl<'s, S: FnMut(&[u8])> Encoder<'s, S> {
    /// Nothing is written yet.
    pub const fn new(sink: &'s mut S) -> Self {
        Self { sink, block: [0; 255], len: 1 }
    }

    /// Takes some bytes.
    pub fn put(&mut self, bytes: &[u8]) {
        for byte in bytes {
            // A full block says nothing about a zero behind it. It waits for the next byte: at the end, no empty block
            // must follow it.
            if self.len == u8::MAX {
                self.flush();
            }
            if *byte == 0 {
                self.flush();
            } else if let Some(place) = self.block.get_mut(usize::from(self.len)) {
                *place = *byte;
                self.len += 1;
            }
        }
    }

    fn flush(&mut self) {
        self.block[0] = self.len;
        (self.sink)(self.block.get(..usize::from(self.len)).unwrap_or(&[]));
        self.len = 1;
    }

    /// Writes what is left.
    pub fn finish(mut self) {
        self.flush();
    }
}

/// Where a decoder stands within the blocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Decoder {
    /// Bytes that the block still has.
    left: u8,
    /// Whether a zero belongs between this block and the next one.
    zero: bool,
}

/// What the next bytes mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Step<'b> {
    /// Bytes of the packet, as they are.
    Bytes(&'b [u8]),
    /// A zero of the packet.
    Zero,
    /// No byte of the packet: only a code was read.
    Code,
    /// The delimiter; whether it came at the end of a block, as it should.
    End(bool),
}

impl Decoder {
    /// At the beginning of a packet.
    pub const fn new() -> Self {
        Self { left: 0, zero: false }
    }

    /// Takes bytes off the front of `input`, one at least; `None` where there is none.
    #[inline]
    pub fn step<'b>(&mut self, input: &mut &'b [u8]) -> Option<Step<'b>> {
        let (&first, rest) = input.split_first()?;
        if first == 0 {
            *input = rest;
            let whole = self.left == 0;
            *self = Self::new();
            return Some(Step::End(whole));
        }
        if self.left == 0 {
            *input = rest;
            let zero = self.zero;
            self.left = first - 1;
            self.zero = first != u8::MAX;
            return Some(if zero { Step::Zero } else { Step::Code });
        }
        // `left` is 1 at least, and so is the run: the first byte is no zero.
        let window = input.get(..usize::from(self.left)).unwrap_or(input);
        let run = window.iter().position(|byte| *byte == 0).unwrap_or(window.len());
        let (bytes, rest) = input.split_at_checked(run)?;
        *input = rest;
        self.left -= run as u8;
        Some(Step::Bytes(bytes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn encode(bytes: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        let mut sink = |block: &[u8]| out.extend_from_slice(block);
        let mut encoder = Encoder::new(&mut sink);
        encoder.put(bytes);
        encoder.finish();
        out
    }

    /// The bytes of a stuffed packet whose delimiter follows, given in pieces.
    fn decode(stuffed: &[u8], piece: usize) -> Option<Vec<u8>> {
        let (mut out, mut decoder) = (Vec::new(), Decoder::new());
        for piece in [stuffed, &[0]].concat().chunks(piece) {
            let mut input = piece;
            while let Some(step) = decoder.step(&mut input) {
                match step {
                    Step::Bytes(bytes) => out.extend_from_slice(bytes),
                    Step::Zero => out.push(0),
                    Step::Code => {}
                    Step::End(whole) => return whole.then_some(out),
                }
            }
        }
        None
    }

    #[test]
    fn the_papers_and_the_encyclopaedias_examples() {
        let run = |from: u8, to: u8| (from..=to).collect::<Vec<u8>>();
        for (plain, stuffed) in [
            (vec![], vec![1]),
            (vec![0], vec![1, 1]),
            (vec![0, 0], vec![1, 1, 1]),
            (vec![0x11, 0x22, 0, 0x33], vec![3, 0x11, 0x22, 2, 0x33]),
            (vec![0x11, 0, 0, 0], vec![2, 0x11, 1, 1, 1]),
            (run(1, 254), [vec![255], run(1, 254)].concat()),
            ([vec![0], run(1, 254)].concat(), [vec![1, 255], run(1, 254)].concat()),
            (run(1, 255), [vec![255], run(1, 254), vec![2, 255]].concat()),
            ([run(2, 255), vec![0]].concat(), [vec![255], run(2, 255), vec![1, 1]].concat()),
        ] {
            assert_eq!(encode(&plain), stuffed);
            assert_eq!(decode(&stuffed, 1), Some(plain));
        }
    }

    #[test]
    fn a_block_that_is_cut_is_noticed() {
        assert_eq!(decode(&[5, 1, 2, 3], 9), None);
        assert_eq!(decode(&[1, 3, 7], 1), None);
    }

    proptest! {
        #[test]
        fn decoding_undoes_encoding(
            plain in proptest::collection::vec(prop_oneof![3 => any::<u8>(), 1 => Just(0), 8 => Just(7)], 0..1500),
            piece in 1usize..600,
        ) {
            let stuffed = encode(&plain);
            prop_assert!(!stuffed.contains(&0));
            prop_assert!(stuffed.len() <= plain.len() + 1 + plain.len() / 254);
            prop_assert_eq!(decode(&stuffed, piece), Some(plain));
        }
    }
}
