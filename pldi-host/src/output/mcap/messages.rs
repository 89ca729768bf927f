//! The messages that are written, as ROS 2 encodes them.

use pldi_core::Intrinsics;

use super::cdr::Cdr;
use crate::Error;
use crate::input::Stamp;

/// Nanoseconds in a second.
const SECOND: i64 = 1_000_000_000;

/// When and in which frame something was seen.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Header<'a> {
    seconds: i32,
    nanoseconds: u32,
    frame: &'a str,
}

impl<'a> Header<'a> {
    /// A time and a frame.
    ///
    /// # Errors
    /// `Content` where ROS has no such time.
    pub(crate) fn new(stamp: Stamp, frame: &'a str) -> Result<Self, Error> {
        let (seconds, nanoseconds) = (stamp.0.div_euclid(SECOND), stamp.0.rem_euclid(SECOND));
        let seconds = i32::try_from(seconds).map_err(|_| {
            let reason = "cannot be written to MCAP: ROS counts the seconds from 1970 up to 2038, which are 2147483647";
            Error::Content { path: format!("a time of {stamp} s").into(), reason: reason.to_owned() }
        })?;
        Ok(Self { seconds, nanoseconds: nanoseconds as u32, frame })
    }

    fn write(&self, cdr: &mut Cdr) {
        cdr.i32(self.seconds);
        cdr.u32(self.nanoseconds);
        cdr.string(self.frame);
    }
}

/// How an image's pixels are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Encoding {
    /// Grey, 8 bits.
    Mono8,
    /// Red, green, blue, 8 bits each.
    Rgb8,
    /// 16 bits, little-endian: depth in mm.
    Depth16,
}

impl Encoding {
    /// ROS' name and the bytes of a pixel.
    const fn form(self) -> (&'static str, u32) {
        match self {
            Self::Mono8 => ("mono8", 1),
            Self::Rgb8 => ("rgb8", 3),
            Self::Depth16 => ("16UC1", 2),
        }
    }
}

/// `sensor_msgs/Image`.
pub(crate) fn image(header: &Header<'_>, size: (u16, u16), encoding: Encoding, pixels: &[u8]) -> Vec<u8> {
    let ((name, bytes), (width, height)) = (encoding.form(), (u32::from(size.0), u32::from(size.1)));
    let mut cdr = Cdr::new(pixels.len() + 128);
    header.write(&mut cdr);
    cdr.u32(height);
    cdr.u32(width);
    cdr.string(name);
    cdr.u8(0); // little-endian
    cdr.u32(width * bytes);
    cdr.bytes(pixels);
    cdr.into_bytes()
}

/// `sensor_msgs/CameraInfo` of a camera without distortion.
pub(crate) fn camera_info(header: &Header<'_>, camera: &Intrinsics) -> Vec<u8> {
    let [fx, fy, cx, cy] = [camera.fx, camera.fy, camera.cx, camera.cy].map(f64::from);
    let mut cdr = Cdr::new(512);
    header.write(&mut cdr);
    cdr.u32(camera.height.into());
    cdr.u32(camera.width.into());
    cdr.string("plumb_bob");
    cdr.length(5);
    cdr.f64s(&[0.0; 5]);
    cdr.f64s(&[fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]);
    cdr.f64s(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    cdr.f64s(&[fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0]);
    // Binning and region of interest: none.
    for _ in 0..6 {
        cdr.u32(0);
    }
    cdr.bool(false);
    cdr.into_bytes()
}

/// Where something is, and how it is turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pose {
    /// In metres.
    pub(crate) position: [f32; 3],
    /// Unit quaternion: x, y, z, w.
    pub(crate) orientation: [f64; 4],
}

impl Pose {
    fn write(&self, cdr: &mut Cdr) {
        cdr.f64s(&self.position.map(f64::from));
        cdr.f64s(&self.orientation);
    }
}

/// What `vision_msgs/Detection3D` says.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Detection<'a> {
    /// Classes and scores, best first.
    pub(crate) results: Vec<(&'a str, f32)>,
    /// Centre and axes of the box.
    pub(crate) pose: Pose,
    /// Lengths of the box along its axes in metres.
    pub(crate) size: [f32; 3],
}

/// `vision_msgs/Detection3DArray`.
pub(crate) fn detections(header: &Header<'_>, detections: &[Detection<'_>]) -> Vec<u8> {
    let mut cdr = Cdr::new(64 + 2500 * detections.len());
    header.write(&mut cdr);
    cdr.length(detections.len());
    for detection in detections {
        header.write(&mut cdr);
        cdr.length(detection.results.len());
        for (class, score) in &detection.results {
            cdr.string(class);
            cdr.f64(f64::from(*score));
            detection.pose.write(&mut cdr);
            // The covariance: not known.
            cdr.f64s(&[0.0; 36]);
        }
        detection.pose.write(&mut cdr);
        cdr.f64s(&detection.size.map(f64::from));
        // An id says that this is the object of another message; nothing is followed from frame to frame.
        cdr.string("");
    }
    cdr.into_bytes()
}

/// What a marker is.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Shape {
    /// A box with these lengths along its axes.
    Cube([f32; 3]),
    /// Text that faces the viewer, and the height of its letters.
    Text(String, f32),
}

/// What `visualization_msgs/Marker` says.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Marker {
    /// Number among the markers of its shape.
    pub(crate) id: usize,
    /// What it is.
    pub(crate) shape: Shape,
    /// Its middle and axes.
    pub(crate) pose: Pose,
    /// Red, green, blue and opacity, 0..1.
    pub(crate) colour: [f32; 4],
}

/// Values of a marker's `type` and `action`.
const CUBE: i32 = 1;
const TEXT_VIEW_FACING: i32 = 9;
const ADD: i32 = 0;
const DELETE_ALL: i32 = 3;

/// `visualization_msgs/MarkerArray`: these markers, and none of the messages before.
pub(crate) fn markers(header: &Header<'_>, markers: &[Marker]) -> Vec<u8> {
    let nowhere = Pose { position: [0.0; 3], orientation: [0.0, 0.0, 0.0, 1.0] };
    let nothing = Marker { id: 0, shape: Shape::Cube([0.0; 3]), pose: nowhere, colour: [0.0; 4] };
    let mut cdr = Cdr::new(256 * (markers.len() + 1));
    cdr.length(markers.len() + 1);
    marker(&mut cdr, header, &nothing, DELETE_ALL);
    for each in markers {
        marker(&mut cdr, header, each, ADD);
    }
    cdr.into_bytes()
}

fn marker(cdr: &mut Cdr, header: &Header<'_>, marker: &Marker, action: i32) {
    let (namespace, kind, scale, text) = match &marker.shape {
        // Without a namespace all of them are deleted.
        Shape::Cube(_) if action == DELETE_ALL => ("", CUBE, [0.0; 3], ""),
        Shape::Cube(size) => ("boxes", CUBE, *size, ""),
        Shape::Text(text, height) => ("classes", TEXT_VIEW_FACING, [0.0, 0.0, *height], text.as_str()),
    };
    header.write(cdr);
    cdr.string(namespace);
    cdr.i32(i32::try_from(marker.id).unwrap_or(i32::MAX));
    cdr.i32(kind);
    cdr.i32(action);
    marker.pose.write(cdr);
    cdr.f64s(&scale.map(f64::from));
    for part in marker.colour {
        cdr.f32(part);
    }
    // For ever: the next message deletes it.
    cdr.i32(0);
    cdr.u32(0);
    cdr.bool(false);
    cdr.length(0); // points
    cdr.length(0); // colors
    cdr.string(""); // texture_resource
    Header { seconds: 0, nanoseconds: 0, frame: "" }.write(cdr); // texture
    cdr.string("");
    cdr.length(0);
    cdr.length(0); // uv_coordinates
    cdr.string(text);
    cdr.string(""); // mesh_resource
    cdr.string(""); // mesh_file
    cdr.length(0);
    cdr.bool(false); // mesh_use_embedded_materials
}

#[cfg(test)]
mod tests;
