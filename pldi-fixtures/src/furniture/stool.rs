//! Stools.

use core::f32::consts::TAU;

use super::palette;
use crate::mesh::Mesh;
use crate::rng::Rng;

/// A stool, 0.42 to 0.75 m tall: three or four slanted legs, a round or square seat, often a ring or rungs.
pub(super) fn build(rng: &mut Rng) -> Mesh {
    let mut mesh = Mesh::new();
    let frame = if rng.chance(0.7) { palette::wood(rng) } else { palette::metal(rng) };
    let frame = mesh.material(frame);
    let pad = mesh.material(palette::cloth(rng));
    let height = if rng.chance(0.35) { rng.range(0.60, 0.75) } else { rng.range(0.42, 0.52) };
    let radius = rng.range(0.14, 0.19);
    let thick = rng.range(0.025, 0.05);
    let legs = if rng.chance(0.35) { 3 } else { 4 };
    let square = legs == 4 && rng.chance(0.3);
    let padded = rng.chance(0.35);

    let seat = if padded { height - 0.05 } else { height };
    if square {
        mesh.add_block([0.0, 0.0, seat - thick], [1.9 * radius, 1.9 * radius, thick], frame);
        if padded {
            mesh.add_cushion([-radius, -radius, seat - 0.01], [radius, radius, height], 0.25, pad);
        }
    } else {
        let edge = 0.3 * thick;
        let profile = [
            [0.0, 0.0],
            [radius - edge, 0.0],
            [radius, edge],
            [radius, thick - edge],
            [radius - edge, thick],
            [0.0, thick],
        ];
        mesh.add_lathe([0.0, 0.0, seat - thick], &profile, 28, frame);
        if padded {
            let profile = [[0.0, 0.0], [radius, 0.0], [radius + 0.01, 0.025], [0.8 * radius, 0.055], [0.0, 0.06]];
            mesh.add_lathe([0.0, 0.0, seat - 0.01], &profile, 28, pad);
        }
    }
    let top = radius * rng.range(0.6, 0.8);
    let foot = radius * rng.range(1.0, 1.0 + 0.7 * height);
    let leg = rng.range(0.012, 0.02);
    let round = rng.chance(0.6);
    let corner = |i: usize, r: f32, z: f32| {
        let (s, c) = libm::sincosf((i as f32 + 0.5) * TAU / legs as f32);
        [r * c, r * s, z]
    };
    for i in 0..legs {
        let (a, b) = (corner(i, foot, 0.0), corner(i, top, seat - thick));
        if round {
            mesh.add_frustum(a, 0.8 * leg, b, leg, 10, frame);
        } else {
            mesh.add_leg(a, [1.6 * leg; 2], b, [2.0 * leg; 2], frame);
        }
    }
    let part = rng.range(0.3, 0.5);
    let reach = foot + (top - foot) * part;
    let z = part * (seat - thick);
    match rng.below(3) {
        0 => {
            let ring: Vec<[f32; 3]> = (0..=24)
                .map(|i| {
                    let (s, c) = libm::sincosf(i as f32 * TAU / 24.0);
                    [reach * c, reach * s, z]
                })
                .collect();
            mesh.add_tube(&ring, 0.009, 6, frame);
        }
        1 => {
            for i in 0..legs {
                mesh.add_tube(&[corner(i, reach, z), corner(i + 1, reach, z)], 0.01, 8, frame);
            }
        }
        _ => {}
    }
    mesh
}
