//! What the fuzz targets do with arbitrary bytes. The test `tests/fuzz.rs` does the same with the corpus.
//!
//! A target panics where a reader does, and where it lets something through that it promises to refuse.

mod image;
mod mesh;
mod pairs;
mod ros;
pub mod serial;
mod templates;
mod text;

use std::fmt::Display;

pub use image::image;
pub use mesh::{obj, off, ply, stl};
pub use pairs::pairs;
pub use ros::{bag, cdr, compressed_depth, mcap};
pub use serial::{serial_device, serial_host};
pub use templates::templates;
pub use text::{associations, camera_info, intrinsics, lists};

/// A target's name and what it does.
pub type Target = (&'static str, fn(&[u8]));

/// All targets, by name.
pub const TARGETS: &[Target] = &[
    ("associations", associations),
    ("bag", bag),
    ("camera_info", camera_info),
    ("cdr", cdr),
    ("compressed_depth", compressed_depth),
    ("image", image),
    ("intrinsics", intrinsics),
    ("lists", lists),
    ("mcap", mcap),
    ("obj", obj),
    ("off", off),
    ("pairs", pairs),
    ("ply", ply),
    ("serial_device", serial_device),
    ("serial_host", serial_host),
    ("stl", stl),
    ("templates", templates),
];

/// What a reader refuses with: a sentence that names the file, however long or strange the file is.
fn refused(error: &impl Display, name: &str) {
    let text = error.to_string();
    assert!(text.contains(name) && text.chars().count() < 600 && !text.chars().any(char::is_control), "{text:?}");
}
