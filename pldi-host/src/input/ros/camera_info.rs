//! `sensor_msgs/CameraInfo` as intrinsics.

use std::path::Path;

use pldi_core::Intrinsics;

use super::super::camera_info::{Calibration, pinhole};
use super::CameraInfo;
use super::image::content;
use crate::Error;
use crate::error::IntrinsicsOrigin;

/// The pinhole part of a calibration; `name` tells the message in errors and warnings.
pub(in crate::input) fn intrinsics(name: &Path, info: &CameraInfo) -> Result<Intrinsics, Error> {
    if info.k.iter().all(|k| *k == 0.0) {
        return Err(content(name, "K is all zeros, the camera is not calibrated: give --intrinsics"));
    }
    let whole = [[0; 4], [0, 0, info.height, info.width]];
    let [bx, by] = info.binning;
    if bx > 1 || by > 1 || !whole.contains(&info.roi) {
        let reason = format!(
            "the images are binned by {bx}x{by} or cut to {:?} (left, top, height, width), which is not undone: give \
             --intrinsics for the images' size",
            info.roi
        );
        return Err(content(name, reason));
    }
    let (size, model) = ([info.width, info.height].map(f64::from), Some(info.distortion_model.as_str()));
    let calibration = Calibration { size, matrix: &info.k, distortion: &info.d, model };
    pinhole(name, &IntrinsicsOrigin::Source(name.display().to_string()), &calibration)
}

#[cfg(test)]
mod tests {
    use super::super::messages::tests::info;
    use super::*;

    #[test]
    fn the_matrix_is_taken_and_what_cannot_be_undone_is_refused() {
        let read = |change: fn(&mut CameraInfo)| {
            let mut info = info();
            change(&mut info);
            intrinsics(Path::new("x.mcap: /camera_info"), &info)
        };
        let expected = Intrinsics { width: 640, height: 480, fx: 525.0, fy: 526.5, cx: 319.5, cy: 239.5 };
        assert_eq!(read(|_| ()).unwrap(), expected);
        assert_eq!(read(|i| (i.binning, i.roi) = ([1, 1], [0, 0, 480, 640])).unwrap(), expected);
        assert_eq!(read(|i| i.d = vec![0.1, 0.2]).unwrap(), expected, "distortion is warned about");
        for (error, message) in [
            (read(|i| i.k = [0.0; 9]), "not calibrated"),
            (read(|i| i.binning = [2, 2]), "binned by 2x2"),
            (read(|i| i.roi = [8, 8, 200, 200]), "[8, 8, 200, 200]"),
            (read(|i| i.k[0] = f64::NAN), "fx = NaN"),
            (read(|i| i.k[1] = 3.0), "skew"),
            (read(|i| i.width = 0), "0"),
            (read(|i| i.width = 70_000), "70000"),
        ] {
            let error = error.unwrap_err().to_string();
            assert!(error.contains(message) && error.contains("x.mcap: /camera_info"), "{error}");
        }
    }
}
