//! Office chairs.

use core::f32::consts::TAU;

use super::palette;
use crate::mesh::{Material, Mesh, Transform};
use crate::rng::Rng;

/// An office chair: five-star base on castors, gas column, curved back, mostly with armrests.
pub(super) fn build(rng: &mut Rng) -> Mesh {
    let mut mesh = Mesh::new();
    let black = mesh.material(Material::plain([58, 58, 62]));
    let base = if rng.chance(0.5) { Material::shiny([180, 182, 186], 0.3) } else { Material::plain([64, 64, 68]) };
    let base = mesh.material(base);
    let soft = mesh.material(palette::cloth(rng));

    let reach = rng.range(0.27, 0.34);
    let start = rng.range(0.0, TAU);
    for i in 0..5 {
        let (s, c) = libm::sincosf(start + i as f32 * TAU / 5.0);
        let at = |r: f32, z: f32| [r * c, r * s, z];
        mesh.add_tube(&[at(0.03, 0.115), at(0.5 * reach, 0.105), at(reach, 0.075)], 0.018, 6, base);
        // The castor's axle lies along the arm.
        mesh.add_cylinder(at(reach - 0.022, 0.028), at(reach + 0.022, 0.028), 0.028, 12, black);
    }
    let seat = rng.range(0.42, 0.53);
    mesh.add_frustum([0.0, 0.0, 0.09], 0.045, [0.0, 0.0, 0.25], 0.03, 14, black);
    mesh.add_cylinder([0.0, 0.0, 0.2], [0.0, 0.0, seat - 0.08], 0.018, 12, base);
    mesh.add_block([0.0, 0.0, seat - 0.1], [0.2, 0.16, 0.04], black);

    let (depth, width) = (rng.range(0.42, 0.50), rng.range(0.44, 0.52));
    let (hx, hy) = (0.5 * depth, 0.5 * width);
    mesh.add_cushion([-hx, -hy, seat - 0.07], [hx, hy, seat + 0.02], rng.range(0.25, 0.45), soft);

    // The back, curved about the sitter, built over x = 0 and then leant over.
    let gap = rng.range(0.04, 0.16);
    let tall = rng.range(0.34, 0.64);
    let back_half = hy * rng.range(0.8, 1.0);
    let curve = rng.range(0.03, 0.09);
    let mesh_back = rng.chance(0.3);
    let mark = mesh.vertices.len();
    let n = 8;
    let thick = if mesh_back { 0.015 } else { rng.range(0.04, 0.07) };
    let at = |i: i32, j: i32, behind: f32| {
        let (t, w) = (i as f32 / n as f32 * 2.0 - 1.0, j as f32 / n as f32 * 2.0 - 1.0);
        // Corners are rounded off; the lumbar region bulges forward.
        let shrink = 1.0 - 0.18 * w * w * w * w;
        let lumbar = 0.03 * (1.0 - (w + 0.4) * (w + 0.4));
        [curve * t * t + lumbar - behind, t * back_half * shrink, 0.5 * tall * (w + 1.0) * (1.0 - 0.06 * t * t)]
    };
    for i in 0..n {
        for j in 0..n {
            for behind in [0.0, thick] {
                let corners = [at(i, j, behind), at(i + 1, j, behind), at(i + 1, j + 1, behind), at(i, j + 1, behind)];
                mesh.add_quad(corners, if mesh_back { black } else { soft });
            }
        }
        for (a, b) in [((i, 0), (i + 1, 0)), ((i, n), (i + 1, n)), ((0, i), (0, i + 1)), ((n, i), (n, i + 1))] {
            mesh.add_quad([at(a.0, a.1, 0.0), at(b.0, b.1, 0.0), at(b.0, b.1, thick), at(a.0, a.1, thick)], black);
        }
    }
    if rng.chance(0.3) {
        let (low, high) = (tall + 0.03, tall + rng.range(0.13, 0.17));
        mesh.add_cushion([-0.05, -0.15, low], [0.02, 0.15, high], 0.4, soft);
        mesh.add_block([-0.03, 0.0, tall - 0.05], [0.02, 0.05, 0.12], black);
    }
    let lean = Transform::rotate_y(-rng.range(0.08, 0.22));
    mesh.transform_since(mark, &lean.then(Transform::translate([-hx, 0.0, seat + gap])));
    let behind = -hx - 0.05;
    mesh.add_tube(
        &[[-0.08, 0.0, seat - 0.08], [behind - 0.01, 0.0, seat - 0.06], [behind - 0.05, 0.0, seat + gap + 0.3 * tall]],
        0.022,
        6,
        black,
    );

    match rng.below(4) {
        0 => {}
        style => {
            let arm = seat + rng.range(0.18, 0.25);
            for side in [-1.0, 1.0] {
                let y = side * (hy + 0.035);
                let pad = [[-0.12, y - 0.035, arm], [0.14, y + 0.035, arm + 0.03]];
                mesh.add_cushion(pad[0], pad[1], 0.3, black);
                let under = [0.02, side * (hy - 0.1), seat - 0.07];
                if style == 1 {
                    // A closed loop at the side.
                    let loop_ = [under, [0.17, y, seat - 0.02], [0.17, y, arm - 0.02], [-0.12, y, arm]];
                    mesh.add_tube(&loop_, 0.016, 8, black);
                    mesh.add_tube(&[[-0.12, y, arm], [-0.15, y, seat - 0.03], under], 0.016, 8, black);
                } else {
                    mesh.add_tube(&[under, [0.0, y, seat - 0.05], [0.0, y, arm]], 0.022, 8, black);
                }
            }
        }
    }
    mesh
}
