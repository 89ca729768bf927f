//! Messages of ROS 1 and ROS 2 as recordings hold them: how they are written, what they hold, and frames from them.

mod bayer;
mod camera_info;
pub(super) mod cdr;
pub(super) mod chunk;
mod compressed;
pub(super) mod decode;
mod image;
pub(super) mod log;
mod messages;
pub(super) mod records;
pub(super) mod ros1;
mod rvl;
pub(super) mod source;
pub(super) mod topics;

pub(super) use camera_info::intrinsics;
pub(super) use messages::{CameraInfo, CompressedImage, Image};

/// Bytes that are no such message.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(super) enum Malformed {
    /// They end too early.
    #[error("it is cut: {needed} bytes are needed at byte {at} of {len}")]
    Cut {
        /// Where.
        at: usize,
        /// How many.
        needed: u64,
        /// Number of bytes.
        len: usize,
    },
    /// A text is none.
    #[error("the text at byte {0} is not UTF-8")]
    Text(usize),
    /// The first four bytes of CDR name another representation.
    #[error("its representation {0:#06x} is not plain CDR")]
    Representation(u16),
}

/// How the fields of a message are written; what follows each other in a message is asked for in its order.
pub(super) trait Fields<'a> {
    /// Whether a header begins with a counter.
    const HEADER_SEQ: bool;

    /// An unsigned byte.
    fn u8(&mut self) -> Result<u8, Malformed>;
    /// An unsigned number of four bytes.
    fn u32(&mut self) -> Result<u32, Malformed>;
    /// A floating-point number of eight bytes.
    fn f64(&mut self) -> Result<f64, Malformed>;
    /// A text.
    fn text(&mut self) -> Result<&'a str, Malformed>;
    /// Any number of bytes.
    fn bytes(&mut self) -> Result<&'a [u8], Malformed>;
    /// Any number of floating-point numbers of eight bytes.
    fn f64s(&mut self) -> Result<Vec<f64>, Malformed>;
}

/// How a topic's messages are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    /// ROS 2: CDR with its four bytes in front.
    Cdr,
    /// ROS 1.
    Ros1,
}

/// The bytes that are left of a message.
#[derive(Debug, Clone)]
struct Bytes<'a> {
    all: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    fn new(all: &'a [u8]) -> Self {
        Self { all, at: 0 }
    }

    fn take(&mut self, n: u64) -> Result<&'a [u8], Malformed> {
        let end = usize::try_from(n).ok().and_then(|n| self.at.checked_add(n));
        match end.and_then(|end| self.all.get(self.at..end)) {
            None => Err(Malformed::Cut { at: self.at, needed: n, len: self.all.len() }),
            Some(bytes) => {
                self.at += bytes.len();
                Ok(bytes)
            }
        }
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Malformed> {
        let cut = Malformed::Cut { at: self.at, needed: N as u64, len: self.all.len() };
        self.take(N as u64)?.first_chunk().copied().ok_or(cut)
    }

    /// A text of `n` bytes.
    fn text(&mut self, n: u64) -> Result<&'a str, Malformed> {
        let at = self.at;
        std::str::from_utf8(self.take(n)?).map_err(|e| Malformed::Text(at + e.valid_up_to()))
    }
}
