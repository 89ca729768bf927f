//! What the stages are measured on. Everything but the real recordings follows from seeds, the same in every run.

pub mod analytic;
pub mod extremes;
pub mod random;
pub mod real;
pub mod recordings;
pub mod views;

use pldi_core::Intrinsics;

/// Columns of all frames.
pub const W: usize = 320;
/// Rows of all frames.
pub const H: usize = 240;

/// A frame.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The camera.
    pub camera: Intrinsics,
    /// Depth in mm, row by row.
    pub depth: Vec<u16>,
    /// Red, green, blue, row by row.
    pub colour: Option<Vec<u8>>,
    /// The camera's height in metres, pitch and roll in radians, where they are known.
    pub pose: Option<[f32; 3]>,
    /// Whether the floor of that pose is in the image.
    pub shows_floor: bool,
    /// Each so many-th pixel is compared where the truth is costly; 0: none.
    pub stride: usize,
}

impl Scene {
    /// Depth in metres, sentinels and what is out of range as 0.
    pub fn metres(&self) -> Vec<f64> {
        self.depth.iter().map(|&d| if d <= 10_000 { f64::from(d) / 1000.0 } else { 0.0 }).collect()
    }

    /// The part from the top left corner of `w` columns and `h` rows, every `step`-th pixel.
    pub fn small(&self, w: usize, h: usize, step: usize) -> (Vec<u16>, Vec<u8>) {
        let pixels = || (0..h).flat_map(|v| (0..w).map(move |u| v * step * W + u * step));
        let colour = self.colour.as_deref().unwrap_or(&[]);
        let colour = pixels().flat_map(|i| colour.get(3 * i..3 * i + 3).unwrap_or(&[0; 3]).to_vec()).collect();
        (pixels().map(|i| self.depth[i]).collect(), colour)
    }
}
