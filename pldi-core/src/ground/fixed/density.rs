//! The points' density on the floor in fixed point.
//!
//! Counts are in pixels as if seen from 2 m, in units of 2^-8 below row [`FAR_ROW`] of the map (1.28 m) and of 2^-7 from
//! there on, and saturate at 256 and 512 pixels. What lies that dense is occupied either way: at the default threshold of
//! 1 pixel, a saturated cell raises every cell that its kernel reaches above the threshold (below 4 m all but the kernel's
//! outermost rim). Densities are in Q10 and saturate at 63.999.

use super::projection::Gate;
use super::{SensoryArea, half_cells};
use crate::fixed::{METRE, exp_neg, quantise, reciprocal};
use crate::floor::fixed::FloorAxes;
use crate::ground::border::OCCUPIED;
use crate::ground::{MAP_DEPTH, MAP_WIDTH, Map};
use crate::rays::fixed::Rays;
use crate::{Error, Image};

/// The row of the map from which counts are in units of 2^-7 pixels.
pub const FAR_ROW: usize = 64;

/// Parameters of the projection onto the floor and of the density, see [`crate::ground::DensityParams`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DensityParams {
    /// Points lower than this above the floor belong to the floor, at the camera, in 1/128 mm.
    pub min_height: i32,
    /// That height grows by this times the squared depth in (1/8 mm)^2, in 1/128 mm, Q32.
    pub min_height_per_z2: u32,
    /// Points higher than this above the floor are not counted, in 1/128 mm.
    pub max_height: i32,
    /// Axial standard deviation times bandwidth, in cells per squared distance in half cells, Q40.
    pub axial: u32,
    /// Lateral standard deviation times bandwidth, in pixels, Q16.
    pub lateral: u32,
    /// Density from which a cell is occupied, in Q10.
    pub threshold: u16,
}

/// Largest standard deviation of a kernel in cells, Q16: with the half cell that is added, three of them are less than
/// 16 cells.
const MAX_DEVIATION: i64 = 5 << 16;

/// Largest product of lateral deviation and bandwidth in pixels, Q16: at a focal length of 250 pixels (QVGA: 65 degrees) and
/// 4.15 m, [`MAX_DEVIATION`]. Kernels of wider lenses are cut there.
const MAX_LATERAL: i64 = 6 << 16;

impl DensityParams {
    /// The parameters rounded to their units; at compile time in a `const`.
    ///
    /// # Errors
    /// `OutOfRange` with the parameter's name, for ranges as in [`crate::ground::DensityParams::validate`], and narrower ones:
    /// kernels reach at most 15 cells (`axial` times `bandwidth` at most 0.0057, `lateral` times `bandwidth` at most 6), the
    /// threshold is at most 60.
    pub const fn new(float: &crate::ground::DensityParams) -> Result<Self, Error> {
        const LENGTH: f64 = METRE as f64;
        // (1/8 mm)^2 are 1/64e6 m^2.
        const PER_SQUARE: f64 = 4_294_967_296.0 * LENGTH / 64e6;
        let Some(min_height) = quantise(float.min_height, 0.0, 1.0, LENGTH) else {
            return Err(Error::OutOfRange("density: min_height"));
        };
        let Some(per_square) = quantise(float.min_height_per_z2, 0.0, 1.0, PER_SQUARE) else {
            return Err(Error::OutOfRange("density: min_height_per_z2"));
        };
        let Some(max_height) = quantise(float.max_height, 0.1, 100.0, LENGTH) else {
            return Err(Error::OutOfRange("density: max_height"));
        };
        let Some(axial) = quantise(float.axial, 0.0, 0.1, 4_294_967_296.0) else {
            return Err(Error::OutOfRange("density: axial"));
        };
        let Some(lateral) = quantise(float.lateral, 0.0, 20.0, 65_536.0) else {
            return Err(Error::OutOfRange("density: lateral"));
        };
        let Some(bandwidth) = quantise(float.bandwidth, 0.0, 10.0, 65_536.0) else {
            return Err(Error::OutOfRange("density: bandwidth"));
        };
        let Some(threshold) = quantise(float.threshold, 0.0, 60.0, 1024.0) else {
            return Err(Error::OutOfRange("density: threshold"));
        };
        // Per m^2 and in m to half cells (0.01 m) and cells (0.02 m): 0.01^2 / 0.02 = 1/200. Q32 times Q16 to Q40.
        let axial = (axial * bandwidth + 25_600) / 51_200;
        let farthest = 2 * MAP_DEPTH as i64 - 1;
        if (axial * farthest * farthest) >> 24 > MAX_DEVIATION {
            return Err(Error::OutOfRange("density: axial times bandwidth"));
        }
        let lateral = (lateral * bandwidth + (1 << 15)) >> 16;
        if lateral > MAX_LATERAL {
            return Err(Error::OutOfRange("density: lateral times bandwidth"));
        }
        Ok(Self {
            min_height: min_height as i32,
            min_height_per_z2: per_square as u32,
            max_height: max_height as i32,
            axial: axial as u32,
            lateral: lateral as u32,
            threshold: threshold as u16,
        })
    }
}

/// Counts the points above the floor in image L. `depth` is in 1/8 mm. A pixel at depth z counts (z / 2 m)^2, in images
/// other than 320 pixels wide as much as its share of such an image; rounded to nearest in the unit of its cell.
///
/// `labels` receives 1 for the pixels that count and 0 for the others, see [`super::candidates::gather`].
pub fn project<const W: usize, const H: usize>(
    depth: &Image<u16, W, H>,
    rays: &Rays<W, H>,
    axes: &FloorAxes,
    area: &SensoryArea,
    params: &DensityParams,
    labels: &mut Image<u8, W, H>,
    counts: &mut Map<u16>,
) {
    let counts = counts.as_flattened_mut();
    counts.fill(0);
    let gate = Gate::new(rays, axes, area, params);
    // (z / 2 m)^2 in 2^-8: z^2 / 10^6, as a factor in Q32.
    let width = (W as u64).max(1);
    let near = (4_294_967_296 * 320 * 320 / (1_000_000 * width * width)).min(u64::from(u32::MAX));
    let step = gate.step();
    for (v, (line, labels)) in depth.iter().zip(labels.iter_mut()).enumerate() {
        labels.fill(0);
        let (columns, ray) = gate.row(rays, v);
        let first = columns.start;
        let (Some(line), Some(labels)) = (line.get(columns.clone()), labels.get_mut(columns)) else { continue };
        let mut up = ray.after(first, step).up();
        for (u, (&z, label)) in line.iter().zip(labels).enumerate() {
            if gate.stands(z, up)
                && let Some(cell) = gate.cell(ray.after(first + u, step).at(z).0)
                && let Some(count) = counts.get_mut(cell)
            {
                *label = 1;
                let unit = if cell < FAR_ROW * MAP_WIDTH { near } else { near / 2 };
                let weight = (u64::from(z) * u64::from(z) * unit + (1 << 31)) >> 32;
                *count = u32::from(*count).saturating_add(weight as u32).min(u32::from(u16::MAX)) as u16;
            }
            up = up.wrapping_add(step.up());
        }
    }
}

/// Gaussians are cut off at this squared Mahalanobis distance, Q20.
const CUT: i32 = 9 << 20;

/// exp(-q/2) for squared distances q up to the cut, in steps of 1/8, Q19.
static GAUSSIAN: [u32; 73] = {
    let mut table = [0; 73];
    let mut i = 0;
    while i < table.len() {
        table[i] = (exp_neg((i as u32) << 20) >> 12).div_ceil(2);
        i += 1;
    }
    table
};

/// What the kernels of a row's cells have in common.
struct Kernel {
    /// Variances in square cells along the ray and across it, Q16, 0.25 to 26.
    axial: u64,
    lateral: u64,
    /// Their inverses, Q24, at most 4.
    per_axial: i64,
    per_lateral: i64,
    /// 1 / (2 pi sqrt(axial lateral)), Q30, at most 0.64.
    peak: u64,
}

impl Kernel {
    /// Of a row; `lateral` is the lateral deviation in cells per distance in half cells, Q32.
    fn new(row: usize, params: &DensityParams, lateral: u64) -> Self {
        let y = 2 * row as u64 + 1;
        // Half a cell is added, so that a Gaussian sampled at the cells' centres keeps its sum.
        let variance = |deviation: u64| {
            let deviation = deviation.min(MAX_DEVIATION as u64);
            ((deviation * deviation) >> 16) + (1 << 14)
        };
        let axial = variance((u64::from(params.axial) * y * y) >> 24);
        let lateral = variance((lateral * y) >> 16);
        // 2^46 / (2 pi)
        const PER_TURN: u64 = 11_199_533_475_044;
        Self {
            axial,
            lateral,
            per_axial: ((1 << 40) / axial) as i64,
            per_lateral: ((1 << 40) / lateral) as i64,
            peak: PER_TURN / (axial * lateral).isqrt().max(1),
        }
    }
}

/// Spreads the counts into densities: in pixels (as if seen from 2 m) per cell, Q10, rounded to nearest with every kernel
/// that is added (about 0.002 pixels for a cell that 16 kernels reach), saturated at 63.999.
///
/// `focal` is the focal length in pixels of the images, Q16, for the lateral error.
pub fn spread(counts: &Map<u16>, params: &DensityParams, focal: i32, density: &mut Map<u16>) {
    density.as_flattened_mut().fill(0);
    let lateral = (u64::from(params.lateral) << 31) / u64::from(focal.max(1).unsigned_abs());
    for (row, line) in counts.iter().enumerate() {
        if line.iter().all(|count| *count == 0) {
            continue;
        }
        let kernel = Kernel::new(row, params, lateral);
        // To Q23 from 2^-8 or 2^-7 pixels times Q30. At most 326 pixels: below 2^32.
        let shift = if row < FAR_ROW { 15 } else { 14 };
        for (column, &count) in line.iter().enumerate() {
            if count != 0 {
                let peak = ((u64::from(count) * kernel.peak) >> shift) as u32;
                spread_cell(column, row, peak, &kernel, density);
            }
        }
    }
}

/// Adds the Gaussian of one cell with the height `peak`, Q23.
#[inline]
fn spread_cell(column: usize, row: usize, peak: u32, kernel: &Kernel, density: &mut Map<u16>) {
    let [x, y] = half_cells(column as u8, row as u8);
    let (xx, yy) = ((x * x) as u64, (y * y) as u64);
    // Below 2^18, so the shift is 45 at least; squared sine and cosine of the ray's angle in Q30.
    let (mantissa, shift) = reciprocal((xx + yy) as u32);
    let to_q30 = shift - 30;
    let sin2 = ((xx * u64::from(mantissa)) >> to_q30) as i64;
    let sin_cos = (i64::from(x * y) * i64::from(mantissa)) >> to_q30;
    let cos2 = (1 << 30) - sin2;
    // Sigma_P = R^T diag(lateral, axial) R and its inverse, Q20: entries of at most 4, the one beside the diagonal doubled.
    let ixx = ((cos2 * kernel.per_lateral + sin2 * kernel.per_axial) >> 34) as i32;
    let iyy = ((sin2 * kernel.per_lateral + cos2 * kernel.per_axial) >> 34) as i32;
    let ixy = ((sin_cos * (kernel.per_axial - kernel.per_lateral)) >> 33) as i32;
    let reach = |along: i64, across: i64| {
        let variance = (along as u64 * kernel.axial + across as u64 * kernel.lateral) >> 30;
        (((9 * variance) >> 16).min(255) as u8).isqrt()
    };
    let (reach_x, reach_y) = (usize::from(reach(sin2, cos2)), usize::from(reach(cos2, sin2)));
    let (left, right) = (column.saturating_sub(reach_x), (column + reach_x + 1).min(MAP_WIDTH));
    let dx = left as i32 - column as i32;
    for (r, line) in density.iter_mut().enumerate().take(row + reach_y + 1).skip(row.saturating_sub(reach_y)) {
        let dy = r as i32 - row as i32;
        // A form of eigenvalues of at most 4, up to 16 cells to the side and 15 ahead: below 2^31.
        let mut q = ixx * dx * dx + iyy * dy * dy + ixy * dx * dy;
        let mut difference = ixx * (2 * dx + 1) + ixy * dy;
        for cell in line.get_mut(left..right).unwrap_or(&mut []) {
            if q < CUT
                && let Some(weight) = GAUSSIAN.get(((q + (1 << 16)) >> 17) as usize)
            {
                let part = (u64::from(peak) * u64::from(*weight) + (1 << 31)) >> 32;
                *cell = u32::from(*cell).saturating_add(part as u32).min(u32::from(u16::MAX)) as u16;
            }
            q += difference;
            difference += 2 * ixx;
        }
    }
}

/// Marks the cells whose density reaches `threshold` (both in Q10) with 1, the others with 0.
pub fn occupied(density: &Map<u16>, threshold: u16, marks: &mut Map<u8>) {
    for (mark, value) in marks.as_flattened_mut().iter_mut().zip(density.as_flattened()) {
        *mark = if *value >= threshold { OCCUPIED } else { 0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ground::{self, density as float};
    use proptest::prelude::*;

    fn map<T: Copy>(value: T) -> Box<Map<T>> {
        vec![[value; MAP_WIDTH]; MAP_DEPTH].into_boxed_slice().try_into().ok().unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// One cell's kernel against the float stage's; where its table steps, the next step is as right.
        #[test]
        fn kernels_agree_with_the_float_ones(
            column in 0usize..MAP_WIDTH, row in 0usize..MAP_DEPTH, bandwidth in 0.0f32..4.0, focal in 140.0f32..600.0,
        ) {
            let params = ground::DensityParams { bandwidth, ..ground::DensityParams::DEFAULT };
            let (mut counts, mut truth) = (map(0.0), map(0.0));
            let (mut fixed_counts, mut density) = (map(0u16), map(0u16));
            counts[row][column] = 40.0;
            fixed_counts[row][column] = 40 << if row < FAR_ROW { 8 } else { 7 };
            float::spread(&counts, &params, focal, &float::Gaussian::new(), &mut truth);
            spread(&fixed_counts, &DensityParams::new(&params).unwrap(), (focal * 65_536.0) as i32, &mut density);
            let mut steps = 0;
            for (a, b) in density.as_flattened().iter().zip(truth.as_flattened()) {
                let error = (f32::from(*a) / 1024.0 - b).abs();
                steps += usize::from(error > 0.01 * b + 0.02);
                prop_assert!(error <= 0.07 * b + 0.02 || *b < 0.3, "{a} {b}");
            }
            // Kernels are symmetric: what meets a step of the table does so at several cells.
            prop_assert!(steps <= 8, "{steps}");
        }
    }

    #[test]
    fn saturated_counts_are_dense() {
        let mut density = map(0);
        for bandwidth in [0.0, 1.0, 4.0] {
            let params = ground::DensityParams { bandwidth, ..ground::DensityParams::DEFAULT };
            let params = DensityParams::new(&params).unwrap();
            for focal in [i32::MIN, 0, 1, i32::MAX] {
                spread(&map(u16::MAX), &params, focal, &mut density);
                // Beside the camera, few kernels meet.
                assert!(density.as_flattened().iter().all(|d| *d > 16 << 10), "{bandwidth} {focal}");
            }
        }
        let mut marks = map(0);
        occupied(&density, 16 << 10, &mut marks);
        assert!(marks.as_flattened().iter().all(|m| *m == 1));
    }

    #[test]
    fn kernels_that_reach_too_far_are_refused() {
        let good = ground::DensityParams::DEFAULT;
        let bad = [
            (ground::DensityParams { axial: 0.02, ..good }, "density: axial times bandwidth"),
            (ground::DensityParams { bandwidth: 8.0, ..good }, "density: axial times bandwidth"),
            (ground::DensityParams { lateral: 7.0, ..good }, "density: lateral times bandwidth"),
            (ground::DensityParams { threshold: 61.0, ..good }, "density: threshold"),
            (ground::DensityParams { min_height: f32::NAN, ..good }, "density: min_height"),
        ];
        for (params, name) in bad {
            assert_eq!(DensityParams::new(&params), Err(Error::OutOfRange(name)));
        }
    }
}
