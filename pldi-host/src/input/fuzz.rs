//! The readers that only the inside of the library calls, for the fuzz targets in `tests/fuzz`. No part of the interface.

use std::cmp::Ordering;
use std::path::Path;

use pldi_core::Intrinsics;

use super::ros::{Encoding, decode, topics::Kind};
use super::{Stamp, camera_info, files, image, lists};
use crate::Error;

/// Width, height and values of a decoded image.
pub type Image<T> = (u16, u16, Vec<T>);

/// Stamp, colour image and depth image of a listed frame.
pub type Frame = (Stamp, Option<String>, String);

/// A colour image.
///
/// # Errors
/// What is wrong with it.
pub fn colour(bytes: &[u8]) -> Result<Image<u8>, Error> {
    let image = image::decode_colour(Path::new("colour"), bytes)?;
    Ok((image.width, image.height, image.values))
}

/// A depth image.
///
/// # Errors
/// What is wrong with it.
pub fn depth(bytes: &[u8]) -> Result<Image<u16>, Error> {
    let image = image::decode_depth(Path::new("depth"), bytes)?;
    Ok((image.width, image.height, image.values))
}

/// A calibration.
///
/// # Errors
/// What is wrong with it.
pub fn camera_info(bytes: &[u8]) -> Result<Intrinsics, Error> {
    let path = Path::new("camera_info.yaml");
    camera_info::parse(path, &files::text(path, bytes.to_vec())?)
}

/// The frames of an association list.
///
/// # Errors
/// What is wrong with it.
pub fn associations(bytes: &[u8]) -> Result<Vec<Frame>, Error> {
    let path = Path::new("associations.txt");
    Ok(frames(lists::parse_associations(path, &files::text(path, bytes.to_vec())?)?))
}

/// The frames of a list of colour images and a list of depth images.
///
/// # Errors
/// What is wrong with them.
pub fn lists(colour: &[u8], depth: &[u8]) -> Result<Vec<Frame>, Error> {
    let read = |name: &str, bytes: &[u8]| {
        let path = Path::new(name);
        lists::parse_list(path, &files::text(path, bytes.to_vec())?)
    };
    let (colour, depth) = (read("rgb.txt", colour)?, read("depth.txt", depth)?);
    Ok(frames(lists::associate(Path::new("depth.txt"), &colour, &depth)?))
}

fn frames(entries: Vec<lists::Entry>) -> Vec<Frame> {
    entries.into_iter().map(|entry| (entry.stamp, entry.colour, entry.depth)).collect()
}

/// The order of file names.
pub fn natural(a: &str, b: &str) -> Ordering {
    lists::natural(a, b)
}

/// A message of ROS 2 (CDR) or ROS 1, taken for each kind of image and for a calibration.
///
/// # Errors
/// What is wrong with it, for each in turn.
pub fn message(bytes: &[u8], ros1: bool) -> [Result<(), Error>; 5] {
    let (name, encoding) = (Path::new("message"), if ros1 { Encoding::Ros1 } else { Encoding::Cdr });
    [
        decode::colour(name, bytes, encoding, Kind::Image).map(drop),
        decode::colour(name, bytes, encoding, Kind::Compressed).map(drop),
        decode::depth(name, bytes, encoding, Kind::Image).map(drop),
        decode::depth(name, bytes, encoding, Kind::Compressed).map(drop),
        decode::info(name, bytes, encoding).and_then(|info| super::ros::intrinsics(name, &info)).map(drop),
    ]
}
