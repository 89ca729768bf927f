//! ROS `camera_info.yaml`: the calibration beside a recording.

use std::path::Path;

use pldi_core::Intrinsics;
use serde::Deserialize;
use serde_saphyr::{Budget, Options};

use super::files;
use super::intrinsics::checked;
use crate::Error;
use crate::error::{IntrinsicsOrigin, excerpt, told};

/// A calibration has 20 lines.
const MAX_BYTES: u64 = 1 << 20;

// Everything is read as f64 and checked here: the message then names the key, not the parser's view of it.
#[derive(Deserialize)]
struct CameraInfo {
    image_width: f64,
    image_height: f64,
    camera_matrix: Matrix,
    distortion_model: Option<String>,
    distortion_coefficients: Option<Matrix>,
}

#[derive(Deserialize)]
struct Matrix {
    data: Vec<f64>,
}

/// Reads the pinhole part of a calibration. Lens distortion is not undone: where the file has some, a warning says so.
///
/// # Errors
/// What is missing or absurd, with the file and the key.
pub fn read_camera_info(path: &Path) -> Result<Intrinsics, Error> {
    parse(path, &files::read_text(path, MAX_BYTES)?)
}

/// The same of a file's text; `path` names it in messages.
pub(super) fn parse(path: &Path, text: &str) -> Result<Intrinsics, Error> {
    let content = |reason: String| Error::Content { path: path.to_owned(), reason };
    // A calibration is three levels deep and has a hundred nodes; the reader's own bounds let it overflow a thread's stack.
    let budget = Budget { max_depth: 16, max_nodes: 10_000, ..Budget::default() };
    let options = Options { budget: Some(budget), ..Options::default() };
    let info: CameraInfo = serde_saphyr::from_str_with_options(text, options).map_err(|e| {
        let message = told(&e);
        content(format!("not a camera_info file with image_width, image_height and camera_matrix.data: {message}"))
    })?;
    let distortion = info.distortion_coefficients.map(|m| m.data).unwrap_or_default();
    let calibration = Calibration {
        size: [info.image_width, info.image_height],
        matrix: &info.camera_matrix.data,
        distortion: &distortion,
        model: info.distortion_model.as_deref(),
    };
    pinhole(path, &IntrinsicsOrigin::File(path.to_owned()), &calibration)
}

/// A calibration as ROS writes it down, in a file or a message.
#[derive(Debug, Clone, Copy)]
pub(super) struct Calibration<'a> {
    /// Width and height of the images.
    pub(super) size: [f64; 2],
    /// The camera's matrix, row by row.
    pub(super) matrix: &'a [f64],
    pub(super) distortion: &'a [f64],
    /// Name of the distortion's model.
    pub(super) model: Option<&'a str>,
}

/// The pinhole part, checked; where there is distortion, a warning says that it is not undone. `path` names the
/// calibration in messages.
pub(super) fn pinhole(
    path: &Path,
    origin: &IntrinsicsOrigin,
    calibration: &Calibration<'_>,
) -> Result<Intrinsics, Error> {
    let Calibration { size: [width, height], matrix, distortion, model } = *calibration;
    let absurd = |name, value, reason: String| Error::Intrinsics { origin: origin.clone(), name, value, reason };
    let side = |name, value: f64| {
        if value.fract() == 0.0 && (1.0..=f64::from(u16::MAX)).contains(&value) {
            return Ok(value as u16);
        }
        Err(absurd(name, value, "is not a size in pixels".into()))
    };
    let size = (side("image_width", width)?, side("image_height", height)?);
    let &[fx, skew, cx, a, fy, cy, b, c, one] = matrix else {
        let reason = format!("camera_matrix.data has {} numbers, a 3x3 matrix has 9", matrix.len());
        return Err(Error::Content { path: path.to_owned(), reason });
    };
    for (name, value, expected) in [
        ("camera_matrix.data[1] (skew)", skew, 0.0),
        ("camera_matrix.data[3]", a, 0.0),
        ("camera_matrix.data[6]", b, 0.0),
        ("camera_matrix.data[7]", c, 0.0),
        ("camera_matrix.data[8]", one, 1.0),
    ] {
        if value != expected {
            return Err(absurd(name, value, format!("must be {expected} in a pinhole camera's matrix")));
        }
    }
    let intrinsics = checked(origin, size, [fx, fy, cx, cy])?;
    if let Some(&value) = distortion.iter().find(|d| !d.is_finite()) {
        return Err(absurd("distortion_coefficients.data", value, "is not a finite number".into()));
    }
    if distortion.iter().any(|&d| d != 0.0) {
        let model = excerpt(model.unwrap_or("unnamed"));
        // No model has more than 14.
        let distortion = &distortion[..distortion.len().min(14)];
        tracing::warn!(
            "{}: the lens distortion ({} {distortion:?}) is not undone; rectify the recording where it matters",
            path.display(),
            model.escape_debug()
        );
    }
    Ok(intrinsics)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const GOOD: &str = "image_width: 640\nimage_height: 480\ncamera_name: x\ncamera_matrix:\n  rows: 3\n  cols: 3\n  \
                        data: [525, 0.0, 319.5, 0.0, 526.5, 239.5, 0.0, 0.0, 1.0]\ndistortion_model: plumb_bob\n\
                        distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.0, 0.0, 0.0, 0.0, 0.0]\n";

    fn read(text: &str) -> Result<Intrinsics, Error> {
        parse(Path::new("camera_info.yaml"), text)
    }

    #[test]
    fn the_ros_keys_are_read() {
        let k = read(GOOD).unwrap();
        assert_eq!(k, Intrinsics { width: 640, height: 480, fx: 525.0, fy: 526.5, cx: 319.5, cy: 239.5 });
        let short = GOOD.split("distortion_model").next().unwrap();
        assert_eq!(read(short).unwrap(), k);
        // Distorted lenses are read (and warned about).
        assert_eq!(read(&GOOD.replace("[0.0, 0.0, 0.0, 0.0, 0.0]", "[0.1, -0.2, 0, 0, 0]")).unwrap(), k);
    }

    #[test]
    fn absurd_numbers_are_refused_by_name() {
        for (from, to, name) in [
            ("640", "0", "image_width = 0"),
            ("640", "-640", "image_width = -640"),
            ("640", "640.5", "image_width = 640.5"),
            ("480", "1e9", "image_height = 1000000000"),
            ("480", ".nan", "image_height = NaN"),
            ("525", ".nan", "fx = NaN"),
            ("526.5", ".inf", "fy = inf"),
            ("525", "0", "fx = 0"),
            ("319.5", "-1e5", "cx = -100000"),
            ("[525, 0.0", "[525, 3", "skew"),
            ("0.0, 0.0, 1.0]", "0.0, 0.0, 0]", "data[8]"),
            (", 1.0]", "]", "has 8 numbers"),
            ("[0.0, 0.0, 0.0, 0.0, 0.0]", "[.inf]", "distortion_coefficients.data = inf"),
            ("image_height: 480\n", "", "image_height"),
            ("camera_matrix", "matrix", "camera_matrix"),
        ] {
            let error = read(&GOOD.replacen(from, to, 1)).unwrap_err();
            let text = error.to_string();
            assert!(!error.is_usage() && text.contains(name) && text.contains("camera_info.yaml"), "{to}: {text}");
        }
    }

    #[test]
    fn garbage_is_refused() {
        for text in ["", "\0\u{1}\u{2}", "{{{{", "- a\n- b", "image_width: [", "&a [*a]", "%YAML:1.0\n---\nx", "640"] {
            assert!(matches!(read(text), Err(Error::Content { .. })), "{text:?}");
        }
        // Nesting far beyond any calibration must neither overflow the stack nor take long.
        assert!(read(&"[".repeat(100_000)).is_err());
        assert!(read(&"a: ".repeat(100_000)).is_err());
        let nested: String = (0..1400).map(|depth| format!("{}a:\n", " ".repeat(depth))).collect();
        assert!(read(&nested).is_err() && read(&nested.replace("a:", "-")).is_err());
    }

    proptest! {
        #[test]
        fn no_text_panics(at in 0usize..300, junk in "\\PC{0,8}") {
            let mut text = GOOD.to_owned();
            text.insert_str(at.min(GOOD.len()), &junk);
            let _ = read(&text);
            let _ = read(&junk);
        }
    }
}
