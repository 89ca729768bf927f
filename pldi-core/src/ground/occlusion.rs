//! Which candidates stand behind others (paper, section 4): rays from the sensor through image L.

use super::{CELL, Cluster, Contour, ContourPoint, MAP_WIDTH, Map};
use crate::math;

/// The share (0..=1) of a cluster's contour cells whose rays from the sensor pass over another cluster that hides the
/// cluster there.
///
/// A cluster in front hides what lies below the line from the sensor over its top: the ray counts where that line
/// arrives higher than `hidden` times the cluster's own height. Clusters that were rejected as noise hide nothing.
/// `labels` holds the number of the cluster (from 1) of each cell of the map; `sensor` is the camera's height in metres.
pub fn occluded_share(
    index: usize,
    clusters: &[Cluster],
    contour: &Contour,
    points: &[ContourPoint],
    labels: &Map<u8>,
    sensor: f32,
    hidden: f32,
) -> f32 {
    let Some(own) = clusters.get(index) else { return 0.0 };
    let points = contour.of(points);
    let blocked = points.iter().filter(|point| {
        let (x, y) = (f32::from(point.column) + 0.5 - MAP_WIDTH as f32 / 2.0, f32::from(point.row) + 0.5);
        let distance = math::sqrt(x * x + y * y);
        // One step per cell, along the ray from the sensor to just before the cell itself.
        let steps = math::floor(distance);
        (1..steps).any(|i| {
            let t = i as f32 / distance;
            let column = math::floor(x * t + MAP_WIDTH as f32 / 2.0);
            let row = math::floor(y * t);
            let label =
                labels.get(row as usize).and_then(|line| line.get(column as usize)).map_or(0, |l| usize::from(*l));
            if label == 0 || label == index + 1 {
                return false;
            }
            let Some(other) = clusters.get(label - 1) else { return false };
            if other.is_noise() {
                return false;
            }
            // The line over the other's top at its distance i, continued to the cell's distance.
            let line = sensor - (sensor - other.top) * distance / i as f32;
            other.top >= sensor || line > hidden * own.top
        })
    });
    blocked.count() as f32 / points.len().max(1) as f32
}

/// The distance (metres) up to which something of height `top` hides what stands behind it at `distance`, all heights
/// above the floor, for a sensor at height `sensor`: where the line over its top meets the floor.
pub fn shadow_end(top: f32, distance: f32, sensor: f32) -> f32 {
    if top >= sensor { f32::INFINITY } else { (distance * sensor / (sensor - top)).max(distance + CELL) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ground::MAP_DEPTH;

    /// Two blocks of 10 x 10 cells straight ahead, one behind the other (or beside it by `offset` cells).
    fn share(front_top: f32, back_top: f32, offset: usize, sensor: f32) -> [f32; 2] {
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
        let clusters = [Cluster { top: front_top, ..Cluster::EMPTY }, Cluster { top: back_top, ..Cluster::EMPTY }];
        [0, 1].map(|i| occluded_share(i, &clusters, &contour(100 * i as u16), &points, &labels, sensor, 0.25))
    }

    #[test]
    fn what_stands_in_front_hides_what_is_behind() {
        assert_eq!(share(1.5, 1.0, 0, 1.2), [0.0, 1.0]);
        assert_eq!(share(1.5, 1.0, 60, 1.2), [0.0, 0.0]);
        let [front, back] = share(1.5, 1.0, 7, 1.2);
        assert!(front == 0.0 && (0.2..0.9).contains(&back), "{back}");
    }

    #[test]
    fn a_low_thing_hides_only_what_is_low_and_near() {
        // The line over 0.3 m at 1.8 m from 1.2 m arrives at 2.5 m at a height of -0.05 m.
        assert_eq!(share(0.3, 1.0, 0, 1.2)[1], 0.0);
        assert_eq!(share(0.9, 0.6, 0, 1.2)[1], 1.0);
        assert!((shadow_end(0.3, 1.8, 1.2) - 2.4).abs() < 1e-5);
        assert!(shadow_end(1.3, 1.8, 1.2).is_infinite());
    }
}
