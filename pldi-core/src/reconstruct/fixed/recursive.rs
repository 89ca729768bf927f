//! The recursive filter of the domain transform in integers, on depth and mask at once, both ways along rows and columns.
//!
//! A line is widened to 32 bits: the weight m, and the product s = D m of depth and weight. `F[x] += a^d[x] (F[x-1] - F[x])` runs forth and back on them without a division; then D = s/m goes back
//! into 16 bits, rounded to nearest. So a depth is rounded once per pass, not once per step: a feedback filter that
//! rounds its own output to 1/8 mm at each step would stick up to half a millimetre beside its mean.

#[cfg(target_arch = "x86_64")]
pub use super::four::{columns, rows};
#[cfg(not(target_arch = "x86_64"))]
pub use super::single::{columns, rows};

/// Columns that are filtered together; on some machines also rows.
pub const LANES: usize = 4;

/// Scratch for [`LANES`] rows or columns: the products and the weights. Columns may not be longer than rows.
pub type Lines<const W: usize> = [[[i32; LANES]; 2]; W];

/// Rows lose no weight but what their codes cannot tell from 0, in Q30.
pub(super) const NO_FLOOR: i32 = 7;
