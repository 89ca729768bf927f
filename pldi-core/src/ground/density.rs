//! The points' density on the floor by an adaptive Parzen window (paper, section 4, data-driven constraints).
//!
//! Every point above the floor is counted in its cell (image L); each cell then spreads its count with a Gaussian
//! of the covariance Sigma_P = R^T Sigma R, where Sigma holds the sensor's lateral and axial error at the cell's
//! distance (Khoshelham and Elberink 2012) and R turns the axes into the ray's direction on the floor.

use super::border::OCCUPIED;
use super::{CELL, MAP_DEPTH, MAP_WIDTH, Map, SensoryArea, cell_centre, cell_of};
use crate::{Error, FloorAxes, Image, Rays, math};

/// "This pixel belongs to no cell" in the image of cell numbers.
pub const NO_CELL: u16 = u16::MAX;

const _: () = assert!(MAP_WIDTH * MAP_DEPTH < NO_CELL as usize);

/// Parameters of the projection onto the floor and of the density.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DensityParams {
    /// Points lower than this above the floor belong to the floor, at the camera, in metres. Default 0.02.
    pub min_height: f32,
    /// That height grows by this times z^2 (per metre). Default 0.004.
    pub min_height_per_z2: f32,
    /// Points higher than this above the floor are not counted, in metres. Default 2.2.
    pub max_height: f32,
    /// Axial standard deviation of the depth: this times z^2 (per metre). Default 1.425e-3.
    pub axial: f32,
    /// Lateral standard deviation in pixels. Default 0.8.
    pub lateral: f32,
    /// Factor on both, the kernel's bandwidth. Default 1.
    pub bandwidth: f32,
    /// Density from which a cell is occupied: pixels per cell, counted as if they were seen from 2 m. Default 1.
    pub threshold: f32,
}

impl DensityParams {
    /// For Kinect-class sensors.
    pub const DEFAULT: Self = Self {
        min_height: 0.02,
        min_height_per_z2: 0.004,
        max_height: 2.2,
        axial: 1.425e-3,
        lateral: 0.8,
        bandwidth: 1.0,
        threshold: 1.0,
    };

    /// Checks every number against its stated range.
    ///
    /// # Errors
    /// `OutOfRange` with the parameter's name.
    pub fn validate(&self) -> Result<(), Error> {
        use crate::error::within;
        within("density: min_height", self.min_height, 0.0, 1.0)?;
        within("density: min_height_per_z2", self.min_height_per_z2, 0.0, 1.0)?;
        within("density: max_height", self.max_height, 0.1, 100.0)?;
        within("density: axial", self.axial, 0.0, 0.1)?;
        within("density: lateral", self.lateral, 0.0, 20.0)?;
        within("density: bandwidth", self.bandwidth, 0.0, 10.0)?;
        within("density: threshold", self.threshold, 0.0, 1e6)
    }

    /// The height above the floor from which a point at depth `z` is an object's, in metres.
    #[inline(always)]
    pub fn lowest(&self, z: f32) -> f32 {
        self.min_height + self.min_height_per_z2 * z * z
    }
}

/// Counts the points above the floor in image L, and notes each pixel's cell.
///
/// `cells` receives for every pixel the number of its cell (row * [`MAP_WIDTH`] + column), or [`NO_CELL`] where the
/// pixel has no depth, belongs to the floor or lies outside of the area. A pixel at depth z counts (z / 2 m)^2.
pub fn project<const W: usize, const H: usize>(
    depth: &Image<f32, W, H>,
    rays: &Rays<W, H>,
    axes: &FloorAxes,
    area: &SensoryArea,
    params: &DensityParams,
    cells: &mut Image<u16, W, H>,
    counts: &mut Map<f32>,
) {
    counts.as_flattened_mut().fill(0.0);
    // Pixels of a larger image see smaller patches.
    let pixel = (320.0 / W as f32) * (320.0 / W as f32) * 0.25;
    for (v, (row, cells)) in depth.iter().zip(cells.iter_mut()).enumerate() {
        for (u, (&z, cell)) in row.iter().zip(cells.iter_mut()).enumerate() {
            *cell = NO_CELL;
            if z <= 0.0 {
                continue;
            }
            let [right, forward, height] = axes.to_floor(rays.point(u, v, z));
            if height < params.lowest(z) || height > params.max_height || !area.contains(right, forward) {
                continue;
            }
            if let Some((column, row)) = cell_of(right, forward) {
                *cell = (row * MAP_WIDTH + column) as u16;
                if let Some(count) = counts.get_mut(row).and_then(|line| line.get_mut(column)) {
                    *count += z * z * pixel;
                }
            }
        }
    }
}

/// Gaussians are cut off at this squared Mahalanobis distance.
const CUT: f32 = 9.0;

/// exp(-q/2) for squared distances q below the cut at 9, in steps of 1/8.
#[derive(Debug, Clone)]
#[allow(missing_copy_implementations, reason = "a table")]
pub struct Gaussian([f32; 73]);

impl Default for Gaussian {
    fn default() -> Self {
        Self::new()
    }
}

impl Gaussian {
    /// Fills the table.
    pub fn new() -> Self {
        Self(core::array::from_fn(|i| math::exp(-0.5 * (i as f32) / 8.0)))
    }

    #[inline(always)]
    fn at(&self, q: f32) -> f32 {
        self.0.get((q * 8.0 + 0.5) as usize).copied().unwrap_or(0.0)
    }
}

/// Spreads the counts into densities: in pixels (as if seen from 2 m) per cell.
///
/// `focal` is the focal length in pixels of the images, for the lateral error.
pub fn spread(counts: &Map<f32>, params: &DensityParams, focal: f32, gaussian: &Gaussian, density: &mut Map<f32>) {
    density.as_flattened_mut().fill(0.0);
    for (row, line) in counts.iter().enumerate() {
        for (column, &count) in line.iter().enumerate() {
            if count > 0.0 {
                spread_cell(column, row, count, params, focal, gaussian, density);
            }
        }
    }
}

/// Marks the cells whose density reaches `threshold` with 1, the others with 0.
pub fn occupied(density: &Map<f32>, threshold: f32, marks: &mut Map<u8>) {
    for (mark, value) in marks.as_flattened_mut().iter_mut().zip(density.as_flattened()) {
        *mark = if *value >= threshold { OCCUPIED } else { 0 };
    }
}

/// Adds the Gaussian of one cell.
fn spread_cell(
    column: usize,
    row: usize,
    count: f32,
    params: &DensityParams,
    focal: f32,
    gaussian: &Gaussian,
    density: &mut Map<f32>,
) {
    let [x, y] = cell_centre(column, row);
    let distance = math::sqrt(x * x + y * y);
    let (sin, cos) = (x / distance, y / distance);
    let square = |s: f32| s * s;
    // In square cells. Half a cell is added, so that a Gaussian sampled at the cells' centres keeps its sum.
    let scale = params.bandwidth / CELL;
    let axial = square(params.axial * y * y * scale) + 0.25;
    let lateral = square(params.lateral * y / focal * scale) + 0.25;
    // Sigma_P = R^T diag(lateral, axial) R: across the ray and along it.
    let (xx, xy, yy) = (
        lateral * cos * cos + axial * sin * sin,
        (axial - lateral) * sin * cos,
        lateral * sin * sin + axial * cos * cos,
    );
    let determinant = axial * lateral;
    let (ixx, ixy, iyy) = (yy / determinant, -xy / determinant, xx / determinant);
    let peak = count / (core::f32::consts::TAU * math::sqrt(determinant));
    let reach = |variance: f32| math::floor(math::sqrt(CUT * variance)) as usize;
    let (reach_x, reach_y) = (reach(xx), reach(yy));
    let (left, right) = (column.saturating_sub(reach_x), (column + reach_x + 1).min(MAP_WIDTH));
    for (r, line) in density.iter_mut().enumerate().take(row + reach_y + 1).skip(row.saturating_sub(reach_y)) {
        let dy = r as f32 - row as f32;
        for (c, cell) in line.iter_mut().enumerate().take(right).skip(left) {
            let dx = c as f32 - column as f32;
            let q = ixx * dx * dx + 2.0 * ixy * dx * dy + iyy * dy * dy;
            if q < CUT {
                *cell += peak * gaussian.at(q);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map() -> Box<Map<f32>> {
        vec![[0.0; MAP_WIDTH]; MAP_DEPTH].into_boxed_slice().try_into().unwrap()
    }

    fn spread_of(column: usize, row: usize, params: &DensityParams) -> Box<Map<f32>> {
        let (mut counts, mut density) = (map(), map());
        counts[row][column] = 100.0;
        spread(&counts, params, 262.5, &Gaussian::new(), &mut density);
        density
    }

    #[test]
    fn the_count_is_kept() {
        for (column, row) in [(128, 190), (20, 150), (128, 40)] {
            let total: f32 = spread_of(column, row, &DensityParams { bandwidth: 2.0, ..DensityParams::DEFAULT })
                .as_flattened()
                .iter()
                .sum();
            assert!((total - 100.0).abs() < 6.0, "{column} {row}: {total}");
        }
    }

    #[test]
    fn far_points_spread_along_their_ray() {
        let density = spread_of(128, 190, &DensityParams { bandwidth: 2.0, ..DensityParams::DEFAULT });
        assert!(density[192][128] > 2.0 * density[190][130].max(0.1));
        // To the right, the ray leans: the cell behind to the right gets more than that behind to the left.
        let density = spread_of(228, 190, &DensityParams { bandwidth: 2.0, ..DensityParams::DEFAULT });
        assert!(density[192][229] > 1.5 * density[192][227]);
    }

    #[test]
    fn near_points_stay_in_their_cell() {
        let density = spread_of(128, 40, &DensityParams::DEFAULT);
        assert!(density[40][128] > 50.0);
    }
}
