//! Decoding colour and depth images, strictly: a cut file is an error even where a decoder would fill in grey.

use std::io::Cursor;
use std::path::Path;

use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::{MAX_FACTOR, files};
use crate::Error;
use crate::error::told;

/// Largest file read: four times the raw size of the largest frame accepted would be less.
const MAX_FILE_BYTES: u64 = 256 << 20;
/// Most memory that a decoder may take for one image.
const MAX_DECODED_BYTES: u64 = 256 << 20;

/// A decoded image: width, height, values row by row.
#[derive(Debug)]
pub(crate) struct Pixels<T> {
    pub(crate) width: u16,
    pub(crate) height: u16,
    pub(crate) values: Vec<T>,
}

/// Reads an 8-bit colour or grey image (PNG or JPEG) as RGB; transparency is dropped.
pub(crate) fn read_colour(path: &Path) -> Result<Pixels<u8>, Error> {
    decode_colour(path, &files::read(path, MAX_FILE_BYTES)?)
}

/// The same of a file's bytes; `path` names them in messages.
pub(crate) fn decode_colour(path: &Path, bytes: &[u8]) -> Result<Pixels<u8>, Error> {
    let (width, height, image) = decode(path, bytes, |_, colour| match colour {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => Ok(()),
        other => Err(format!("a colour image must have 8 bits a channel, this one is {other:?}")),
    })?;
    Ok(Pixels { width, height, values: image.into_rgb8().into_raw() })
}

/// Reads a 16-bit grey PNG as it is.
pub(crate) fn read_depth(path: &Path) -> Result<Pixels<u16>, Error> {
    decode_depth(path, &files::read(path, MAX_FILE_BYTES)?)
}

/// The same of a file's bytes; `path` names them in messages.
pub(crate) fn decode_depth(path: &Path, bytes: &[u8]) -> Result<Pixels<u16>, Error> {
    let (width, height, image) = decode(path, bytes, |format, colour| match (format, colour) {
        (ImageFormat::Png, ColorType::L16) => Ok(()),
        (_, ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8) => Err(
            "a depth image must be a 16-bit grey PNG, this one has 8 bits a channel: it was made for looking at and \
             has lost the distances; export the raw depth"
                .to_owned(),
        ),
        (_, other) => Err(format!("a depth image must be a 16-bit grey PNG, this one is {other:?}")),
    })?;
    match image {
        DynamicImage::ImageLuma16(image) => Ok(Pixels { width, height, values: image.into_raw() }),
        _ => Err(content(path, "the decoder did not keep its 16 bits")),
    }
}

fn content(path: &Path, reason: impl Into<String>) -> Error {
    Error::Content { path: path.to_owned(), reason: reason.into() }
}

/// Decodes a PNG or JPEG whose size is acceptable and whose kind `accept` approves, before memory is taken for it.
fn decode(
    path: &Path,
    bytes: &[u8],
    accept: impl FnOnce(ImageFormat, ColorType) -> Result<(), String>,
) -> Result<(u16, u16, DynamicImage), Error> {
    let complete = match image::guess_format(bytes) {
        Ok(ImageFormat::Png) => png_is_complete(bytes),
        Ok(ImageFormat::Jpeg) => jpeg_is_complete(bytes),
        _ if b"\x89PNG\r\n\x1a\n".starts_with(bytes) => false,
        _ => return Err(content(path, "neither a PNG nor a JPEG image")),
    };
    if !complete {
        return Err(content(
            path,
            format!(
                "the image is cut after {} bytes: the recording or a copy was interrupted, fetch it again",
                bytes.len()
            ),
        ));
    }
    if image::guess_format(bytes).is_ok_and(|format| format == ImageFormat::Jpeg) && !jpeg_sampling_is_usual(bytes) {
        return Err(content(path, "the image is damaged: its colours are sampled more finely than its brightness"));
    }
    let damaged = |e: image::ImageError| content(path, format!("the image is damaged: {}", told(&e)));
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(MAX_DECODED_BYTES);
    let mut reader = ImageReader::new(Cursor::new(bytes));
    reader.limits(limits);
    let reader = reader.with_guessed_format().map_err(|cause| Error::Read { path: path.to_owned(), cause })?;
    let format = reader.format().unwrap_or(ImageFormat::Png);
    let decoder = reader.into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    let unsupported = || Error::UnsupportedSize { image: path.to_owned(), size: (width, height) };
    if width > 320 * u32::from(MAX_FACTOR) || height > 240 * u32::from(MAX_FACTOR) {
        return Err(unsupported());
    }
    let size = (u16::try_from(width), u16::try_from(height));
    let (Ok(w), Ok(h)) = size else { return Err(unsupported()) };
    accept(format, decoder.color_type()).map_err(|reason| content(path, reason))?;
    if u64::from(width) * u64::from(height) > most_pixels(format, bytes.len()) {
        let reason = format!("the image is damaged: its {} bytes cannot hold {width}x{height} pixels", bytes.len());
        return Err(content(path, reason));
    }
    Ok((w, h, DynamicImage::from_decoder(decoder).map_err(damaged)?))
}

/// How many pixels a file can hold at most: a header is not trusted with memory for more.
fn most_pixels(format: ImageFormat, bytes: usize) -> u64 {
    let each = match format {
        // A bit each at least, which deflate makes 1032 times shorter at most.
        ImageFormat::Png => 8 * 1032,
        // A bit for a block of 64, and one block for four where the brightness is sampled less than the colour.
        _ => 8 * 64 * 4,
    };
    bytes as u64 * each
}

/// Whether a PNG's chunks go on to IEND.
fn png_is_complete(bytes: &[u8]) -> bool {
    let mut rest = bytes.get(8..).unwrap_or_default();
    while let Some((head, after)) = rest.split_first_chunk::<8>() {
        let [l0, l1, l2, l3, kind @ ..] = *head;
        // Content and checksum.
        let skip = u64::from(u32::from_be_bytes([l0, l1, l2, l3])) + 4;
        match usize::try_from(skip).ok().and_then(|n| after.get(n..)) {
            None => return false,
            Some(_) if kind == *b"IEND" => return true,
            Some(next) => rest = next,
        }
    }
    false
}

/// The segments of a JPEG: each marker with its content, which for the first scan, the last one here, is all that follows.
struct Segments<'a>(&'a [u8]);

impl<'a> Iterator for Segments<'a> {
    type Item = (u8, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let (&[0xff, kind], after) = self.0.split_first_chunk::<2>()? else { return None };
            match kind {
                0xda => {
                    self.0 = &[];
                    return Some((kind, after));
                }
                // Fill bytes and markers without content.
                0xff => self.0 = &self.0[1..],
                0x01 | 0xd0..=0xd7 => self.0 = after,
                _ => {
                    let length = usize::from(u16::from_be_bytes(*after.first_chunk()?)).max(2);
                    self.0 = after.get(length..)?;
                    return Some((kind, after.get(2..length)?));
                }
            }
        }
    }
}

/// Whether a JPEG has its end marker. Segments before the scan are skipped by their lengths, because a thumbnail in
/// them has an end marker of its own; within the scan 0xFF is escaped, so that a marker found is one.
fn jpeg_is_complete(bytes: &[u8]) -> bool {
    let mut segments = Segments(bytes.get(2..).unwrap_or_default());
    segments.any(|(kind, scan)| kind == 0xda && scan.windows(2).any(|w| w == [0xff, 0xd9]))
}

/// Whether a JPEG's brightness is sampled as finely as its colours, both ways: the decoder panics on some where it is not,
/// and no camera writes any.
fn jpeg_sampling_is_usual(bytes: &[u8]) -> bool {
    let frames = Segments(bytes.get(2..).unwrap_or_default())
        .filter(|(kind, _)| matches!(kind, 0xc0..=0xcf) && ![0xc4, 0xc8, 0xcc].contains(kind));
    frames.into_iter().all(|(_, content)| {
        // Precision, height, width and number of components; of each its name, sampling and table.
        let components = content.get(6..).unwrap_or_default().as_chunks::<3>().0;
        let mut sampling = components.iter().map(|[_, sampling, _]| [sampling >> 4, sampling & 15]);
        sampling.next().is_none_or(|[w, h]| sampling.all(|[x, y]| x <= w && y <= h))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{ExtendedColorType, ImageEncoder, codecs::jpeg::JpegEncoder, codecs::png::PngEncoder};
    use std::path::PathBuf;

    fn png(w: u32, h: u32, kind: ExtendedColorType, bytes: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        PngEncoder::new(&mut out).write_image(bytes, w, h, kind).unwrap();
        out
    }

    fn save(folder: &tempfile::TempDir, bytes: &[u8]) -> PathBuf {
        let path = folder.path().join("image.bin");
        std::fs::write(&path, bytes).unwrap();
        path
    }

    #[test]
    fn every_8_bit_kind_becomes_rgb() {
        let folder = tempfile::tempdir().unwrap();
        for (kind, bytes, rgb) in [
            (ExtendedColorType::L8, &[7u8, 9][..], [7, 7, 7, 9, 9, 9]),
            (ExtendedColorType::La8, &[7, 0, 9, 255], [7, 7, 7, 9, 9, 9]),
            (ExtendedColorType::Rgb8, &[1, 2, 3, 4, 5, 6], [1, 2, 3, 4, 5, 6]),
            (ExtendedColorType::Rgba8, &[1, 2, 3, 0, 4, 5, 6, 128], [1, 2, 3, 4, 5, 6]),
        ] {
            let image = read_colour(&save(&folder, &png(2, 1, kind, bytes))).unwrap();
            assert_eq!((image.width, image.height, image.values.as_slice()), (2, 1, rgb.as_slice()));
        }
        let deep = png(1, 1, ExtendedColorType::Rgb16, &[0; 6]);
        assert!(read_colour(&save(&folder, &deep)).unwrap_err().to_string().contains("8 bits"));
        let mut jpeg = Vec::new();
        JpegEncoder::new(&mut jpeg).write_image(&[200; 3 * 64], 8, 8, ExtendedColorType::Rgb8).unwrap();
        assert!(read_colour(&save(&folder, &jpeg)).unwrap().values.iter().all(|v| v.abs_diff(200) < 3));
        assert!(read_depth(&save(&folder, &jpeg)).unwrap_err().to_string().contains("8 bits"));
    }

    #[test]
    fn depth_has_16_bits_or_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let bytes: Vec<u8> = [1u16, 0x1234, 65_535].iter().flat_map(|v| v.to_ne_bytes()).collect();
        let path = save(&folder, &png(3, 1, ExtendedColorType::L16, &bytes));
        assert_eq!(read_depth(&path).unwrap().values, [1, 0x1234, 65_535]);
        for kind in [ExtendedColorType::L8, ExtendedColorType::Rgb8] {
            let bytes = vec![0; 3 * usize::from(kind.bits_per_pixel() / 8)];
            let error = read_depth(&save(&folder, &png(3, 1, kind, &bytes))).unwrap_err().to_string();
            assert!(error.contains("16-bit grey") && error.contains("image.bin"), "{error}");
        }
        let error = read_depth(&save(&folder, &png(1, 1, ExtendedColorType::La16, &[0; 4]))).unwrap_err().to_string();
        assert!(error.contains("La16"), "{error}");
    }

    #[test]
    fn a_file_cut_anywhere_is_an_error_that_names_it() {
        let folder = tempfile::tempdir().unwrap();
        let depth: Vec<u8> = (0..24 * 16u32).flat_map(|i| (i as u16 * 37).to_ne_bytes()).collect();
        let whole = png(24, 16, ExtendedColorType::L16, &depth);
        for cut in 0..whole.len() {
            let error = read_depth(&save(&folder, &whole[..cut])).unwrap_err().to_string();
            assert!(
                error.contains("image.bin") && error.contains(if cut == 0 { "empty" } else { "cut" }),
                "{cut}: {error}"
            );
        }
        let mut jpeg = Vec::new();
        JpegEncoder::new(&mut jpeg).write_image(&depth, 16, 16, ExtendedColorType::Rgb8).unwrap();
        assert!(read_colour(&save(&folder, &jpeg)).is_ok());
        for cut in 0..jpeg.len() {
            assert!(read_colour(&save(&folder, &jpeg[..cut])).is_err(), "{cut}");
        }
    }

    #[test]
    fn flipped_bytes_never_panic() {
        let folder = tempfile::tempdir().unwrap();
        let whole = png(24, 16, ExtendedColorType::L16, &[5; 24 * 16 * 2]);
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= 0xff;
            let _ = read_depth(&save(&folder, &bytes));
            let _ = read_colour(&save(&folder, &bytes));
        }
        assert!(read_depth(&save(&folder, b"not an image at all")).unwrap_err().to_string().contains("neither"));
    }

    #[test]
    fn an_absurd_header_costs_no_memory() {
        let folder = tempfile::tempdir().unwrap();
        let mut bytes = png(1, 1, ExtendedColorType::L16, &[0; 2]);
        // IHDR: width and height at 16, checksum over type and content at 29.
        bytes[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
        let crc = crc32(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&crc.to_be_bytes());
        let error = read_depth(&save(&folder, &bytes)).unwrap_err().to_string();
        assert!(error.contains("image.bin"), "{error}");
    }

    #[test]
    fn a_short_file_cannot_hold_a_large_image() {
        let mut bytes = png(1, 1, ExtendedColorType::L16, &[0; 2]);
        bytes[16..24].copy_from_slice(&[0, 0, 0x14, 0, 0, 0, 0x0f, 0]);
        let crc = crc32(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&crc.to_be_bytes());
        let error = decode_depth(Path::new("image.bin"), &bytes).unwrap_err().to_string();
        assert!(error.contains("cannot hold 5120x3840 pixels"), "{error}");
        // What deflate can do to the largest image, all of one colour, passes.
        let flat = png(5120, 3840, ExtendedColorType::L8, &vec![9; 5120 * 3840]);
        assert!(decode_colour(Path::new("image.bin"), &flat).is_ok(), "{} bytes", flat.len());
        let mut jpeg = Vec::new();
        let encoder = JpegEncoder::new_with_quality(&mut jpeg, 1);
        encoder.write_image(&vec![9; 5120 * 3840], 5120, 3840, ExtendedColorType::L8).unwrap();
        assert!(decode_colour(Path::new("image.bin"), &jpeg).is_ok(), "{} bytes", jpeg.len());
    }

    #[test]
    fn brightness_is_sampled_as_finely_as_colour() {
        let mut jpeg = Vec::new();
        JpegEncoder::new(&mut jpeg).write_image(&[200; 3 * 24 * 17], 24, 17, ExtendedColorType::Rgb8).unwrap();
        let frame = jpeg.windows(2).position(|w| w == [0xff, 0xc0]).unwrap();
        let sampling = |jpeg: &mut [u8], y: u8, cb: u8| (jpeg[frame + 11], jpeg[frame + 14]) = (y, cb);
        sampling(&mut jpeg, 0x11, 0x44);
        let error = decode_colour(Path::new("image.bin"), &jpeg).unwrap_err().to_string();
        assert!(error.contains("more finely than its brightness"), "{error}");
        for (y, cb, usual) in [(0x22, 0x11, true), (0x21, 0x11, true), (0x21, 0x12, false), (0x12, 0x21, false)] {
            sampling(&mut jpeg, y, cb);
            assert_eq!(jpeg_sampling_is_usual(&jpeg), usual, "{y:x} {cb:x}");
        }
    }

    fn crc32(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(!0u32, |crc, &b| {
            (0..8).fold(crc ^ u32::from(b), |c, _| if c & 1 == 1 { c >> 1 ^ 0xedb8_8320 } else { c >> 1 })
        })
    }
}
