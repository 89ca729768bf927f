//! Surface normals by principal components within a fixed radius: the points within `r_max` of the pixel's own point,
//! wherever in the window they are (paper, section 3: `e_2` of the local point density).
//!
//! Neighbouring pixels of a row are worked on side by side, because everything about the window's offset (dx, dy) is
//! then a constant: with the ray (x, y, 1) of the centre at depth z, and a neighbour at depth z + b on the ray
//! (x + dx, y + dy, 1), the neighbour lies at
//!
//! (a + x b, c + y b, b) from the centre, where a = dx (z + b) and c = dy (z + b).
//!
//! Only the moments of a and b need a sum per neighbour; those with c follow row by row. All sums are relative to the
//! centre: sums about the origin would cancel (square millimetres at a distance of metres).

use crate::eigen::{self, Symmetric3};
use crate::{Image, Rays, math};

/// Pixels that are worked on side by side: the same additions in the same order on every target, in vector registers
/// where there are any.
pub const LANES: usize = 4;

/// One number for each of the pixels.
type Lanes = [f32; LANES];

/// The normals' directions, of either sign and any length, at the pixels `u..u + LANES` of row `v`.
///
/// `None` where a pixel lies outside of the image or has no depth (depths within the radius count as none), where fewer
/// than three points lie within `radius` (metres), or where they lie on a line.
#[inline]
pub fn directions<const W: usize, const H: usize>(
    depth: &Image<f32, W, H>,
    rays: &Rays<W, H>,
    radius: f32,
    u: usize,
    v: usize,
) -> [Option<[f32; 3]>; LANES] {
    let (Some(row), Some(&y)) = (depth.get(v), rays.y().get(v)) else { return [None; LANES] };
    // NaN is within no radius.
    let centre = |i: usize| row.get(u + i).copied().filter(|z| *z > radius).unwrap_or(f32::NAN);
    let z: Lanes = core::array::from_fn(centre);
    let nearest = z.iter().fold(f32::INFINITY, |near, z| if *z < near { *z } else { near });
    if nearest.is_infinite() {
        return [None; LANES];
    }
    let k = rays.intrinsics();
    // A point within the radius is seen within this many pixels, but for those much nearer to the camera.
    let reach = |f: f32| (math::floor(radius * f / nearest) + 1).clamp(1, 4096) as usize;
    let (reach_x, reach_y) = (reach(k.fx), reach(k.fy));
    let mut window = Window {
        z,
        x: core::array::from_fn(|i| rays.x().get(u + i).copied().unwrap_or(0.0)),
        radius2: radius * radius,
        step: 1.0 / k.fx,
        sums: Sums::default(),
    };
    let first = v.saturating_sub(reach_y);
    let rows = depth.iter().zip(rays.y()).take(v + reach_y + 1).skip(first);
    for (line, &y_there) in rows {
        window.add_row(line, u, reach_x, y_there, y_there - y);
    }
    core::array::from_fn(|i| {
        let y_centre = y;
        eigen::least_direction(&window.sums.covariance(i, window.x[i], y_centre)?)
    })
}

/// The centres and what is summed over their neighbours.
struct Window {
    z: Lanes,
    x: Lanes,
    radius2: f32,
    /// Difference of x between neighbouring columns.
    step: f32,
    sums: Sums,
}

/// Sums over the neighbours: count, first and second moments of (a, b, c).
#[derive(Default)]
struct Sums {
    n: Lanes,
    a: Lanes,
    b: Lanes,
    c: Lanes,
    aa: Lanes,
    ab: Lanes,
    ac: Lanes,
    bb: Lanes,
    bc: Lanes,
    cc: Lanes,
}

/// The same for one row of the window, without c.
#[derive(Default)]
struct RowSums {
    n: Lanes,
    a: Lanes,
    b: Lanes,
    aa: Lanes,
    ab: Lanes,
    bb: Lanes,
}

impl Window {
    /// Adds the neighbours in a row at y = `y`, `dy` from the centres' row.
    #[inline(always)]
    fn add_row<const W: usize>(&mut self, line: &[f32; W], u: usize, reach: usize, y: f32, dy: f32) {
        let mut row = RowSums::default();
        // Offsets at which all lanes are inside of the image, and those at which some are not.
        let left = u.min(reach);
        let right = (W.saturating_sub(u + LANES)).min(reach);
        for d in (left + 1..=reach).map(|d| -(d as i32)).chain((right + 1..=reach).map(|d| d as i32)) {
            let there = |i: usize| line.get((u + i).wrapping_add_signed(d as isize)).copied().unwrap_or(0.0);
            self.add(&mut row, core::array::from_fn(there), d as f32, y, dy);
        }
        let span = line.get(u - left..(u + right + LANES).min(W)).unwrap_or(&[]);
        let mut d = -(left as f32);
        for there in span.array_windows::<LANES>() {
            self.add(&mut row, *there, d, y, dy);
            d += 1.0;
        }
        self.sums.add(&row, &self.z, dy);
    }

    /// Adds the neighbours `offset` columns to the right, at depths `there`.
    #[inline(always)]
    fn add(&self, row: &mut RowSums, there: Lanes, offset: f32, y: f32, dy: f32) {
        let dx = offset * self.step;
        for i in 0..LANES {
            let z = there[i];
            let (a, b) = (dx * z, z - self.z[i]);
            // c + y_centre b = dy z_centre + (y_centre + dy) b
            let (p, q) = (a + self.x[i] * b, dy * self.z[i] + y * b);
            // A missing depth is 0: then b is -z, which is beyond the radius.
            let near = p * p + q * q + b * b <= self.radius2;
            let (a, b) = (if near { a } else { 0.0 }, if near { b } else { 0.0 });
            row.n[i] += if near { 1.0 } else { 0.0 };
            row.a[i] += a;
            row.b[i] += b;
            row.aa[i] += a * a;
            row.ab[i] += a * b;
            row.bb[i] += b * b;
        }
    }
}

impl Sums {
    /// Adds a row, whose neighbours all have c = dy (z + b).
    #[inline(always)]
    fn add(&mut self, row: &RowSums, z: &Lanes, dy: f32) {
        for i in 0..LANES {
            let (n, a, b) = (row.n[i], row.a[i], row.b[i]);
            self.n[i] += n;
            self.a[i] += a;
            self.b[i] += b;
            self.aa[i] += row.aa[i];
            self.ab[i] += row.ab[i];
            self.bb[i] += row.bb[i];
            let (zn, zb) = (z[i] * n + b, z[i] * b + row.bb[i]);
            self.c[i] += dy * zn;
            self.ac[i] += dy * (z[i] * a + row.ab[i]);
            self.bc[i] += dy * zb;
            self.cc[i] += dy * dy * (z[i] * (zn + b) + row.bb[i]);
        }
    }

    /// The covariance (m^2) of the neighbours of pixel `i`, whose ray is (x, y, 1); `None` for fewer than three.
    #[inline(always)]
    fn covariance(&self, i: usize, x: f32, y: f32) -> Option<Symmetric3> {
        // Written so that NaN fails the test.
        if !(self.n[i] >= 3.0) {
            return None;
        }
        let s = 1.0 / self.n[i];
        let (a, b, c) = (self.a[i] * s, self.b[i] * s, self.c[i] * s);
        let (aa, ab, ac) = (self.aa[i] * s - a * a, self.ab[i] * s - a * b, self.ac[i] * s - a * c);
        let (bb, bc, cc) = (self.bb[i] * s - b * b, self.bc[i] * s - b * c, self.cc[i] * s - c * c);
        // Back from (a, b, c) to (a + x b, c + y b, b).
        let (xb, yb) = (ab + x * bb, bc + y * bb);
        Some([aa + x * (ab + xb), ac + x * bc + y * (ab + x * bb), xb, cc + y * (bc + yb), yb, bb])
    }
}
