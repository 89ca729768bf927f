//! From OpenNI2's frames to images: rows without gaps, not mirrored.

use super::facts::Frame;
use super::{modes, sys};
use crate::input::{DepthScale, Images, MAX_FACTOR, yuv};

/// Images from a pair of frames, with the rows of those turned round that are `mirrored` (depth, colour).
pub(super) fn images(depth: &Frame, colour: Option<&Frame>, mirrored: [bool; 2]) -> Result<Images, String> {
    let scale = match depth.format {
        sys::DEPTH_1_MM => DepthScale::Millimetres,
        sys::DEPTH_100_UM => DepthScale::PerMetre(10_000.0),
        other => return Err(format!("depth comes as {}, which is not read", modes::format_name(other))),
    };
    let size = size(depth)?;
    let mut values: Vec<u16> =
        rows(depth, 2)?.flat_map(|row| row.as_chunks().0.iter().map(|&bytes| u16::from_ne_bytes(bytes))).collect();
    if mirrored[0] {
        values.chunks_exact_mut(size.0.into()).for_each(<[u16]>::reverse);
    }
    let colour = colour.map(|frame| rgb(frame, size, mirrored[1])).transpose()?;
    Ok(Images { size, depth: values, scale, colour })
}

/// Red, green and blue of a colour frame that must have the depth frame's size.
fn rgb(frame: &Frame, depth: (u16, u16), mirrored: bool) -> Result<Vec<u8>, String> {
    let size = size(frame)?;
    if size != depth {
        return Err(format!(
            "colour is {}x{}, but depth is {}x{}: they must be registered and of one size",
            size.0, size.1, depth.0, depth.1
        ));
    }
    if matches!(frame.format, sys::YUV422 | sys::YUYV) && !size.0.is_multiple_of(2) {
        return Err(format!("colour of {} columns cannot be YUV 4:2:2", size.0));
    }
    let mut values: Vec<u8> = match frame.format {
        sys::RGB888 => rows(frame, 3)?.flatten().copied().collect(),
        sys::YUV422 => rows(frame, 2)?.flat_map(|row| yuv::to_rgb(row, yuv::Order::Uyvy)).collect(),
        sys::YUYV => rows(frame, 2)?.flat_map(|row| yuv::to_rgb(row, yuv::Order::Yuyv)).collect(),
        sys::GRAY8 => rows(frame, 1)?.flatten().flat_map(|&grey| [grey; 3]).collect(),
        other => return Err(format!("colour comes as {}, which is not read", modes::format_name(other))),
    };
    if mirrored {
        for row in values.chunks_exact_mut(3 * usize::from(size.0)) {
            row.as_chunks_mut::<3>().0.reverse();
        }
    }
    Ok(values)
}

fn size(frame: &Frame) -> Result<(u16, u16), String> {
    let (width, height) = frame.size;
    let within = |n: i32, most: u16| u16::try_from(n).ok().filter(|n| (1..=most).contains(n));
    match (within(width, 320 * MAX_FACTOR), within(height, 240 * MAX_FACTOR)) {
        (Some(width), Some(height)) => Ok((width, height)),
        _ => Err(format!("a frame of {width}x{height} is not read")),
    }
}

/// The rows of a frame that has so many bytes a pixel.
fn rows(frame: &Frame, pixel: usize) -> Result<impl Iterator<Item = &[u8]>, String> {
    let (width, height) = size(frame)?;
    let (row, height) = (usize::from(width) * pixel, usize::from(height));
    // Files tell strides that are not theirs; where there is no gap, the count of the bytes says it.
    let stride = usize::try_from(frame.stride).ok().filter(|&s| s > row && frame.bytes.len() != row * height);
    let stride = stride.unwrap_or(row);
    let needed = stride * (height - 1) + row;
    if frame.bytes.len() < needed {
        return Err(format!("a frame of {width}x{height} has {} bytes in place of {needed}", frame.bytes.len()));
    }
    Ok(frame.bytes.chunks(stride).take(height).filter_map(move |bytes| bytes.get(..row)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn frame(format: i32, size: (i32, i32), stride: i32, bytes: &[u8]) -> Frame {
        Frame { bytes: bytes.to_vec(), microseconds: 0, index: 1, size, stride, format }
    }

    fn depth(values: &[u16]) -> Vec<u8> {
        values.iter().flat_map(|v| v.to_ne_bytes()).collect()
    }

    #[test]
    fn gaps_between_rows_are_left_out_and_mirrored_rows_turned_round() {
        let gaps = frame(sys::DEPTH_1_MM, (2, 2), 6, &depth(&[1, 2, 9, 3, 4]));
        let colour = frame(sys::RGB888, (2, 2), 6, &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]);
        let read = images(&gaps, Some(&colour), [false; 2]).unwrap();
        assert_eq!((read.size, read.depth, read.scale), ((2, 2), vec![1, 2, 3, 4], DepthScale::Millimetres));
        assert_eq!(read.colour.unwrap(), colour.bytes);
        let read = images(&gaps, Some(&colour), [true; 2]).unwrap();
        assert_eq!(read.depth, [2, 1, 4, 3]);
        assert_eq!(read.colour.unwrap(), [4, 5, 6, 1, 2, 3, 10, 11, 12, 7, 8, 9]);
    }

    #[test]
    fn formats_are_told_apart() {
        let fine = frame(sys::DEPTH_100_UM, (1, 1), 0, &depth(&[12_345]));
        let grey = frame(sys::GRAY8, (1, 1), 7, &[5]);
        let read = images(&fine, Some(&grey), [false; 2]).unwrap();
        assert_eq!((read.depth_mm(), read.colour.unwrap()), (vec![1235], vec![5, 5, 5]));
        let two = frame(sys::DEPTH_1_MM, (2, 1), 0, &depth(&[1, 2]));
        for (format, bytes) in [(sys::YUV422, [90, 81, 240, 81]), (sys::YUYV, [81, 90, 81, 240])] {
            let red = images(&two, Some(&frame(format, (2, 1), 4, &bytes)), [false; 2]).unwrap();
            assert_eq!(red.colour.unwrap(), [254, 0, 0, 254, 0, 0]);
            assert!(images(&fine, Some(&frame(format, (1, 1), 2, &bytes)), [false; 2]).is_err());
        }
        let jpeg = frame(204, (1, 1), 0, &[0xff, 0xd8]);
        let error = images(&fine, Some(&jpeg), [false; 2]).unwrap_err();
        assert!(error.contains("JPEG"), "{error}");
        assert!(images(&grey, None, [false; 2]).unwrap_err().contains("grey"));
    }

    #[test]
    fn sizes_must_agree_and_bytes_suffice() {
        let fine = frame(sys::DEPTH_1_MM, (2, 1), 0, &depth(&[1, 2]));
        let error = images(&fine, Some(&frame(sys::RGB888, (1, 1), 0, &[0; 3])), [false; 2]).unwrap_err();
        assert!(error.contains("1x1") && error.contains("2x1"), "{error}");
        let error = images(&frame(sys::DEPTH_1_MM, (2, 2), 0, &depth(&[1, 2, 3])), None, [false; 2]).unwrap_err();
        assert!(error.contains("6 bytes in place of 8"), "{error}");
        assert!(images(&frame(sys::DEPTH_1_MM, (70_000, 1), 0, &[]), None, [false; 2]).is_err());
    }

    proptest! {
        #[test]
        fn no_frame_panics(
            format in prop_oneof![Just(100), Just(101), Just(200), Just(201), Just(202), Just(205), any::<i32>()],
            size in (-1i32..6, -1i32..6),
            stride in prop_oneof![-5i32..40, any::<i32>()],
            bytes in proptest::collection::vec(any::<u8>(), 0..80),
            colour in proptest::collection::vec(any::<u8>(), 0..80),
        ) {
            let depth = frame(sys::DEPTH_1_MM, size, stride, &bytes);
            let colour = frame(format, size, stride, &colour);
            if let Ok(images) = images(&depth, Some(&colour), [true, false]) {
                prop_assert_eq!(images.depth.len() * 3, images.colour.unwrap().len());
            }
            let _ = images(&colour, None, [true; 2]);
        }
    }
}
