//! Cardboard boxes.

use super::palette;
use crate::mesh::{Material, Mesh, Texture, Transform};
use crate::rng::Rng;

/// A box of 0.3 to 0.6 m: taped shut, or open with its flaps at various angles.
pub(super) fn build(rng: &mut Rng) -> Mesh {
    let mut mesh = Mesh::new();
    let brown = [[186, 146, 100], [170, 128, 84], [202, 166, 122], [224, 220, 210]];
    let card = mesh.material(Material::new(rng.pick(&brown), Texture::Noise));
    let tape = mesh.material(Material::plain([206, 190, 150]));
    let (x, y) = (rng.range(0.26, 0.45), rng.range(0.34, 0.60));
    let z = rng.range(0.24, 0.52);
    let (hx, hy) = (0.5 * x, 0.5 * y);
    let wall = 0.006;
    if rng.chance(0.55) {
        mesh.add_block([0.0; 3], [x, y, z], card);
        mesh.add_block([0.0, 0.0, z], [0.05, y, 0.001], tape);
        mesh.add_block([0.0, hy, 0.75 * z], [0.05, 0.002, 0.25 * z], tape);
        mesh.add_block([0.0, -hy, 0.75 * z], [0.05, 0.002, 0.25 * z], tape);
        if rng.chance(0.35) {
            // A smaller one on top.
            let (sx, sy, sz) = (x * rng.range(0.6, 0.95), y * rng.range(0.5, 0.9), rng.range(0.12, 0.2));
            let mark = mesh.vertices.len();
            let card = mesh.material(palette_card(rng));
            mesh.add_block([0.0, 0.0, z + 0.001], [sx, sy, sz], card);
            mesh.transform_since(mark, &Transform::rotate_z(rng.range(-0.3, 0.3)));
        }
        return mesh;
    }
    mesh.add_box([-hx, -hy, 0.0], [hx, hy, wall], card);
    for side in [-1.0, 1.0] {
        mesh.add_block([side * (hx - 0.5 * wall), 0.0, 0.0], [wall, y, z], card);
        mesh.add_block([0.0, side * (hy - 0.5 * wall), 0.0], [x, wall, z], card);
    }
    // Flaps: 0 stands upright, pi hangs down outside.
    let flap = 0.5 * x;
    for side in 0..4 {
        let (reach, length) = if side % 2 == 0 { (hx, y) } else { (hy, x) };
        let mark = mesh.vertices.len();
        mesh.add_box([-0.5 * wall, -0.5 * length, 0.0], [0.5 * wall, 0.5 * length, flap], card);
        let open = Transform::rotate_y(rng.range(0.15, 2.6));
        let place = open.then(Transform::translate([reach + 0.5 * wall, 0.0, z + 0.5 * wall]));
        mesh.transform_since(mark, &place.then(Transform::rotate_z(side as f32 * core::f32::consts::FRAC_PI_2)));
    }
    if rng.chance(0.4) {
        let filling = mesh.material(palette::cloth(rng));
        mesh.add_cushion([-0.9 * hx, -0.9 * hy, 0.3 * z], [0.9 * hx, 0.9 * hy, 0.85 * z], 0.4, filling);
    }
    mesh
}

/// Another carton's card.
fn palette_card(rng: &mut Rng) -> Material {
    Material::new(rng.pick(&[[176, 136, 92], [214, 208, 196], [196, 156, 108]]), Texture::Noise)
}
