//! Recordings as folders in the manner of the TUM RGB-D benchmark, with depth in mm.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use pldi_core::Intrinsics;

use super::{Recorder, Taken};
use crate::Error;
use crate::output::{atomic, png};

/// Writes `rgb/000000.png`, `depth/000000.png` (16 bits, mm), the lists and `camera_info.yaml` into a folder that has
/// `.partial` at the end of its name until the recording is finished. The lists grow with each frame, so that even one
/// that was killed can be read up to there.
pub(super) struct FolderRecorder {
    target: PathBuf,
    partial: PathBuf,
    /// `associations.txt`, or `depth.txt` where there is no colour; and whether there is. Known from the first frame on.
    list: Option<(File, bool)>,
    /// Whether the camera is written down.
    calibrated: bool,
    frames: u32,
}

impl FolderRecorder {
    pub(super) fn create(target: &Path) -> Result<Self, Error> {
        let fails = |path: &Path, cause| Error::Write { path: path.to_owned(), cause };
        let name = target.file_name().ok_or_else(|| {
            fails(target, io::Error::new(io::ErrorKind::InvalidInput, "the folder needs a name of its own"))
        })?;
        let mut partial = name.to_owned();
        partial.push(".partial");
        let partial = target.with_file_name(partial);
        if let Some(parent) = partial.parent().filter(|p| !p.as_os_str().is_empty()) {
            fs::create_dir_all(parent).map_err(|e| fails(parent, e))?;
        }
        fs::create_dir(&partial).map_err(|cause| match cause.kind() {
            io::ErrorKind::AlreadyExists => {
                let text = "what a former recording left is there; keep it under another name, or remove it";
                fails(&partial, io::Error::new(io::ErrorKind::AlreadyExists, text))
            }
            _ => fails(&partial, cause),
        })?;
        Ok(Self { target: target.to_owned(), partial, list: None, calibrated: false, frames: 0 })
    }
}

impl Recorder for FolderRecorder {
    fn frame(&mut self, frame: &Taken) -> Result<(), Error> {
        let colour = frame.images.colour.is_some();
        let (list, coloured) = match &mut self.list {
            Some(list) => list,
            none => {
                let begun = begin(&self.partial, colour)?;
                none.insert((begun, colour))
            }
        };
        if *coloured != colour {
            let which = if colour { "has colour" } else { "has no colour" };
            let reason = format!("a frame {which}, unlike the first: a folder's frames are alike");
            return Err(Error::Content { path: self.target.clone(), reason });
        }
        let line = write(&self.partial, self.frames, frame)?;
        let path = || self.partial.join(list_name(colour));
        list.write_all(line.as_bytes()).map_err(|cause| Error::Write { path: path(), cause })?;
        self.frames += 1;
        if let (false, Some(k)) = (self.calibrated, frame.camera) {
            atomic::write_bytes(&self.partial.join("camera_info.yaml"), camera_info(&k).as_bytes())?;
            self.calibrated = true;
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), Error> {
        let Self { partial, target, frames, .. } = *self;
        // Without a frame there is nothing that could be read.
        let ended = if frames == 0 { fs::remove_dir_all(&partial) } else { fs::rename(&partial, &target) };
        ended.map_err(|cause| Error::Write { path: if frames == 0 { partial } else { target }, cause })
    }
}

/// Name of the list of frames with or without colour.
fn list_name(colour: bool) -> &'static str {
    if colour { "associations.txt" } else { "depth.txt" }
}

/// Makes the folders and the list with its first line.
fn begin(folder: &Path, colour: bool) -> Result<File, Error> {
    for name in if colour { &["depth", "rgb"][..] } else { &["depth"] } {
        let path = folder.join(name);
        fs::create_dir(&path).map_err(|cause| Error::Write { path, cause })?;
    }
    let head = match colour {
        true => "# colour stamp in s, colour, depth stamp in s, depth in mm\n",
        false => "# stamp in s, depth in mm\n",
    };
    let path = folder.join(list_name(colour));
    let begun = File::create_new(&path).and_then(|mut file| file.write_all(head.as_bytes()).map(|()| file));
    begun.map_err(|cause| Error::Write { path, cause })
}

/// Writes the images of frame `number`; the line of the list that names them.
fn write(folder: &Path, number: u32, frame: &Taken) -> Result<String, Error> {
    let Taken { stamp, colour_stamp, images, .. } = frame;
    let size = (images.size.0.into(), images.size.1.into());
    let (rgb, depth) = (format!("rgb/{number:06}.png"), format!("depth/{number:06}.png"));
    let mm: Vec<u16> = images.depth.iter().map(|&raw| images.scale.millimetres(raw)).collect();
    png::write_grey16_fast(&folder.join(&depth), size, &mm)?;
    let Some(colour) = &images.colour else { return Ok(format!("{stamp} {depth}\n")) };
    png::write_rgb8_fast(&folder.join(&rgb), size, colour)?;
    Ok(format!("{colour_stamp} {rgb} {stamp} {depth}\n"))
}

/// The intrinsics in the form of ROS' `camera_info` files.
fn camera_info(k: &Intrinsics) -> String {
    format!(
        "image_width: {}\nimage_height: {}\ncamera_name: recorded\n\
         camera_matrix:\n  rows: 3\n  cols: 3\n  data: [{:?}, 0.0, {:?}, 0.0, {:?}, {:?}, 0.0, 0.0, 1.0]\n\
         distortion_model: plumb_bob\n\
         distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.0, 0.0, 0.0, 0.0, 0.0]\n",
        k.width, k.height, k.fx, k.cx, k.fy, k.cy
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::{DepthScale, Images, OpenOptions, Stamp, Stop, open};

    fn taken(i: u16, colour: bool) -> Taken {
        let camera = Some(Intrinsics { width: 320, height: 240, fx: 262.5, fy: 262.75, cx: 159.5, cy: 119.25 });
        let images = Images {
            size: (320, 240),
            // 12 m lie outside what the pipeline takes; a recording keeps them.
            depth: (0..320 * 240).map(|p| if p == 0 { 12_000 } else { 1000 + i }).collect(),
            scale: DepthScale::Millimetres,
            colour: colour.then(|| vec![i as u8; 3 * 320 * 240]),
        };
        let ns = 1_700_000_000_123_456_789 + i64::from(i) * 33_333_333;
        Taken { stamp: Stamp(ns), colour_stamp: Stamp(ns - 4_000_001), frame_id: None, camera, images }
    }

    #[test]
    fn what_was_recorded_comes_back() {
        let place = tempfile::tempdir().unwrap();
        for colour in [true, false] {
            let target = place.path().join(format!("below/{colour}"));
            let mut recorder = Box::new(FolderRecorder::create(&target).unwrap());
            for i in 0..3 {
                recorder.frame(&taken(i, colour)).unwrap();
            }
            assert!(!target.exists(), "it appears when it is finished");
            let error = recorder.frame(&taken(3, !colour)).unwrap_err().to_string();
            assert!(error.contains("unlike the first"), "{error}");
            recorder.finish().unwrap();
            let mut input = open(target.to_str().unwrap(), &OpenOptions::default()).unwrap();
            for i in 0..3u16 {
                let (_, raw) = input.raw(&Stop::default()).unwrap().unwrap();
                let expected = taken(i, colour);
                assert_eq!(raw.stamp, expected.stamp);
                assert_eq!(raw.colour_stamp, colour.then_some(expected.colour_stamp));
                assert_eq!(raw.camera.as_ref().map(|c| c.0), expected.camera);
                assert_eq!((raw.images)().unwrap(), expected.images);
            }
            assert!(input.raw(&Stop::default()).unwrap().is_none());
        }
    }

    #[test]
    fn what_is_there_stays() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("r");
        let mut killed = FolderRecorder::create(&target).unwrap();
        killed.frame(&taken(7, true)).unwrap();
        drop(killed);
        // As far as it came it can be read.
        let partial = place.path().join("r.partial");
        let mut input = open(partial.to_str().unwrap(), &OpenOptions::default()).unwrap();
        assert_eq!(input.frames().map(|f| f.unwrap().qvga.depth[1]).collect::<Vec<_>>(), [1007]);
        let error = FolderRecorder::create(&target).err().unwrap().to_string();
        assert!(error.contains("r.partial") && error.contains("former recording"), "{error}");
    }

    #[test]
    fn without_a_frame_nothing_is_left() {
        let place = tempfile::tempdir().unwrap();
        Box::new(FolderRecorder::create(&place.path().join("r")).unwrap()).finish().unwrap();
        assert_eq!(std::fs::read_dir(place.path()).unwrap().count(), 0);
    }
}
