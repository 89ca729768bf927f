//! Cabinets, chests of drawers and shelves.

use super::palette;
use crate::mesh::{Material, Mesh};
use crate::rng::Rng;

/// A cabinet, 0.72 to 1.3 m tall: doors, drawers, open shelves or doors under an open shelf, on a plinth or legs.
pub(super) fn build(rng: &mut Rng) -> Mesh {
    let mut mesh = Mesh::new();
    let body = mesh.material(palette::wood(rng));
    let dark = mesh.material(Material::plain([60, 56, 52]));
    let metal = mesh.material(Material::shiny([180, 180, 184], 0.3));
    let (depth, width) = (rng.range(0.30, 0.48), rng.range(0.42, 1.10));
    let height = rng.range(0.76, 1.28);
    let lift = if rng.chance(0.5) { rng.range(0.09, 0.18) } else { 0.05 };
    let (hx, hy) = (0.5 * depth, 0.5 * width);
    let board = 0.02;

    if lift > 0.06 {
        for (sx, sy) in [(1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (-1.0, 1.0)] {
            let at = [sx * (hx - 0.05), sy * (hy - 0.05)];
            mesh.add_leg([at[0], at[1], 0.0], [0.028; 2], [at[0], at[1], lift], [0.04; 2], body);
        }
    } else {
        mesh.add_box([-hx + 0.02, -hy + 0.01, 0.0], [hx - 0.04, hy - 0.01, lift], dark);
    }
    // The carcass is open at the front.
    let top_over = if rng.chance(0.4) { 0.015 } else { 0.0 };
    mesh.add_box([-hx, -hy - top_over, height - board], [hx + top_over, hy + top_over, height], body);
    mesh.add_box([-hx, -hy, lift], [hx, hy, lift + board], body);
    mesh.add_box([-hx, -hy, lift], [-hx + 0.008, hy, height], body);
    for side in [-1.0, 1.0] {
        mesh.add_block([0.0, side * (hy - 0.5 * board), lift], [depth, board, height - lift], body);
    }
    let (z0, z1) = (lift + board, height - board);
    let mut front = Front { mesh: &mut mesh, x: hx, half: hy - board, body, metal, bar: rng.chance(0.5) };
    match rng.below(4) {
        0 => front.doors(z0, z1, width > 0.6),
        1 => {
            let rows = 3 + rng.below(3);
            front.drawers(z0, z1, rows, width > 0.9);
        }
        2 => {
            let rows = 2 + rng.below(2);
            front.shelves(z0, z1, rows, depth, width > 0.75);
        }
        _ => {
            let split = z0 + (z1 - z0) * rng.range(0.5, 0.7);
            front.doors(z0, split, width > 0.6);
            front.mesh.add_box([-hx, -front.half, split], [hx - 0.01, front.half, split + board], body);
            front.shelves(split + board, z1, 1, depth, false);
        }
    }
    mesh
}

/// The front of a carcass, being fitted out.
struct Front<'a> {
    mesh: &'a mut Mesh,
    /// The front plane's x in metres.
    x: f32,
    /// Half the clear width in metres.
    half: f32,
    body: u16,
    metal: u16,
    /// Bar handles instead of knobs.
    bar: bool,
}

impl Front<'_> {
    fn panel(&mut self, y: [f32; 2], z: [f32; 2]) {
        let gap = 0.004;
        self.mesh.add_box(
            [self.x - 0.012, y[0] + gap, z[0] + gap],
            [self.x + 0.008, y[1] - gap, z[1] - gap],
            self.body,
        );
    }

    fn handle(&mut self, y: f32, z: f32, upright: bool) {
        let x = self.x + 0.008;
        if self.bar {
            let (dy, dz) = if upright { (0.0, 0.07) } else { (0.07, 0.0) };
            let line =
                [[x, y - dy, z - dz], [x + 0.03, y - dy, z - dz], [x + 0.03, y + dy, z + dz], [x, y + dy, z + dz]];
            self.mesh.add_tube(&line, 0.006, 6, self.metal);
        } else {
            self.mesh.add_frustum([x, y, z], 0.008, [x + 0.025, y, z], 0.016, 12, self.metal);
        }
    }

    fn doors(&mut self, z0: f32, z1: f32, double: bool) {
        let (h, z) = (self.half, z0 + 0.6 * (z1 - z0));
        if double {
            self.panel([-h, 0.0], [z0, z1]);
            self.panel([0.0, h], [z0, z1]);
            self.handle(-0.04, z, true);
            self.handle(0.04, z, true);
        } else {
            self.panel([-h, h], [z0, z1]);
            self.handle(h - 0.05, z, true);
        }
    }

    fn drawers(&mut self, z0: f32, z1: f32, rows: usize, double: bool) {
        let step = (z1 - z0) / rows as f32;
        for row in 0..rows {
            let (a, b) = (z0 + row as f32 * step, z0 + (row + 1) as f32 * step);
            let columns: &[[f32; 2]] = if double { &[[-1.0, 0.0], [0.0, 1.0]] } else { &[[-1.0, 1.0]] };
            for y in columns {
                self.panel([y[0] * self.half, y[1] * self.half], [a, b]);
                self.handle(0.5 * (y[0] + y[1]) * self.half, 0.5 * (a + b), false);
            }
        }
    }

    fn shelves(&mut self, z0: f32, z1: f32, rows: usize, depth: f32, divided: bool) {
        let step = (z1 - z0) / (rows + 1) as f32;
        for row in 1..=rows {
            let z = z0 + row as f32 * step;
            self.mesh.add_box([self.x - depth, -self.half, z - 0.01], [self.x - 0.01, self.half, z + 0.01], self.body);
        }
        if divided {
            self.mesh.add_box([self.x - depth, -0.01, z0], [self.x - 0.01, 0.01, z1], self.body);
        }
    }
}
