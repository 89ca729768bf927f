//! The ground stages in fixed point, see [`crate::ground`]. Lengths in 1/128 mm, slopes in Q16.

pub mod area;
pub mod candidates;
pub mod density;
pub mod occlusion;
mod projection;

pub use area::{AreaParams, SensoryArea};
pub use candidates::Limits;
pub use density::DensityParams;

use super::{Contour, MAP_WIDTH};

/// Side of a cell of the ground map.
pub const CELL: i32 = 2560;

const _: () = assert!(super::CELL == CELL as f32 / crate::fixed::METRE as f32);

/// A cluster with its lengths in 1/128 mm.
pub type Cluster = super::Cluster<i32>;

/// The centre of a cell in floor coordinates (right, forward): exact.
#[inline(always)]
pub fn cell_centre(column: u8, row: u8) -> [i32; 2] {
    let [x, y] = half_cells(column, row);
    [x * (CELL / 2), y * (CELL / 2)]
}

/// The centre of a cell in floor coordinates (right, forward) in half cells: odd numbers, below 512.
#[inline(always)]
fn half_cells(column: u8, row: u8) -> [i32; 2] {
    [2 * i32::from(column) + 1 - MAP_WIDTH as i32, 2 * i32::from(row) + 1]
}

/// Length of the way through the centres of a contour's cells, rounded to nearest.
pub fn length(contour: &Contour) -> i32 {
    // 2560 times the square root of 2 in Q16; fewer than 2^17 steps make less than 2^45.
    const DIAGONAL: u64 = 237_265_664;
    let straight = i32::from(contour.straight) * CELL;
    straight + ((u64::from(contour.diagonal) * DIAGONAL + (1 << 15)) >> 16) as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_and_centres_agree_with_the_float_ones() {
        for (straight, diagonal) in [(0, 0), (10, 0), (0, 1), (123, 77), (0, u16::MAX), (u16::MAX, 0)] {
            let contour = Contour { start: 0, points: 0, cells: 0, straight, diagonal };
            let truth = f64::from(contour.length()) * 128_000.0;
            assert!((f64::from(length(&contour)) - truth).abs() <= 1.0 + 1e-6 * truth, "{straight} {diagonal}");
        }
        for (column, row) in [(0, 0), (255, 207), (128, 100)] {
            let float = super::super::cell_centre(usize::from(column), usize::from(row));
            let fixed = cell_centre(column, row);
            assert!((0..2).all(|i| (float[i] * 128_000.0 - fixed[i] as f32).abs() < 0.1), "{float:?} {fixed:?}");
        }
    }
}
