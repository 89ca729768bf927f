//! Frames and views at the ends of all ranges, and neighbourhoods whose points lie in a plane, on a line, in one place.

use super::analytic::CAMERA;
use super::{H, Scene, W};
use crate::common::Random;
use pldi_core::descriptor::View;
use pldi_core::wavelet::SIZE;

/// Depth at a column and row, in mm.
type Depth = fn(usize, usize) -> u16;
/// Level of all three channels at a column and row.
type Colour = fn(usize, usize) -> u8;

/// Depth and colour of each frame.
const FRAMES: &[(Depth, Colour)] = &[
    // All invalid: nothing, a sentinel, just beyond the range.
    (|_, _| 0, |_, _| 0),
    (|_, _| u16::MAX, |_, _| 255),
    (|_, _| 10_001, |_, _| 128),
    // All one value: the smallest, what lies within the normals' radius and just beyond, the largest that a depth of
    // 1/8 mm holds and the first that it does not, the largest.
    (|_, _| 1, |_, _| 0),
    (|_, _| 40, |_, _| 9),
    (|_, _| 60, |_, _| 9),
    (|_, _| 8191, |_, _| 255),
    (|_, _| 8192, |_, _| 255),
    (|_, _| 10_000, |_, _| 128),
    // Checkerboards: of readings, of depths, of colours, the largest steps of both.
    (|u, v| if (u + v) % 2 == 0 { 2000 } else { 0 }, |_, _| 100),
    (|u, v| if (u + v) % 2 == 0 { 1000 } else { 1010 }, |_, _| 100),
    (|_, _| 2000, |u, v| if (u + v) % 2 == 0 { 0 } else { 255 }),
    (|u, v| if (u + v) % 2 == 0 { 1 } else { 10_000 }, |u, v| if (u + v) % 2 == 0 { 0 } else { 255 }),
    (|u, v| if (u / 8 + v / 8) % 2 == 0 { 500 } else { 8000 }, |u, _| u as u8),
    // A single reading; a row, a column and a diagonal of them; pairs and threes far apart: no normal, or a bare one.
    (|u, v| if (u, v) == (160, 120) { 1500 } else { 0 }, |_, _| 50),
    (|_, v| if v == 120 { 1500 } else { 0 }, |_, _| 50),
    (|u, _| if u == 160 { 1500 } else { 0 }, |_, _| 50),
    (|u, v| if u == v { 1500 } else { 0 }, |u, v| (u ^ v) as u8),
    (|u, v| if u % 40 < 2 && v % 40 == 0 { 1200 } else { 0 }, |u, v| 40 * (u % 2 + v % 2) as u8),
    (|u, v| if u % 40 + v % 40 < 2 { 1200 } else { 0 }, |u, v| 120 * (u % 2 + v % 2) as u8),
    // Stripes two pixels wide, a plane seen almost edge on, a wedge down to nothing, a ramp over the whole range.
    (|u, _| if u % 4 < 2 { 900 } else { 0 }, |u, _| 200 * ((u / 2) % 2) as u8),
    (|_, v| (240_000 / (v + 24)) as u16, |_, v| v as u8),
    (|u, _| u as u16, |_, _| 77),
    (|u, v| (130 * v + u) as u16, |u, v| (u * v) as u8),
];

/// Frames.
pub const COUNT: usize = FRAMES.len();

/// A frame.
pub fn scene(number: usize) -> Scene {
    let (depth, level) = FRAMES[number];
    let depth: Vec<u16> = (0..W * H).map(|i| depth(i % W, i / W)).collect();
    let colour = (0..W * H).flat_map(|i| [level(i % W, i / W); 3]).collect();
    // Near the camera each neighbourhood is most of the image.
    let near = depth.iter().any(|d| (40..400).contains(d));
    let stride = if near { 997 } else { 13 };
    Scene { camera: CAMERA, depth, colour: Some(colour), pose: Some([1.2, 0.4, 0.0]), shows_floor: false, stride }
}

/// Views: empty, full, one pixel, checkerboards, halves, stripes, steps, noise at full and at little amplitude.
pub fn views() -> Vec<Box<View>> {
    let mut random = Random(30);
    let mut noise = |amplitude: f64| view(|_, _| random.between(0.0, amplitude) as u16);
    let loud = [noise(65_535.9), noise(900.0), noise(2.0)];
    let mut out = vec![
        view(|_, _| 0),
        view(|_, _| 1),
        view(|_, _| u16::MAX),
        view(|u, v| if (u, v) == (0, 0) { u16::MAX } else { 0 }),
        view(|u, v| if (u, v) == (77, 50) { 1 } else { 0 }),
        view(|u, v| if (u + v) % 2 == 0 { u16::MAX } else { 0 }),
        view(|u, v| if (u / 8 + v / 8) % 2 == 0 { u16::MAX } else { 0 }),
        view(|_, v| if v < SIZE / 2 { u16::MAX } else { 0 }),
        view(|u, _| if u % 2 == 0 { u16::MAX } else { 0 }),
        view(|_, v| if v % 4 < 2 { u16::MAX } else { 1 }),
        view(|u, v| ((u * 65_535 / 127) / (1 + v / 64)) as u16),
    ];
    out.extend(loud);
    out
}

fn view(mut value: impl FnMut(usize, usize) -> u16) -> Box<View> {
    let mut view: Box<View> = crate::stages::boxed(0);
    for (v, row) in view.iter_mut().enumerate() {
        row.iter_mut().enumerate().for_each(|(u, n)| *n = value(u, v));
    }
    view
}
