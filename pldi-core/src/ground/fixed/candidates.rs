//! Clusters of pixels and their tests in fixed point.

use super::projection::{CELL_BITS, Point, Projection, cell_of};
use super::{CELL, Cluster, SensoryArea, cell_centre, length, occlusion};
use crate::fixed::{METRE, mul_q30, quantise, unit};
use crate::floor::fixed::FloorAxes;
use crate::ground::candidates::{cut, reject_occluded};
use crate::ground::{Contour, ContourPoint, Map, Rejection};
use crate::rays::fixed::Rays;
use crate::{Error, Image};

/// What a cluster must be like to be a candidate, see [`crate::ground::Limits`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Limits {
    /// Fewest pixels (of a QVGA image); below, it is noise.
    pub min_pixels: u32,
    /// Smallest and largest area of the footprint in 1/16 cells.
    pub area: (u32, u32),
    /// Smallest and largest length of the footprint's contour in 1/128 mm.
    pub length: (i32, i32),
    /// Smallest height above the floor in 1/128 mm.
    pub min_top: i32,
    /// Largest share of the contour's cells that may lie behind another cluster, Q16.
    pub max_occluded: u32,
    /// A cell counts as hidden where more than this share of the cluster's height is, Q16.
    pub hidden: u32,
    /// Pixels within so many columns or rows of the image's left, right or lower border make a cluster reach it.
    pub margin: u16,
}

impl Limits {
    /// The limits rounded to their units; at compile time in a `const`.
    ///
    /// # Errors
    /// `OutOfRange` with the parameter's name, for ranges as in [`crate::ground::Limits::validate`].
    pub const fn new(float: &crate::ground::Limits) -> Result<Self, Error> {
        const LENGTH: f64 = METRE as f64;
        // A cell is 4 square centimetres.
        const AREA: f64 = 16.0 / 0.0004;
        let (Some(least), Some(most)) =
            (quantise(float.area.0, 0.0, float.area.1, AREA), quantise(float.area.1, 0.0, 1e4, AREA))
        else {
            return Err(Error::OutOfRange("limits: area"));
        };
        let (Some(shortest), Some(longest)) =
            (quantise(float.length.0, 0.0, float.length.1, LENGTH), quantise(float.length.1, 0.0, 1e4, LENGTH))
        else {
            return Err(Error::OutOfRange("limits: length"));
        };
        let Some(min_top) = quantise(float.min_top, 0.0, 10.0, LENGTH) else {
            return Err(Error::OutOfRange("limits: min_top"));
        };
        let Some(max_occluded) = quantise(float.max_occluded, 0.0, 1.0, 65_536.0) else {
            return Err(Error::OutOfRange("limits: max_occluded"));
        };
        let Some(hidden) = quantise(float.hidden, 0.0, 1.0, 65_536.0) else {
            return Err(Error::OutOfRange("limits: hidden"));
        };
        Ok(Self {
            min_pixels: float.min_pixels,
            area: (least as u32, most as u32),
            length: (shortest as i32, longest as i32),
            min_top: min_top as i32,
            max_occluded: max_occluded as u32,
            hidden: hidden as u32,
            margin: float.margin,
        })
    }

    /// Checks numbers that were put together by hand.
    ///
    /// # Errors
    /// `OutOfRange` with the parameter's name, for ranges as in [`crate::ground::Limits::validate`].
    pub const fn validate(&self) -> Result<(), Error> {
        // 10,000 square metres in 1/16 cells; 10 km in 1/128 mm.
        if self.area.0 > self.area.1 || self.area.1 > 400_000_000 {
            return Err(Error::OutOfRange("limits: area"));
        }
        if self.length.0 < 0 || self.length.0 > self.length.1 || self.length.1 > 10_000 * METRE {
            return Err(Error::OutOfRange("limits: length"));
        }
        if self.min_top < 0 || self.min_top > 10 * METRE {
            return Err(Error::OutOfRange("limits: min_top"));
        }
        if self.max_occluded > 1 << 16 {
            return Err(Error::OutOfRange("limits: max_occluded"));
        }
        if self.hidden > 1 << 16 {
            return Err(Error::OutOfRange("limits: hidden"));
        }
        Ok(())
    }
}

/// Replaces the marks of [`super::density::project`] in `labels` by cluster numbers (1, 2, ..., 0 = none), and gathers each
/// cluster's pixels. `clusters` holds one entry per contour, `depth` is in 1/8 mm, and the other arguments are as there: every
/// pixel falls into the same cell.
///
/// This is the depth culling of the paper: a pixel is an object's when its projection falls within the contour of the
/// object's footprint and it is above the floor. Centroids and heights are less than 0.1 mm off up to 8 m.
pub fn gather<const W: usize, const H: usize>(
    depth: &Image<u16, W, H>,
    rays: &Rays<W, H>,
    axes: &FloorAxes,
    map_labels: &Map<u8>,
    labels: &mut Image<u8, W, H>,
    clusters: &mut [Cluster],
) {
    let map_labels = map_labels.as_flattened();
    gather_pixels(depth, rays, axes, labels, clusters, |point| {
        cell_of(point).and_then(|cell| map_labels.get(cell)).copied().unwrap_or(0)
    });
}

/// Gathers the pixels that are known to be one object, those with depth where `mask` holds (column, row), in the first of
/// `clusters` and under the label 1. For templates and benchmarks: no ground map.
pub fn gather_mask<const W: usize, const H: usize>(
    depth: &Image<u16, W, H>,
    rays: &Rays<W, H>,
    axes: &FloorAxes,
    mask: impl Fn(usize, usize) -> bool,
    labels: &mut Image<u8, W, H>,
    clusters: &mut [Cluster],
) {
    for (v, (line, labels)) in depth.iter().zip(labels.iter_mut()).enumerate() {
        for (u, (z, label)) in line.iter().zip(labels).enumerate() {
            *label = u8::from(*z != 0 && mask(u, v));
        }
    }
    gather_pixels(depth, rays, axes, labels, clusters, |_| 1);
}

/// Pixels that are looked at together.
const STRIDE: usize = 4;

/// Neighbours in a row with the same label.
#[derive(Clone, Copy)]
struct Run {
    label: u8,
    first: usize,
    end: usize,
    right: i64,
    forward: i64,
    top: i32,
}

impl Run {
    const fn new(label: u8, first: usize) -> Self {
        Self { label, first, end: first, right: 0, forward: 0, top: 0 }
    }

    /// Adds the run to its cluster; it is in row `v`.
    #[inline(never)]
    fn close(self, v: usize, clusters: &mut [Cluster]) {
        let Some(cluster) = usize::from(self.label).checked_sub(1).and_then(|i| clusters.get_mut(i)) else { return };
        cluster.pixels += (self.end - self.first) as u32;
        let [u0, v0, u1, v1] = cluster.bbox;
        cluster.bbox = [u0.min(self.first as u16), v0.min(v as u16), u1.max(self.end as u16 - 1), v1.max(v as u16)];
        add(&mut cluster.center, self.right);
        add(&mut cluster.size, self.forward);
        cluster.top = cluster.top.max(self.top);
    }
}

/// Adds to a sum of 64 bits. While pixels are gathered, the cluster's centre holds the sum of right, its size that of
/// forward: below 2^27 per pixel, so images of 2^32 pixels fit.
fn add(words: &mut [i32; 3], value: i64) {
    let sum = sum_of(*words).wrapping_add(value);
    (words[0], words[1]) = (sum as i32, (sum >> 32) as i32);
}

fn sum_of(words: [i32; 3]) -> i64 {
    (i64::from(words[1]) << 32) | i64::from(words[0] as u32)
}

/// Adds the pixels whose label is 1 to the cluster that `label_of` their point says, and labels them so.
#[inline(always)]
fn gather_pixels<const W: usize, const H: usize>(
    depth: &Image<u16, W, H>,
    rays: &Rays<W, H>,
    axes: &FloorAxes,
    labels: &mut Image<u8, W, H>,
    clusters: &mut [Cluster],
    label_of: impl Fn(Point) -> u8,
) {
    clusters.fill(Cluster::EMPTY);
    let projection = Projection::new(rays, axes);
    let step = projection.step();
    for (v, (line, labels)) in depth.iter().zip(labels.iter_mut()).enumerate() {
        let ray = projection.ray(rays, v);
        let mut run = Run::new(0, 0);
        for (k, (depths, labels)) in line.chunks(STRIDE).zip(labels.chunks_mut(STRIDE)).enumerate() {
            // Most pixels are nobody's: a word of them at once.
            if <&[u8; STRIDE]>::try_from(&*labels).is_ok_and(|word| u32::from_ne_bytes(*word) == 0) {
                continue;
            }
            for (i, (&z, label)) in depths.iter().zip(labels).enumerate() {
                if *label == 0 {
                    continue;
                }
                let u = STRIDE * k + i;
                let (point, up) = ray.after(u, step).at(z);
                *label = label_of(point);
                if *label != run.label || u != run.end {
                    run.close(v, clusters);
                    run = Run::new(*label, u);
                }
                run.end = u + 1;
                run.right += i64::from(point[0]);
                run.forward += i64::from(point[1]);
                run.top = run.top.max(axes.floor.height.wrapping_add(up));
            }
        }
        run.close(v, clusters);
    }
    for cluster in clusters {
        // A cell is 5/4 * 2^11 units of 1/128 mm.
        let divisor = i64::from(cluster.pixels.max(1)) << (CELL_BITS - 9);
        const { assert!(CELL == 5 << 9) };
        cluster.centroid = [cluster.center, cluster.size].map(|words| {
            let sum = 5 * sum_of(words);
            (sum + divisor / 2).div_euclid(divisor) as i32
        });
        (cluster.center, cluster.size) = ([0; 3], [0; 3]);
    }
}

/// Puts the box around each cluster (it stands on the floor and faces the sensor) and tests it.
#[allow(clippy::too_many_arguments, reason = "one call, from the pipeline")]
pub fn judge<const W: usize, const H: usize>(
    clusters: &mut [Cluster],
    contours: &[Contour],
    points: &[ContourPoint],
    labels: &Map<u8>,
    axes: &FloorAxes,
    area: &SensoryArea,
    limits: &Limits,
) {
    for (cluster, contour) in clusters.iter_mut().zip(contours) {
        measure(cluster, contour.of(points), axes);
        cluster.rejection = judge_alone::<W, H>(cluster, contour, contour.of(points), area, limits);
    }
    reject_occluded(clusters, contours, |i, clusters, contour| {
        let (sensor, all) = (axes.floor.height, u64::from(contour.points));
        let hidden = occlusion::occluded_points(i, clusters, contours, points, labels, sensor, limits.hidden);
        (hidden as u64) << 16 > u64::from(limits.max_occluded) * all
    });
}

/// The box around a cluster, from its footprint and its height.
fn measure(cluster: &mut Cluster, contour: &[ContourPoint], axes: &FloorAxes) {
    let [x, y] = cluster.centroid.map(i64::from);
    let [sin, cos, _] = unit([x, y, 0]).unwrap_or([0; 3]);
    let (mut low, mut high) = ([i32::MAX; 2], [i32::MIN; 2]);
    for point in contour {
        let [x, y] = cell_centre(point.column, point.row);
        let across = [mul_q30(x, cos) - mul_q30(y, sin), mul_q30(x, sin) + mul_q30(y, cos)];
        for k in 0..2 {
            low[k] = low[k].min(across[k]);
            high[k] = high[k].max(across[k]);
        }
    }
    if contour.is_empty() {
        return;
    }
    let (a, b) = ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2);
    let (right, forward) = (mul_q30(a, cos) + mul_q30(b, sin), mul_q30(b, cos) - mul_q30(a, sin));
    cluster.center = axes.to_camera([right, forward, cluster.top / 2]);
    cluster.size = [high[0] - low[0] + CELL, cluster.top, high[1] - low[1] + CELL];
}

/// The tests that need no other cluster.
fn judge_alone<const W: usize, const H: usize>(
    cluster: &Cluster,
    contour: &Contour,
    points: &[ContourPoint],
    area: &SensoryArea,
    limits: &Limits,
) -> Option<Rejection> {
    let (ground, length) = (contour.cells.saturating_mul(16), length(contour));
    Rejection::first(
        // Pixels as many as a QVGA image would have.
        u64::from(cluster.pixels) * 320 * 320 < u64::from(limits.min_pixels) * (W * W) as u64,
        || cut::<W, H>(cluster.bbox, limits.margin) || points.iter().any(|p| area.at_border(p.column, p.row)),
        ground < limits.area.0 || length < limits.length.0 || cluster.top < limits.min_top,
        ground > limits.area.1 || length > limits.length.1,
    )
}

#[cfg(test)]
mod tests;
