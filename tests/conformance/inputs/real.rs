//! Recordings of real sensors, beside the checkout.

use std::path::{Path, PathBuf};

use pldi_host::input::{FrameSource, OpenOptions, Recording};

use super::Scene;

/// The recordings' folders; empty where there are none.
pub fn folders() -> Vec<PathBuf> {
    let place = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/recordings");
    let Ok(entries) = std::fs::read_dir(place) else { return Vec::new() };
    let mut folders: Vec<_> = entries.flatten().map(|entry| entry.path()).filter(|path| path.is_dir()).collect();
    folders.sort();
    folders
}

/// All frames of a recording.
pub fn scenes(folder: &Path) -> Vec<Scene> {
    let recording = Recording::open(folder, &OpenOptions::default()).expect("a recording");
    let scene = |i: usize| {
        let frame = recording.frame(i).unwrap_or_else(|e| panic!("{} {i}: {e}", folder.display()));
        // The costly truths are computed on the first frame.
        let stride = if i == 0 { 3 } else { 0 };
        Scene {
            camera: frame.intrinsics,
            depth: frame.depth,
            colour: frame.colour,
            pose: None,
            shows_floor: false,
            stride,
        }
    };
    (0..recording.len()).map(scene).collect()
}
