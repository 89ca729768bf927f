//! Messages as ROS 2 writes them: XCDR version 1, little-endian.

/// Bytes of the encapsulation: the representation, and options that nobody uses. Alignment counts from behind them.
const HEADER: [u8; 4] = [0, 1, 0, 0];

/// A message that is being written, field by field.
#[derive(Debug, Clone)]
pub(super) struct Cdr(Vec<u8>);

impl Cdr {
    /// An empty message, with memory for `capacity` bytes.
    pub(super) fn new(capacity: usize) -> Self {
        let mut bytes = Vec::with_capacity(HEADER.len() + capacity);
        bytes.extend(HEADER);
        Self(bytes)
    }

    /// The message.
    pub(super) fn into_bytes(self) -> Vec<u8> {
        self.0
    }

    /// A number takes a place that is a multiple of its own size.
    fn number<const N: usize>(&mut self, bytes: [u8; N]) {
        let behind = self.0.len() - HEADER.len();
        self.0.resize(HEADER.len() + behind.next_multiple_of(N), 0);
        self.0.extend(bytes);
    }

    pub(super) fn u8(&mut self, value: u8) {
        self.number([value]);
    }

    pub(super) fn bool(&mut self, value: bool) {
        self.number([value.into()]);
    }

    pub(super) fn i32(&mut self, value: i32) {
        self.number(value.to_le_bytes());
    }

    pub(super) fn u32(&mut self, value: u32) {
        self.number(value.to_le_bytes());
    }

    pub(super) fn f32(&mut self, value: f32) {
        self.number(value.to_le_bytes());
    }

    pub(super) fn f64(&mut self, value: f64) {
        self.number(value.to_le_bytes());
    }

    /// An array of fixed length.
    pub(super) fn f64s(&mut self, values: &[f64]) {
        for value in values {
            self.f64(*value);
        }
    }

    /// Number of the elements that follow. More than fit are never written: the file takes no such message.
    pub(super) fn length(&mut self, length: usize) {
        self.u32(u32::try_from(length).unwrap_or(u32::MAX));
    }

    /// Text, with the zero behind it counted.
    pub(super) fn string(&mut self, text: &str) {
        self.length(text.len() + 1);
        self.0.extend(text.as_bytes());
        self.0.push(0);
    }

    /// A sequence of bytes.
    pub(super) fn bytes(&mut self, bytes: &[u8]) {
        self.length(bytes.len());
        self.0.extend(bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_lie_at_multiples_of_their_size() {
        let mut cdr = Cdr::new(0);
        cdr.u8(1);
        cdr.u32(2);
        cdr.bool(true);
        cdr.f64(1.0);
        cdr.string("ab");
        cdr.i32(-1);
        cdr.bytes(&[7, 8]);
        cdr.f32(0.5);
        let expected: [&[u8]; 10] = [
            &[0, 1, 0, 0],
            &[1, 0, 0, 0],
            &[2, 0, 0, 0],
            &[1, 0, 0, 0, 0, 0, 0, 0],
            &[0, 0, 0, 0, 0, 0, 0xf0, 0x3f],
            &[3, 0, 0, 0],
            b"ab\0\0",
            &[255, 255, 255, 255],
            &[2, 0, 0, 0, 7, 8, 0, 0],
            &[0, 0, 0, 0x3f],
        ];
        assert_eq!(cdr.into_bytes(), expected.concat());
    }
}
