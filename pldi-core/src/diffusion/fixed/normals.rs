//! Surface normals within a fixed radius in integers, see the float twin. Eight pixels of a row are worked on side by side.
//!
//! Coordinates are brought to a fine unit, 2^-s of 1/8 mm, in which the radius is 5,461 to 10,922 (41 to 82 units for one
//! millimetre at 4 cm wide), and kept modulo 2^16: an offset from the centre is right wherever it matters, because depths far
//! from the centres' are clamped (so z does not wrap) and s is chosen so that no x or y within the window
//! wraps into the radius. Squares of offsets count 2^16 fine units.
//!
//! Moments are summed in the fine unit times 2^t, where the radius times the window's rows or columns stays below 2^14: sums
//! over a row fit 16 bits, sums of products over the window 28 and two more for the fraction of those with y.
//! In a row of the window y follows from z (y = y0 + slope z), so only the moments of x and z are summed per neighbour.

pub use super::row::LANES;
use super::row::{self, Centres, Row, Sums};
use crate::Image;
use crate::eigen::fixed::{self as eigen, Symmetric3};
use crate::rays::fixed::Rays;

/// Largest radius in fine units: twice this and the spread of depths fit 15 bits.
const FINE: i32 = 10_922;

/// Depth by which a neighbour that does not count is clamped beyond the radius, and at least which centres' depths are.
const MARGIN: i32 = 16;

/// Bits of fraction of the moments with y.
const FRACTION: u32 = 2;

/// Columns of the window that are worked on at a time.
const CHUNK: usize = 64;

/// Offsets at a time: all lanes' neighbours lie in the chunk.
const OFFSETS: usize = CHUNK - LANES;

/// The image and the radius.
#[derive(Debug)]
pub struct Normals<'a, const W: usize, const H: usize> {
    depth: &'a Image<u16, W, H>,
    rays: &'a Rays<W, H>,
    /// In 1/8 mm.
    radius: i32,
    /// The fine unit is 2^-scale of 1/8 mm.
    scale: i32,
    /// Depths in 1/8 mm by which centres that are worked on together may differ.
    spread: i32,
}

/// A window around some centres, and how far into it.
struct Window {
    /// Rows to each side.
    rows: i32,
    /// Columns to each side.
    columns: i32,
    /// Nearest depth of a neighbour.
    near: i32,
    /// Bound of x^2 of the row's points within the radius: (1 + x^2 + y^2) / (1 + y^2), Q12.
    width2: u64,
    /// The same's lean per radius, times the radius.
    lean: u32,
    /// 1 / (1 + y^2), Q24.
    across: u32,
    /// Columns for 1/8 mm at the nearest depth, Q16.
    pixels: u64,
}

/// The square root of 1 + x^2 in Q10, rounded up, for x in Q26.
fn secant(x: u32) -> u32 {
    // Below 2^15, so that squares fit.
    let x = (x >> 16).min(32_766) + 1;
    ((1 << 20) + x * x).isqrt() + 1
}

/// The high half of the product, modulo 2^16.
fn high(factor: i32, depth: u16) -> i16 {
    (factor.wrapping_mul(i32::from(depth)) >> 16) as i16
}

impl<'a, const W: usize, const H: usize> Normals<'a, W, H> {
    /// Of a depth image (1/8 mm, 0 = none) in a radius in 1/8 mm (clamped to 40..=4000).
    pub fn new(depth: &'a Image<u16, W, H>, rays: &'a Rays<W, H>, radius: u16) -> Self {
        let radius = i32::from(radius.clamp(40, 4000));
        let scale = (FINE / radius).ilog2() as i32;
        Self { depth, rays, radius, scale, spread: (32_767 >> scale) - radius - MARGIN - 1 }
    }

    /// Depth (1/8 mm) of a centre; 0 where there is none: outside of the image, or less than 2 mm beyond the radius.
    #[inline]
    pub fn depth_at(&self, u: usize, v: usize) -> u16 {
        let z = self.depth.get(v).and_then(|row| row.get(u)).copied().unwrap_or(0);
        if i32::from(z) >= self.radius + MARGIN { z } else { 0 }
    }

    /// The normals' directions, of either sign and with the largest component about 2^28..2^29, at the pixels
    /// `u..u + LANES` of row `v`, whose depths are `z` (0 = not wanted), see [`Self::depth_at`].
    ///
    /// `None` where z is 0, where fewer than three points lie within the radius, or where they lie on a line.
    pub fn directions(&self, z: [u16; LANES], u: usize, v: usize) -> [Option<[i32; 3]>; LANES] {
        let mut directions = [None; LANES];
        let mut left = z;
        // Each round takes the nearest centres that are left, one at least.
        while let Some(nearest) = left.iter().copied().filter(|z| *z > 0).min() {
            let most = i32::from(nearest) + self.spread;
            let group = left.map(|z| if i32::from(z) <= most { z } else { 0 });
            let found = self.group(group, u, v);
            for (((out, left), taken), direction) in directions.iter_mut().zip(&mut left).zip(group).zip(found) {
                if taken > 0 {
                    (*out, *left) = (direction, 0);
                }
            }
        }
        directions
    }

    /// How far to look from centres at depths of `nearest` and more, in columns `u..u + LANES` of a row at `y`.
    fn window(&self, nearest: i32, u: usize, y: i32) -> Window {
        let k = self.rays.intrinsics();
        let columns = self.rays.x().get(u..(u + LANES).min(W)).unwrap_or(&[]);
        let x = columns.iter().fold(0, |most, x| x.unsigned_abs().max(most));
        // At least MARGIN for depths of `depth_at`.
        let near = (nearest - self.radius).max(1);
        // An offset along a row is within the radius times sqrt(1 + x^2), one across within that of y.
        let reach = |slope: u32, focal: i32, size: usize| {
            let extent = u64::from(secant(slope)) * self.radius as u64;
            let pixels = u32::try_from(((extent * focal as u64) >> 26) + 1).unwrap_or(u32::MAX);
            (pixels / near as u32).min(size as u32) as i32
        };
        // Below 2^15 (Q10); squares Q20.
        let (x10, y10) = ((x >> 16).min(32_766) + 1, y.unsigned_abs() >> 16);
        let along = (1 << 20) + y10 * y10;
        Window {
            rows: reach(y.unsigned_abs() + (1 << 16), k.fy, H),
            columns: reach(x, k.fx, W),
            near,
            width2: (1 << 12) + u64::from(x10 * x10 / (along >> 12).max(1)) + 1,
            lean: (((u64::from(x10) * u64::from(y10 + 1) / u64::from(along.isqrt().max(1))) as u32
                * self.radius as u32)
                >> 10)
                + 1,
            across: ((1u64 << 44) / u64::from(((1 << 20) + (y10 + 1) * (y10 + 1)).max(1))) as u32,
            pixels: ((k.fx as u32) / near as u32) as u64 + 1,
        }
    }

    /// The directions of centres whose depths differ little.
    fn group(&self, z: [u16; LANES], u: usize, v: usize) -> [Option<[i32; 3]>; LANES] {
        let taken = || z.iter().copied().filter(|z| *z > 0).map(i32::from);
        let (Some(nearest), Some(farthest), Some(&y)) = (taken().min(), taken().max(), self.rays.y().get(v)) else {
            return [None; LANES];
        };
        let window = self.window(nearest, u, y);
        let radius = self.radius;

        // The largest offsets: along a row a lies within the radius' extent at the nearest depth, and grows with depth.
        let growth = (((farthest + radius) as u64) << 8) / window.near as u64 + 1;
        let columns = self.rays.x().get(u..(u + LANES).min(W)).unwrap_or(&[]);
        let x = columns.iter().fold(0, |most, x| x.unsigned_abs().max(most));
        let offset = |slope: u32| {
            let extent = (u64::from(secant(slope)) * radius as u64) >> 10;
            (((extent + 1) * growth) >> 8) + ((u64::from(slope) * radius as u64) >> 26) + 2
        };
        let (most_x, most_y) = (offset(x), offset(y.unsigned_abs() + (1 << 16)));
        let fits = |scale: i32| {
            let most = most_x.max(most_y) + (radius + MARGIN) as u64;
            if scale >= 0 { most << scale < 1 << 16 } else { most >> -scale < 1 << 16 }
        };
        let mut scale = self.scale;
        while !fits(scale) && scale > -24 {
            scale -= 1;
        }
        let fine = |v: u64| if scale >= 0 { v << scale } else { v >> -scale };
        let radius_fine = fine(radius as u64) as i32;
        let side = (2 * window.columns.max(window.rows) + 1).min(W.max(H) as i32);
        let mut shift = 0;
        while shift < 15
            && (((radius_fine >> shift) + 2) * side >= 1 << 14
                || (radius_fine >> shift) >= 2000
                || fine(most_y) >> shift >= 1 << (15 - FRACTION))
        {
            shift += 1;
        }

        let factor = |slope: i32, by: i32| if by >= 0 { slope << by.min(31) } else { slope >> (-by).min(31) };
        let x_factor = |column: usize| factor(self.rays.x().get(column).copied().unwrap_or(0), scale - 10);
        let z_factor = 1i32 << (16 + scale).max(0);
        let y_factor = factor(y, scale - 10);
        let lane = |f: &dyn Fn(usize) -> i16| core::array::from_fn(|i| if z[i] > 0 { f(i) } else { 0 });
        // The squares are rounded down, by a half each on average.
        let limit = ((radius_fine * radius_fine - 98_304) >> 16).max(-1) as i16;
        let centres = Centres {
            point: [
                lane(&|i| high(x_factor(u + i), z[i])),
                lane(&|i| high(y_factor, z[i])),
                lane(&|i| high(z_factor, z[i])),
            ],
            depth: z,
            limit: z.map(|z| if z > 0 { limit } else { -1 }),
            shift,
            fraction: FRACTION,
        };
        let nearest_kept = (window.near - MARGIN) as u16;
        let farthest_kept = (farthest + radius + MARGIN).min(65_535) as u16;

        let mut sums = Sums::default();
        let first_row = v.saturating_sub(window.rows as usize);
        let offsets = 2 * window.columns + 1;
        let mut chunk = 0;
        while chunk < offsets {
            // The column of the chunk's first place; may lie outside of the image.
            let base = u as i32 - window.columns + chunk;
            let mut x_factors = [[0u16; CHUNK]; 2];
            let places = x_factors[0].len().min((offsets - chunk) as usize + LANES);
            let [lows, highs] = &mut x_factors;
            for (i, (low, high)) in lows.iter_mut().zip(highs).enumerate().take(places) {
                let factor = usize::try_from(base + i as i32).map_or(0, x_factor);
                (*low, *high) = (factor as u16, (factor >> 16) as u16);
            }
            let rows = self.depth.iter().zip(self.rays.y()).enumerate();
            for (_, (line, &y_there)) in rows.take(v + window.rows as usize + 1).skip(first_row) {
                let dy = y_there - y;
                let Some(reach) = window.columns_at(dy, radius) else { continue };
                let reach = reach.min(window.columns);
                // Offsets of the chunk that are in reach, and at which a lane is inside of the image.
                let from = (window.columns - reach - chunk).max(0).max(1 - LANES as i32 - base);
                let to = (window.columns + reach + 1 - chunk).min(OFFSETS as i32).min(W as i32 - base);
                if from >= to {
                    continue;
                }
                let (from, to) = (from as usize, to as usize + LANES - 1);
                let mut depths = [0u16; CHUNK];
                let inside = (-base).max(from as i32) as usize;
                let there = line.iter().skip((base + inside as i32) as usize);
                for (out, z) in depths.iter_mut().take(to).skip(inside).zip(there) {
                    *out = *z;
                }
                let mut points = [[0i16; CHUNK]; 3];
                let y_here = factor(y_there, scale - 10);
                project(&depths, &x_factors, [y_here, z_factor], [nearest_kept, farthest_kept], from..to, &mut points);
                let [px, py, pz] = &points;
                if let (Some(px), Some(py), Some(pz)) = (px.get(from..to), py.get(from..to), pz.get(from..to)) {
                    let row = Row {
                        points: [px, py, pz],
                        step: factor(dy, scale - 10 - shift as i32 + FRACTION as i32),
                        y: (y_there >> (16 - FRACTION)).clamp(-32_768, 32_767) as i16,
                    };
                    row::add(&centres, &row, &mut sums);
                }
            }
            chunk += OFFSETS as i32;
        }
        core::array::from_fn(|i| {
            let few = 3..=i64::from(side);
            let covariance = match sums.count(i) {
                // No more than a line of pixels has.
                n if few.contains(&n) => self.exact(z[i], u + i, v, &window)?,
                _ => sums.covariance(i)?,
            };
            eigen::least_direction(&covariance)
        })
    }

    /// n^2 times the covariance in 1/2048 mm, of few neighbours: pixels on a line lie in a plane with their rays, and the less
    /// they deviate from a line in space the more it takes to see that.
    fn exact(&self, z: u16, u: usize, v: usize, window: &Window) -> Option<Symmetric3> {
        let centre = self.place(z, u, v);
        let (rows, columns) = (window.rows as usize, window.columns as usize);
        let radius2 = i64::from(self.radius * self.radius) << 16;
        let (mut n, mut first, mut second) = (0i64, [0i64; 3], [0i64; 6]);
        for (row, line) in self.depth.iter().enumerate().take(v + rows + 1).skip(v.saturating_sub(rows)) {
            for (column, there) in line.iter().enumerate().take(u + columns + 1).skip(u.saturating_sub(columns)) {
                if (i32::from(*there) - i32::from(z)).abs() > self.radius || *there == 0 {
                    continue;
                }
                let place = self.place(*there, column, row);
                // |x| < 2^31 in Q26 times 2^16: below 2^30 in Q8.
                let [p, q, b] = core::array::from_fn(|i| place[i] - centre[i]);
                if p * p + q * q + b * b <= radius2 {
                    n += 1;
                    for (sum, d) in first.iter_mut().zip([p, q, b]) {
                        *sum += d;
                    }
                    for (sum, product) in second.iter_mut().zip([p * p, p * q, p * b, q * q, q * b, b * b]) {
                        *sum += product;
                    }
                }
            }
        }
        // Offsets below 2^20 and n below 2^10 or so (lines of pixels): below 2^60; wrapping where a huge radius has more.
        let [p, q, b] = first;
        let least = [p * p, p * q, p * b, q * q, q * b, b * b];
        (n >= 3).then(|| core::array::from_fn(|i| n.wrapping_mul(second[i]).wrapping_sub(least[i])))
    }

    /// The point (1/2048 mm) at depth `z` of a pixel.
    #[inline(always)]
    fn place(&self, z: u16, u: usize, v: usize) -> [i64; 3] {
        let across = |slope: Option<&i32>| (i64::from(slope.copied().unwrap_or(0)) * i64::from(z)) >> 18;
        [across(self.rays.x().get(u)), across(self.rays.y().get(v)), i64::from(z) << 8]
    }
}

/// Brings the pixels `range` of a row to the fine unit: depths clamped, times the rays' factors (x in two halves of 16
/// bits; y, z), the high halves of the products.
#[inline(always)]
fn project(
    depths: &[u16; CHUNK],
    x: &[[u16; CHUNK]; 2],
    [y, z]: [i32; 2],
    [nearest, farthest]: [u16; 2],
    range: core::ops::Range<usize>,
    points: &mut [[i16; CHUNK]; 3],
) {
    let halves = |v: i32| (v as u16, (v >> 16) as u16);
    let ((y_low, y_high), (z_low, z_high)) = (halves(y), halves(z));
    let times = |low: u16, high: u16, depth: u16| {
        (((u32::from(low) * u32::from(depth)) >> 16) as u16).wrapping_add(high.wrapping_mul(depth)) as i16
    };
    let blocks = range.start / LANES..range.end.div_ceil(LANES);
    let [px, py, pz] = points;
    let [x_low, x_high] = x;
    let (px, py, pz) = (px.as_chunks_mut::<LANES>().0, py.as_chunks_mut::<LANES>().0, pz.as_chunks_mut::<LANES>().0);
    let inputs =
        depths.as_chunks::<LANES>().0.iter().zip(x_low.as_chunks::<LANES>().0).zip(x_high.as_chunks::<LANES>().0);
    let outputs = px.iter_mut().zip(py).zip(pz);
    for (((depths, low), high), ((px, py), pz)) in inputs.zip(outputs).take(blocks.end).skip(blocks.start) {
        for i in 0..LANES {
            let depth = depths[i].max(nearest).min(farthest);
            px[i] = times(low[i], high[i], depth);
            py[i] = times(y_low, y_high, depth);
            pz[i] = times(z_low, z_high, depth);
        }
    }
}

impl Window {
    /// Columns to each side that may hold neighbours in a row at `dy` (Q26) from the centres'; `None` where there is none.
    ///
    /// The points within the radius lie, projected along the centre's ray, in an ellipse, see the float twin.
    #[inline(always)]
    fn columns_at(&self, dy: i32, radius: i32) -> Option<i32> {
        let c = (u64::from(dy.unsigned_abs()) * self.near as u64) >> 26;
        let c2 = (c * c * u64::from(self.across)) >> 24;
        let left = ((radius * radius) as u64).checked_sub(c2)?;
        let square = u32::try_from(((left * self.width2) >> 12) + 1).unwrap_or(u32::MAX);
        let a = square.isqrt() + 1 + self.lean;
        Some(((u64::from(a) * self.pixels) >> 16).min(1 << 16) as i32)
    }
}

impl Sums {
    #[inline(always)]
    fn count(&self, i: usize) -> i64 {
        self.n.get(i).copied().map_or(0, i64::from)
    }

    /// n^2 times the covariance of the neighbours of pixel `i`; `None` for fewer than three.
    #[inline(always)]
    fn covariance(&self, i: usize) -> Option<Symmetric3> {
        let at = |sums: &row::Long| sums.get(i).copied().map_or(0, i64::from);
        let n = self.count(i);
        if n < 3 {
            return None;
        }
        // Moments below 2^30 and n below 2^32: no product exceeds 62 bits.
        let (p, q, b) = (at(&self.p), at(&self.q), at(&self.b));
        Some([
            n * at(&self.pp) - p * p,
            (n * at(&self.pq) - p * q) >> FRACTION,
            n * at(&self.pb) - p * b,
            (n * (at(&self.qq) << FRACTION) - q * q) >> (2 * FRACTION),
            (n * at(&self.qb) - q * b) >> FRACTION,
            n * at(&self.bb) - b * b,
        ])
    }
}
