//! Frames from a seed: what no sensor gives, but might.

use super::analytic::CAMERA;
use super::{H, Scene, W};
use crate::common::Random;

/// Frames.
pub const COUNT: usize = 24;

/// A frame: of noise, of patches, of waves, of walks, each with holes of its own.
pub fn scene(number: usize) -> Scene {
    let mut random = Random(1000 + number as u64);
    let mut depth: Vec<u16> = match number % 4 {
        0 => (0..W * H).map(|_| random.bits() as u16 >> (random.bits() % 5)).collect(),
        1 => patches(&mut random),
        2 => waves(&mut random),
        _ => walks(&mut random),
    };
    let holes = random.between(0.0, 0.6);
    depth.iter_mut().for_each(|d| *d = if random.unit() < holes { 0 } else { *d });
    let level = random.bits() % 4;
    let colour =
        (0..3 * W * H).map(|i| (((i / 960) as u64 * level) as u8).wrapping_add(random.bits() as u8 >> (2 * level)));
    let colour = Some(colour.collect());
    let pose = [random.between(0.4, 2.0), random.between(0.0, 0.8), random.between(-0.2, 0.2)].map(|v| v as f32);
    Scene { camera: CAMERA, depth, colour, pose: Some(pose), shows_floor: false, stride: 29 }
}

/// Rectangles at random depths, one over the other.
fn patches(random: &mut Random) -> Vec<u16> {
    let mut depth = vec![0; W * H];
    for _ in 0..60 {
        let z = random.between(400.0, 9999.0) as u16;
        let (u, v) = (random.bits() as usize % W, random.bits() as usize % H);
        let (w, h) = (1 + random.bits() as usize % 120, 1 + random.bits() as usize % 90);
        for row in depth.chunks_mut(W).skip(v).take(h) {
            row.iter_mut().skip(u).take(w).for_each(|d| *d = z);
        }
    }
    depth
}

/// A sum of waves.
fn waves(random: &mut Random) -> Vec<u16> {
    let waves: Vec<[f64; 4]> = (0..5)
        .map(|_| {
            [
                random.between(-0.2, 0.2),
                random.between(-0.2, 0.2),
                random.between(0.0, 6.3),
                random.between(10.0, 300.0),
            ]
        })
        .collect();
    let middle = random.between(900.0, 5000.0);
    let at = |u: usize, v: usize| {
        let wave = |[a, b, phase, height]: &[f64; 4]| height * libm::sin(a * u as f64 + b * v as f64 + phase);
        (middle + waves.iter().map(wave).sum::<f64>()).max(0.0) as u16
    };
    (0..W * H).map(|i| at(i % W, i / W)).collect()
}

/// A random walk along each row.
fn walks(random: &mut Random) -> Vec<u16> {
    let mut z = 2000.0;
    (0..W * H)
        .map(|i| {
            z = if i % W == 0 { random.between(500.0, 6000.0) } else { z + 20.0 * random.normal() };
            z.clamp(300.0, 9900.0) as u16
        })
        .collect()
}
