//! Four-legged chairs.

use super::palette;
use crate::mesh::{Mesh, Transform};
use crate::rng::Rng;

/// A dining or visitor's chair: seat at 0.42 to 0.48 m; legs of square, round or slanted kind; a back of slats, rungs,
/// a panel, a low ring or a cushion; perhaps armrests.
pub(super) fn build(rng: &mut Rng) -> Mesh {
    let mut mesh = Mesh::new();
    let frame = if rng.chance(0.7) { palette::wood(rng) } else { palette::metal(rng) };
    let frame = mesh.material(frame);
    let soft = mesh.material(palette::cloth(rng));
    let (depth, width) = (rng.range(0.38, 0.46), rng.range(0.38, 0.50));
    let seat = rng.range(0.42, 0.48);
    let height = rng.range(0.78, 1.04);
    let (hx, hy) = (0.5 * depth, 0.5 * width);
    let leg = rng.range(0.024, 0.045);
    let splay = rng.range(0.0, 0.07);
    let round = rng.chance(0.4);
    let thick = rng.range(0.02, 0.05);

    for (sx, sy) in [(1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (-1.0, 1.0)] {
        let top = [sx * (hx - leg), sy * (hy - leg), seat - thick];
        let foot = [top[0] + sx * splay, top[1] + sy * splay * 0.6, 0.0];
        if round {
            mesh.add_frustum(foot, 0.35 * leg, top, 0.6 * leg, 12, frame);
        } else {
            mesh.add_leg(foot, [0.8 * leg; 2], top, [leg; 2], frame);
        }
    }
    if rng.chance(0.45) {
        let (z, reach) = (rng.range(0.12, 0.28), 0.5 * splay);
        for side in [-1.0, 1.0] {
            let y = side * (hy - leg + 0.3 * splay);
            mesh.add_tube(&[[-hx + leg - reach, y, z], [hx - leg + reach, y, z]], 0.01, 8, frame);
        }
        mesh.add_tube(&[[0.0, -hy + leg, z], [0.0, hy - leg, z]], 0.01, 8, frame);
    }
    if rng.chance(0.5) {
        let roundness = rng.range(0.12, 0.25);
        mesh.add_cushion([-hx, -hy, seat - thick], [hx, hy, seat + 0.04], roundness, soft);
    } else {
        mesh.add_box([-hx, -hy, seat - thick], [hx, hy, seat], frame);
    }

    // The back is built upright over x = 0 and then leant over about the seat's rear edge.
    let mark = mesh.vertices.len();
    let rise = height - seat;
    let post = 0.9 * leg;
    let inner = hy - post;
    let style = rng.below(6);
    if style != 4 {
        for side in [-1.0, 1.0] {
            let y = side * (hy - 0.5 * post);
            mesh.add_leg([0.0, y, -thick], [post; 2], [0.0, y, rise], [0.8 * post; 2], frame);
        }
    }
    match style {
        0 => {
            // Upright slats under a rail.
            mesh.add_box([-0.012, -hy, rise - 0.07], [0.012, hy, rise], frame);
            let n = 3 + rng.below(4);
            let slat = rng.range(0.012, 0.03);
            for i in 0..n {
                let y = inner * (2.0 * (i as f32 + 0.5) / n as f32 - 1.0);
                mesh.add_block([0.0, y, 0.0], [0.012, slat, rise - 0.06], frame);
            }
        }
        1 => {
            // Ladder: rungs across.
            let n = 2 + rng.below(3);
            let tall = rng.range(0.04, 0.075);
            for i in 0..n {
                let z = rise - tall - i as f32 * (rise - 0.1) / n as f32;
                mesh.add_box([-0.01, -inner, z], [0.01, inner, z + tall], frame);
            }
        }
        2 => {
            // A solid panel down to the seat.
            mesh.add_box([-0.01, -inner, 0.06], [0.01, inner, rise - 0.01], frame);
        }
        3 => {
            // A padded panel with a gap above the seat.
            mesh.add_cushion([-0.025, -hy, 0.38 * rise], [0.035, hy, rise], 0.2, soft);
        }
        4 => {
            // A moulded shell: a back curved across its width.
            let n = 8;
            for i in 0..n {
                let slope = |i: i32| (i as f32 / n as f32 - 0.5) * 2.0;
                let at = |t: f32, z: f32| [0.09 * t * t, t * hy, z];
                let (a, b) = (slope(i), slope(i + 1));
                let crown = |t: f32| rise * (1.0 - 0.12 * t * t);
                mesh.add_quad([at(a, -0.02), at(b, -0.02), at(b, crown(b)), at(a, crown(a))], frame);
            }
        }
        _ => {
            // A single broad rail, open below.
            let tall = rng.range(0.12, 0.2);
            mesh.add_box([-0.012, -inner, rise - tall], [0.012, inner, rise], frame);
        }
    }
    let lean = Transform::rotate_y(-rng.range(0.06, 0.24));
    mesh.transform_since(mark, &lean.then(Transform::translate([-hx + 0.5 * post, 0.0, seat])));

    if rng.chance(0.25) {
        let arm = seat + rng.range(0.19, 0.24);
        for side in [-1.0, 1.0] {
            let y = side * hy;
            mesh.add_box([-hx - 0.02, y - 0.022, arm], [hx - 0.06, y + 0.022, arm + 0.025], frame);
            mesh.add_leg([hx - 0.1, y, seat - thick], [0.028; 2], [hx - 0.1, y, arm], [0.028; 2], frame);
        }
    }
    mesh
}
