//! Surface normals by principal components within a fixed radius: the points within r_max of the pixel's own point,
//! wherever in the window they are (paper, section 3: e_2 of the local point density).

use super::eigen::{self, Symmetric3};
use crate::{Image, Rays, math};

/// Sums run in this many lanes side by side: the same additions in the same order on every target, in vector registers
/// where there are any.
const LANES: usize = 4;

/// The direction of the normal at a pixel, of either sign and any length; `None` where the pixel has no depth, where
/// fewer than three points lie within `radius` (metres), or where they lie on a line.
#[inline]
pub fn direction<const W: usize, const H: usize>(
    depth: &Image<f32, W, H>,
    rays: &Rays<W, H>,
    radius: f32,
    u: usize,
    v: usize,
) -> Option<[f32; 3]> {
    let z = *depth.get(v)?.get(u)?;
    if z <= 0.0 {
        return None;
    }
    let intrinsics = rays.intrinsics();
    // A point within the radius is nearer to the camera than z by it at most: it is seen within this many pixels.
    let reach = |f: f32| (math::floor(radius * f / z) + 1).clamp(1, 4096) as usize;
    let (reach_x, reach_y) = (reach(intrinsics.fx), reach(intrinsics.fy));
    let columns = u.saturating_sub(reach_x)..(u + reach_x + 1).min(W);
    let rows = v.saturating_sub(reach_y)..(v + reach_y + 1).min(H);

    let mut sums = Sums::new(rays.point(u, v, z), radius);
    let x = rays.x().get(columns.clone())?;
    for (row, &y) in depth.get(rows.clone())?.iter().zip(rays.y().get(rows)?) {
        sums.add_row(row.get(columns.clone())?, x, y);
    }
    eigen::least_direction(&sums.covariance()?)
}

/// Sums over the points within the radius, relative to the centre (sums about the origin would cancel: a covariance
/// of square millimetres at a distance of metres).
struct Sums {
    centre: [f32; 3],
    radius2: f32,
    count: [f32; LANES],
    first: [[f32; LANES]; 3],
    second: [[f32; LANES]; 6],
}

impl Sums {
    fn new(centre: [f32; 3], radius: f32) -> Self {
        Self {
            centre,
            radius2: radius * radius,
            count: [0.0; LANES],
            first: [[0.0; LANES]; 3],
            second: [[0.0; LANES]; 6],
        }
    }

    /// Adds a row's points: depths `z` on the rays (x, y, 1).
    #[inline(always)]
    fn add_row(&mut self, z: &[f32], x: &[f32], y: f32) {
        let (z, z_rest) = z.as_chunks::<LANES>();
        let (x, x_rest) = x.as_chunks::<LANES>();
        for (z, x) in z.iter().zip(x) {
            self.add(z, x, y);
        }
        if !z_rest.is_empty() {
            let (mut z, mut x) = ([0.0; LANES], [0.0; LANES]);
            z.iter_mut().zip(z_rest).for_each(|(to, from)| *to = *from);
            x.iter_mut().zip(x_rest).for_each(|(to, from)| *to = *from);
            self.add(&z, &x, y);
        }
    }

    #[inline(always)]
    fn add(&mut self, z: &[f32; LANES], x: &[f32; LANES], y: f32) {
        for i in 0..LANES {
            let d = [x[i] * z[i] - self.centre[0], y * z[i] - self.centre[1], z[i] - self.centre[2]];
            let near = z[i] > 0.0 && d[0] * d[0] + d[1] * d[1] + d[2] * d[2] <= self.radius2;
            let d = d.map(|d| if near { d } else { 0.0 });
            self.count[i] += if near { 1.0 } else { 0.0 };
            for k in 0..3 {
                self.first[k][i] += d[k];
            }
            self.second[0][i] += d[0] * d[0];
            self.second[1][i] += d[0] * d[1];
            self.second[2][i] += d[0] * d[2];
            self.second[3][i] += d[1] * d[1];
            self.second[4][i] += d[1] * d[2];
            self.second[5][i] += d[2] * d[2];
        }
    }

    /// The covariance in m^2; `None` for fewer than three points.
    fn covariance(&self) -> Option<Symmetric3> {
        let total = |lanes: &[f32; LANES]| (lanes[0] + lanes[2]) + (lanes[1] + lanes[3]);
        let count = total(&self.count);
        if count < 3.0 {
            return None;
        }
        let scale = 1.0 / count;
        let [x, y, z] = [0, 1, 2].map(|k| total(&self.first[k]) * scale);
        let means = [x * x, x * y, x * z, y * y, y * z, z * z];
        Some(core::array::from_fn(|k| total(&self.second[k]) * scale - means[k]))
    }
}
