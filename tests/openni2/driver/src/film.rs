//! What the sensor sees, as a plain file; little-endian:
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `PLDIFILM` |
//! | 4 each | width, height, frames per second, number of frames |
//! | 4 each, f32 | horizontal, vertical field of view in rad |
//!
//! then of each frame the depth, registered to the colour (u16 in mm row by row), and the colour (8 bits each of red,
//! green, blue row by row).

use std::fs::File;
use std::io::{Error, ErrorKind, Result};
use std::os::unix::fs::FileExt;
use std::path::Path;

/// First bytes of a film.
const MAGIC: &[u8; 8] = b"PLDIFILM";
/// Size of what comes before the frames.
const HEADER: usize = 32;

/// Which of the two cameras.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// u16 in mm.
    Depth,
    /// 8 bits each of red, green, blue.
    Color,
}

impl Kind {
    /// Both, in the order in which they take a frame.
    pub const ALL: [Self; 2] = [Self::Depth, Self::Color];

    /// Bytes of one pixel.
    pub const fn pixel(self) -> usize {
        match self {
            Self::Depth => 2,
            Self::Color => 3,
        }
    }
}

/// How a frame is taken from the film.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct View {
    /// Every `step`-th pixel and row.
    pub step: usize,
    /// Left and right swapped.
    pub mirrored: bool,
    /// Columns by which the image lies further to the left than in the film.
    pub shift: usize,
}

/// An opened film.
#[derive(Debug)]
pub struct Film {
    file: File,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Frames per second.
    pub rate: u32,
    /// Number of frames, at least 1.
    pub frames: u64,
    /// Horizontal and vertical field of view in rad.
    pub fov: [f32; 2],
}

impl Film {
    /// Opens a film and checks that it is whole.
    pub fn open(path: &Path) -> Result<Self> {
        let file = File::open(path)?;
        let mut header = [0; HEADER];
        file.read_exact_at(&mut header, 0)?;
        let word = |i: usize| u32::from_le_bytes(std::array::from_fn(|k| header[8 + 4 * i + k]));
        let [width, height, rate, frames] = [0, 1, 2, 3].map(word);
        let film = Self {
            width: width as usize,
            height: height as usize,
            rate,
            frames: frames.into(),
            fov: [f32::from_bits(word(4)), f32::from_bits(word(5))],
            file,
        };
        let size = HEADER as u64 + film.frames * film.frame_size() as u64;
        if &header[..8] != MAGIC || [width, height, rate, frames].contains(&0) || film.file.metadata()?.len() != size {
            return Err(Error::new(ErrorKind::InvalidData, format!("{} is not a whole film", path.display())));
        }
        Ok(film)
    }

    /// Bytes of depth and colour together.
    const fn frame_size(&self) -> usize {
        self.width * self.height * 5
    }

    /// One image of a frame; frames past the end are those from the beginning again.
    pub fn image(&self, frame: u64, kind: Kind, view: View) -> Result<Vec<u8>> {
        let size = kind.pixel();
        let mut whole = vec![0; self.width * self.height * size];
        let before = match kind {
            Kind::Depth => 0,
            Kind::Color => self.width * self.height * Kind::Depth.pixel(),
        };
        let start = HEADER as u64 + (frame % self.frames) * self.frame_size() as u64 + before as u64;
        self.file.read_exact_at(&mut whole, start)?;
        let (columns, rows) = (self.width / view.step, self.height / view.step);
        let mut image = Vec::with_capacity(columns * rows * size);
        for y in 0..rows {
            for x in 0..columns {
                let x = if view.mirrored { columns - 1 - x } else { x } * view.step + view.shift;
                let at = (y * view.step * self.width + x) * size;
                match x < self.width {
                    true => image.extend_from_slice(&whole[at..at + size]),
                    false => image.extend(std::iter::repeat_n(0, size)),
                }
            }
        }
        Ok(image)
    }
}
