//! The readers that only the inside of the library calls, for the fuzz targets in `tests/fuzz`. No part of the interface.

use std::cmp::Ordering;
use std::path::Path;

use pldi_core::Intrinsics;

use super::ros::topics::Kind;
use super::ros::{self, decode};
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

fn encoding(cdr: bool) -> ros::Encoding {
    if cdr { ros::Encoding::Cdr } else { ros::Encoding::Ros1 }
}

fn kind(compressed: bool) -> Kind {
    if compressed { Kind::Compressed } else { Kind::Image }
}

/// The beginning of a message of ROS 2 (`cdr`) or ROS 1, as any kind.
pub fn ros_header(cdr: bool, message: &[u8]) {
    let _ = decode::stamp(message, encoding(cdr));
    for kind in [Kind::Image, Kind::Compressed, Kind::Info] {
        let _ = decode::sample(message, encoding(cdr), kind);
    }
}

/// A message's calibration.
///
/// # Errors
/// What is wrong with it.
pub fn ros_info(cdr: bool, message: &[u8]) -> Result<Intrinsics, Error> {
    let name = Path::new("camera_info");
    ros::intrinsics(name, &decode::info(name, message, encoding(cdr))?)
}

/// A message's colour image.
///
/// # Errors
/// What is wrong with it.
pub fn ros_colour(cdr: bool, compressed: bool, message: &[u8]) -> Result<Image<u8>, Error> {
    let image = decode::colour(Path::new("colour"), message, encoding(cdr), kind(compressed))?;
    Ok((image.width, image.height, image.values))
}

/// A message's depth image.
///
/// # Errors
/// What is wrong with it.
pub fn ros_depth(cdr: bool, compressed: bool, message: &[u8]) -> Result<Image<u16>, Error> {
    let image = decode::depth(Path::new("depth"), message, encoding(cdr), kind(compressed))?.pixels;
    Ok((image.width, image.height, image.values))
}
