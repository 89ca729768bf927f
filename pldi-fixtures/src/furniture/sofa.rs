//! Sofas and armchairs.

use core::f32::consts::PI;

use super::palette;
use crate::mesh::{Material, Mesh, Transform};
use crate::rng::Rng;

/// A sofa for two or three (1.4 to 2.1 m wide), or with `single` an armchair (0.7 to 0.95 m), mostly upholstered:
/// block or rolled armrests, one or several cushions, legs or plinth; armchairs also as wing chairs, tub chairs or
/// cushions on a bent wooden frame.
pub(super) fn build(rng: &mut Rng, single: bool) -> Mesh {
    let mut mesh = Mesh::new();
    let cover = palette::cloth(rng);
    let cover = mesh.material(cover);
    let wood = mesh.material(palette::wood(rng));
    if single {
        match rng.below(4) {
            0 => {
                tub(&mut mesh, rng, cover, wood);
                return mesh;
            }
            1 => {
                bent_frame(&mut mesh, rng, cover, wood);
                return mesh;
            }
            _ => {}
        }
    }
    let seats = if single { 1 } else { 2 + rng.below(2) };
    let arm = if single { rng.range(0.10, 0.18) } else { rng.range(0.10, 0.24) };
    let seat_width = if single { rng.range(0.50, 0.60) } else { rng.range(0.56, 0.64) };
    let inner = 0.5 * seat_width * seats as f32;
    let outer = inner + arm;
    let depth = rng.range(0.76, 0.95);
    let hx = 0.5 * depth;
    let seat = rng.range(0.38, 0.46);
    let back = rng.range(0.70, 0.90) + if single { 0.06 } else { 0.0 };
    let arm_top = seat + rng.range(0.12, 0.24);
    let lift = rng.range(0.03, 0.15);
    let back_thick = rng.range(0.14, 0.2);

    mesh.add_box([-hx + 0.02, -inner, lift], [hx - 0.03, inner, seat - 0.13], cover);
    mesh.add_cushion([-hx, -outer, lift], [-hx + back_thick, outer, back - 0.06], 0.12, cover);
    let rolled = rng.chance(0.35);
    for side in [-1.0, 1.0] {
        let (low, high) = if side > 0.0 { (inner, outer) } else { (-outer, -inner) };
        if rolled {
            let r = 0.5 * arm + 0.025;
            let y = 0.5 * (low + high) + 0.02 * side;
            mesh.add_box([-hx + 0.02, low, lift], [hx - 0.01, high, arm_top - r], cover);
            mesh.add_cylinder([-hx + 0.02, y, arm_top - r], [hx, y, arm_top - r], r, 20, cover);
        } else {
            mesh.add_cushion([-hx + 0.01, low, lift], [hx - 0.01, high, arm_top], 0.12, cover);
        }
    }
    for i in 0..seats {
        let (a, b) = (-inner + i as f32 * seat_width, -inner + (i + 1) as f32 * seat_width);
        mesh.add_cushion([-hx + back_thick - 0.03, a + 0.004, seat - 0.14], [hx, b - 0.004, seat + 0.02], 0.2, cover);
        let mark = mesh.vertices.len();
        let tall = back - seat;
        mesh.add_cushion([0.0, a + 0.006, -0.01], [0.17, b - 0.006, tall], 0.3, cover);
        let lean = Transform::rotate_y(-rng.range(0.1, 0.22));
        mesh.transform_since(mark, &lean.then(Transform::translate([-hx + back_thick - 0.01, 0.0, seat])));
    }
    if single && rng.chance(0.5) {
        // Wings beside a tall back.
        let top = back + 0.1;
        mesh.add_cushion([-hx, -inner - 0.03, seat], [-hx + back_thick, inner + 0.03, top], 0.15, cover);
        for side in [-1.0, 1.0] {
            let y = side * (inner + 0.03);
            mesh.add_cushion([-hx + 0.02, y - 0.04, arm_top - 0.06], [-hx + 0.33, y + 0.04, top - 0.02], 0.3, cover);
        }
    }
    if !single && rng.chance(0.5) {
        scatter_cushions(&mut mesh, rng, inner, seat, back_thick - hx);
    }
    for (sx, sy) in [(1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (-1.0, 1.0)] {
        let at = [sx * (hx - 0.09), sy * (outer - 0.07)];
        if lift > 0.07 {
            mesh.add_frustum([at[0], at[1], 0.0], 0.015, [at[0], at[1], lift + 0.02], 0.028, 12, wood);
        } else {
            mesh.add_block([at[0], at[1], 0.0], [0.06, 0.06, lift + 0.01], wood);
        }
    }
    mesh
}

/// One or two loose cushions of another colour that lean in the corners.
fn scatter_cushions(mesh: &mut Mesh, rng: &mut Rng, inner: f32, seat: f32, back: f32) {
    for side in [-1.0, 1.0] {
        if rng.chance(0.7) {
            let material = palette::cloth(rng);
            let material = mesh.material(material);
            let mark = mesh.vertices.len();
            mesh.add_cushion([-0.06, -0.21, 0.0], [0.06, 0.21, 0.4], 0.55, material);
            let turn = Transform::rotate_y(-0.35).then(Transform::rotate_z(-side * rng.range(0.1, 0.5)));
            let place = Transform::translate([back + 0.24, side * (inner - 0.26), seat + 0.01]);
            mesh.transform_since(mark, &turn.then(place));
        }
    }
}

/// A tub chair: one curved shell is back and arms.
fn tub(mesh: &mut Mesh, rng: &mut Rng, cover: u16, wood: u16) {
    let radius = rng.range(0.35, 0.42);
    let seat = rng.range(0.38, 0.44);
    let (arm, back) = (seat + rng.range(0.16, 0.22), rng.range(0.70, 0.84));
    let lift = rng.range(0.05, 0.16);
    let thick = 0.09;
    let n = 26;
    // The angle runs from one front end of the shell round the back to the other.
    let open = rng.range(0.75, 1.0);
    let top = |t: f32| {
        let rear = 0.5 - 0.5 * libm::cosf(2.0 * PI * t);
        arm + (back - arm) * libm::powf(rear, 1.4)
    };
    let at = |t: f32, r: f32, z: f32| {
        let (s, c) = libm::sincosf(open + t * 2.0 * (PI - open));
        [r * c, r * s, z]
    };
    for i in 0..n {
        let (a, b) = (i as f32 / n as f32, (i + 1) as f32 / n as f32);
        let (outer, inside) = (radius, radius - thick);
        let flare = 0.03;
        mesh.add_quad(
            [at(a, outer, lift), at(b, outer, lift), at(b, outer + flare, top(b)), at(a, outer + flare, top(a))],
            cover,
        );
        mesh.add_quad(
            [at(a, inside, lift), at(b, inside, lift), at(b, inside + flare, top(b)), at(a, inside + flare, top(a))],
            cover,
        );
        let crown = |t: f32, r: f32| at(t, r + flare, top(t));
        let ridge = |t: f32| at(t, 0.5 * (outer + inside) + flare, top(t) + 0.025);
        mesh.add_quad([crown(a, outer), crown(b, outer), ridge(b), ridge(a)], cover);
        mesh.add_quad([ridge(a), ridge(b), crown(b, inside), crown(a, inside)], cover);
        mesh.add_quad([at(a, outer, lift), at(b, outer, lift), at(b, inside, lift), at(a, inside, lift)], cover);
    }
    for t in [0.0, 1.0] {
        let (inside, flare) = (radius - thick, 0.03);
        let end = [at(t, radius, lift), at(t, inside, lift), at(t, inside + flare, arm), at(t, radius + flare, arm)];
        mesh.add_quad(end, cover);
    }
    let profile = [[0.0, 0.0], [radius - 0.06, 0.0], [radius - 0.06, 0.08], [radius - 0.08, 0.1], [0.0, 0.115]];
    mesh.add_lathe([0.01, 0.0, seat - 0.115], &profile, 30, cover);
    mesh.add_cylinder([0.0, 0.0, lift], [0.0, 0.0, seat - 0.1], radius - 0.05, 30, cover);
    for (sx, sy) in [(1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (-1.0, 1.0)] {
        let (x, y) = (sx * 0.62 * radius, sy * 0.62 * radius);
        mesh.add_frustum([1.1 * x, 1.1 * y, 0.0], 0.012, [x, y, lift + 0.01], 0.024, 12, wood);
    }
}

/// A lounge chair: seat and back cushion on a bent wooden frame whose sides are armrests and runners in one.
fn bent_frame(mesh: &mut Mesh, rng: &mut Rng, cover: u16, wood: u16) {
    let half = rng.range(0.28, 0.33);
    let height = rng.range(0.90, 1.02);
    let arm = rng.range(0.50, 0.58);
    let front = rng.range(0.36, 0.42);
    for side in [-1.0, 1.0] {
        let y = side * half;
        let line = [
            [-0.42, y, 0.025],
            [0.0, y, 0.02],
            [front - 0.06, y, 0.025],
            [front, y, 0.08],
            [front, y, arm - 0.08],
            [front - 0.07, y, arm],
            [-0.3, y, arm - 0.03],
        ];
        for pair in line.windows(2) {
            // Laminated wood: a flat band, so two slim tubes side by side.
            mesh.add_tube(pair, 0.02, 4, wood);
            let shifted = [[pair[0][0], y - side * 0.028, pair[0][2]], [pair[1][0], y - side * 0.028, pair[1][2]]];
            mesh.add_tube(&shifted, 0.02, 4, wood);
        }
    }
    mesh.add_block([front - 0.06, 0.0, 0.28], [0.03, 2.0 * half, 0.06], wood);
    let frame = Material::plain([70, 66, 62]);
    let frame = mesh.material(frame);
    let wide = half - 0.04;
    let mark = mesh.vertices.len();
    mesh.add_cushion([0.0, -wide, 0.0], [front + 0.2, wide, 0.12], 0.2, cover);
    mesh.add_block([0.5 * front, 0.0, -0.025], [0.9 * front, 2.0 * wide, 0.03], frame);
    mesh.transform_since(mark, &Transform::rotate_y(-0.17).then(Transform::translate([-0.2, 0.0, 0.27])));
    let mark = mesh.vertices.len();
    let tall = height - 0.3;
    mesh.add_cushion([0.0, -wide, 0.0], [0.12, wide, tall], 0.2, cover);
    mesh.add_block([-0.012, 0.0, 0.0], [0.03, 2.0 * wide, tall - 0.04], frame);
    mesh.transform_since(
        mark,
        &Transform::rotate_y(-rng.range(0.35, 0.5)).then(Transform::translate([-0.2, 0.0, 0.3])),
    );
}
