//! `sensor_msgs/Image`: the encodings of colour and depth, as OpenCV's bridge reads them.

use std::path::Path;

use super::super::MAX_FACTOR;
use super::super::image::Pixels;
use super::super::yuv;
use super::{Image, bayer};
use crate::Error;
use crate::error::excerpt;

/// Depth as it was sent.
#[derive(Debug)]
pub(in crate::input) struct Depth {
    pub(in crate::input) pixels: Pixels<u16>,
    /// Whether the numbers are millimetres for certain; otherwise they are in the sensor's unit.
    pub(in crate::input) millimetres: bool,
}

pub(super) fn content(name: &Path, reason: impl Into<String>) -> Error {
    Error::Content { path: name.to_owned(), reason: reason.into() }
}

/// Width and height, if frames may have them.
pub(super) fn checked_size(name: &Path, width: u32, height: u32) -> Result<(u16, u16), Error> {
    let fits = |side: u32, limit: u16| u16::try_from(side).ok().filter(|s| (1..=limit * MAX_FACTOR).contains(s));
    match (fits(width, 320), fits(height, 240)) {
        (Some(width), Some(height)) => Ok((width, height)),
        _ => Err(Error::UnsupportedSize { image: name.to_owned(), size: (width, height) }),
    }
}

/// The rows of an image whose pixels have `bytes` bytes, without what pads them; and its size.
fn rows<'a>(
    name: &Path,
    image: &Image<'a>,
    bytes: usize,
) -> Result<((u16, u16), impl Iterator<Item = &'a [u8]> + use<'a>), Error> {
    let size = checked_size(name, image.width, image.height)?;
    let (row, step) = (usize::from(size.0) * bytes, image.step as usize);
    if step < row {
        let Image { width, encoding, .. } = image;
        return Err(content(name, format!("step is {step}: a row of {width} pixels {encoding} has {row} bytes")));
    }
    // The last row needs no padding.
    let needed = step as u64 * u64::from(size.1 - 1) + row as u64;
    if (image.data.len() as u64) < needed {
        let Image { width, height, encoding, data, .. } = image;
        let have = data.len();
        let reason = format!(
            "{have} bytes of image, {width}x{height} pixels {encoding} with {step} bytes a row have {needed}: it is cut"
        );
        return Err(content(name, reason));
    }
    Ok((size, image.data.chunks(step).take(size.1.into()).map(move |r| r.get(..row).unwrap_or_default())))
}

/// The image as RGB.
pub(in crate::input) fn colour(name: &Path, image: &Image<'_>) -> Result<Pixels<u8>, Error> {
    let pixels = |((width, height), values)| Pixels { width, height, values };
    let packed = |bytes: usize, order: [usize; 3]| {
        let (size, rows) = rows(name, image, bytes)?;
        let mut values = Vec::with_capacity(usize::from(size.0) * usize::from(size.1) * 3);
        for pixel in rows.flat_map(|row| row.chunks_exact(bytes)) {
            values.extend(order.map(|i| pixel[i]));
        }
        Ok((size, values))
    };
    let mosaic = |pattern: [usize; 4]| {
        let (size, rows) = rows(name, image, 1)?;
        Ok((size, bayer::demosaic(size, &rows.collect::<Vec<_>>().concat(), pattern)))
    };
    let subsampled = |order: yuv::Order| {
        let (size, rows) = rows(name, image, 2)?;
        if size.0 % 2 != 0 {
            return Err(content(
                name,
                format!("{} has two pixels in four bytes, but width is {}", image.encoding, size.0),
            ));
        }
        Ok((size, rows.flat_map(|row| yuv::to_rgb(row, order)).collect()))
    };
    let image = match image.encoding {
        "rgb8" => packed(3, [0, 1, 2]),
        // 8UC3 says nothing of colours; what OpenCV has in three channels is blue, green and red.
        "bgr8" | "8UC3" => packed(3, [2, 1, 0]),
        "rgba8" => packed(4, [0, 1, 2]),
        "bgra8" | "8UC4" => packed(4, [2, 1, 0]),
        "mono8" | "8UC1" => packed(1, [0; 3]),
        "mono16" | "16UC1" => {
            let (size, values) = sixteen_bits(name, image)?;
            let grey = |v: u16| ((u32::from(v) * 255 + 32_767) / 65_535) as u8;
            Ok((size, values.into_iter().flat_map(|v| [grey(v); 3]).collect()))
        }
        "bayer_rggb8" => mosaic(bayer::RGGB),
        "bayer_bggr8" => mosaic(bayer::BGGR),
        "bayer_gbrg8" => mosaic(bayer::GBRG),
        "bayer_grbg8" => mosaic(bayer::GRBG),
        "yuv422" | "uyvy" | "UYVY" => subsampled(yuv::Order::Uyvy),
        "yuv422_yuy2" | "yuyv" | "YUYV" => subsampled(yuv::Order::Yuyv),
        other => Err(content(
            name,
            format!(
                "colour in encoding {:?} is not read (rgb8, bgr8, rgba8, bgra8, mono8, mono16, bayer_*8, yuv422, \
                 yuv422_yuy2 are): convert it, or choose another topic with --color",
                excerpt(other)
            ),
        )),
    };
    image.map(pixels)
}

/// The image as depth.
pub(in crate::input) fn depth(name: &Path, image: &Image<'_>) -> Result<Depth, Error> {
    let (((width, height), values), millimetres) = match image.encoding {
        "16UC1" | "mono16" => (sixteen_bits(name, image)?, false),
        "32FC1" => {
            let (size, rows) = rows(name, image, 4)?;
            let read = if image.is_bigendian { f32::from_be_bytes } else { f32::from_le_bytes };
            ((size, rows.flat_map(|row| row.as_chunks().0).map(|&b| millimetres(read(b))).collect()), true)
        }
        other => {
            let reason = format!(
                "depth in encoding {:?} is not read (16UC1 and 32FC1 are): choose the depth topic with --depth",
                excerpt(other)
            );
            return Err(content(name, reason));
        }
    };
    Ok(Depth { pixels: Pixels { width, height, values }, millimetres })
}

fn sixteen_bits(name: &Path, image: &Image<'_>) -> Result<((u16, u16), Vec<u16>), Error> {
    let (size, rows) = rows(name, image, 2)?;
    let read = if image.is_bigendian { u16::from_be_bytes } else { u16::from_le_bytes };
    Ok((size, rows.flat_map(|row| row.as_chunks().0).map(|&b| read(b)).collect()))
}

/// Metres in millimetres, rounded to nearest; 0 where it is no distance or too far.
pub(super) fn millimetres(metres: f32) -> u16 {
    let mm = libm::floor(f64::from(metres) * 1000.0 + 0.5);
    // Written so that NaN fails the test.
    if (0.0..=f64::from(u16::MAX)).contains(&mm) { mm as u16 } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::super::messages::tests::image;
    use super::*;
    use proptest::prelude::*;

    fn named() -> &'static Path {
        Path::new("x.mcap: /image at 1.5")
    }

    fn of<'a>(encoding: &'a str, (width, height): (u32, u32), step: u32, data: &'a [u8]) -> Image<'a> {
        Image { width, height, encoding, step, data, ..image() }
    }

    #[test]
    fn packed_encodings_become_rgb() {
        for (encoding, step, data, rgb) in [
            ("rgb8", 6, &[1, 2, 3, 4, 5, 6][..], [1, 2, 3, 4, 5, 6]),
            ("bgr8", 6, &[3, 2, 1, 6, 5, 4], [1, 2, 3, 4, 5, 6]),
            ("8UC3", 6, &[3, 2, 1, 6, 5, 4], [1, 2, 3, 4, 5, 6]),
            ("rgba8", 8, &[1, 2, 3, 0, 4, 5, 6, 255], [1, 2, 3, 4, 5, 6]),
            ("bgra8", 8, &[3, 2, 1, 0, 6, 5, 4, 255], [1, 2, 3, 4, 5, 6]),
            ("mono8", 2, &[7, 9], [7, 7, 7, 9, 9, 9]),
            ("8UC1", 2, &[7, 9], [7, 7, 7, 9, 9, 9]),
            // 128 is 0.498 of a step of 257, 129 is 0.502 of it.
            ("mono16", 4, &[128, 0, 129, 255], [0, 0, 0, 255, 255, 255]),
            ("uyvy", 4, &[90, 81, 240, 81], [254, 0, 0, 254, 0, 0]),
            ("yuv422_yuy2", 4, &[81, 90, 81, 240], [254, 0, 0, 254, 0, 0]),
        ] {
            let pixels = colour(named(), &of(encoding, (2, 1), step, data)).unwrap();
            assert_eq!((pixels.width, pixels.height, pixels.values.as_slice()), (2, 1, &rgb[..]), "{encoding}");
        }
        let mosaic = of("bayer_bggr8", (2, 2), 2, &[30, 20, 20, 10]);
        assert_eq!(colour(named(), &mosaic).unwrap().values, [10, 20, 30].repeat(4));
    }

    #[test]
    fn rows_may_be_padded() {
        let padded = of("mono8", (2, 3), 4, &[1, 2, 0xee, 0xee, 3, 4, 0xee, 0xee, 5, 6]);
        assert_eq!(
            colour(named(), &padded).unwrap().values.iter().step_by(3).copied().collect::<Vec<_>>(),
            [1, 2, 3, 4, 5, 6]
        );
    }

    #[test]
    fn depth_in_either_order_of_bytes() {
        let little = of("16UC1", (2, 2), 6, &[0x34, 0x12, 0xff, 0xff, 0xee, 0xee, 0, 0, 1, 0]);
        let read = depth(named(), &little).unwrap();
        assert_eq!((read.pixels.values.as_slice(), read.millimetres), (&[0x1234, 0xffff, 0, 1][..], false));
        let big = Image { is_bigendian: true, encoding: "mono16", ..little };
        assert_eq!(depth(named(), &big).unwrap().pixels.values, [0x3412, 0xffff, 0, 0x0100]);
        let metres = [1.2344f32, 1.2345, f32::NAN, f32::INFINITY, -1.0, 65.535, 65.6, -0.0];
        for is_bigendian in [false, true] {
            let bytes: Vec<u8> =
                metres.iter().flat_map(|m| if is_bigendian { m.to_be_bytes() } else { m.to_le_bytes() }).collect();
            let read = depth(named(), &Image { is_bigendian, ..of("32FC1", (4, 2), 16, &bytes) }).unwrap();
            assert_eq!(
                (read.pixels.values.as_slice(), read.millimetres),
                (&[1234, 1235, 0, 0, 0, 65_535, 0, 0][..], true)
            );
        }
        for mm in 0..=u16::MAX {
            assert_eq!(millimetres(f32::from(mm) / 1000.0), mm);
            assert_eq!(millimetres(f32::from(mm) * 0.001), mm);
        }
    }

    #[test]
    fn what_does_not_fit_is_refused_by_name() {
        for (image, message) in [
            (of("rgb8", (2, 1), 5, &[0; 6]), "step is 5"),
            (of("rgb8", (2, 2), 6, &[0; 11]), "11 bytes of image"),
            (of("rgb8", (2, 2), u32::MAX, &[0; 11]), "it is cut"),
            (of("rgb8", (0, 2), 6, &[0; 11]), "0x2"),
            (of("rgb8", (5121, 1), 3 * 5121, &[0; 11]), "5121x1"),
            (of("rgb8", (u32::MAX, u32::MAX), u32::MAX, &[0; 11]), "4294967295x4294967295"),
            (of("bayer_rggb16", (2, 1), 4, &[0; 4]), "\"bayer_rggb16\""),
            (of("uyvy", (3, 1), 6, &[0; 6]), "width is 3"),
        ] {
            let error = colour(named(), &image).unwrap_err().to_string();
            assert!(error.contains(message) && error.contains("x.mcap: /image at 1.5"), "{error}");
        }
        let error = depth(named(), &image()).unwrap_err().to_string();
        assert!(error.contains("\"rgb8\"") && error.contains("--depth"), "{error}");
    }

    proptest! {
        #[test]
        fn no_image_panics(
            encoding in prop_oneof![Just("rgb8"), Just("mono16"), Just("32FC1"), Just("uyvy"), Just("bayer_gbrg8")],
            size in (0u32..9, 0u32..9),
            step in 0u32..40,
            data in proptest::collection::vec(any::<u8>(), 0..200),
        ) {
            let image = of(encoding, size, step, &data);
            let _ = depth(named(), &image);
            if let Ok(pixels) = colour(named(), &image) {
                prop_assert_eq!(pixels.values.len(), (size.0 * size.1 * 3) as usize);
            }
        }
    }
}
