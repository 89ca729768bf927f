//! Chunks: stretches of a bag or MCAP file, compressed or not, that hold records.

use std::fs::File;
use std::io::{self, BufReader, Cursor, Read, Seek, SeekFrom};
use std::sync::Arc;

use crc32fast::Hasher;

/// A chunk of up to so many bytes is decompressed and checked before anything of it is believed; a larger one (few
/// writers make any) while it is read.
const WHOLE: u64 = 64 << 20;

/// Bytes that are read from the file at a time.
const BUFFER: usize = 64 << 10;

/// A stretch of a file, read from where it was left, whoever else reads the file in between.
#[derive(Debug, Clone)]
pub(in crate::input) struct Span {
    file: Arc<File>,
    at: u64,
    end: u64,
}

impl Span {
    /// The bytes from `at` up to `end`, buffered.
    pub(in crate::input) fn new(file: &Arc<File>, at: u64, end: u64) -> BufReader<Self> {
        BufReader::with_capacity(BUFFER, Self { file: Arc::clone(file), at, end })
    }
}

impl Read for Span {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let most = usize::try_from(self.end.saturating_sub(self.at)).unwrap_or(usize::MAX).min(buffer.len());
        let mut file = &*self.file;
        file.seek(SeekFrom::Start(self.at))?;
        let read = file.read(&mut buffer[..most])?;
        self.at += read as u64;
        Ok(read)
    }
}

/// How a chunk is compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::input) enum Compression {
    None,
    Zstd,
    Lz4,
    Bzip2,
}

impl Compression {
    /// By its name in a chunk's header, if it is one.
    pub(in crate::input) fn named(name: &[u8]) -> Option<Self> {
        match name {
            b"" | b"none" => Some(Self::None),
            b"zstd" => Some(Self::Zstd),
            b"lz4" => Some(Self::Lz4),
            b"bz2" => Some(Self::Bzip2),
            _ => None,
        }
    }
}

/// Where a chunk's content is, and what its header says of it.
#[derive(Debug, Clone, Copy)]
pub(in crate::input) struct Place {
    /// First byte of the content in the file, and the first behind it; beyond the file's end where that is cut.
    pub(in crate::input) at: u64,
    pub(in crate::input) end: u64,
    pub(in crate::input) compression: Compression,
    /// Number of bytes when decompressed.
    pub(in crate::input) size: u64,
    /// CRC-32 of the decompressed bytes; 0 is none.
    pub(in crate::input) crc: u32,
}

/// A chunk's content.
pub(in crate::input) struct Chunk {
    content: Box<dyn Read + Send>,
    /// Bytes to come.
    left: u64,
    /// To be compared at the end, where that was not done at the beginning.
    check: Option<(Hasher, u32)>,
}

impl std::fmt::Debug for Chunk {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Chunk").field("left", &self.left).finish_non_exhaustive()
    }
}

impl Chunk {
    /// Opens a chunk of a file of `file_size` bytes. Of one that the file's end cuts, what is there is given.
    ///
    /// # Errors
    /// What is wrong with the content, where that can be told in advance.
    pub(in crate::input) fn open(file: &Arc<File>, file_size: u64, place: Place) -> io::Result<Self> {
        let Place { at, end, compression, size, crc } = place;
        let cut = end > file_size;
        let span = Span::new(file, at, end.min(file_size));
        if compression == Compression::None && (cut || crc == 0 || size > WHOLE) {
            let left = size.min(end.min(file_size).saturating_sub(at));
            let check = (crc != 0 && !cut).then(|| (Hasher::new(), crc));
            return Ok(Self { content: Box::new(span), left, check });
        }
        let mut content: Box<dyn Read + Send> = match compression {
            Compression::None => Box::new(span),
            Compression::Zstd => Box::new(zstd::Decoder::with_buffer(span)?),
            Compression::Lz4 => Box::new(lz4_flex::frame::FrameDecoder::new(span)),
            Compression::Bzip2 => Box::new(bzip2::bufread::BzDecoder::new(span)),
        };
        if size > WHOLE {
            let check = (crc != 0 && !cut).then(|| (Hasher::new(), crc));
            return Ok(Self { content, left: size, check });
        }
        let mut bytes = Vec::new();
        // One byte more makes decoders look at what is behind the last one: their checksums.
        match content.by_ref().take(size + 1).read_to_end(&mut bytes) {
            // Behind a cut nothing else can be expected.
            Ok(_) | Err(_) if cut => {}
            Err(error) => return Err(error),
            Ok(read) if read as u64 != size => return Err(other(format!("not the {size} bytes that are announced"))),
            Ok(_) if crc != 0 && crc32fast::hash(&bytes) != crc => return Err(other("its checksum does not fit")),
            Ok(_) => {}
        }
        bytes.truncate(usize::try_from(size).unwrap_or(usize::MAX));
        Ok(Self { left: bytes.len() as u64, content: Box::new(Cursor::new(bytes)), check: None })
    }

    /// Bytes that are still to come.
    pub(in crate::input) fn left(&self) -> u64 {
        self.left
    }
}

impl Read for Chunk {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let most = usize::try_from(self.left).unwrap_or(usize::MAX).min(buffer.len());
        let read = self.content.read(&mut buffer[..most])?;
        self.left -= read as u64;
        if let Some((hasher, _)) = &mut self.check {
            hasher.update(&buffer[..read]);
        }
        if self.left == 0
            && let Some((hasher, crc)) = self.check.take()
            && hasher.finalize() != crc
        {
            return Err(other("its checksum does not fit"));
        }
        Ok(read)
    }
}

fn other(reason: impl Into<String>) -> io::Error {
    io::Error::other(reason.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::io::Write;

    fn pack(compression: Compression, bytes: &[u8]) -> Vec<u8> {
        match compression {
            Compression::None => bytes.to_vec(),
            Compression::Zstd => zstd::encode_all(bytes, 1).unwrap(),
            Compression::Lz4 => {
                let info = lz4_flex::frame::FrameInfo::new().content_checksum(true);
                let info = info.block_size(lz4_flex::frame::BlockSize::Max64KB);
                let mut encoder = lz4_flex::frame::FrameEncoder::with_frame_info(info, Vec::new());
                encoder.write_all(bytes).unwrap();
                encoder.finish().unwrap()
            }
            Compression::Bzip2 => {
                let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
                encoder.write_all(bytes).unwrap();
                encoder.finish().unwrap()
            }
        }
    }

    fn file(bytes: &[u8]) -> Arc<File> {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(bytes).unwrap();
        Arc::new(file)
    }

    fn read(file: &Arc<File>, file_size: u64, place: Place) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        Chunk::open(file, file_size, place)?.read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    const ALL: [Compression; 4] = [Compression::None, Compression::Zstd, Compression::Lz4, Compression::Bzip2];

    /// Something behind three bytes, and where it is.
    fn example(compression: Compression) -> (Vec<u8>, Vec<u8>, Place) {
        let mut state = 1u32;
        let mut noise = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 28) as u8
        };
        let content: Vec<u8> = (0..300_000).map(|_| noise()).collect();
        let packed = [b"xyz", pack(compression, &content).as_slice(), b"behind"].concat();
        let (end, crc) = (packed.len() as u64 - 6, crc32fast::hash(&content));
        (content, packed, Place { at: 3, end, compression, size: 300_000, crc })
    }

    #[test]
    fn every_compression_is_undone() {
        for compression in ALL {
            let (content, packed, place) = example(compression);
            let (file, size) = (file(&packed), packed.len() as u64);
            assert!(read(&file, size, place).unwrap() == content, "{compression:?}");
            assert!(read(&file, size, Place { crc: 0, ..place }).unwrap() == content);
            // Two readers of one file do not disturb each other.
            let [mut a, mut b] = [0, 1].map(|_| Chunk::open(&file, size, Place { crc: 0, ..place }).unwrap());
            let [mut x, mut y] = [[0; 1000]; 2];
            a.read_exact(&mut x).unwrap();
            b.read_exact(&mut y).unwrap();
            a.read_exact(&mut x).unwrap();
            assert!(x[..] == content[1000..2000] && y[..] == content[..1000]);
        }
    }

    #[test]
    fn damage_is_told() {
        for compression in ALL {
            let (_, packed, place) = example(compression);
            let (sound, size) = (file(&packed), packed.len() as u64);
            let error = read(&sound, size, Place { crc: place.crc ^ 1, ..place }).unwrap_err().to_string();
            assert!(error.contains("checksum"), "{error}");
            assert!(read(&sound, size, Place { size: 300_001, ..place }).is_err(), "{compression:?}");
            let mut damaged = packed.clone();
            damaged[packed.len() / 2] ^= 0x10;
            assert!(read(&file(&damaged), size, place).is_err(), "{compression:?}");
        }
    }

    #[test]
    fn of_a_cut_chunk_the_beginning_is_there() {
        for compression in ALL {
            let (content, packed, place) = example(compression);
            let size = packed.len() as u64 / 2;
            let got = read(&file(&packed[..size as usize]), size, place).unwrap();
            assert!(content.starts_with(&got), "{compression:?}");
            assert!(got.len() > 10_000 || compression == Compression::Bzip2, "{}", got.len());
        }
    }

    #[test]
    fn zstd_frames_follow_each_other() {
        let packed = [pack(Compression::Zstd, b"one, "), pack(Compression::Zstd, b"two")].concat();
        let place = Place { at: 0, end: packed.len() as u64, compression: Compression::Zstd, size: 8, crc: 0 };
        assert_eq!(read(&file(&packed), packed.len() as u64, place).unwrap(), b"one, two");
    }

    proptest! {
        #[test]
        fn no_bytes_panic(
            mut bytes in proptest::collection::vec(any::<u8>(), 0..300),
            magic in 0usize..4,
            size in prop_oneof![0u64..4000, Just(u64::MAX), Just(WHOLE + 1)],
            end in prop_oneof![0u64..400, any::<u64>()],
        ) {
            let compression = ALL[magic];
            let start: &[u8] = [&[][..], b"\x28\xb5\x2f\xfd", b"\x04\x22\x4d\x18", b"BZh9"][magic];
            bytes.splice(..0, start.iter().copied());
            let place = Place { at: 0, end, compression, size, crc: 1 };
            let _ = read(&file(&bytes), bytes.len() as u64, place).map(|read| assert!(read.len() < 1 << 26));
        }
    }
}
