//! What the fuzz targets do with arbitrary bytes. The test `tests/fuzz.rs` does the same with the corpus.
//!
//! A target panics where a reader does, and where it lets something through that it promises to refuse.

mod image;
mod mesh;
pub mod serial;
mod templates;
mod text;

pub use image::image;
pub use mesh::{obj, off, ply, stl};
pub use serial::{serial_device, serial_host};
pub use templates::templates;
pub use text::{associations, camera_info, intrinsics, lists};

/// A target's name and what it does.
pub type Target = (&'static str, fn(&[u8]));

/// All targets, by name.
pub const TARGETS: &[Target] = &[
    ("associations", associations),
    ("camera_info", camera_info),
    ("image", image),
    ("intrinsics", intrinsics),
    ("lists", lists),
    ("obj", obj),
    ("off", off),
    ("ply", ply),
    ("serial_device", serial_device),
    ("serial_host", serial_host),
    ("stl", stl),
    ("templates", templates),
];
