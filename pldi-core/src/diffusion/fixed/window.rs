//! The window around centres in which all points within the radius lie.

use crate::rays::fixed::Rays;

/// A window around some centres, and how far into it.
#[derive(Debug)]
pub struct Window {
    /// Rows to each side.
    pub rows: i32,
    /// Columns to each side.
    pub columns: i32,
    /// Nearest depth of a neighbour.
    pub near: i32,
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
pub fn secant(x: u32) -> u32 {
    // Below 2^15, so that squares fit.
    let x = (x >> 16).min(32_766) + 1;
    ((1 << 20) + x * x).isqrt() + 1
}

/// A bound of the square root, a thousandth too large at most: three of Newton's steps, which come from above.
#[inline(always)]
fn root_above(x: u32) -> u32 {
    let first = 1u32 << ((33 - (x | 1).leading_zeros()) / 2);
    let second = (first + x / first.max(1)) / 2 + 1;
    let third = (second + x / second.max(1)) / 2 + 1;
    (third + x / third.max(1)) / 2 + 1
}

impl Window {
    /// How far to look from centres at depths of `nearest` (1/8 mm) and more, in columns whose rays' x is at most `x`, of a
    /// row at `y` (Q26), for a radius in 1/8 mm.
    pub fn new<const W: usize, const H: usize>(rays: &Rays<W, H>, radius: i32, nearest: i32, x: u32, y: i32) -> Self {
        let k = rays.intrinsics();
        // At least MARGIN for depths of `depth_at`.
        let near = (nearest - radius).max(1);
        // An offset along a row is within the radius times sqrt(1 + x^2), one across within that of y.
        let reach = |slope: u32, focal: i32, size: usize| {
            let extent = u64::from(secant(slope)) * radius as u64;
            let pixels = u32::try_from(((extent * focal as u64) >> 26) + 1).unwrap_or(u32::MAX);
            (pixels / near as u32).min(size as u32) as i32
        };
        // Below 2^15 (Q10); squares Q20.
        let (x10, y10) = ((x >> 16).min(32_766) + 1, y.unsigned_abs() >> 16);
        let along = (1 << 20) + y10 * y10;
        Self {
            rows: reach(y.unsigned_abs() + (1 << 16), k.fy, H),
            columns: reach(x, k.fx, W),
            near,
            width2: (1 << 12) + u64::from(x10 * x10 / (along >> 12).max(1)) + 1,
            lean: (((x10 * (y10 + 1) / along.isqrt().max(1)) * radius as u32) >> 10) + 1,
            // A bound, so that a division of 32 bits will do.
            across: (((1 << 31) / ((((1 << 20) + (y10 + 1) * (y10 + 1)) >> 7) + 1)) << 6),
            pixels: ((k.fx as u32) / near as u32) as u64 + 1,
        }
    }

    /// Columns to each side that may hold neighbours in a row at `dy` (Q26) from the centres'; `None` where there is none.
    ///
    /// The points within the radius lie, projected along the centre's ray, in an ellipse, see the float twin.
    #[inline(always)]
    pub fn columns_at(&self, dy: i32, radius: i32) -> Option<i32> {
        let c = (u64::from(dy.unsigned_abs()) * self.near as u64) >> 26;
        let c2 = (c * c * u64::from(self.across)) >> 24;
        let left = ((radius * radius) as u64).checked_sub(c2)?;
        let square = u32::try_from(((left * self.width2) >> 12) + 1).unwrap_or(u32::MAX);
        let a = root_above(square) + 1 + self.lean;
        Some(((u64::from(a) * self.pixels) >> 16).min(1 << 16) as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn roots_are_bounded_from_above(x: u32, bits in 0u32..32) {
            let x = x >> bits;
            let (bound, root) = (f64::from(root_above(x)), f64::from(x).sqrt());
            prop_assert!(bound >= root && bound <= 1.001 * root + 3.0, "{x}: {bound}");
        }
    }
}
