//! The serialisation of ROS 1, which is also that of the records in bags and MCAP files: little-endian and packed.

use super::{Bytes, Fields, Malformed};

/// Reads packed little-endian fields. No length is believed before the bytes are there.
#[derive(Debug, Clone)]
pub(in crate::input) struct Ros1<'a>(Bytes<'a>);

impl<'a> Ros1<'a> {
    /// Takes the bytes of a whole message or record.
    pub(in crate::input) fn new(message: &'a [u8]) -> Self {
        Self(Bytes::new(message))
    }

    /// An unsigned number of two bytes.
    pub(in crate::input) fn u16(&mut self) -> Result<u16, Malformed> {
        self.0.array().map(u16::from_le_bytes)
    }

    /// An unsigned number of eight bytes.
    pub(in crate::input) fn u64(&mut self) -> Result<u64, Malformed> {
        self.0.array().map(u64::from_le_bytes)
    }

    /// What has not been read yet.
    pub(in crate::input) fn rest(&self) -> &'a [u8] {
        self.0.all.get(self.0.at..).unwrap_or_default()
    }
}

impl<'a> Fields<'a> for Ros1<'a> {
    const HEADER_SEQ: bool = true;

    fn u8(&mut self) -> Result<u8, Malformed> {
        self.0.array().map(u8::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32, Malformed> {
        self.0.array().map(u32::from_le_bytes)
    }

    fn f64(&mut self) -> Result<f64, Malformed> {
        self.0.array().map(f64::from_le_bytes)
    }

    fn text(&mut self) -> Result<&'a str, Malformed> {
        let length = self.u32()?;
        self.0.text(length.into())
    }

    fn bytes(&mut self) -> Result<&'a [u8], Malformed> {
        let length = self.u32()?;
        self.0.take(length.into())
    }

    fn f64s(&mut self) -> Result<Vec<f64>, Malformed> {
        let length = self.u32()?;
        let bytes = self.0.take(u64::from(length) * 8)?;
        let (numbers, _) = bytes.as_chunks::<8>();
        Ok(numbers.iter().map(|&number| f64::from_le_bytes(number)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_packed() {
        let bytes = [
            7, 4, 3, 2, 1, 0, 0, 0, 0, 0, 0, 0xf8, 0x3f, 2, 0, 0, 0, b'a', b'b', 1, 0, 0, 0, 9, //
            1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x40, 1, 2, 8, 7, 6, 5, 4, 3, 2, 1, 5,
        ];
        let mut fields = Ros1::new(&bytes);
        assert_eq!((fields.u8(), fields.u32(), fields.f64()), (Ok(7), Ok(0x0102_0304), Ok(1.5)));
        assert_eq!((fields.text(), fields.bytes()), (Ok("ab"), Ok(&[9][..])));
        assert_eq!((fields.f64s(), fields.u16(), fields.u64()), (Ok(vec![2.0]), Ok(0x0201), Ok(0x0102_0304_0506_0708)));
        assert_eq!(fields.rest(), [5]);
        assert_eq!(fields.text(), Err(Malformed::Cut { at: 46, needed: 4, len: 47 }));
        assert!(Ros1::new(&[0xff; 4]).f64s().is_err());
    }
}
