//! Tables.

use core::f32::consts::TAU;

use super::palette;
use crate::mesh::Mesh;
use crate::rng::Rng;

/// A table, 0.70 to 0.77 m high: a rectangular, round or oval top on four legs, two trestles or a column.
pub(super) fn build(rng: &mut Rng) -> Mesh {
    let mut mesh = Mesh::new();
    let top = mesh.material(palette::wood(rng));
    let legs = if rng.chance(0.6) { palette::wood(rng) } else { palette::metal(rng) };
    let legs = mesh.material(legs);
    let height = rng.range(0.70, 0.77);
    let thick = rng.range(0.02, 0.045);
    let under = height - thick;
    if rng.chance(0.3) {
        column_table(&mut mesh, rng, top, legs, height, thick);
        return mesh;
    }
    let (depth, width) = (rng.range(0.65, 0.90), rng.range(0.75, 1.65));
    let (hx, hy) = (0.5 * depth, 0.5 * width);
    if rng.chance(0.2) {
        // Oval, or with bowed sides.
        let corners: Vec<[f32; 2]> = (0..40)
            .map(|i| {
                let (s, c) = libm::sincosf(i as f32 * TAU / 40.0);
                let bow = |v: f32| libm::copysignf(libm::powf(v.abs(), 0.6), v);
                [hx * bow(c), hy * bow(s)]
            })
            .collect();
        mesh.add_prism(&corners, under, height, top);
    } else {
        mesh.add_block([0.0, 0.0, under], [depth, width, thick], top);
    }
    let inset = rng.range(0.04, 0.12);
    let (lx, ly) = (hx - inset, hy - inset);
    let leg = rng.range(0.035, 0.075);
    match rng.below(4) {
        0 => {
            // Trestles: an A at either end.
            let y = ly - 0.1;
            for side in [-1.0, 1.0] {
                for sx in [-1.0, 1.0] {
                    let from = [sx * lx, side * y, 0.0];
                    mesh.add_leg(from, [leg, leg], [sx * 0.05, side * y, under], [leg, leg], legs);
                }
                mesh.add_block([0.0, side * y, 0.25], [1.2 * lx, 0.03, 0.04], legs);
            }
            mesh.add_block([0.0, 0.0, 0.4], [0.03, 2.0 * y, 0.06], legs);
        }
        1 => {
            // Frames of square tube: a U at either end.
            let bar = 0.5 * leg;
            for side in [-1.0, 1.0] {
                let y = side * ly;
                for sx in [-1.0, 1.0] {
                    mesh.add_leg([sx * lx, y, 0.0], [leg, bar], [sx * lx, y, under], [leg, bar], legs);
                }
                mesh.add_block([0.0, y, 0.0], [2.0 * lx, bar, bar], legs);
            }
        }
        style => {
            let splay = if style == 2 { 0.0 } else { rng.range(0.02, 0.06) };
            let round = rng.chance(0.4);
            for (sx, sy) in [(1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (-1.0, 1.0)] {
                let (a, b) = ([sx * (lx + splay), sy * (ly + splay), 0.0], [sx * lx, sy * ly, under]);
                if round {
                    mesh.add_frustum(a, 0.3 * leg, b, 0.55 * leg, 14, legs);
                } else {
                    mesh.add_leg(a, [0.75 * leg; 2], b, [leg; 2], legs);
                }
            }
            if rng.chance(0.7) {
                let apron = rng.range(0.06, 0.1);
                for side in [-1.0, 1.0] {
                    mesh.add_block([side * lx, 0.0, under - apron], [0.02, 2.0 * ly, apron], legs);
                    mesh.add_block([0.0, side * ly, under - apron], [2.0 * lx, 0.02, apron], legs);
                }
            }
        }
    }
    mesh
}

/// A bistro or meeting table: a round or square top on one column with a disc or a cross as its foot.
fn column_table(mesh: &mut Mesh, rng: &mut Rng, top: u16, foot: u16, height: f32, thick: f32) {
    let radius = rng.range(0.35, 0.58);
    let under = height - thick;
    if rng.chance(0.7) {
        mesh.add_cylinder([0.0, 0.0, under], [0.0, 0.0, height], radius, 40, top);
    } else {
        mesh.add_block([0.0, 0.0, under], [1.8 * radius, 1.8 * radius, thick], top);
    }
    let column = rng.range(0.03, 0.055);
    mesh.add_cylinder([0.0, 0.0, 0.02], [0.0, 0.0, under], column, 18, foot);
    mesh.add_frustum([0.0, 0.0, under - 0.05], column, [0.0, 0.0, under], 0.14, 18, foot);
    let reach = 0.62 * radius;
    if rng.chance(0.5) {
        let profile = [[0.0, 0.0], [reach, 0.0], [reach, 0.012], [1.4 * column, 0.05], [0.0, 0.06]];
        mesh.add_lathe([0.0; 3], &profile, 32, foot);
    } else {
        for i in 0..4 {
            let (s, c) = libm::sincosf((i as f32 + 0.5) * TAU / 4.0);
            let arm = [[0.0, 0.0, 0.09], [1.15 * reach * c, 1.15 * reach * s, 0.022]];
            mesh.add_tube(&arm, 0.026, 4, foot);
        }
    }
}
