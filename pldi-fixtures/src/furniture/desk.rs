//! Desks.

use super::palette;
use crate::mesh::{Material, Mesh};
use crate::rng::Rng;

/// A writing desk, 0.71 to 0.76 m high: a drawer unit under one end, a panel or frame under the other, mostly a modesty
/// panel at the back, sometimes a row of pigeonholes on the top. The sitter's side is +x.
pub(super) fn build(rng: &mut Rng) -> Mesh {
    let mut mesh = Mesh::new();
    let top = mesh.material(palette::wood(rng));
    let body = mesh.material(if rng.chance(0.5) { palette::wood(rng) } else { Material::plain([214, 214, 210]) });
    let metal = mesh.material(Material::shiny([180, 180, 184], 0.3));
    let (depth, width) = (rng.range(0.58, 0.78), rng.range(1.05, 1.60));
    let (hx, hy) = (0.5 * depth, 0.5 * width);
    let height = rng.range(0.71, 0.76);
    let thick = rng.range(0.022, 0.035);
    let under = height - thick;
    mesh.add_block([0.0, 0.0, under], [depth, width, thick], top);

    let hand: f32 = if rng.chance(0.5) { 1.0 } else { -1.0 };
    let pedestal = rng.range(0.36, 0.46);
    // From the desk's end inwards; `span` orders the two for the box.
    let span = |a: f32, b: f32| if hand > 0.0 { [hy - b, hy - a] } else { [-hy + a, -hy + b] };
    let reach = hx - 0.02;
    let drawers = 2 + rng.below(3);
    let unit = |mesh: &mut Mesh, y: [f32; 2], rows: usize| {
        let bottom = if rows > 2 { 0.05 } else { under - 0.32 };
        mesh.add_box([-reach, y[0], bottom], [reach - 0.02, y[1], under], body);
        let step = (under - 0.01 - bottom) / rows as f32;
        for row in 0..rows {
            let (a, b) = (bottom + row as f32 * step, bottom + (row + 1) as f32 * step);
            mesh.add_box([reach - 0.02, y[0] + 0.004, a + 0.004], [reach, y[1] - 0.004, b - 0.004], top);
            let (c, z) = (0.5 * (y[0] + y[1]), 0.5 * (a + b) + 0.02);
            let x = reach;
            let line = [[x, c - 0.06, z], [x + 0.025, c - 0.06, z], [x + 0.025, c + 0.06, z], [x, c + 0.06, z]];
            mesh.add_tube(&line, 0.006, 6, metal);
        }
    };
    unit(&mut mesh, span(0.01, pedestal), drawers);
    let low = drawers <= 2;
    if low {
        // The drawers hang: a side panel carries this end.
        let y = span(0.0, 0.025);
        mesh.add_box([-hx + 0.01, y[0], 0.0], [hx - 0.03, y[1], under], body);
    } else {
        let y = span(0.03, pedestal - 0.03);
        mesh.add_box([-reach + 0.03, y[0], 0.0], [reach - 0.06, y[1], 0.05], metal);
    }
    let far = span(width - 0.03, width);
    match rng.below(4) {
        0 => {
            // Drawers at this end, too.
            let y = span(width - pedestal, width - 0.01);
            unit(&mut mesh, y, 3);
            mesh.add_box([-reach + 0.03, y[0] + 0.03, 0.0], [reach - 0.06, y[1] - 0.03, 0.05], metal);
        }
        1 => {
            // A C-shaped metal frame.
            let y = 0.5 * (far[0] + far[1]) - 0.04 * -hand;
            mesh.add_block([0.0, y, 0.0], [depth - 0.04, 0.06, 0.03], metal);
            mesh.add_leg([-0.1, y, 0.0], [0.1, 0.05], [-0.1, y, under], [0.1, 0.05], metal);
        }
        _ => mesh.add_box([-hx + 0.01, far[0], 0.0], [hx - 0.03, far[1], under], body),
    }
    if rng.chance(0.75) {
        let drop = rng.range(0.25, 0.6);
        mesh.add_box([-hx + 0.05, -hy + 0.03, under - drop], [-hx + 0.068, hy - 0.03, under], body);
    }
    if rng.chance(0.25) {
        let (z, x) = (height + rng.range(0.16, 0.22), -hx + 0.2);
        mesh.add_box([-hx, -hy, z - 0.018], [x, hy, z], top);
        let n = 4;
        for i in 0..=n {
            let y = (hy - 0.01) * (2.0 * i as f32 / n as f32 - 1.0);
            mesh.add_block([0.5 * (x - hx), y, height], [0.2, 0.018, z - height - 0.018], top);
        }
        mesh.add_box([-hx, -hy, height], [-hx + 0.01, hy, z], top);
    }
    mesh
}
