//! Waste bins.

use super::palette;
use crate::mesh::{Material, Mesh};
use crate::rng::Rng;

/// A waste bin, 0.28 to 0.7 m tall, tapered downwards: round and open, with a rim, sometimes a bag over it, or a pedal
/// bin with a domed lid.
pub(super) fn build(rng: &mut Rng) -> Mesh {
    let mut mesh = Mesh::new();
    let skin = if rng.chance(0.25) { Material::shiny([172, 174, 178], 0.2) } else { palette::plastic(rng) };
    let skin = mesh.material(skin);
    let dark = mesh.material(Material::plain([66, 66, 68]));
    let style = rng.below(4);
    let height = if style == 3 { rng.range(0.40, 0.66) } else { rng.range(0.29, 0.62) };
    let top = (height * rng.range(0.28, 0.42)).clamp(0.11, 0.2);
    let foot = top * if style == 3 { rng.range(0.94, 1.0) } else { rng.range(0.65, 0.88) };
    let wall = 0.005;
    if style == 3 {
        // Pedal bin: closed by a lid.
        let body = height - 0.09;
        mesh.add_lathe([0.0; 3], &[[0.0, 0.0], [foot + 0.004, 0.0], [foot + 0.004, 0.03], [foot, 0.03]], 36, dark);
        mesh.add_lathe([0.0; 3], &[[foot, 0.03], [top, body], [0.0, body]], 36, skin);
        let dome: Vec<[f32; 2]> = (0..=7)
            .map(|i| {
                let (s, c) = libm::sincosf(i as f32 / 7.0 * core::f32::consts::FRAC_PI_2);
                [if i == 7 { 0.0 } else { top * libm::powf(c, 0.7) }, body + 0.025 + 0.065 * s]
            })
            .collect();
        let mut lid = vec![[0.0, body + 0.005], [top + 0.004, body + 0.005], [top + 0.004, body + 0.025]];
        lid.extend(dome);
        mesh.add_lathe([0.0; 3], &lid, 36, skin);
        mesh.add_block([foot + 0.02, 0.0, 0.012], [0.07, 0.08, 0.012], dark);
        return mesh;
    }
    let rim = rng.range(0.004, 0.014);
    let band = rng.range(0.01, 0.03);
    let profile = [
        [0.0, 0.012],
        [foot - wall, 0.012],
        [top - wall, height],
        [top + rim, height],
        [top + rim, height - band],
        [top, height - band],
        [foot, 0.0],
        [0.0, 0.0],
    ];
    mesh.add_lathe([0.0; 3], &profile, 36, skin);
    match style {
        0 => {
            // A bag folded over the rim.
            let bag = mesh.material(Material::plain([224, 224, 222]));
            let down = height - rng.range(0.06, 0.14);
            let inside = top - 0.02;
            let out = top + rim + 0.005;
            let slack = out + 0.01;
            let skirt =
                [[inside * 0.8, 0.4 * height], [inside, height], [out, height + 0.006], [slack, down], [out, down]];
            mesh.add_lathe([0.0; 3], &skirt, 36, bag);
        }
        1 => {
            for side in [-1.0, 1.0] {
                let (y, z) = (side * (top + rim), 0.86 * height);
                let line = [[-0.04, y, z], [-0.035, y + side * 0.025, z], [0.035, y + side * 0.025, z], [0.04, y, z]];
                mesh.add_tube(&line, 0.006, 6, dark);
            }
        }
        _ => {}
    }
    if rng.chance(0.4) {
        // Crumpled paper inside.
        let paper = mesh.material(Material::plain([236, 234, 226]));
        let level = height * rng.range(0.4, 0.75);
        for _ in 0..5 {
            let (s, c) = libm::sincosf(rng.range(0.0, core::f32::consts::TAU));
            let r = (foot - 0.05) * rng.uniform();
            let size = [rng.range(0.03, 0.05), rng.range(0.03, 0.05), rng.range(0.03, 0.05)];
            mesh.add_ellipsoid([r * c, r * s, level], size, 8, paper);
        }
    }
    mesh
}
