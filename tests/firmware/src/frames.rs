//! The golden frames, read over semihosting.

use semihosting::fs::File;
use semihosting::io::{self, Read, Seek, SeekFrom};

/// Columns of a frame.
pub const W: usize = 320;

/// Rows of a frame.
pub const H: usize = 240;

/// Name, intrinsics and variant.
const HEADER: usize = 48 + 16 + 4;

/// Bytes of a frame in the file.
const RECORD: usize = HEADER + W * H * 5;

/// The file of frames.
#[derive(Debug)]
pub struct Frames {
    file: File,
    start: usize,
}

/// What is said of a frame.
#[derive(Debug, Clone, Copy)]
pub struct Header([u8; HEADER]);

impl Header {
    /// The frame's name.
    pub fn name(&self) -> &str {
        let name = self.0[..48].split(|byte| *byte == 0).next().unwrap_or_default();
        core::str::from_utf8(name).unwrap_or("?")
    }

    /// fx, fy, cx and cy.
    pub fn camera(&self) -> [f32; 4] {
        core::array::from_fn(|i| f32::from_bits(self.word(48 + 4 * i)))
    }

    /// Which parameters the frame is run with.
    pub fn variant(&self) -> usize {
        self.word(64) as usize
    }

    fn word(&self, at: usize) -> u32 {
        u32::from_le_bytes(core::array::from_fn(|i| self.0[at + i]))
    }
}

impl Frames {
    /// Opens the file.
    ///
    /// # Errors
    /// What the host says.
    pub fn open(path: &core::ffi::CStr) -> io::Result<Self> {
        Ok(Self { file: File::open(path)?, start: 0 })
    }

    /// The header of a frame; `None` after the last one.
    ///
    /// # Errors
    /// What the host says.
    pub fn header(&mut self, index: usize) -> io::Result<Option<Header>> {
        self.start = index * RECORD;
        self.seek(0)?;
        let mut header = [0; HEADER];
        if self.file.read(&mut header)? < HEADER {
            return Ok(None);
        }
        Ok(Some(Header(header)))
    }

    /// Reads rows of the frame whose header was read last: as many as the buffers hold.
    ///
    /// # Errors
    /// What the host says.
    pub fn rows(&mut self, first: usize, depth: &mut [u16], colour: &mut [u8]) -> io::Result<()> {
        self.seek(HEADER + first * W * 2)?;
        // Little-endian, as the boards are: the file's bytes are the numbers.
        let mut chunk = [0; 2 * W];
        for row in depth.chunks_mut(W) {
            self.file.read_exact(&mut chunk)?;
            row.iter_mut().zip(chunk.chunks_exact(2)).for_each(|(d, pair)| *d = u16::from_le_bytes([pair[0], pair[1]]));
        }
        self.seek(HEADER + W * H * 2 + first * W * 3)?;
        self.file.read_exact(colour)
    }

    fn seek(&mut self, offset: usize) -> io::Result<()> {
        self.file.seek(SeekFrom::Start((self.start + offset) as u64)).map(|_| ())
    }
}
