//! Surface normals within a fixed radius in integers, see the float twin. Centres of a row of the image are taken by
//! eights; those whose depths differ little form a group, with one unit and one window for all.

pub use super::group::Scratch;
use super::group::{FINE, Group, MARGIN};
use crate::Image;
use crate::eigen::fixed::{self as eigen, Symmetric3};
use crate::rays::fixed::Rays;

/// Pixels that are worked on side by side.
pub const LANES: usize = 8;

/// The image and the radius.
#[derive(Debug)]
pub struct Normals<'a, const W: usize, const H: usize> {
    pub(super) depth: &'a Image<u16, W, H>,
    pub(super) rays: &'a Rays<W, H>,
    /// In 1/8 mm.
    pub(super) radius: i32,
    /// The fine unit is 2^-scale of 1/8 mm.
    pub(super) scale: i32,
    /// Depths in 1/8 mm by which centres that are worked on together may differ.
    spread: i32,
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
    pub fn directions(&self, z: [u16; LANES], u: usize, v: usize, scratch: &mut Scratch) -> [Option<[i32; 3]>; LANES] {
        let mut directions = [None; LANES];
        let mut left = z;
        // Each round takes the nearest centres that are left, one at least.
        loop {
            let mut nearest = u16::MAX;
            for z in left {
                // 0 becomes the largest there is.
                nearest = nearest.min(z.wrapping_sub(1));
            }
            if nearest == u16::MAX {
                break;
            }
            let most = i32::from(nearest) + 1 + self.spread;
            let mut group = [0; LANES];
            for (taken, left) in group.iter_mut().zip(&mut left) {
                if i32::from(*left) <= most {
                    (*taken, *left) = (*left, 0);
                }
            }
            self.group(group, u, v, scratch, &mut directions);
        }
        directions
    }

    /// The directions of centres whose depths differ little (0 = none).
    fn group(
        &self,
        z: [u16; LANES],
        u: usize,
        v: usize,
        scratch: &mut Scratch,
        directions: &mut [Option<[i32; 3]>; LANES],
    ) {
        let Some(group) = Group::new(self, z, u, v) else { return };
        let sums = group.sums(scratch);
        for (i, direction) in directions.iter_mut().enumerate() {
            let z = z.get(i).copied().unwrap_or(0);
            if z == 0 {
                continue;
            }
            let moments = sums.lane(i);
            // No more than a line of pixels has.
            let few = moments.n >= 3 && moments.n <= group.side;
            let covariance = if few { self.exact(z, u + i, v, &group.window) } else { moments.covariance() };
            *direction = covariance.as_ref().and_then(eigen::least_direction);
        }
    }

    /// n^2 times the covariance in 1/2048 mm, of few neighbours: pixels on a line lie in a plane with their rays, and the less
    /// they deviate from a line in space the more it takes to see that.
    fn exact(&self, z: u16, u: usize, v: usize, window: &super::window::Window) -> Option<Symmetric3> {
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
