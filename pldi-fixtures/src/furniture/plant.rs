//! Plants in pots.

use core::f32::consts::TAU;

use super::palette;
use crate::mesh::{Material, Mesh, Texture};
use crate::rng::Rng;
use crate::vec3::{add, cross, lerp, scale, unit};

/// A plant of 0.6 to 1.5 m with its pot: long arching blades, big leaves on stalks, a bush of small leaves on a stem,
/// or a palm.
pub(super) fn build(rng: &mut Rng) -> Mesh {
    let mut mesh = Mesh::new();
    let pots = [[178, 96, 62], [226, 224, 218], [96, 100, 106], [84, 110, 134], [150, 132, 108]];
    let pot = mesh.material(Material::new(rng.pick(&pots), Texture::Noise));
    let soil = mesh.material(Material::new([84, 62, 46], Texture::Noise));
    let (rim, tall) = (rng.range(0.12, 0.19), rng.range(0.2, 0.38));
    let foot = rim * rng.range(0.62, 0.95);
    let level = tall - 0.03;
    let profile =
        [[0.0, 0.0], [foot, 0.0], [rim, tall], [rim - 0.012, tall], [rim - 0.015, level - 0.005], [0.0, level - 0.005]];
    mesh.add_lathe([0.0; 3], &profile, 28, pot);
    if rng.chance(0.4) {
        let saucer = [[0.0, 0.0], [foot + 0.03, 0.0], [foot + 0.045, 0.025], [foot, 0.02]];
        mesh.add_lathe([0.0; 3], &saucer, 28, pot);
    }
    mesh.add_cylinder([0.0, 0.0, level - 0.02], [0.0, 0.0, level], rim - 0.014, 28, soil);

    let greens = [[74, 128, 62], [58, 104, 58], [110, 146, 70], [84, 120, 84]];
    let leaf = mesh.material(Material::new(rng.pick(&greens), Texture::Noise));
    let bark = palette::wood(rng);
    let stem = mesh.material(Material::new([112, 88, 60], bark.texture));
    let height = rng.range(0.3, 1.0);
    let base = [0.0, 0.0, level];
    match rng.below(4) {
        0 => {
            // Long blades that rise and arch over.
            let spread = rng.range(0.15, 0.55);
            for _ in 0..34 + rng.below(20) {
                let (h, r) = (height * rng.range(0.6, 1.0), spread * rng.range(0.3, 1.0));
                blade(&mut mesh, rng, base, h, r, 0.02, leaf);
            }
        }
        1 => {
            // Big leaves, each on its stalk.
            for _ in 0..16 + rng.below(10) {
                let (s, c) = libm::sincosf(rng.range(0.0, TAU));
                let (r, h) = (rng.range(0.05, 0.34), height * rng.range(0.35, 1.0));
                let top = add(base, [r * c, r * s, h]);
                let bend = add(base, [0.4 * r * c, 0.4 * r * s, 0.7 * h]);
                mesh.add_tube(&[base, bend, top], 0.006, 5, leaf);
                let size = rng.range(0.16, 0.26);
                broad_leaf(&mut mesh, top, [c, s, rng.range(-0.5, 0.4)], size, 0.36 * size, leaf);
            }
        }
        2 => {
            // A bush of small leaves about a stem.
            let radius = rng.range(0.18, 0.32);
            let middle = add(base, [0.0, 0.0, (height - 0.5 * radius).max(radius)]);
            mesh.add_tube(&[base, middle], 0.014, 8, stem);
            let upright = rng.range(0.9, 1.5);
            for _ in 0..230 {
                let d = [rng.normal(), rng.normal(), rng.normal()];
                let Some(d) = unit(d) else { continue };
                let r = radius * rng.range(0.45, 1.0);
                let at = add(middle, [r * d[0], r * d[1], r * upright * d[2]]);
                if at[2] > level + 0.02 {
                    broad_leaf(
                        &mut mesh,
                        at,
                        add(d, [rng.normal(), rng.normal(), 0.0]),
                        rng.range(0.07, 0.12),
                        0.024,
                        leaf,
                    );
                }
            }
        }
        _ => {
            // A palm: a trunk with a crown of blades.
            let trunk = height * rng.range(0.35, 0.6);
            let lean = [rng.range(-0.06, 0.06), rng.range(-0.06, 0.06), trunk];
            let crown = add(base, lean);
            mesh.add_frustum(base, 0.03, crown, 0.02, 10, stem);
            for _ in 0..26 + rng.below(12) {
                let (h, r) = ((height - trunk) * rng.range(0.3, 1.0), rng.range(0.2, 0.45));
                blade(&mut mesh, rng, crown, h, r, 0.03, leaf);
            }
        }
    }
    mesh
}

/// A blade that starts at `base`, rises by `height` and reaches out by `reach`, its tip drooping.
fn blade(mesh: &mut Mesh, rng: &mut Rng, base: [f32; 3], height: f32, reach: f32, half_width: f32, material: u16) {
    let (s, c) = libm::sincosf(rng.range(0.0, TAU));
    let droop = rng.range(0.0, 0.5) * reach;
    let n = 7;
    let mut points = Vec::with_capacity(n);
    let mut widths = Vec::with_capacity(n);
    for i in 0..n {
        let t = i as f32 / (n - 1) as f32;
        let out = reach * t * t;
        let up = height * (2.0 * t - t * t) - droop * t * t * t;
        points.push(add(base, [out * c, out * s, up]));
        widths.push(half_width * (1.0 - t * t) * (0.5 + t));
    }
    mesh.add_ribbon(&points, &widths, [-s, c, 0.0], material);
}

/// A leaf of `length` that grows from `base` along `direction`, bent downwards.
fn broad_leaf(mesh: &mut Mesh, base: [f32; 3], direction: [f32; 3], length: f32, half_width: f32, material: u16) {
    let along = unit(direction).unwrap_or([1.0, 0.0, 0.0]);
    let across = unit(cross([0.0, 0.0, 1.0], along)).unwrap_or([1.0, 0.0, 0.0]);
    let tip = add(add(base, scale(along, length)), [0.0, 0.0, -0.35 * length]);
    let bulge = add(base, scale(along, 0.5 * length));
    let shape = [(0.0, 0.15), (0.25, 0.85), (0.5, 1.0), (0.75, 0.7), (1.0, 0.0)];
    let points = shape.map(|(t, _)| lerp(lerp(base, bulge, t), lerp(bulge, tip, t), t));
    mesh.add_ribbon(&points, &shape.map(|(_, w)| w * half_width), across, material);
}
