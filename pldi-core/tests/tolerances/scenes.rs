//! The inputs that the table is measured on: depth and colour as sensors give them, the same in every run.

use crate::common::{BENCH, Block, CHAIR, CHEST, Random, Room};
use pldi_core::Intrinsics;

/// Columns of the scenes.
pub const W: usize = 320;
/// Rows of the scenes.
pub const H: usize = 240;
/// The camera of all scenes.
pub const CAMERA: Intrinsics = Intrinsics { width: 320, height: 240, fx: 285.63, fy: 283.1, cx: 161.2, cy: 117.9 };

/// A frame.
pub struct Scene {
    /// Depth in mm, row by row.
    pub depth: Vec<u16>,
    /// Red, green, blue, row by row.
    pub colour: Vec<u8>,
}

impl Scene {
    /// Depth in metres, sentinels and what is out of range as 0.
    pub fn metres(&self) -> Vec<f64> {
        self.depth.iter().map(|&d| if d <= 10_000 { f64::from(d) / 1000.0 } else { 0.0 }).collect()
    }

    /// The part from the top left corner of `w` columns and `h` rows, every `step`-th pixel.
    pub fn small(&self, w: usize, h: usize, step: usize) -> Self {
        let pixels = || (0..h).flat_map(|v| (0..w).map(move |u| v * step * W + u * step));
        Self {
            depth: pixels().map(|i| self.depth[i]).collect(),
            colour: pixels().flat_map(|i| self.colour[3 * i..3 * i + 3].to_vec()).collect(),
        }
    }
}

/// Builds a scene from the depth in metres and the colour at each pixel's ray (x, y, 1), then measures it: noise and
/// steps of depth that grow with z^2, missing readings, sentinels.
fn scene(seed: u64, surface: impl Fn(f64, f64) -> (f64, [f64; 3])) -> Scene {
    let mut random = Random(seed);
    let mut out = Scene { depth: Vec::new(), colour: Vec::new() };
    for v in 0..H {
        for u in 0..W {
            let x = (u as f64 - f64::from(CAMERA.cx)) / f64::from(CAMERA.fx);
            let y = (v as f64 - f64::from(CAMERA.cy)) / f64::from(CAMERA.fy);
            let (z, colour) = surface(x, y);
            out.depth.push(measured(z, &mut random));
            out.colour.extend(colour.map(|c| (c + 2.0 * random.normal()).clamp(0.0, 255.0) as u8));
        }
    }
    holes(&mut out, &mut random);
    out
}

/// What a sensor makes of a depth in metres.
fn measured(z: f64, random: &mut Random) -> u16 {
    let step = 2.85e-3 * z * z;
    let noisy = z + 1.0e-3 * z * z * random.normal();
    let z = if step > 0.0 { libm::round(noisy / step) * step } else { 0.0 };
    match random.bits() % 200 {
        0 | 1 => 0,
        2 => 65_535,
        _ if (0.3..9.5).contains(&z) => (z * 1000.0 + 0.5) as u16,
        _ => 0,
    }
}

/// Round and square regions without readings, as dark or shining things have, and shadows right of steps.
fn holes(scene: &mut Scene, random: &mut Random) {
    for i in 0..6 {
        let (cu, cv, r) = (random.between(0.0, 320.0), random.between(0.0, 240.0), random.between(2.0, 24.0));
        for v in 0..H {
            for u in 0..W {
                let (du, dv) = ((u as f64 - cu).abs(), (v as f64 - cv).abs());
                if if i % 2 == 0 { du * du + dv * dv < r * r } else { du.max(dv) < r } {
                    scene.depth[v * W + u] = 0;
                }
            }
        }
    }
    for v in 0..H {
        let mut shadow = 0;
        for u in 1..W {
            let (left, here) = (scene.depth[v * W + u - 1], scene.depth[v * W + u]);
            if left > 0 && here > left.saturating_add(150) && here < 10_000 {
                shadow = 5;
            }
            if shadow > 0 {
                shadow -= 1;
                scene.depth[v * W + u] = 0;
            }
        }
    }
}

/// Slanted planes that meet in edges, under a texture that has nothing to do with them.
fn planes() -> Scene {
    scene(1, |x, y| {
        let planes = [(0.5, 0.1, 0.85, 1.4), (-0.6, 0.0, 0.8, 1.5), (0.1, 0.75, 0.65, 1.1)];
        let z = planes.map(|(a, b, c, d)| d / (a * x + b * y + c));
        let near = z.into_iter().filter(|z| *z > 0.0).fold(4.0, f64::min);
        let texture = 60.0 * libm::sin(31.0 * x) * libm::sin(23.0 * y);
        (near, [128.0 + texture, 120.0 + 0.5 * texture, 110.0 - texture])
    })
}

/// Steps of 3 cm to 1 m between planes that face the camera, with edges of colour on some of them.
fn steps() -> Scene {
    scene(2, |x, y| {
        let column = libm::floor((x + 0.6) * 6.0);
        let row = libm::floor((y + 0.5) * 5.0);
        let z = 1.0 + 0.03 * column * column + 0.25 * (row + column).rem_euclid(3.0);
        let bright = if row.rem_euclid(2.0) < 1.0 { 70.0 * column.rem_euclid(3.0) } else { 100.0 };
        (z, [bright, bright + 20.0, 180.0 - bright])
    })
}

/// A sphere before a wall that slants.
fn sphere() -> Scene {
    scene(3, |x, y| {
        let (a, b, c) = (x * x + y * y + 1.0, -2.0 * (0.1 * x + 1.6), 0.1 * 0.1 + 1.6 * 1.6 - 0.5 * 0.5);
        let root = b * b - 4.0 * a * c;
        let wall = 2.6 / (1.0 - 0.2 * x);
        if root > 0.0 {
            let z = (-b - root.sqrt()) / (2.0 * a);
            let light = 80.0 + 250.0 * (1.6 - z);
            (z, [light, 0.6 * light, 0.5 * light])
        } else {
            (wall, [170.0 + 40.0 * x, 170.0, 165.0])
        }
    })
}

/// A room with furniture, and pixels that lost their reading.
fn furniture() -> Scene {
    let room = rooms()[1];
    let shot = room.shoot(&CAMERA, 4);
    let mut out = Scene { depth: shot.depth, colour: shot.colour };
    holes(&mut out, &mut Random(44));
    out
}

/// All frames.
pub fn all() -> Vec<Scene> {
    vec![planes(), steps(), sphere(), furniture()]
}

/// Rooms with one object each.
pub fn rooms() -> [Room<'static>; 3] {
    let room = |object: &'static [Block], at, pitch| Room { height: 1.2, pitch, wall: 3.7, at, object, noise: 1.4e-3 };
    [room(CHEST, [-0.2, 2.1], 0.4), room(CHAIR, [0.3, 1.8], 0.45), room(BENCH, [0.0, 2.4], 0.3)]
}
