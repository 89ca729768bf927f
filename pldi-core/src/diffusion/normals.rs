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
    let bound = Bound::new(radius, nearest, &window.x, y);
    let first = v.saturating_sub(reach_y);
    let rows = depth.iter().zip(rays.y()).take(v + reach_y + 1).skip(first);
    for (line, &y_there) in rows {
        let dy = y_there - y;
        let Some(reach) = bound.columns(dy, k.fx) else { continue };
        window.add_row(line, u, reach.min(reach_x), y_there, dy);
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

/// How far from the centre's column a row's points within the radius can be seen: (a, c) are the point's offset from the
/// centre projected along the ray, so they lie in the ellipse with the matrix 1 + (x, y)^T (x, y), times the radius.
struct Bound {
    /// Depth of the nearest possible neighbour.
    depth: f32,
    /// Radius squared.
    radius2: f32,
    /// 1 + y^2.
    along_y: f32,
    /// The ellipse's half width at c = 0 is the root of this times the radius.
    width2: f32,
    /// Largest |x y| / (1 + y^2): how far the ellipse leans, per c.
    lean: f32,
}

impl Bound {
    fn new(radius: f32, nearest: f32, x: &Lanes, y: f32) -> Self {
        let x = x.iter().fold(0.0f32, |m, x| m.max(x.abs()));
        let along_y = 1.0 + y * y;
        Self {
            depth: nearest - radius,
            radius2: radius * radius,
            along_y,
            width2: (1.0 + x * x + y * y) / along_y,
            lean: x * y.abs() / along_y,
        }
    }

    /// Columns to each side at most, for a focal length `f` in pixels; `None` where the row is out of reach.
    #[inline(always)]
    fn columns(&self, dy: f32, f: f32) -> Option<usize> {
        let c = dy * self.depth;
        let left = self.radius2 - c * c / self.along_y;
        if left < 0.0 {
            return None;
        }
        // c itself is at most radius * sqrt(1 + y^2).
        let a = math::sqrt(left * self.width2) + self.lean * math::sqrt(self.radius2 * self.along_y);
        // The nearest depth can be next to nothing; the caller bounds the window anyway.
        Some((math::floor((a * f / self.depth).min(4096.0)) + 1).clamp(1, 4096) as usize)
    }
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
        // One quantity at a time, all lanes of it: that is what compilers turn into vector instructions.
        let lanes = |f: &dyn Fn(usize) -> f32| -> Lanes { core::array::from_fn(f) };
        let add = |sum: &mut Lanes, more: Lanes| (0..LANES).for_each(|i| sum[i] += more[i]);
        let zn = lanes(&|i| z[i] * row.n[i] + row.b[i]);
        let zb = lanes(&|i| z[i] * row.b[i] + row.bb[i]);
        let za = lanes(&|i| z[i] * row.a[i] + row.ab[i]);
        add(&mut self.n, row.n);
        add(&mut self.a, row.a);
        add(&mut self.b, row.b);
        add(&mut self.aa, row.aa);
        add(&mut self.ab, row.ab);
        add(&mut self.bb, row.bb);
        add(&mut self.c, zn.map(|v| dy * v));
        add(&mut self.ac, za.map(|v| dy * v));
        add(&mut self.bc, zb.map(|v| dy * v));
        add(&mut self.cc, lanes(&|i| dy * dy * (z[i] * zn[i] + zb[i])));
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
