//! Beds.

use super::palette;
use crate::mesh::{Material, Mesh, Texture, Transform};
use crate::rng::Rng;

/// A single or double bed, 2 m long, its head at -x: frame with or without head and foot board, mattress, pillows and
/// mostly a blanket.
pub(super) fn build(rng: &mut Rng) -> Mesh {
    let mut mesh = Mesh::new();
    let frame = mesh.material(palette::wood(rng));
    let sheet = mesh.material(Material::new([228, 226, 220], Texture::Cloth));
    let blanket = mesh.material(palette::cloth(rng));
    let width = rng.pick(&[0.80, 0.90, 1.00, 1.20, 1.40]) + rng.range(0.0, 0.06);
    let length = rng.range(1.92, 2.06);
    let (hx, hy) = (0.5 * length, 0.5 * width);
    let rail = rng.range(0.22, 0.34);
    let top = rail + rng.range(0.14, 0.22);
    let box_spring = rng.chance(0.3);

    if box_spring {
        mesh.add_box([-hx, -hy, 0.06], [hx, hy, rail], blanket);
    } else {
        let board = 0.03;
        let tall = rng.range(0.1, 0.2);
        for side in [-1.0, 1.0] {
            mesh.add_block([0.0, side * (hy - 0.5 * board), rail - tall], [length, board, tall], frame);
            mesh.add_block([side * (hx - 0.5 * board), 0.0, rail - tall], [board, width, tall], frame);
        }
        mesh.add_box([-hx, -hy, rail - 0.04], [hx, hy, rail - 0.02], frame);
    }
    for (sx, sy) in [(1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (-1.0, 1.0)] {
        mesh.add_block([sx * (hx - 0.04), sy * (hy - 0.04), 0.0], [0.07, 0.07, rail - 0.02], frame);
    }
    mesh.add_cushion([-hx + 0.03, -hy + 0.02, rail - 0.03], [hx - 0.03, hy - 0.02, top], 0.1, sheet);

    let head = match rng.below(4) {
        0 => top,
        _ => rng.range(0.75, 1.15),
    };
    if head > top {
        head_board(&mut mesh, rng, [-hx, hy], rail, head, frame, blanket);
    }
    if rng.chance(0.35) {
        mesh.add_box([hx - 0.01, -hy, rail - 0.15], [hx + 0.025, hy, top + rng.range(0.02, 0.2)], frame);
    }

    let pillows = if width > 1.1 { 2 } else { 1 };
    for i in 0..pillows {
        let y = if pillows == 1 { 0.0 } else { (i as f32 - 0.5) * hy };
        let half = (0.45 * width / pillows as f32).min(0.36);
        let mark = mesh.vertices.len();
        mesh.add_cushion([0.0, -half, 0.0], [0.42, half, 0.14], 0.5, sheet);
        let turn = Transform::rotate_y(-rng.range(0.05, 0.4)).then(Transform::rotate_z(rng.range(-0.1, 0.1)));
        mesh.transform_since(mark, &turn.then(Transform::translate([-hx + 0.06, y, top - 0.02])));
    }
    if rng.chance(0.75) {
        let start = -hx + rng.range(0.5, 1.0);
        let over = 0.03;
        let down = top - rng.range(0.12, 0.25);
        mesh.add_cushion([start, -hy - over, down], [hx - 0.02, hy + over, top + 0.04], 0.14, blanket);
    }
    mesh
}

/// A head board from the floor to height `head`: a panel, upright bars or padding. `corner` is x and half the width.
fn head_board(mesh: &mut Mesh, rng: &mut Rng, corner: [f32; 2], rail: f32, head: f32, frame: u16, soft: u16) {
    let [x, hy] = corner;
    match rng.below(3) {
        0 => mesh.add_box([x - 0.03, -hy, rail - 0.1], [x + 0.005, hy, head], frame),
        1 => {
            for side in [-1.0, 1.0] {
                mesh.add_block([x - 0.015, side * (hy - 0.025), 0.0], [0.05, 0.05, head], frame);
            }
            mesh.add_box([x - 0.03, -hy, head - 0.06], [x, hy, head], frame);
            let n = 7;
            for i in 0..n {
                let y = (hy - 0.05) * (2.0 * (i as f32 + 0.5) / n as f32 - 1.0);
                mesh.add_block([x - 0.015, y, rail - 0.1], [0.02, 0.03, head - rail + 0.06], frame);
            }
        }
        _ => mesh.add_cushion([x - 0.08, -hy - 0.02, 0.05], [x + 0.03, hy + 0.02, head], 0.12, soft),
    }
}
