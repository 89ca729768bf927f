//! `sensor_msgs/CompressedImage`: JPEG and PNG, and the forms of `compressed_depth_image_transport`.

use std::path::Path;

use super::super::image::{Pixels, decode_colour, decode_depth};
use super::image::{Depth, checked_size, content, millimetres};
use super::{CompressedImage, rvl};
use crate::Error;
use crate::error::excerpt;

/// Most bytes of a compressed image; the raw size of the largest frame accepted is less.
const MAX_BYTES: usize = 256 << 20;

/// How a depth image is packed, as the message's format says.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Packing {
    /// Distances in metres, stored by their inverse.
    inverse: bool,
    /// Whether the transport's header stands in front.
    headed: bool,
    rvl: bool,
}

/// Whether the format is one of depth.
pub(super) fn is_depth(format: &str) -> bool {
    ["compressedDepth", "16UC1", "32FC1"].iter().any(|name| format.contains(name))
}

/// The image as RGB.
pub(in crate::input) fn colour(name: &Path, image: &CompressedImage<'_>) -> Result<Pixels<u8>, Error> {
    if is_depth(image.format) {
        return Err(content(
            name,
            format!("format {:?} is one of depth: choose the colour topic with --color", excerpt(image.format)),
        ));
    }
    decode_colour(name, bounded(name, image.data)?)
}

/// The image as depth.
pub(in crate::input) fn depth(name: &Path, image: &CompressedImage<'_>) -> Result<Depth, Error> {
    let packing = packing(image.format).ok_or_else(|| {
        let known = "16UC1 or 32FC1 with compressedDepth png or rvl, or a 16-bit png";
        content(name, format!("depth in format {:?} is not read ({known} are)", excerpt(image.format)))
    })?;
    let bytes = bounded(name, image.data)?;
    if !packing.headed {
        return Ok(Depth { pixels: decode_depth(name, bytes)?, millimetres: false });
    }
    let Some((head, bytes)) = bytes.split_first_chunk::<12>() else {
        return Err(content(name, format!("{} bytes hold no compressed depth: it is cut", bytes.len())));
    };
    let mut pixels = if packing.rvl { decode_rvl(name, bytes)? } else { decode_depth(name, bytes)? };
    if packing.inverse {
        let [_, _, _, _, a0, a1, a2, a3, b0, b1, b2, b3] = *head;
        let (a, b) = (f32::from_le_bytes([a0, a1, a2, a3]), f32::from_le_bytes([b0, b1, b2, b3]));
        if !(a.is_finite() && b.is_finite()) {
            return Err(content(name, format!("the depth was quantised with {a} and {b}: the image is damaged")));
        }
        for value in &mut pixels.values {
            *value = if *value == 0 { 0 } else { millimetres(a / (f32::from(*value) - b)) };
        }
    }
    Ok(Depth { pixels, millimetres: packing.inverse })
}

/// What a format says, such as `16UC1; compressedDepth png`, `32FC1; compressedDepth` or `16UC1; png compressed `.
fn packing(format: &str) -> Option<Packing> {
    let (kind, how) = format.split_once(';').unwrap_or((format, ""));
    let inverse = match kind.trim() {
        "16UC1" | "mono16" => false,
        "32FC1" => true,
        // Publishers that do not go through the transport name the file's kind alone.
        "png" if how.is_empty() => return Some(Packing { inverse: false, headed: false, rvl: false }),
        _ => return None,
    };
    match how.trim().strip_prefix("compressedDepth").map(str::trim) {
        Some("" | "png") => Some(Packing { inverse, headed: true, rvl: false }),
        Some("rvl") => Some(Packing { inverse, headed: true, rvl: true }),
        Some(_) => None,
        // Old transports say no more than the encoding.
        None if how.is_empty() => Some(Packing { inverse, headed: true, rvl: false }),
        None => (!inverse && how.contains("png")).then_some(Packing { inverse, headed: false, rvl: false }),
    }
}

fn decode_rvl(name: &Path, bytes: &[u8]) -> Result<Pixels<u16>, Error> {
    let cut = || content(name, format!("the image is cut or damaged: {} bytes of RVL do not fill it", bytes.len()));
    let (width, rest) = bytes.split_first_chunk().ok_or_else(cut)?;
    let (height, rest) = rest.split_first_chunk().ok_or_else(cut)?;
    let (width, height) = checked_size(name, u32::from_le_bytes(*width), u32::from_le_bytes(*height))?;
    let values = rvl::decode(rest, usize::from(width) * usize::from(height)).ok_or_else(cut)?;
    Ok(Pixels { width, height, values })
}

fn bounded<'a>(name: &Path, bytes: &'a [u8]) -> Result<&'a [u8], Error> {
    if bytes.len() > MAX_BYTES {
        return Err(Error::TooLarge { path: name.to_owned(), bytes: bytes.len() as u64, limit: MAX_BYTES as u64 });
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::super::messages::tests::image;
    use super::super::rvl::tests::encode;
    use super::*;
    use ::image::codecs::{jpeg::JpegEncoder, png::PngEncoder};
    use ::image::{ExtendedColorType, ImageEncoder};
    use proptest::prelude::*;

    fn of<'a>(format: &'a str, data: &'a [u8]) -> CompressedImage<'a> {
        CompressedImage { header: image().header, format, data }
    }

    fn named() -> &'static Path {
        Path::new("x.bag: /depth at 2")
    }

    fn png(values: &[u16]) -> Vec<u8> {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_ne_bytes()).collect();
        let mut out = Vec::new();
        PngEncoder::new(&mut out).write_image(&bytes, values.len() as u32, 1, ExtendedColorType::L16).unwrap();
        out
    }

    /// The transport's header: a kind, and the two numbers of the quantisation.
    fn headed(a: f32, b: f32, image: &[u8]) -> Vec<u8> {
        [&[0; 4], &a.to_le_bytes(), &b.to_le_bytes(), image].concat()
    }

    fn rvl(values: &[u16]) -> Vec<u8> {
        [&(values.len() as u32).to_le_bytes(), &1u32.to_le_bytes(), encode(values).as_slice()].concat()
    }

    #[test]
    fn every_form_of_16_bits() {
        let values = [0, 1, 1234, 65_535];
        for (format, data) in [
            ("16UC1; compressedDepth png", headed(0.0, 0.0, &png(&values))),
            ("16UC1; compressedDepth", headed(0.0, 0.0, &png(&values))),
            ("16UC1", headed(0.0, 0.0, &png(&values))),
            ("16UC1; compressedDepth rvl", headed(0.0, 0.0, &rvl(&values))),
            ("16UC1; png compressed ", png(&values)),
            ("png", png(&values)),
        ] {
            let depth = depth(named(), &of(format, &data)).unwrap();
            assert_eq!((depth.pixels.values.as_slice(), depth.millimetres), (&values[..], false), "{format}");
        }
    }

    #[test]
    fn inverse_depth_is_undone() {
        // As the transport chooses them for a quantisation of 100 and at most 10 m: v = a / depth + b.
        let (a, b) = (100.0 * 101.0, 1.0 - 100.0 * 101.0 / 10.0);
        let quantised = |metres: f32| (a / metres + b) as u16;
        let values = [0, quantised(1.0), quantised(2.5), quantised(9.9)];
        assert_eq!(values[1], 9091);
        for data in [headed(a, b, &png(&values)), headed(a, b, &rvl(&values))] {
            let format = if data.len() > 60 { "32FC1; compressedDepth png" } else { "32FC1; compressedDepth rvl" };
            let depth = depth(named(), &of(format, &data)).unwrap();
            let [none, one, middle, far] = depth.pixels.values[..] else { panic!() };
            assert!(none == 0 && one == 1000 && middle.abs_diff(2500) <= 1 && far.abs_diff(9900) <= 10, "{depth:?}");
            assert!(depth.millimetres);
        }
        // Beyond the range of the formula: v below b is no distance.
        let depth = depth(named(), &of("32FC1; compressedDepth png", &headed(1.0, 9.0, &png(&[5, 9, 10])))).unwrap();
        assert_eq!(depth.pixels.values, [0, 0, 1000]);
    }

    #[test]
    fn colour_is_jpeg_or_png() {
        let mut jpeg = Vec::new();
        JpegEncoder::new(&mut jpeg).write_image(&[200; 3 * 64], 8, 8, ExtendedColorType::Rgb8).unwrap();
        for format in ["jpeg", "rgb8; jpeg compressed bgr8", ""] {
            let pixels = colour(named(), &of(format, &jpeg)).unwrap();
            assert!((pixels.width, pixels.height) == (8, 8) && pixels.values.iter().all(|v| v.abs_diff(200) < 3));
        }
        assert!(colour(named(), &of("jpeg", &jpeg[..jpeg.len() - 9])).unwrap_err().to_string().contains("cut"));
        assert!(colour(named(), &of("16UC1; compressedDepth png", &jpeg)).unwrap_err().to_string().contains("--color"));
    }

    #[test]
    fn what_is_not_read_is_named() {
        for (format, data, message) in [
            ("jpeg", vec![0; 40], "\"jpeg\""),
            ("16UC1; compressedDepth zstd", vec![0; 40], "zstd"),
            ("32FC1; png compressed", vec![0; 40], "32FC1"),
            ("16UC1; compressedDepth", vec![0; 11], "cut"),
            ("16UC1; compressedDepth", vec![0; 40], "neither a PNG nor a JPEG"),
            ("16UC1; compressedDepth rvl", headed(0.0, 0.0, &rvl(&[1, 2, 3])[..9]), "cut"),
            ("16UC1; compressedDepth rvl", vec![0xff; 40], "4294967295x4294967295"),
            ("32FC1; compressedDepth", headed(f32::NAN, 0.0, &png(&[1])), "NaN"),
        ] {
            let error = depth(named(), &of(format, &data)).unwrap_err().to_string();
            assert!(error.contains(message) && error.contains("x.bag: /depth at 2"), "{format}: {error}");
        }
    }

    proptest! {
        #[test]
        fn no_bytes_panic(
            format in prop_oneof![Just("16UC1; compressedDepth rvl"), Just("32FC1; compressedDepth png"), Just("png")],
            side in 0u32..50,
            data in proptest::collection::vec(any::<u8>(), 0..100),
        ) {
            let sized = headed(1.0, 0.5, &[&side.to_le_bytes(), &3u32.to_le_bytes(), data.as_slice()].concat());
            for data in [&data, &sized] {
                let _ = (depth(named(), &of(format, data)), colour(named(), &of("jpeg", data)));
            }
        }
    }
}
