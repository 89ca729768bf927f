//! Recordings as files: TUM-style folders, plain folders of images, single pairs.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use super::intrinsics::Camera;
use super::lists::{self, Entry};
use super::{DepthScale, FrameSource, IntrinsicsSpec, Original, QvgaFrame, files, image, read_camera_info, reduce};
use crate::Error;
use crate::error::IntrinsicsOrigin;

/// A list of a million frames (nine hours) fits.
const MAX_LIST_BYTES: u64 = 256 << 20;
/// Frames per second assumed where no list gives times.
const FRAME_RATE: f64 = 30.0;

/// Where most readings of a room lie, in mm: a Kinect measures from 0.4 m or 0.5 m on, and coarsely beyond 6 m.
const USUAL_MM: std::ops::RangeInclusive<u16> = 400..=6000;

/// How to understand a recording.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct OpenOptions {
    /// Unit of the depth images.
    pub depth_scale: DepthScale,
    /// Intrinsics to use in place of the recording's.
    pub intrinsics: Option<IntrinsicsSpec>,
    /// Calibration file to use in place of the folder's `camera_info.yaml`.
    pub camera_info: Option<PathBuf>,
}

/// Frames in files. Opening reads the lists; each image is read when its frame is asked for, and nothing is kept.
#[derive(Debug)]
pub struct Recording {
    /// What the names in the entries are relative to.
    folder: PathBuf,
    /// The file that lists the frames, for messages.
    list: Option<PathBuf>,
    entries: Vec<Entry>,
    camera: Camera,
    scale: DepthScale,
    warned_default: AtomicBool,
    warned_range: AtomicBool,
}

/// A frame's images as they are in the files.
struct Decoded {
    /// The depth image.
    path: PathBuf,
    raw: image::Pixels<u16>,
    colour: Option<Vec<u8>>,
}

impl Recording {
    /// Opens a folder: with `associations.txt`, or `depth.txt` (with or without `rgb.txt`), or the sub-folders `depth`
    /// and `rgb` (or `color`) with equally many images, taken in the order of their names at 30 frames per second.
    ///
    /// # Errors
    /// Where there is no such folder, no frame in it, a list or the calibration is not understood.
    pub fn open(path: &Path, options: &OpenOptions) -> Result<Self, Error> {
        let metadata = std::fs::metadata(path).map_err(|cause| Error::Read { path: path.to_owned(), cause })?;
        if !metadata.is_dir() {
            return Err(Error::Usage(format!(
                "{} is a file: give a recording's folder, or a pair of images by their own options",
                path.display()
            )));
        }
        let (list, entries) = find_entries(path)?;
        if entries.is_empty() {
            let reason = match &list {
                Some(list) => format!("no frame: {} lists none", list.display()),
                None => "no frame: there is no image in the folder depth".to_owned(),
            };
            return Err(Error::Content { path: path.to_owned(), reason });
        }
        let info = path.join("camera_info.yaml");
        let camera = camera(options, info.try_exists().unwrap_or(true).then_some(info))?;
        Ok(Self::new(path.to_owned(), list, entries, camera, options))
    }

    /// A recording of one frame from its files. Without intrinsics in the options the nominal camera is assumed.
    ///
    /// # Errors
    /// Where the calibration in the options is not understood; the images are read later.
    pub fn open_pair(colour: Option<&Path>, depth: &Path, options: &OpenOptions) -> Result<Self, Error> {
        let text = |path: &Path| {
            path.to_str().map(str::to_owned).ok_or_else(|| Error::Content {
                path: path.to_owned(),
                reason: "the name is not UTF-8: rename the file".into(),
            })
        };
        let entry = Entry { stamp: 0.0, colour: colour.map(text).transpose()?, depth: text(depth)?, line: 0 };
        Ok(Self::new(PathBuf::new(), None, vec![entry], camera(options, None)?, options))
    }

    fn new(folder: PathBuf, list: Option<PathBuf>, entries: Vec<Entry>, camera: Camera, options: &OpenOptions) -> Self {
        let (warned_default, warned_range) = Default::default();
        Self { folder, list, entries, camera, scale: options.depth_scale, warned_default, warned_range }
    }

    /// Time of each frame in seconds, in the frames' order, as listed.
    pub fn stamps(&self) -> impl ExactSizeIterator<Item = f64> {
        self.entries.iter().map(|entry| entry.stamp)
    }

    /// Where the intrinsics come from.
    pub fn intrinsics_origin(&self) -> IntrinsicsOrigin {
        match &self.camera {
            Camera::Option(_) => IntrinsicsOrigin::Option,
            Camera::File(_, path) => IntrinsicsOrigin::File(path.clone()),
            Camera::Default => IntrinsicsOrigin::Default,
        }
    }

    /// Decodes a frame's images: the raw depth, and the colour of the same size.
    fn decode(&self, entry: &Entry) -> Result<Decoded, Error> {
        let path = self.folder.join(&entry.depth);
        let raw = image::read_depth(&path)?;
        let Some(name) = &entry.colour else { return Ok(Decoded { path, raw, colour: None }) };
        let colour_path = self.folder.join(name);
        let colour = image::read_colour(&colour_path)?;
        if (colour.width, colour.height) == (raw.width, raw.height) {
            return Ok(Decoded { path, raw, colour: Some(colour.values) });
        }
        Err(Error::PairSizes {
            colour: colour_path,
            colour_size: (colour.width.into(), colour.height.into()),
            depth: path,
            depth_size: (raw.width.into(), raw.height.into()),
        })
    }

    fn read(&self, index: usize, entry: &Entry) -> Result<QvgaFrame, Error> {
        let Decoded { path, raw, colour } = self.decode(entry)?;
        let original_size = (raw.width, raw.height);
        let factor = reduce::factor(&path, original_size)?;
        let intrinsics = self.camera.for_image(&path, original_size)?;
        if matches!(self.camera, Camera::Default) && !self.warned_default.swap(true, Ordering::Relaxed) {
            tracing::warn!(
                "no intrinsics given and no camera_info.yaml: assuming the nominal PrimeSense camera \
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
            .map_err(|e| Error::Content { path: path.clone(), reason: format!("intrinsics: {e}") })?;
        let depth = reduce::depth(&raw.values, factor, self.scale);
        self.check_scale(&path, &raw.values, &depth);
        let colour = colour.map(|values| reduce::colour(values, factor));
        let (stamp, name) = (entry.stamp, entry.depth.clone());
        Ok(QvgaFrame { index, stamp, name, depth, colour, intrinsics, factor, original_size })
    }

    /// Says where a file that cannot be read is listed: it may be the list's mistake; other faults are the image's own.
    fn listed(&self, entry: &Entry, cause: Error) -> Error {
        match (&self.list, cause) {
            (Some(list), Error::Read { path, cause }) => {
                Error::Listed { list: list.clone(), line: entry.line, cause: Box::new(Error::Read { path, cause }) }
            }
            (_, cause) => cause,
        }
    }

    /// Says once when most readings lie where the sensor hardly has any, which is what a wrong unit looks like.
    fn check_scale(&self, path: &Path, raw: &[u16], depth: &[u16]) {
        let share = |values: &[u16], reading: fn(&u16) -> bool| {
            values.iter().filter(|v| reading(v)).count() as f64 / values.len().max(1) as f64
        };
        // 65535 is "no reading" for some recorders.
        let (read, usual) = (share(raw, |&v| v != 0 && v != u16::MAX), share(depth, |v| USUAL_MM.contains(v)));
        if usual < 0.5 * read && !self.warned_range.swap(true, Ordering::Relaxed) {
            tracing::warn!(
                "{}: most depth readings are nearer than {} mm or farther than {} mm with depth scale {}; is it \
                 another one (mm, tum, sun3d, or units per metre)?",
                path.display(),
                USUAL_MM.start(),
                USUAL_MM.end(),
                self.scale
            );
        }
    }
}

impl FrameSource for Recording {
    fn len(&self) -> usize {
        self.entries.len()
    }

    fn frame(&self, index: usize) -> Result<QvgaFrame, Error> {
        let entry = self.entries.get(index).ok_or(Error::FrameIndex { index, len: self.entries.len() })?;
        self.read(index, entry).map_err(|cause| self.listed(entry, cause))
    }

    fn original(&self, index: usize) -> Result<Original, Error> {
        let entry = self.entries.get(index).ok_or(Error::FrameIndex { index, len: self.entries.len() })?;
        let Decoded { raw, colour, .. } = self.decode(entry).map_err(|cause| self.listed(entry, cause))?;
        let depth = raw.values.iter().map(|&value| self.scale.to_mm(value)).collect();
        Ok(Original { size: (raw.width, raw.height), depth, colour })
    }
}

/// The camera by precedence: the user's numbers, the user's file, the folder's file, the default.
fn camera(options: &OpenOptions, found: Option<PathBuf>) -> Result<Camera, Error> {
    if let Some(spec) = options.intrinsics {
        return Ok(Camera::Option(spec));
    }
    match options.camera_info.clone().or(found) {
        Some(path) => Ok(Camera::File(read_camera_info(&path)?, path)),
        None => Ok(Camera::Default),
    }
}

fn find_entries(folder: &Path) -> Result<(Option<PathBuf>, Vec<Entry>), Error> {
    let [associations, rgb, depth] = ["associations.txt", "rgb.txt", "depth.txt"].map(|name| folder.join(name));
    if associations.exists() {
        let text = files::read_text(&associations, MAX_LIST_BYTES)?;
        let entries = lists::parse_associations(&associations, &text)?;
        return Ok((Some(associations), entries));
    }
    if depth.exists() {
        let depths = lists::parse_list(&depth, &files::read_text(&depth, MAX_LIST_BYTES)?)?;
        if !rgb.exists() {
            let entry = |s: lists::Stamped| Entry { stamp: s.stamp, colour: None, depth: s.file, line: s.line };
            return Ok((Some(depth), depths.into_iter().map(entry).collect()));
        }
        let colours = lists::parse_list(&rgb, &files::read_text(&rgb, MAX_LIST_BYTES)?)?;
        let entries = lists::associate(&depth, &colours, &depths)?;
        if entries.is_empty() && !depths.is_empty() {
            let reason = "no stamp lies within 0.02 s of one in rgb.txt: are both lists of one recording?".into();
            return Err(Error::Content { path: depth, reason });
        }
        tracing::debug!("{} of {} depth and {} colour images make frames", entries.len(), depths.len(), colours.len());
        return Ok((Some(depth), entries));
    }
    Ok((None, list_folders(folder)?))
}

/// Frames of a folder without lists.
fn list_folders(folder: &Path) -> Result<Vec<Entry>, Error> {
    let depth = folder.join("depth");
    if !depth.is_dir() {
        return Err(Error::Content {
            path: folder.to_owned(),
            reason: "no recording: there is neither associations.txt, nor depth.txt, nor a folder depth".into(),
        });
    }
    let depths = images("depth", &depth)?;
    let colour = ["rgb", "color", "colour"].into_iter().find(|name| folder.join(name).is_dir());
    let colours = match colour {
        None => vec![None; depths.len()],
        Some(name) => {
            let colours = images(name, &folder.join(name))?;
            if colours.len() != depths.len() {
                let reason = format!(
                    "{} images in depth, {} in {name}: without a list they must be equally many (or write one: \
                     associations.txt)",
                    depths.len(),
                    colours.len()
                );
                return Err(Error::Content { path: folder.to_owned(), reason });
            }
            colours.into_iter().map(Some).collect()
        }
    };
    let entry = |(i, (depth, colour))| Entry { stamp: i as f64 / FRAME_RATE, colour, depth, line: 0 };
    Ok(depths.into_iter().zip(colours).enumerate().map(entry).collect())
}

/// The images in a folder, as `name/file`, in the order of their names.
fn images(name: &str, folder: &Path) -> Result<Vec<String>, Error> {
    let failed = |cause: io::Error| Error::Read { path: folder.to_owned(), cause };
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let file = entry.map_err(failed)?.file_name();
        let Some(file) = file.to_str().filter(|f| !f.starts_with('.')) else { continue };
        let extension = Path::new(file).extension().and_then(|e| e.to_str()).unwrap_or_default();
        if ["png", "jpg", "jpeg"].iter().any(|e| extension.eq_ignore_ascii_case(e)) {
            found.push(format!("{name}/{file}"));
        }
    }
    found.sort_by(|a, b| lists::natural(a, b));
    Ok(found)
}

#[cfg(test)]
#[path = "recording_tests.rs"]
mod tests;
