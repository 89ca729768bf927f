//! Recordings as folders in the manner of the TUM RGB-D benchmark, with depth in mm.

use std::fs;
use std::io;
use std::path::Path;

use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use pldi_core::Intrinsics;
use serde_json::json;

use super::{RecordedFrame, Recording};

/// Writes a recording as a folder: `rgb/0000.png`, `depth/0000.png` (16 bits, mm), `masks/0000.png` (labels),
/// `associations.txt`, `camera_info.yaml` and `truth.json`. Existing files of these names are replaced; each file
/// appears whole or not at all.
///
/// # Errors
/// What the file system says, with the path.
pub fn write_tum(recording: &Recording, name: &str, folder: &Path) -> io::Result<()> {
    let writer = TumWriter::new(recording, name, folder)?;
    let frames: io::Result<Vec<TumFrame>> = (0..recording.len()).map(|i| writer.frame(i)).collect();
    writer.finish(&frames?)
}

/// Writes the folder of [`write_tum`] frame by frame, in any order and from several threads. A file that is there with
/// the same content is left alone.
#[derive(Debug)]
pub struct TumWriter<'a> {
    recording: &'a Recording,
    name: &'a str,
    folder: &'a Path,
}

/// A frame whose images are written: what the lists say about it.
#[derive(Debug, Clone, PartialEq)]
pub struct TumFrame {
    /// The frame as it was made, images included.
    pub frame: RecordedFrame,
    /// Name of its images.
    file: String,
}

impl<'a> TumWriter<'a> {
    /// Makes the folder and those below it, as far as they are missing.
    ///
    /// # Errors
    /// What the file system says, with the path.
    pub fn new(recording: &'a Recording, name: &'a str, folder: &'a Path) -> io::Result<Self> {
        for part in ["rgb", "depth", "masks"] {
            fs::create_dir_all(folder.join(part)).map_err(|e| about(e, &folder.join(part)))?;
        }
        Ok(Self { recording, name, folder })
    }

    /// Makes frame `i` and writes its images.
    ///
    /// # Errors
    /// What the file system says, with the path; `NotFound` where there is no such frame.
    pub fn frame(&self, i: usize) -> io::Result<TumFrame> {
        let frame = self.recording.frame(i).ok_or_else(|| io::Error::from(io::ErrorKind::NotFound))?;
        let file = format!("{i:04}.png");
        let capture = &frame.capture;
        let size = [capture.width as u32, capture.height as u32];
        let depth: Vec<u8> = capture.depth.iter().flat_map(|d| d.to_ne_bytes()).collect();
        png(&self.folder.join("rgb").join(&file), &capture.colour, size, ExtendedColorType::Rgb8)?;
        png(&self.folder.join("depth").join(&file), &depth, size, ExtendedColorType::L16)?;
        png(&self.folder.join("masks").join(&file), &capture.labels, size, ExtendedColorType::L8)?;
        Ok(TumFrame { frame, file })
    }

    /// Writes the lists, with which the folder is complete.
    ///
    /// # Errors
    /// What the file system says, with the path.
    pub fn finish(&self, frames: &[TumFrame]) -> io::Result<()> {
        let about_frame = |TumFrame { frame, file }: &TumFrame| {
            let c = frame.camera;
            json!({
                "stamp": frame.stamp,
                "file": file,
                "camera": { "x": c.x, "y": c.y, "yaw": c.yaw, "height": c.height, "pitch": c.pitch, "roll": c.roll },
                "objects": frame.truth,
            })
        };
        let truth = json!({
            "about": "Lengths in metres, angles in rad; centre in the camera's frame (x right, y down, z forward); \
                      masks show instance + 1.",
            "name": self.name,
            "frames": frames.iter().map(about_frame).collect::<Vec<_>>(),
        });
        let line = |f: &TumFrame| format!("{0:.6} rgb/{1} {0:.6} depth/{1}\n", f.frame.stamp, f.file);
        let associations: String = frames.iter().map(line).collect();
        let truth = serde_json::to_string_pretty(&truth).map_err(io::Error::other)? + "\n";
        whole(&self.folder.join("truth.json"), truth.as_bytes())?;
        let info = camera_info(&self.recording.sensor.intrinsics, self.name);
        whole(&self.folder.join("camera_info.yaml"), info.as_bytes())?;
        whole(&self.folder.join("associations.txt"), associations.as_bytes())
    }
}

/// The intrinsics in the form of ROS' `camera_info` files.
fn camera_info(k: &Intrinsics, name: &str) -> String {
    format!(
        "image_width: {}\nimage_height: {}\ncamera_name: {name}\n\
         camera_matrix:\n  rows: 3\n  cols: 3\n  data: [{:?}, 0.0, {:?}, 0.0, {:?}, {:?}, 0.0, 0.0, 1.0]\n\
         distortion_model: plumb_bob\n\
         distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.0, 0.0, 0.0, 0.0, 0.0]\n",
        k.width, k.height, k.fx, k.cx, k.fy, k.cy
    )
}

/// Writes one image.
fn png(path: &Path, bytes: &[u8], [width, height]: [u32; 2], colour: ExtendedColorType) -> io::Result<()> {
    let mut file = Vec::new();
    PngEncoder::new(&mut file).write_image(bytes, width, height, colour).map_err(io::Error::other)?;
    whole(path, &file)
}

/// Writes a file under a temporary name and then gives it its own, so that nobody reads half of it.
fn whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    if fs::read(path).is_ok_and(|old| old == bytes) {
        return Ok(());
    }
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".part");
    let part = path.with_file_name(name);
    fs::write(&part, bytes).and_then(|()| fs::rename(&part, path)).map_err(|e| about(e, path))
}

/// The error with the path it is about.
fn about(error: io::Error, path: &Path) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}
