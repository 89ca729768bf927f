//! Recordings of real sensors, beside the checkout.

use std::path::{Path, PathBuf};

use pldi_host::input::{self, Frame, OpenOptions};

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
    let uri = folder.to_str().expect("a name in UTF-8");
    let mut recording = input::open(uri, &OpenOptions::default()).expect("a recording");
    let scene = |(i, frame): (usize, Result<Frame, _>)| {
        let frame = frame.unwrap_or_else(|e| panic!("{uri} {i}: {e}")).qvga;
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
    recording.frames().enumerate().map(scene).collect()
}
