//! From a source's frame to the pipeline's: decoded, reduced to QVGA, with intrinsics that belong to it.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use pldi_core::Intrinsics;

use super::intrinsics::Camera;
use super::{Images, OpenOptions, QvgaFrame, RawFrame, Stamp, read_camera_info, reduce};
use crate::Error;
use crate::error::IntrinsicsOrigin;
use crate::record::Taken;

/// Where most readings of a room lie, in mm: a Kinect measures from 0.4 m or 0.5 m on, and coarsely beyond 6 m.
const USUAL_MM: std::ops::RangeInclusive<u16> = 400..=6000;

/// A frame ready for the pipeline, and what it was made from.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// As the pipeline takes it.
    pub qvga: QvgaFrame,
    /// As it was taken.
    pub images: Images,
    /// Time of the depth image.
    pub stamp: Stamp,
    /// Name of the depth camera's coordinate frame, where the source has one.
    pub frame_id: Option<String>,
    /// Where the intrinsics come from.
    pub origin: IntrinsicsOrigin,
    /// Frames lost between this and the one before.
    pub dropped: u64,
}

/// What is the same for all frames of a source. Frames may be prepared by several threads at once.
#[derive(Debug)]
pub struct Preparation {
    /// The user's word about the camera, which goes before the source's.
    camera: Option<Camera>,
    warned_default: AtomicBool,
    warned_range: AtomicBool,
}

impl Preparation {
    /// Reads the user's calibration file, where there is one.
    pub(super) fn new(options: &OpenOptions) -> Result<Self, Error> {
        let file = |path: &std::path::PathBuf| {
            Ok(Camera::Known(read_camera_info(path)?, IntrinsicsOrigin::File(path.clone())))
        };
        let camera = match options.intrinsics {
            Some(spec) => Some(Camera::Option(spec)),
            None => options.camera_info.as_ref().map(file).transpose()?,
        };
        let (warned_default, warned_range) = Default::default();
        Ok(Self { camera, warned_default, warned_range })
    }

    /// Decodes and reduces a frame, which gets the number `index`.
    ///
    /// # Errors
    /// What is wrong with its images, or intrinsics that do not belong to them.
    pub fn frame(&self, index: usize, raw: RawFrame) -> Result<Frame, Error> {
        let RawFrame { stamp, name, frame_id, camera, images, dropped, .. } = raw;
        let images = images()?;
        // Names the image in messages.
        let path = Path::new(&name);
        let factor = reduce::factor(path, images.size)?;
        let camera = self.camera(camera);
        let intrinsics = camera.for_image(path, images.size)?;
        if matches!(camera, Camera::Default) && !self.warned_default.swap(true, Ordering::Relaxed) {
            tracing::warn!(
                "no intrinsics given and none in the recording: assuming the nominal PrimeSense camera \
                 ({},{},{},{}@{}x{}); sizes will be off for another one",
                intrinsics.fx,
                intrinsics.fy,
                intrinsics.cx,
                intrinsics.cy,
                intrinsics.width,
                intrinsics.height
            );
        }
        let intrinsics = intrinsics
            .reduced(factor)
            .map_err(|e| Error::Content { path: path.to_owned(), reason: format!("intrinsics: {e}") })?;
        let depth = reduce::depth(&images.depth, factor, images.scale);
        self.check_scale(&name, &images, &depth);
        let colour = images.colour.as_ref().map(|values| reduce::colour(values, factor));
        let (original_size, origin) = (images.size, camera.origin());
        let qvga = QvgaFrame { index, stamp: stamp.seconds(), name, depth, colour, intrinsics, factor, original_size };
        Ok(Frame { qvga, images, stamp, frame_id, origin, dropped })
    }

    /// Decodes a frame and leaves it as it was taken, with the camera where that is known.
    ///
    /// # Errors
    /// What is wrong with its images, or intrinsics that do not belong to them.
    pub fn taken(&self, raw: RawFrame) -> Result<Taken, Error> {
        let RawFrame { stamp, colour_stamp, name, frame_id, camera, images, .. } = raw;
        let images = images()?;
        let camera = match self.camera(camera) {
            Camera::Default => None,
            known => Some(known.for_image(Path::new(&name), images.size)?),
        };
        Ok(Taken { stamp, colour_stamp: colour_stamp.unwrap_or(stamp), frame_id, camera, images })
    }

    /// The camera by precedence: the user's word, the source's, the default.
    fn camera(&self, source: Option<(Intrinsics, IntrinsicsOrigin)>) -> Camera {
        match (&self.camera, source) {
            (Some(camera), _) => camera.clone(),
            (None, Some((intrinsics, origin))) => Camera::Known(intrinsics, origin),
            (None, None) => Camera::Default,
        }
    }

    /// Says once when most readings lie where the sensor hardly has any, which is what a wrong unit looks like.
    fn check_scale(&self, name: &str, images: &Images, depth: &[u16]) {
        let share = |values: &[u16], reading: fn(&u16) -> bool| {
            values.iter().filter(|v| reading(v)).count() as f64 / values.len().max(1) as f64
        };
        // 65535 is "no reading" for some recorders.
        let read = share(&images.depth, |&v| v != 0 && v != u16::MAX);
        let usual = share(depth, |v| USUAL_MM.contains(v));
        if usual < 0.5 * read && !self.warned_range.swap(true, Ordering::Relaxed) {
            tracing::warn!(
                "{name}: most depth readings are nearer than {} mm or farther than {} mm with depth scale {}; is it \
                 another one (mm, tum, sun3d, or units per metre)?",
                USUAL_MM.start(),
                USUAL_MM.end(),
                images.scale
            );
        }
    }
}
