//! PNG files of the kinds that the project writes: grey and RGB of 8 bits, grey of 16 bits.

use std::io;
use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use super::atomic;
use crate::Error;
use crate::input::image::read_depth;

/// Side of a view in pixels (the paper's 2B x 2B with B = 64).
const VIEW_SIDE: u16 = 128;

/// Writes a grey image of 8 bits; `size` is (width, height), `pixels` row by row.
///
/// # Errors
/// `Write`, also where the number of pixels is not that of the size.
pub fn write_grey8(path: &Path, size: (u32, u32), pixels: &[u8]) -> Result<(), Error> {
    write(path, size, pixels, ExtendedColorType::L8, CompressionType::Default)
}

/// Writes a colour image of 8 bits a channel; `pixels` holds r, g, b row by row.
///
/// # Errors
/// `Write`, also where the number of pixels is not that of the size.
pub fn write_rgb8(path: &Path, size: (u32, u32), pixels: &[u8]) -> Result<(), Error> {
    write(path, size, pixels, ExtendedColorType::Rgb8, CompressionType::Default)
}

/// Writes a grey image of 16 bits, e.g. depth in mm.
///
/// # Errors
/// `Write`, also where the number of pixels is not that of the size.
pub fn write_grey16(path: &Path, size: (u32, u32), pixels: &[u16]) -> Result<(), Error> {
    write(path, size, &native(pixels), ExtendedColorType::L16, CompressionType::Default)
}

/// 16-bit values in the order that the encoder takes them in; it stores them as PNG wants them.
fn native(pixels: &[u16]) -> Vec<u8> {
    pixels.iter().flat_map(|v| v.to_ne_bytes()).collect()
}

/// As [`write_rgb8`], for images that must keep up with a sensor: less time, larger files.
///
/// # Errors
/// As [`write_rgb8`].
pub fn write_rgb8_fast(path: &Path, size: (u32, u32), pixels: &[u8]) -> Result<(), Error> {
    write(path, size, pixels, ExtendedColorType::Rgb8, CompressionType::Fast)
}

/// As [`write_grey16`], for images that must keep up with a sensor: less time, larger files.
///
/// # Errors
/// As [`write_grey16`].
pub fn write_grey16_fast(path: &Path, size: (u32, u32), pixels: &[u16]) -> Result<(), Error> {
    write(path, size, &native(pixels), ExtendedColorType::L16, CompressionType::Fast)
}

fn write(
    path: &Path,
    (w, h): (u32, u32),
    bytes: &[u8],
    kind: ExtendedColorType,
    compression: CompressionType,
) -> Result<(), Error> {
    atomic::write_with(path, |out| {
        // The encoder panics on a wrong length and on an empty image.
        if w == 0 || h == 0 || u64::from(kind.bits_per_pixel() / 8) * u64::from(w) * u64::from(h) != bytes.len() as u64
        {
            let text = format!("{} bytes are not a {w}x{h} image of {kind:?}", bytes.len());
            return Err(io::Error::new(io::ErrorKind::InvalidInput, text));
        }
        PngEncoder::new_with_quality(out, compression, FilterType::Adaptive)
            .write_image(bytes, w, h, kind)
            .map_err(io::Error::other)
    })
}

/// Reads a grey PNG of 16 bits: width, height and the values row by row, as stored.
///
/// # Errors
/// Where the file cannot be read, is cut, or is an image of another kind.
pub fn read_grey16(path: &Path) -> Result<((u16, u16), Vec<u16>), Error> {
    let image = read_depth(path)?;
    Ok(((image.width, image.height), image.values))
}

/// Reads a view: a grey PNG of 16 bits, 128x128.
///
/// # Errors
/// As [`read_grey16`], and where the size is another.
pub fn read_view(path: &Path) -> Result<Vec<u16>, Error> {
    let ((w, h), values) = read_grey16(path)?;
    if (w, h) != (VIEW_SIDE, VIEW_SIDE) {
        let reason = format!("the image is {w}x{h}, a view is {VIEW_SIDE}x{VIEW_SIDE}");
        return Err(Error::Content { path: path.to_owned(), reason });
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_bits_survive() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("view.png");
        let values: Vec<u16> = (0..128 * 128u32).map(|i| (i * 4 + 3) as u16).collect();
        write_grey16(&path, (128, 128), &values).unwrap();
        assert_eq!(read_view(&path).unwrap(), values);
        write_grey16(&path, (2, 1), &[0, u16::MAX]).unwrap();
        assert_eq!(read_grey16(&path).unwrap(), ((2, 1), vec![0, u16::MAX]));
        let text = read_view(&path).unwrap_err().to_string();
        assert!(text.contains("2x1") && text.contains("128x128"), "{text}");
    }

    #[test]
    fn eight_bits_are_no_view() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("grey.png");
        write_grey8(&path, (128, 128), &[9; 128 * 128]).unwrap();
        assert!(read_view(&path).unwrap_err().to_string().contains("16-bit"));
        write_rgb8(&path, (1, 2), &[1, 2, 3, 4, 5, 6]).unwrap();
        assert_eq!(image::open(&path).unwrap().into_rgb8().into_raw(), [1, 2, 3, 4, 5, 6]);
    }

    #[test]
    fn a_wrong_number_of_pixels_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.png");
        assert!(write_grey8(&path, (2, 2), &[0; 3]).unwrap_err().to_string().contains("2x2"));
        assert!(write_grey16(&path, (0, 2), &[]).is_err());
        assert!(!path.exists());
    }
}
