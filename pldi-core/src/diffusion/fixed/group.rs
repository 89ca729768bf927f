//! Centres side by side whose depths differ little: the units that they are computed in, and the sums over their neighbours.
//!
//! Coordinates are brought to a fine unit, 2^-s of 1/8 mm, in which the radius is 5,461 to 10,922 (41 to 82 units for one
//! millimetre at 4 cm wide), and kept modulo 2^16: an offset from the centre is right wherever it matters, because depths far
//! from the centres' are clamped (so z does not wrap) and s is chosen so that no x or y within the window
//! wraps into the radius. Squares of offsets count 2^16 fine units.
//!
//! Moments are summed in the fine unit times 2^t, where the radius times the window's rows or columns stays below 2^14: sums
//! over a row fit 16 bits, sums of products over the window 28 and two more for the fraction of those with y.
//! In a row of the window y follows from z (y = y0 + slope z), so only the moments of x and z are summed per neighbour.
//!
//! The sums are made eight lanes at a time (`lanes`) or one centre after the other (`single`), with the same bits.

use super::normals::{LANES, Normals};
use super::window::{Window, secant};
use crate::Image;
use crate::eigen::fixed::Symmetric3;
use crate::rays::fixed::Rays;

#[cfg(target_arch = "x86_64")]
pub use super::lanes::Scratch;
#[cfg(target_arch = "x86_64")]
use super::lanes::{self as way, Sums};
#[cfg(not(target_arch = "x86_64"))]
pub use super::single::Scratch;
#[cfg(not(target_arch = "x86_64"))]
use super::single::{self as way, Sums};

/// Largest radius in fine units: twice this and the spread of depths fit 15 bits.
pub const FINE: i32 = 10_922;

/// Depth by which a neighbour that does not count is clamped beyond the radius, and at least which centres' depths are.
pub const MARGIN: i32 = 16;

/// Bits of fraction of the moments with y.
pub const FRACTION: u32 = 2;

/// What is left of pb and bb (2^-10) beside a slope of [`Row::y`] (2^10): their product has the unit of the sums.
pub const SLOPE_BITS: u32 = 10;

/// One number of 16 bits for each of the pixels.
pub type Short = [i16; LANES];

/// The centres, in fine units; coordinates of points count modulo 2^16.
#[derive(Debug, Clone, Copy)]
pub struct Centres {
    /// x, y and z.
    pub point: [Short; 3],
    /// Depth in 1/8 mm.
    pub depth: [u16; LANES],
    /// Largest sum of the squares (each 2^-16, rounded down) of a neighbour's offset; -1 for lanes without a centre.
    pub limit: Short,
    /// The moments' unit is 2^shift fine units.
    pub shift: u32,
}

/// A row of the window.
#[derive(Debug, Clone, Copy)]
pub struct Row<'a, const W: usize> {
    /// The depths of the image's row.
    pub depths: &'a [u16; W],
    /// Columns to each side that may hold neighbours.
    pub reach: usize,
    /// What a depth gives y with, in fine units.
    pub factor: i32,
    /// Difference of the rays' y to the centres' row: times a depth, in 2^-16 of the moments' fraction.
    pub step: i32,
    /// The rays' y, in 2^-(10 + fraction).
    pub y: i16,
}

/// Sums over the neighbours of a centre, relative to it: count, first and second moments of x (p), y (q) and z (b).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Moments {
    pub n: i32,
    pub p: i32,
    pub q: i32,
    pub b: i32,
    pub pp: i32,
    pub pq: i32,
    pub pb: i32,
    pub qq: i32,
    pub qb: i32,
    pub bb: i32,
}

/// Some centres of a row of the image.
#[derive(Debug)]
pub struct Group<'a, const W: usize, const H: usize> {
    depth: &'a Image<u16, W, H>,
    rays: &'a Rays<W, H>,
    /// In 1/8 mm.
    radius: i32,
    /// The fine unit is 2^-scale of 1/8 mm.
    scale: i32,
    /// The column of the first centre.
    pub u: usize,
    v: usize,
    /// The rays' y of the centres.
    y: i32,
    pub window: Window,
    /// Most neighbours in a line of pixels.
    pub side: i32,
    pub centres: Centres,
    /// Depths are clamped to these, so that offsets in depth do not wrap.
    pub kept: [u16; 2],
    /// What a depth gives z with, in fine units.
    pub z_factor: i32,
}

/// The high half of the product, modulo 2^16.
#[inline(always)]
pub fn high(factor: i32, depth: u16) -> i16 {
    (factor.wrapping_mul(i32::from(depth)) >> 16) as i16
}

/// A ray's slope (Q26) as a factor 2^(26 - 10) times finer units.
#[inline(always)]
fn factor(slope: i32, by: i32) -> i32 {
    if by >= 0 { slope << by.min(31) } else { slope >> (-by).min(31) }
}

impl<'a, const W: usize, const H: usize> Group<'a, W, H> {
    /// Centres at depths of `z` (0 = none) in the columns `u..u + LANES` of row `v`; `None` where there is none at all.
    #[inline(always)]
    pub fn new(normals: &Normals<'a, W, H>, z: [u16; LANES], u: usize, v: usize) -> Option<Self> {
        let Normals { depth, rays, radius, .. } = *normals;
        let y = *rays.y().get(v)?;
        let (mut nearest, mut farthest) = (u16::MAX, 0);
        for z in z {
            if z > 0 {
                (nearest, farthest) = (nearest.min(z), farthest.max(z));
            }
        }
        if farthest == 0 {
            return None;
        }
        let (nearest, farthest) = (i32::from(nearest), i32::from(farthest));
        let columns = rays.x().get(u..(u + LANES).min(W)).unwrap_or(&[]);
        let x = columns.iter().fold(0, |most, x| x.unsigned_abs().max(most));
        let window = Window::new(rays, radius, nearest, x, y);

        // The largest offsets: along a row a lies within the radius' extent at the nearest depth, and grows with depth.
        let growth = (((farthest + radius) as u32) << 8) / window.near as u32 + 1;
        let offset = |slope: u32| {
            let extent = (u64::from(secant(slope)) * radius as u64) >> 10;
            (((extent + 1) * u64::from(growth)) >> 8) + ((u64::from(slope) * radius as u64) >> 26) + 2
        };
        let (most_x, most_y) = (offset(x), offset(y.unsigned_abs() + (1 << 16)));
        let fits = |scale: i32| {
            let most = most_x.max(most_y) + (radius + MARGIN) as u64;
            if scale >= 0 { most << scale < 1 << 16 } else { most >> -scale < 1 << 16 }
        };
        let mut scale = normals.scale;
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

        let (z_factor, y_factor) = (1i32 << (16 + scale).max(0), factor(y, scale - 10));
        // The squares are rounded down, by a half each on average.
        let limit = ((radius_fine * radius_fine - 98_304) >> 16).max(-1) as i16;
        let mut centres = Centres { point: [[0; LANES]; 3], depth: z, limit: [-1; LANES], shift };
        for (i, z) in z.into_iter().enumerate() {
            if z > 0 {
                let x = rays.x().get(u + i).copied().unwrap_or(0);
                centres.point[0][i] = high(factor(x, scale - 10), z);
                centres.point[1][i] = high(y_factor, z);
                centres.point[2][i] = high(z_factor, z);
                centres.limit[i] = limit;
            }
        }
        let kept = [(window.near - MARGIN) as u16, (farthest + radius + MARGIN).min(65_535) as u16];
        Some(Self { depth, rays, radius, scale, u, v, y, window, side, centres, kept, z_factor })
    }

    /// What a depth in a column gives x with, in fine units.
    #[inline(always)]
    pub fn x_factor(&self, column: usize) -> i32 {
        factor(self.rays.x().get(column).copied().unwrap_or(0), self.scale - 10)
    }

    /// The rows in which there may be neighbours.
    #[inline(always)]
    pub fn rows(&self) -> impl Iterator<Item = Row<'a, W>> {
        let first = self.v.saturating_sub(self.window.rows as usize);
        let last = self.v + self.window.rows as usize;
        let (depths, ys) = (self.depth.get(first..).unwrap_or(&[]), self.rays.y().get(first..).unwrap_or(&[]));
        depths.iter().zip(ys).take(last + 1 - first).filter_map(|(depths, &y)| {
            let dy = y - self.y;
            Some(Row {
                depths,
                reach: self.window.columns_at(dy, self.radius)?.min(self.window.columns) as usize,
                factor: factor(y, self.scale - 10),
                step: factor(dy, self.scale - 10 - self.centres.shift as i32 + FRACTION as i32),
                y: (y >> (16 - FRACTION)).clamp(-32_768, 32_767) as i16,
            })
        })
    }

    /// The sums over the neighbours of all centres.
    pub fn sums(&self, scratch: &mut Scratch) -> Sums {
        way::sums(self, scratch)
    }
}

impl Moments {
    /// n^2 times the covariance; `None` for fewer than three neighbours.
    #[inline(always)]
    pub fn covariance(&self) -> Option<Symmetric3> {
        if self.n < 3 {
            return None;
        }
        // Moments below 2^30 and n below 2^32: no product exceeds 62 bits.
        let [n, p, q, b] = [self.n, self.p, self.q, self.b].map(i64::from);
        let [pp, pq, pb, qq, qb, bb] = [self.pp, self.pq, self.pb, self.qq, self.qb, self.bb].map(i64::from);
        Some([
            n * pp - p * p,
            (n * pq - p * q) >> FRACTION,
            n * pb - p * b,
            (n * (qq << FRACTION) - q * q) >> (2 * FRACTION),
            (n * qb - q * b) >> FRACTION,
            n * bb - b * b,
        ])
    }
}
