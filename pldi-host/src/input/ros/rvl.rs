//! RVL (Wilson 2017), the depth compression of `compressedDepth rvl`: runs of zeros and of differences, in groups of
//! three bits.

/// Decodes `pixels` values; none where the bytes end before or a run goes beyond them.
pub(super) fn decode(bytes: &[u8], pixels: usize) -> Option<Vec<u16>> {
    let mut nibbles = Nibbles { bytes, at: 0 };
    let mut values: Vec<u16> = Vec::new();
    let mut previous = 0u16;
    while values.len() < pixels {
        let zeros = usize::try_from(nibbles.number()?).ok()?;
        let end = values.len().checked_add(zeros).filter(|end| *end <= pixels)?;
        values.resize(end, 0);
        let others = usize::try_from(nibbles.number()?).ok()?;
        let end = values.len().checked_add(others).filter(|end| *end <= pixels)?;
        while values.len() < end {
            let zigzag = nibbles.number()?;
            let difference = (zigzag >> 1) as i32 ^ -((zigzag & 1) as i32);
            previous = previous.wrapping_add(difference as u16);
            values.push(previous);
        }
        // Neither zeros nor others: no encoder writes that, and it could go on for ever.
        if zeros == 0 && others == 0 {
            return None;
        }
    }
    Some(values)
}

/// Groups of four bits, the highest of each little-endian word of 32 bits first.
struct Nibbles<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Nibbles<'_> {
    /// A number in groups of three bits, the lowest first; the fourth bit says that more follow.
    fn number(&mut self) -> Option<u32> {
        let mut value = 0u32;
        for shift in (0..32).step_by(3) {
            let (word, nibble) = (self.at / 8 * 4, self.at % 8);
            let byte = *self.bytes.get(word + 3 - nibble / 2)?;
            self.at += 1;
            let bits = u32::from(if nibble % 2 == 0 { byte >> 4 } else { byte & 15 });
            value |= (bits & 7) << shift;
            if bits & 8 == 0 {
                return Some(value);
            }
        }
        None
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The encoder, as published.
    pub(in super::super) fn encode(values: &[u16]) -> Vec<u8> {
        let mut nibbles: Vec<u8> = Vec::new();
        let mut number = |mut value: u32| {
            loop {
                let more = value >> 3 != 0;
                nibbles.push((value & 7) as u8 | u8::from(more) << 3);
                value >>= 3;
                if !more {
                    break;
                }
            }
        };
        let (mut at, mut previous) = (0, 0i32);
        while at < values.len() {
            let zeros = values[at..].iter().take_while(|v| **v == 0).count();
            let others = values[at + zeros..].iter().take_while(|v| **v != 0).count();
            number(zeros as u32);
            number(others as u32);
            for &value in &values[at + zeros..at + zeros + others] {
                let difference = i32::from(value) - previous;
                number((difference << 1 ^ difference >> 31) as u32);
                previous = value.into();
            }
            at += zeros + others;
        }
        nibbles.resize(nibbles.len().next_multiple_of(8), 0);
        let word = |n: &[u8]| n.iter().fold(0u32, |word, n| word << 4 | u32::from(*n)).to_le_bytes();
        nibbles.chunks(8).flat_map(word).collect()
    }

    #[test]
    fn a_known_word() {
        // 2 zeros, 2 others: 5 (+5 is 10 = 2 + 8 * 1) and 4 (-1 is 1).
        assert_eq!(decode(&0x22a1_1000u32.to_le_bytes(), 4), Some(vec![0, 0, 5, 4]));
        assert_eq!(encode(&[0, 0, 5, 4]), 0x22a1_1000u32.to_le_bytes());
    }

    #[test]
    fn runs_beyond_the_image_and_cut_bytes_are_refused() {
        let whole = encode(&[0, 0, 5, 4, 1000, 0, 65_535, 1]);
        assert!(decode(&whole, 8).is_some() && decode(&whole, 7).is_none());
        for cut in 0..whole.len() - 3 {
            assert!(decode(&whole[..cut], 8).is_none(), "{cut}");
        }
        assert_eq!(decode(&[0; 64], 8), None, "empty runs without end");
        assert_eq!(decode(&[0xff; 64], usize::MAX), None, "a number without end");
    }

    proptest! {
        #[test]
        fn what_is_encoded_comes_back(values in proptest::collection::vec(prop_oneof![Just(0), any::<u16>()], 0..200)) {
            prop_assert_eq!(decode(&encode(&values), values.len()), Some(values));
        }

        #[test]
        fn no_bytes_panic(bytes in proptest::collection::vec(any::<u8>(), 0..64), pixels in 0usize..5000) {
            let _ = decode(&bytes, pixels);
        }
    }
}
