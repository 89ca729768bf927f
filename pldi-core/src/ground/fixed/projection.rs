//! Where on the floor a pixel stands: the same place for the count of the points and for the gathering of the pixels, bit for
//! bit, because both ask here.
//!
//! A pixel's floor coordinates are its depth times its ray in floor axes, and along a row that ray changes by the same
//! step from column to column. So a row starts with three exact numbers, rounded, and adds three steps per column; what
//! the rounded steps add up to is below W/2 units: for 320 columns and 4 m, 0.03 mm on the floor and 0.02 mm in height.

use super::{DensityParams, SensoryArea};
use crate::fixed::{mul_high, where_not_negative};
use crate::floor::fixed::FloorAxes;
use crate::ground::{MAP_DEPTH, MAP_WIDTH};
use crate::rays::fixed::Rays;
use core::ops::Range;

/// Units of a cell's side in [`Point`]s: 2^11.
pub(super) const CELL_BITS: u32 = 11;

/// Right and forward in 2^-11 cells, rounded down.
pub(super) type Point = [i32; 2];

/// A row's rays in floor axes: right and forward in cells per 1/8 mm, Q32 (below 0.29 for |x|, |y| < 32), height in
/// 1/8 mm per 1/8 mm, Q25 (below 46).
#[derive(Clone, Copy)]
pub(super) struct Ray([i32; 3]);

impl Ray {
    /// The point at a depth in 1/8 mm, and its height relative to the camera's in 1/128 mm. All below 2^27 (2^16 of depth
    /// times 0.29 cells in 2^-11, times 46 in 1/128 mm).
    #[inline(always)]
    pub(super) fn at(self, z: u16) -> (Point, i32) {
        let z = i32::from(z) << CELL_BITS;
        ([mul_high(z, self.0[0]), mul_high(z, self.0[1])], mul_high(z, self.0[2]))
    }

    /// The ray so many columns on. Wrapping, for axes that are no unit vectors.
    #[inline(always)]
    pub(super) fn after(self, columns: usize, step: Self) -> Self {
        let on = |i: usize| self.0[i].wrapping_add((columns as i32).wrapping_mul(step.0[i]));
        Self([on(0), on(1), on(2)])
    }

    /// Height per depth, Q25.
    #[inline(always)]
    pub(super) fn up(self) -> i32 {
        self.0[2]
    }
}

/// The rays of a camera in floor axes.
pub(super) struct Projection {
    /// Right and forward in cells per 1/8 mm, Q37; up in Q30.
    axes: [[i32; 3]; 3],
    step: Ray,
}

impl Projection {
    pub(super) fn new<const W: usize, const H: usize>(rays: &Rays<W, H>, axes: &FloorAxes) -> Self {
        // A cell is 160 times 1/8 mm: Q30 / 160 = Q37 / 5 * 4.
        let cells = |axis: [i32; 3]| axis.map(|v| ((4 * i64::from(v) + 2).div_euclid(5)) as i32);
        let axes = [cells(axes.right), cells(axes.forward), axes.floor.normal];
        let focal = i64::from(rays.intrinsics().fx.max(1));
        // Q37 (Q30) over Q16 pixels to Q32 (Q25).
        let step = axes.map(|axis| (((i64::from(axis[0]) << 11) + focal / 2).div_euclid(focal)) as i32);
        Self { axes, step: Ray(step) }
    }

    /// The step from column to column.
    pub(super) fn step(&self) -> Ray {
        self.step
    }

    /// The ray of row `v` and column 0.
    pub(super) fn ray<const W: usize, const H: usize>(&self, rays: &Rays<W, H>, v: usize) -> Ray {
        let (x, y) = (rays.x().first().copied().unwrap_or(0), rays.y().get(v).copied().unwrap_or(0));
        // The axes' parts along x and y make at most 2^30 together, x and y at most 2^31.5: below 2^62.
        Ray(self.axes.map(|a| {
            let dot = (i64::from(a[0]).wrapping_mul(i64::from(x)))
                .wrapping_add(i64::from(a[1]).wrapping_mul(i64::from(y)))
                .wrapping_add(i64::from(a[2]) << 26);
            (dot.wrapping_add(1 << 30) >> 31) as i32
        }))
    }
}

/// The number of the cell that a point lies in: row * [`MAP_WIDTH`] + column.
#[inline(always)]
pub(super) fn cell_of([right, forward]: Point) -> Option<usize> {
    let (column, row) = ((right >> CELL_BITS) + MAP_WIDTH as i32 / 2, forward >> CELL_BITS);
    let inside = (column as u32) < MAP_WIDTH as u32 && (row as u32) < MAP_DEPTH as u32;
    inside.then_some(row as usize * MAP_WIDTH + column as usize)
}

/// Which pixels count.
pub(super) struct Gate {
    projection: Projection,
    /// 2^-11 cells.
    near: i32,
    far: i32,
    /// Slopes in Q16.
    left: i64,
    right: i64,
    /// Of the camera, 1/128 mm.
    height: i32,
    min_height: i32,
    per_square: u32,
    max_height: i32,
}

impl Gate {
    pub(super) fn new<const W: usize, const H: usize>(
        rays: &Rays<W, H>,
        axes: &FloorAxes,
        area: &SensoryArea,
        params: &DensityParams,
    ) -> Self {
        // 2560 units of 1/128 mm are 2048 here.
        let units = |length: i32| ((4 * i64::from(length) + 2).div_euclid(5)) as i32;
        Self {
            projection: Projection::new(rays, axes),
            near: units(area.near),
            far: units(area.far),
            left: i64::from(area.left),
            right: i64::from(area.right),
            height: axes.floor.height,
            min_height: params.min_height,
            per_square: params.min_height_per_z2,
            max_height: params.max_height,
        }
    }

    /// The columns of row `v` whose rays lie between the area's sides (as first and behind the last), and the ray of column 0.
    ///
    /// The sides' test does not depend on the depth: left * forward <= right holds for a ray or does not.
    pub(super) fn row<const W: usize, const H: usize>(&self, rays: &Rays<W, H>, v: usize) -> (Range<usize>, Ray) {
        let (ray, Ray([dr, df, _])) = (self.projection.ray(rays, v), self.projection.step);
        let Ray([right, forward, _]) = ray;
        // Below 2^47 + 2^29 * 2^31.
        let beyond = |slope: i64, right: i32, forward: i32| (i64::from(right) << 16) - slope * i64::from(forward);
        let (a, b) = where_not_negative(beyond(self.left, right, forward), beyond(self.left, dr, df), W);
        let (c, d) = where_not_negative(-beyond(self.right, right, forward), -beyond(self.right, dr, df), W);
        let first = a.max(c);
        (first..b.min(d).max(first), ray)
    }

    /// The step from column to column.
    pub(super) fn step(&self) -> Ray {
        self.projection.step
    }

    /// Whether what lies at depth `z` on a ray with this height per depth has a depth and stands above the floor; to be
    /// asked first, because most pixels do not.
    #[inline(always)]
    pub(super) fn stands(&self, z: u16, up: i32) -> bool {
        let height = self.height.wrapping_add(mul_high(i32::from(z) << CELL_BITS, up));
        let square = u32::from(z) * u32::from(z);
        // Below 2^24.
        let grown = ((u64::from(square) * u64::from(self.per_square)) >> 32) as i32;
        height >= self.min_height + grown && height <= self.max_height && z != 0
    }

    /// The cell of a point within the area.
    #[inline(always)]
    pub(super) fn cell(&self, point: Point) -> Option<usize> {
        if point[1] < self.near || point[1] > self.far { None } else { cell_of(point) }
    }
}
