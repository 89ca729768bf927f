//! Object candidates on the floor (paper, section 4): the sensory area, the points projected onto it (image L), their
//! density, the outer borders of what is dense, and the tests that a cluster must pass.

pub mod area;
pub mod border;
pub mod candidates;
pub mod density;
pub mod fixed;
pub mod occlusion;

pub use area::{AreaParams, SensoryArea};
pub use border::{Contour, ContourPoint};
pub use candidates::{Cluster, Length, Limits, Rejection};
pub use density::DensityParams;

use crate::Image;

/// Side of a cell of the ground map in metres.
pub const CELL: f32 = 0.02;

/// Columns of the ground map, left to right: 5.12 m, the camera in the middle.
pub const MAP_WIDTH: usize = 256;

/// Rows of the ground map, row 0 below the camera, forward: 4.16 m.
pub const MAP_DEPTH: usize = 208;

/// Most clusters that a frame can have, rejected ones included.
pub const MAX_CLUSTERS: usize = 192;

/// Most contour points of all clusters together.
pub const MAX_CONTOUR_POINTS: usize = 8192;

/// A value for every cell of the ground map.
pub type Map<T> = Image<T, MAP_WIDTH, MAP_DEPTH>;

/// The centre of a cell in floor coordinates (right, forward) in metres.
#[inline(always)]
pub fn cell_centre(column: usize, row: usize) -> [f32; 2] {
    [(column as f32 + 0.5 - MAP_WIDTH as f32 / 2.0) * CELL, (row as f32 + 0.5) * CELL]
}

/// The cell (column, row) of a point in floor coordinates; `None` outside of the map.
#[inline(always)]
pub fn cell_of(right: f32, forward: f32) -> Option<(usize, usize)> {
    let column = right * (1.0 / CELL) + MAP_WIDTH as f32 / 2.0;
    let row = forward * (1.0 / CELL);
    // Written so that NaN is outside.
    if column >= 0.0 && row >= 0.0 && column < MAP_WIDTH as f32 && row < MAP_DEPTH as f32 {
        Some((column as usize, row as usize))
    } else {
        None
    }
}
