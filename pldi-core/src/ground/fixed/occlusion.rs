//! Which candidates stand behind others, in fixed point.

use super::{CELL, Cluster, half_cells};
use crate::fixed::reciprocal;
use crate::ground::{Contour, ContourPoint, MAP_WIDTH, Map};

/// How many of a cluster's contour cells have rays from the sensor that pass over another cluster which hides the
/// cluster there, see [`crate::ground::occlusion::occluded_share`].
///
/// `sensor` is the camera's height in 1/128 mm, `hidden` the share in Q16. Rays are followed in steps of one cell, at most
/// 0.005 cells off at their end.
///
/// `contours` are those of the clusters, in the same order.
pub fn occluded_points(
    index: usize,
    clusters: &[Cluster],
    contours: &[Contour],
    points: &[ContourPoint],
    labels: &Map<u8>,
    sensor: i32,
    hidden: u32,
) -> usize {
    let (Some(own), Some(contour)) = (clusters.get(index), contours.get(index)) else { return 0 };
    let others = clusters.iter().zip(contours).enumerate().filter(|(i, (other, _))| *i != index && !other.is_noise());
    // Before that row, no ray meets another cluster.
    let Some(nearest) = others.flat_map(|(_, (_, contour))| contour.of(points)).map(|point| point.row).min() else {
        return 0;
    };
    let labels = labels.as_flattened();
    // Times distances in cells (below 2^8) in Q8, heights below 2^31 stay below 2^48.
    let (sensor, own) = (i64::from(sensor), (i64::from(own.top) * i64::from(hidden)) >> 16);
    contour
        .of(points)
        .iter()
        .filter(|point| {
            let [x, y] = half_cells(point.column, point.row);
            // In half cells, Q7: squares below 2^17.9, so 14 bits more fit.
            let distance = (((x * x + y * y) as u32) << 14).isqrt();
            let (mantissa, shift) = reciprocal(distance);
            // One step per cell, along the ray from the sensor to just before the cell itself: in cells, Q20. The distance is
            // at least 1, so the shift is at least 39.
            let along = |v: i32| ((i64::from(v) * i64::from(mantissa)) >> (shift - 27)) as i32;
            let (dx, dy) = (along(x), along(y));
            // In whole cells; the distance is in cells, Q8.
            let (steps, distance) = (distance >> 8, i64::from(distance));
            let first = (u32::from(nearest) << 20).div_ceil(dy.max(1).unsigned_abs()).clamp(1, steps.max(1));
            // Below 2^8 steps of 2^20 at most.
            let passed = first as i32 - 1;
            let (mut column, mut row) = (((MAP_WIDTH as i32 / 2) << 20) + dx * passed, dy * passed);
            (first..steps).any(|i| {
                column += dx;
                row += dy;
                let cell = (row >> 20) as usize * MAP_WIDTH + (column >> 20) as usize;
                let label = usize::from(labels.get(cell).copied().unwrap_or(0));
                if label == 0 || label == index + 1 {
                    return false;
                }
                let Some(other) = clusters.get(label - 1) else { return false };
                if other.is_noise() {
                    return false;
                }
                // The line over the other's top at its distance i, continued to the cell's distance; all times i.
                let (top, i) = (i64::from(other.top), i64::from(i));
                let line = ((sensor * i) << 8) - (sensor - top) * distance;
                top >= sensor || line > (own * i) << 8
            })
        })
        .count()
}

/// The distance up to which something of height `top` hides what stands behind it at `distance`, all heights above the
/// floor, for a sensor at height `sensor`: where the line over its top meets the floor. All in 1/128 mm, rounded down;
/// `i32::MAX` where there is no end.
pub fn shadow_end(top: i32, distance: i32, sensor: i32) -> i32 {
    let below = i64::from(sensor) - i64::from(top);
    if below <= 0 {
        return i32::MAX;
    }
    let end = (i64::from(distance) * i64::from(sensor) / below).max(i64::from(distance) + i64::from(CELL));
    i32::try_from(end).unwrap_or(i32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ground::{self, MAP_DEPTH, occlusion};

    /// Two blocks of 10 x 10 cells straight ahead, one behind the other (or beside it by `offset` cells): the shares in
    /// both arithmetics.
    fn shares(tops: [f32; 2], offset: usize, sensor: f32) -> [(f32, f32); 2] {
        let mut labels: Box<Map<u8>> = vec![[0; MAP_WIDTH]; MAP_DEPTH].into_boxed_slice().try_into().unwrap();
        let mut points = Vec::new();
        for (label, column, row) in [(1, 123, 80), (2, 123 + offset, 120)] {
            for r in row..row + 10 {
                for c in column..column + 10 {
                    labels[r][c] = label;
                    points.push(ContourPoint { column: c as u8, row: r as u8 });
                }
            }
        }
        let contour = |start| Contour { start, points: 100, cells: 100, straight: 40, diagonal: 0 };
        let float = tops.map(|top| ground::Cluster { top, ..ground::Cluster::EMPTY });
        let units = |v: f32| (v * 128_000.0) as i32;
        let fixed = tops.map(|top| Cluster { top: units(top), ..Cluster::EMPTY });
        [0, 1].map(|i| {
            let contours = [contour(0), contour(100)];
            (
                occlusion::occluded_share(i, &float, &contours[i], &points, &labels, sensor, 0.25),
                occluded_points(i, &fixed, &contours, &points, &labels, units(sensor), 1 << 14) as f32 / 100.0,
            )
        })
    }

    #[test]
    fn shares_agree_with_the_float_ones() {
        for offset in [0, 3, 7, 11, 60] {
            for tops in [[1.5, 1.0], [0.3, 1.0], [0.9, 0.6], [0.7, 1.1], [0.5, 0.2]] {
                for (float, fixed) in shares(tops, offset, 1.2) {
                    assert!((float - fixed).abs() < 0.011, "{offset} {tops:?}: {float} {fixed}");
                }
            }
        }
        assert_eq!(shares([1.5, 1.0], 0, 1.2)[1].1, 1.0);
    }

    #[test]
    fn shadows_end_on_the_floor() {
        assert!((shadow_end(38_400, 230_400, 153_600) - 307_200).abs() <= 1);
        assert_eq!(shadow_end(200_000, 230_400, 153_600), i32::MAX);
        assert_eq!(shadow_end(i32::MIN, i32::MAX, i32::MAX), i32::MAX);
        assert_eq!(shadow_end(0, 0, 1), CELL);
    }
}
