//! The projective light diffusion image (paper, section 3): N = |n . v| / |v|, the cosine between the surface's
//! normal and the ray to the pixel, as if the scene were lit from the camera.

pub mod fixed;
pub mod normals;

use crate::eigen::dot;
use crate::{Image, Rays, math};
use normals::LANES;

/// N is stored as an unsigned fraction: this value is 1.
pub const ONE: u16 = u16::MAX;

/// Fills `n` where `wanted(column, row)` holds, and puts 0 elsewhere and where no normal is determined.
///
/// `depth` is the reconstructed depth in metres (0 = none), `radius` the normals' r_max in metres. Every pixel with
/// depth counts as a neighbour, wanted or not. The value is in units of 1/65535 ([`ONE`] = 1), rounded to nearest.
pub fn diffusion<const W: usize, const H: usize>(
    depth: &Image<f32, W, H>,
    rays: &Rays<W, H>,
    radius: f32,
    wanted: impl Fn(usize, usize) -> bool,
    n: &mut Image<u16, W, H>,
) {
    for (v, row) in n.iter_mut().enumerate() {
        for (block, out) in row.chunks_mut(LANES).enumerate() {
            let u = block * LANES;
            let mask: [bool; LANES] = core::array::from_fn(|i| u + i < W && wanted(u + i, v));
            out.fill(0);
            if !mask.contains(&true) {
                continue;
            }
            let directions = normals::directions(depth, rays, radius, u, v);
            for (i, out) in out.iter_mut().enumerate() {
                // No block is longer; the compiler does not see it.
                if let (true, Some(direction)) = (mask[i % LANES], directions[i % LANES]) {
                    *out = cosine(direction, rays.point(u + i, v, 1.0));
                }
            }
        }
    }
}

/// |n . v| / (|n| |v|) as a fraction of [`ONE`] (equation 3).
fn cosine(normal: [f32; 3], ray: [f32; 3]) -> u16 {
    let length = math::sqrt(dot(normal, normal) * dot(ray, ray));
    let cosine = (dot(normal, ray).abs() / length).min(1.0);
    (cosine * f32::from(ONE) + 0.5) as u16
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Intrinsics;
    use crate::frame::{QVGA_HEIGHT as H, QVGA_WIDTH as W};

    const CAMERA: Intrinsics = Intrinsics::KINECT_QVGA;
    const RADIUS: f32 = 0.04;

    /// N of a surface given as depth along the ray (x, y, 1), over a window of the image.
    fn image_of(surface: impl Fn(f32, f32) -> f32, window: [usize; 4]) -> Vec<(usize, usize, f32)> {
        let rays = Rays::<W, H>::new(&CAMERA).unwrap();
        let mut depth = vec![[0.0; W]; H];
        for (v, row) in depth.iter_mut().enumerate() {
            for (u, z) in row.iter_mut().enumerate() {
                *z = surface(rays.x()[u], rays.y()[v]);
            }
        }
        let depth: Box<Image<f32, W, H>> = depth.into_boxed_slice().try_into().unwrap();
        let mut n: Box<Image<u16, W, H>> = vec![[0; W]; H].into_boxed_slice().try_into().unwrap();
        let [u0, v0, u1, v1] = window;
        let inside = |u, v| (u0..u1).contains(&u) && (v0..v1).contains(&v);
        diffusion(&depth, &rays, RADIUS, inside, &mut n);
        assert!((0..H).all(|v| (0..W).all(|u| inside(u, v) || n[v][u] == 0)));
        (v0..v1)
            .flat_map(|v| (u0..u1).map(move |u| (u, v)))
            .map(|(u, v)| (u, v, f32::from(n[v][u]) / 65535.0))
            .collect()
    }

    /// cos of the ray's angle to the principal direction.
    fn obliquity(u: usize, v: usize) -> f32 {
        let [x, y, _] = CAMERA.back_project(u as f32, v as f32, 1.0);
        1.0 / (1.0 + x * x + y * y).sqrt()
    }

    #[test]
    fn a_fronto_parallel_plane_gives_the_cosine_of_the_rays_angle() {
        for (u, v, n) in image_of(|_, _| 2.0, [0, 100, 320, 120]) {
            assert!((n - obliquity(u, v)).abs() < 2e-5, "{u} {v}: {n}");
        }
    }

    #[test]
    fn a_slanted_plane_gives_the_cosine_to_its_normal() {
        // x sin a + z cos a = d, with a = 30 degrees
        let (sin, cos) = (0.5, 0.75f32.sqrt());
        for (u, v, n) in image_of(|x, _| 1.5 / (x * sin + cos), [40, 80, 280, 100]) {
            let [x, ..] = CAMERA.back_project(u as f32, v as f32, 1.0);
            assert!((n - (x * sin + cos) * obliquity(u, v)).abs() < 1e-4, "{u} {v}: {n}");
        }
    }

    #[test]
    fn a_sphere_gives_the_cosine_at_the_point_that_is_seen() {
        // Radius 0.5 m, centre on the axis at 2 m.
        let hit = |x: f32, y: f32| {
            let (a, b, c) = (x * x + y * y + 1.0, -4.0, 4.0 - 0.25);
            let disc = b * b - 4.0 * a * c;
            if disc > 0.0 { (-b - disc.sqrt()) / (2.0 * a) } else { 0.0 }
        };
        for (u, v, n) in image_of(hit, [125, 85, 195, 155]) {
            let [x, y, _] = CAMERA.back_project(u as f32, v as f32, 1.0);
            let z = hit(x, y);
            let p = [x * z, y * z, z - 2.0];
            let truth = (dot(p, [x, y, 1.0]) / 0.5).abs() * obliquity(u, v);
            // The patch of 4 cm is not flat, nor symmetric where the surface slants.
            assert!(z > 0.0 && (n - truth).abs() < 0.01, "{u} {v}: {n} {truth}");
        }
    }

    #[test]
    fn neighbours_across_a_step_do_not_count() {
        // Two planes 30 cm apart: N stays that of a plane right up to the edge.
        for (u, v, n) in image_of(|x, _| if x < 0.0 { 1.5 } else { 1.8 }, [150, 100, 170, 110]) {
            assert!((n - obliquity(u, v)).abs() < 2e-5, "{u} {v}: {n}");
        }
    }

    #[test]
    fn too_few_neighbours_give_no_normal() {
        // A single row of pixels is a line; alone, a pixel is a point.
        let row = image_of(|_, y| if (y - 0.0019).abs() < 1e-3 { 1.0 } else { 0.0 }, [100, 110, 200, 130]);
        assert!(row.iter().all(|&(.., n)| n == 0.0));
    }
}
