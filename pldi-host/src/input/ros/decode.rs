//! Messages of either serialisation as images.

use std::path::Path;

use super::super::image::Pixels;
use super::cdr::Cdr;
pub(in crate::input) use super::image::Depth;
use super::image::content;
use super::messages::Header;
use super::ros1::Ros1;
use super::topics::Kind;
use super::{CameraInfo, CompressedImage, Encoding, Image, Malformed, compressed, image};
use crate::Error;

/// Reads a message in its serialisation; `$fields` are its fields.
macro_rules! read {
    ($encoding:expr, $bytes:expr, $fields:ident => $what:expr) => {
        match $encoding {
            Encoding::Ros1 => {
                let $fields = &mut Ros1::new($bytes);
                $what
            }
            Encoding::Cdr => Cdr::new($bytes).and_then(|mut cdr| {
                let $fields = &mut cdr;
                $what
            }),
        }
    };
}

/// What the beginning of an image's message tells.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::input) struct Sample {
    /// The image's encoding, or its format where it is compressed.
    pub(in crate::input) encoding: String,
    /// Its width and height, where they are told.
    pub(in crate::input) size: Option<(u32, u32)>,
}

fn malformed(name: &Path, kind: Kind) -> impl Fn(Malformed) -> Error {
    move |cause| content(name, format!("no {}: {cause}", kind.name()))
}

/// The stamp in the header of a message.
pub(in crate::input) fn stamp(bytes: &[u8], encoding: Encoding) -> Result<i64, Malformed> {
    read!(encoding, bytes, fields => Header::read(fields)).map(|header| header.stamp)
}

/// The name of the coordinate frame in a message's header.
pub(in crate::input) fn frame_id(bytes: &[u8], encoding: Encoding) -> Result<String, Malformed> {
    read!(encoding, bytes, fields => Header::read(fields)).map(|header| header.frame_id.to_owned())
}

/// What an image's message holds.
pub(in crate::input) fn sample(bytes: &[u8], encoding: Encoding, kind: Kind) -> Result<Sample, Malformed> {
    match kind {
        Kind::Image => {
            let image = read!(encoding, bytes, fields => Image::read(fields))?;
            Ok(Sample { encoding: image.encoding.to_owned(), size: Some((image.width, image.height)) })
        }
        Kind::Compressed => {
            let image = read!(encoding, bytes, fields => CompressedImage::read(fields))?;
            Ok(Sample { encoding: image.format.to_owned(), size: None })
        }
        Kind::Info => {
            let info = read!(encoding, bytes, fields => CameraInfo::read(fields))?;
            Ok(Sample { encoding: info.distortion_model, size: Some((info.width, info.height)) })
        }
    }
}

/// A colour image; `name` tells the message in errors.
pub(in crate::input) fn colour(name: &Path, bytes: &[u8], encoding: Encoding, kind: Kind) -> Result<Pixels<u8>, Error> {
    if kind == Kind::Compressed {
        let message = read!(encoding, bytes, fields => CompressedImage::read(fields));
        return compressed::colour(name, &message.map_err(malformed(name, kind))?);
    }
    let message = read!(encoding, bytes, fields => Image::read(fields));
    image::colour(name, &message.map_err(malformed(name, kind))?)
}

/// A depth image; `name` tells the message in errors.
pub(in crate::input) fn depth(name: &Path, bytes: &[u8], encoding: Encoding, kind: Kind) -> Result<Depth, Error> {
    if kind == Kind::Compressed {
        let message = read!(encoding, bytes, fields => CompressedImage::read(fields));
        return compressed::depth(name, &message.map_err(malformed(name, kind))?);
    }
    let message = read!(encoding, bytes, fields => Image::read(fields));
    image::depth(name, &message.map_err(malformed(name, kind))?)
}

/// A calibration; `name` tells the message in errors.
pub(in crate::input) fn info(name: &Path, bytes: &[u8], encoding: Encoding) -> Result<CameraInfo, Error> {
    let message = read!(encoding, bytes, fields => CameraInfo::read(fields));
    message.map_err(malformed(name, Kind::Info))
}
