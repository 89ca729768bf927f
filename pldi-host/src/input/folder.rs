//! Recordings as files: TUM-style folders, plain folders of images, single pairs.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use pldi_core::Intrinsics;

use super::lists::{self, Entry};
use super::{DepthScale, Images, OpenOptions, RawFrame, Source, Stamp, Stop, files, image, read_camera_info};
use crate::Error;
use crate::error::IntrinsicsOrigin;

/// A list of a million frames (nine hours) fits.
const MAX_LIST_BYTES: u64 = 256 << 20;
/// Frames per second assumed where no list gives times.
const FRAME_RATE: i64 = 30;

/// Frames in files. Opening reads the lists; each image is read when its frame is decoded, and nothing is kept.
struct Folder {
    place: Arc<Place>,
    entries: std::vec::IntoIter<Entry>,
    camera: Option<(Intrinsics, IntrinsicsOrigin)>,
}

/// Where the files are, and what the depths mean.
struct Place {
    /// What the names in the entries are relative to.
    folder: PathBuf,
    /// The file that lists the frames, for messages.
    list: Option<PathBuf>,
    scale: DepthScale,
}

/// Opens a folder: with `associations.txt`, or `depth.txt` (with or without `rgb.txt`), or the sub-folders `depth` and
/// `rgb` (or `color`) with equally many images, taken in the order of their names at 30 frames per second; in each case
/// with or without a `camera_info.yaml`.
///
/// # Errors
/// Where there is no such folder, no frame in it, a list or the calibration is not understood.
pub(super) fn open(uri: &str, options: &OpenOptions) -> Result<Box<dyn Source>, Error> {
    let path = Path::new(uri);
    let (list, entries) = find_entries(path)?;
    if entries.is_empty() {
        let reason = match &list {
            Some(list) => format!("no frame: {} lists none", list.display()),
            None => "no frame: there is no image in the folder depth".to_owned(),
        };
        return Err(Error::Content { path: path.to_owned(), reason });
    }
    let info = path.join("camera_info.yaml");
    // One that is not asked for may be broken.
    let wanted = options.intrinsics.is_none() && options.camera_info.is_none() && info.try_exists().unwrap_or(true);
    let camera = wanted.then(|| Ok((read_camera_info(&info)?, IntrinsicsOrigin::File(info.clone())))).transpose()?;
    let place = Place { folder: path.to_owned(), list, scale: options.depth_scale };
    Ok(Box::new(Folder { place: Arc::new(place), entries: entries.into_iter(), camera }))
}

/// Opens a depth image, with the colour image in the options where there is one: a recording of one frame.
///
/// # Errors
/// None: the images are read when the frame is decoded.
pub(super) fn open_image(uri: &str, options: &OpenOptions) -> Result<Box<dyn Source>, Error> {
    let colour = options.colour_image.as_deref().map(|path| {
        path.to_str().map(str::to_owned).ok_or_else(|| Error::Content {
            path: path.to_owned(),
            reason: "the name is not UTF-8: rename the file".into(),
        })
    });
    let entry = Entry {
        stamp: Stamp::default(),
        colour_stamp: None,
        colour: colour.transpose()?,
        depth: uri.to_owned(),
        line: 0,
    };
    let place = Place { folder: PathBuf::new(), list: None, scale: options.depth_scale };
    Ok(Box::new(Folder { place: Arc::new(place), entries: vec![entry].into_iter(), camera: None }))
}

impl Source for Folder {
    fn next(&mut self, _: &Stop) -> Result<Option<RawFrame>, Error> {
        let Some(entry) = self.entries.next() else { return Ok(None) };
        let place = Arc::clone(&self.place);
        Ok(Some(RawFrame {
            stamp: entry.stamp,
            colour_stamp: entry.colour_stamp,
            name: entry.depth.clone(),
            frame_id: None,
            camera: self.camera.clone(),
            dropped: 0,
            images: Box::new(move || place.decode(&entry).map_err(|cause| place.listed(&entry, cause))),
        }))
    }

    fn frames(&self) -> Option<usize> {
        Some(self.entries.len())
    }
}

impl Place {
    /// Decodes a frame's images.
    fn decode(&self, entry: &Entry) -> Result<Images, Error> {
        let path = self.folder.join(&entry.depth);
        let image::Pixels { width, height, values } = image::read_depth(&path)?;
        let frame = Images { size: (width, height), depth: values, scale: self.scale, colour: None };
        let Some(name) = &entry.colour else { return Ok(frame) };
        let colour_path = self.folder.join(name);
        let colour = image::read_colour(&colour_path)?;
        if (colour.width, colour.height) == frame.size {
            return Ok(Images { colour: Some(colour.values), ..frame });
        }
        Err(Error::PairSizes {
            colour: colour_path,
            colour_size: (colour.width.into(), colour.height.into()),
            depth: path,
            depth_size: (width.into(), height.into()),
        })
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
            let entry = |s: lists::Stamped| Entry {
                stamp: s.stamp,
                colour_stamp: None,
                colour: None,
                depth: s.file,
                line: s.line,
            };
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
    let entry = |(i, (depth, colour))| {
        // Rounded to nearest: a third of a second is 0.333333333 s.
        let stamp = Stamp((i as i64 * 1_000_000_000 + FRAME_RATE / 2) / FRAME_RATE);
        Entry { stamp, colour_stamp: None, colour, depth, line: 0 }
    };
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
#[path = "folder_tests.rs"]
mod tests;
