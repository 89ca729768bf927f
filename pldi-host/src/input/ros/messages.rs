//! The messages of `sensor_msgs` that frames are made of, written once for either serialisation.

use super::{Fields, Malformed};

/// `std_msgs/Header`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::input) struct Header<'a> {
    /// Time of the image, in nanoseconds.
    pub(in crate::input) stamp: i64,
    /// Name of the coordinate frame.
    pub(in crate::input) frame_id: &'a str,
}

/// `sensor_msgs/Image`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::input) struct Image<'a> {
    pub(in crate::input) header: Header<'a>,
    pub(in crate::input) height: u32,
    pub(in crate::input) width: u32,
    pub(in crate::input) encoding: &'a str,
    pub(in crate::input) is_bigendian: bool,
    /// Bytes from one row to the next.
    pub(in crate::input) step: u32,
    pub(in crate::input) data: &'a [u8],
}

/// `sensor_msgs/CompressedImage`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::input) struct CompressedImage<'a> {
    pub(in crate::input) header: Header<'a>,
    pub(in crate::input) format: &'a str,
    pub(in crate::input) data: &'a [u8],
}

/// `sensor_msgs/CameraInfo`, without what rectifies.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::input) struct CameraInfo {
    pub(in crate::input) height: u32,
    pub(in crate::input) width: u32,
    pub(in crate::input) distortion_model: String,
    pub(in crate::input) d: Vec<f64>,
    /// The camera's matrix, row by row.
    pub(in crate::input) k: [f64; 9],
    /// Pixels that were joined, horizontally and vertically; 0 is 1.
    pub(in crate::input) binning: [u32; 2],
    /// The part of the sensor that was read: left, top, height, width; all 0 is the whole.
    pub(in crate::input) roi: [u32; 4],
}

impl<'a> Header<'a> {
    pub(in crate::input) fn read<F: Fields<'a>>(fields: &mut F) -> Result<Self, Malformed> {
        if F::HEADER_SEQ {
            fields.u32()?;
        }
        let (seconds, nanoseconds) = (fields.u32()?, fields.u32()?);
        // ROS 2 counts seconds with a sign, ROS 1 without; neither has been used with times before 1970.
        let stamp = i64::from(seconds) * 1_000_000_000 + i64::from(nanoseconds);
        Ok(Self { stamp, frame_id: fields.text()? })
    }
}

impl<'a> Image<'a> {
    pub(in crate::input) fn read<F: Fields<'a>>(fields: &mut F) -> Result<Self, Malformed> {
        Ok(Self {
            header: Header::read(fields)?,
            height: fields.u32()?,
            width: fields.u32()?,
            encoding: fields.text()?,
            is_bigendian: fields.u8()? != 0,
            step: fields.u32()?,
            data: fields.bytes()?,
        })
    }
}

impl<'a> CompressedImage<'a> {
    pub(in crate::input) fn read<F: Fields<'a>>(fields: &mut F) -> Result<Self, Malformed> {
        Ok(Self { header: Header::read(fields)?, format: fields.text()?, data: fields.bytes()? })
    }
}

impl CameraInfo {
    pub(in crate::input) fn read<'a, F: Fields<'a>>(fields: &mut F) -> Result<Self, Malformed> {
        Header::read(fields)?;
        let (height, width) = (fields.u32()?, fields.u32()?);
        let distortion_model = fields.text()?.to_owned();
        let d = fields.f64s()?;
        let mut k = [0.0; 9];
        for number in &mut k {
            *number = fields.f64()?;
        }
        // The rotation and the projection of the rectified image.
        for _ in 0..9 + 12 {
            fields.f64()?;
        }
        let binning = [fields.u32()?, fields.u32()?];
        let roi = [fields.u32()?, fields.u32()?, fields.u32()?, fields.u32()?];
        fields.u8()?;
        Ok(Self { height, width, distortion_model, d, k, binning, roi })
    }
}

#[cfg(test)]
pub(in crate::input) mod tests {
    use super::super::cdr::Cdr;
    use super::super::ros1::Ros1;
    use super::*;
    use proptest::prelude::*;

    /// Writes messages in either serialisation.
    pub(in crate::input) struct Writer {
        pub(in crate::input) bytes: Vec<u8>,
        cdr: bool,
    }

    impl Writer {
        pub(in crate::input) fn new(cdr: bool) -> Self {
            Self { bytes: if cdr { vec![0, 1, 0, 0] } else { Vec::new() }, cdr }
        }

        fn align(&mut self, n: usize) {
            while self.cdr && !(self.bytes.len() - 4).is_multiple_of(n) {
                self.bytes.push(0);
            }
        }

        pub(in crate::input) fn u32(mut self, value: u32) -> Self {
            self.align(4);
            self.bytes.extend(value.to_le_bytes());
            self
        }

        fn f64(mut self, value: f64) -> Self {
            self.align(8);
            self.bytes.extend(value.to_le_bytes());
            self
        }

        fn text(mut self, text: &str) -> Self {
            let nul = u32::from(self.cdr);
            self = self.u32(text.len() as u32 + nul);
            self.bytes.extend(text.as_bytes());
            if self.cdr {
                self.bytes.push(0);
            }
            self
        }

        fn data(mut self, data: &[u8]) -> Self {
            self = self.u32(data.len() as u32);
            self.bytes.extend(data);
            self
        }

        pub(in crate::input) fn header(mut self, stamp: i64) -> Self {
            if !self.cdr {
                self = self.u32(77);
            }
            let (seconds, nanoseconds) = (stamp / 1_000_000_000, stamp % 1_000_000_000);
            self.u32(seconds as u32).u32(nanoseconds as u32).text("camera")
        }

        pub(in crate::input) fn image(self, image: &Image<'_>) -> Vec<u8> {
            let mut w = self.header(image.header.stamp).u32(image.height).u32(image.width).text(image.encoding);
            w.bytes.push(image.is_bigendian.into());
            w.u32(image.step).data(image.data).bytes
        }

        pub(in crate::input) fn compressed(self, stamp: i64, format: &str, data: &[u8]) -> Vec<u8> {
            self.header(stamp).text(format).data(data).bytes
        }

        pub(in crate::input) fn info(self, info: &CameraInfo) -> Vec<u8> {
            let mut w = self.header(0).u32(info.height).u32(info.width).text(&info.distortion_model);
            w = w.u32(info.d.len() as u32);
            for value in info.d.iter().chain(&info.k).chain(&[0.0; 21]) {
                w = w.f64(*value);
            }
            for value in info.binning.iter().chain(&info.roi) {
                w = w.u32(*value);
            }
            w.bytes.push(0);
            w.bytes
        }
    }

    pub(in crate::input) fn image() -> Image<'static> {
        let header = Header { stamp: 1_305_031_102_175_304_000, frame_id: "camera" };
        let (step, data) = (6, &[1, 2, 3, 4, 5, 6][..]);
        Image { header, height: 1, width: 2, encoding: "rgb8", is_bigendian: false, step, data }
    }

    pub(in crate::input) fn info() -> CameraInfo {
        CameraInfo {
            height: 480,
            width: 640,
            distortion_model: "plumb_bob".into(),
            d: vec![0.0; 5],
            k: [525.0, 0.0, 319.5, 0.0, 526.5, 239.5, 0.0, 0.0, 1.0],
            binning: [0, 0],
            roi: [0; 4],
        }
    }

    #[test]
    fn either_serialisation_gives_the_same_messages() {
        let (ros2, ros1) = (Writer::new(true).image(&image()), Writer::new(false).image(&image()));
        assert_eq!(Image::read(&mut Cdr::new(&ros2).unwrap()), Ok(image()));
        assert_eq!(Image::read(&mut Ros1::new(&ros1)), Ok(image()));
        let compressed = CompressedImage { header: image().header, format: "jpeg", data: &[1, 2, 3] };
        let write = |cdr| Writer::new(cdr).compressed(image().header.stamp, "jpeg", &[1, 2, 3]);
        let (ros2, ros1) = (write(true), write(false));
        assert_eq!(CompressedImage::read(&mut Cdr::new(&ros2).unwrap()), Ok(compressed));
        assert_eq!(CompressedImage::read(&mut Ros1::new(&ros1)), Ok(compressed));
        let (ros2, ros1) = (Writer::new(true).info(&info()), Writer::new(false).info(&info()));
        assert_eq!(CameraInfo::read(&mut Cdr::new(&ros2).unwrap()), Ok(info()));
        assert_eq!(CameraInfo::read(&mut Ros1::new(&ros1)), Ok(info()));
    }

    #[test]
    fn a_message_cut_anywhere_is_refused() {
        for cdr in [true, false] {
            let (image, info) = (Writer::new(cdr).image(&image()), Writer::new(cdr).info(&info()));
            for cut in 0..image.len() {
                let bytes = &image[..cut];
                let cut = if cdr {
                    Cdr::new(bytes).and_then(|mut f| Image::read(&mut f))
                } else {
                    Image::read(&mut Ros1::new(bytes))
                };
                assert!(matches!(cut, Err(Malformed::Cut { .. })), "{cut:?}");
            }
            for cut in 0..info.len() {
                let bytes = &info[..cut];
                let cut = if cdr {
                    Cdr::new(bytes).and_then(|mut f| CameraInfo::read(&mut f))
                } else {
                    CameraInfo::read(&mut Ros1::new(bytes))
                };
                assert!(matches!(cut, Err(Malformed::Cut { .. })), "{cut:?}");
            }
        }
    }

    proptest! {
        #[test]
        fn no_bytes_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400), zeros in 0usize..400) {
            let mut padded = vec![0, 1, 0, 0];
            padded.extend(std::iter::repeat_n(0, zeros));
            padded.extend(bytes);
            let cdr = || Cdr::new(&padded).unwrap();
            let _ = (Image::read(&mut cdr()), CompressedImage::read(&mut cdr()), CameraInfo::read(&mut cdr()));
            let ros1 = || Ros1::new(&padded);
            let _ = (Image::read(&mut ros1()), CompressedImage::read(&mut ros1()), CameraInfo::read(&mut ros1()));
        }
    }
}
