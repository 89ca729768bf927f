//! CDR (XCDR1), the serialisation of ROS 2: numbers of n bytes stand at multiples of n, counted from behind the four
//! bytes that name the representation.

use super::{Bytes, Fields, Malformed};

/// Reads the fields of a message in CDR. No length is believed before the bytes are there.
#[derive(Debug, Clone)]
pub(in crate::input) struct Cdr<'a> {
    bytes: Bytes<'a>,
    little: bool,
}

/// Length of what names the representation.
const HEAD: usize = 4;

impl<'a> Cdr<'a> {
    /// Takes the bytes of a whole message.
    pub(in crate::input) fn new(message: &'a [u8]) -> Result<Self, Malformed> {
        let mut bytes = Bytes::new(message);
        let [kind0, kind1, _, _] = bytes.array::<HEAD>()?;
        match [kind0, kind1] {
            [0, 0] => Ok(Self { bytes, little: false }),
            [0, 1] => Ok(Self { bytes, little: true }),
            other => Err(Malformed::Representation(u16::from_be_bytes(other))),
        }
    }

    fn aligned<const N: usize>(&mut self) -> Result<[u8; N], Malformed> {
        let padding = (self.bytes.at - HEAD).wrapping_neg() % N;
        self.bytes.take(padding as u64)?;
        self.bytes.array()
    }
}

impl<'a> Fields<'a> for Cdr<'a> {
    const HEADER_SEQ: bool = false;

    fn u8(&mut self) -> Result<u8, Malformed> {
        Ok(u8::from_le_bytes(self.bytes.array()?))
    }

    fn u32(&mut self) -> Result<u32, Malformed> {
        let bytes = self.aligned()?;
        Ok(if self.little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) })
    }

    fn f64(&mut self) -> Result<f64, Malformed> {
        let bytes = self.aligned()?;
        Ok(if self.little { f64::from_le_bytes(bytes) } else { f64::from_be_bytes(bytes) })
    }

    /// The length counts a NUL at the end; some writers leave it out of an empty text.
    fn text(&mut self) -> Result<&'a str, Malformed> {
        let length = self.u32()?;
        let text = self.bytes.text(length.into())?;
        Ok(text.strip_suffix('\0').unwrap_or(text))
    }

    fn bytes(&mut self) -> Result<&'a [u8], Malformed> {
        let length = self.u32()?;
        self.bytes.take(length.into())
    }

    fn f64s(&mut self) -> Result<Vec<f64>, Malformed> {
        let length = self.u32()?;
        // The numbers are pushed as they are found: the length alone takes no memory.
        let mut numbers = Vec::new();
        for _ in 0..length {
            numbers.push(self.f64()?);
        }
        Ok(numbers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn numbers_stand_at_multiples_of_their_size() {
        let little = [
            0, 1, 0, 0, // representation
            7, 0xee, 0xee, 0xee, // a byte and padding
            4, 3, 2, 1, // u32
            0, 0, 0, 0, 0, 0, 0xf8, 0x3f, // f64 at 8, counted from behind the representation
            4, 0, 0, 0, b'a', b'b', b'c', 0, // text
            2, 0, 0, 0, 9, 8, // bytes
            0xee, 0xee, 1, 0, 0, 0, 0xee, 0xee, 0xee, 0xee, // one number
            0, 0, 0, 0, 0, 0, 0, 0x40,
        ];
        let mut cdr = Cdr::new(&little).unwrap();
        assert_eq!((cdr.u8(), cdr.u32(), cdr.f64()), (Ok(7), Ok(0x0102_0304), Ok(1.5)));
        assert_eq!((cdr.text(), cdr.bytes()), (Ok("abc"), Ok(&[9, 8][..])));
        assert_eq!(cdr.f64s(), Ok(vec![2.0]));
        assert_eq!(cdr.u8(), Err(Malformed::Cut { at: little.len(), needed: 1, len: little.len() }));
        let big = [0, 0, 0, 0, 1, 2, 3, 4, 0xee, 0xee, 0xee, 0xee, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0];
        let mut cdr = Cdr::new(&big).unwrap();
        assert_eq!((cdr.u32(), cdr.u32(), cdr.f64()), (Ok(0x0102_0304), Ok(0xeeee_eeee), Ok(0.0)));
        assert_eq!(cdr.text(), Ok(""));
    }

    #[test]
    fn what_is_no_plain_cdr_is_named() {
        assert_eq!(Cdr::new(&[0, 3, 0, 0]).unwrap_err(), Malformed::Representation(3));
        assert_eq!(Cdr::new(&[0, 1, 0]).unwrap_err(), Malformed::Cut { at: 0, needed: 4, len: 3 });
        let mut text = Cdr::new(&[0, 1, 0, 0, 2, 0, 0, 0, 0xff, 0]).unwrap();
        assert_eq!(text.text(), Err(Malformed::Text(8)));
        let mut long = Cdr::new(&[0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff]).unwrap();
        assert_eq!(long.clone().bytes(), Err(Malformed::Cut { at: 8, needed: 0xffff_ffff, len: 8 }));
        assert!(long.f64s().is_err());
    }

    proptest! {
        #[test]
        fn no_bytes_panic(bytes in proptest::collection::vec(any::<u8>(), 0..64), asked in "[1478tbs]{0,12}") {
            if let Ok(mut cdr) = Cdr::new(&bytes) {
                for what in asked.chars() {
                    let _ = match what {
                        '1' => cdr.u8().map(drop),
                        '4' => cdr.u32().map(drop),
                        '8' => cdr.f64().map(drop),
                        't' => cdr.text().map(drop),
                        'b' => cdr.bytes().map(drop),
                        _ => cdr.f64s().map(drop),
                    };
                }
            }
        }
    }
}
