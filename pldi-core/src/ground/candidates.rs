//! Clusters of pixels on the floor, and the tests that make a candidate of a cluster (paper, section 4).

use super::density::NO_CELL;
use super::{CELL, Contour, ContourPoint, MAP_WIDTH, Map, SensoryArea, cell_centre, occlusion};
use crate::{Error, FloorAxes, Image, Rays, math};

/// Why a cluster is no candidate. The first reason that holds, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Rejection {
    /// Too few pixels to be a surface.
    Noise,
    /// It reaches the border of the sensory area or of the image: only a part of it is seen.
    AtBorder,
    /// Its footprint or height is below the limits.
    TooSmall,
    /// Its footprint is above the limits.
    TooLarge,
    /// Another cluster stands in front of it.
    Occluded,
}

impl Rejection {
    /// The name used in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Noise => "noise",
            Self::AtBorder => "at border",
            Self::TooSmall => "too small",
            Self::TooLarge => "too large",
            Self::Occluded => "occluded",
        }
    }

    /// The first reason that holds, of those that need no other cluster.
    pub(super) fn first(
        noise: bool,
        at_border: impl FnOnce() -> bool,
        too_small: bool,
        too_large: bool,
    ) -> Option<Self> {
        if noise {
            Some(Self::Noise)
        } else if at_border() {
            Some(Self::AtBorder)
        } else if too_small {
            Some(Self::TooSmall)
        } else {
            too_large.then_some(Self::TooLarge)
        }
    }
}

/// What a cluster must be like to be a candidate.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Limits {
    /// Fewest pixels (of a QVGA image); below, it is noise. Default 60.
    pub min_pixels: u32,
    /// Smallest and largest area of the footprint in m^2. Default 0.01 to 6.
    pub area: (f32, f32),
    /// Smallest and largest length of the footprint's contour in m. Default 0.3 to 24.
    pub length: (f32, f32),
    /// Smallest height above the floor in m. Default 0.15.
    pub min_top: f32,
    /// Largest share (0..1) of the contour's cells that may lie behind another cluster. Default 0.1.
    pub max_occluded: f32,
    /// A cell counts as hidden where more than this share of the cluster's height is, 0..1. Default 0.25.
    pub hidden: f32,
    /// Pixels within so many columns or rows of the image's left, right or lower border make a cluster reach it. Default 2.
    pub margin: u16,
}

impl Limits {
    /// For furniture.
    pub const DEFAULT: Self = Self {
        min_pixels: 60,
        area: (0.01, 6.0),
        length: (0.3, 24.0),
        min_top: 0.15,
        max_occluded: 0.1,
        hidden: 0.25,
        margin: 2,
    };

    /// Checks every number against its stated range.
    ///
    /// # Errors
    /// `OutOfRange` with the parameter's name.
    pub fn validate(&self) -> Result<(), Error> {
        use crate::error::within;
        within("limits: area", self.area.0, 0.0, self.area.1)?;
        within("limits: area", self.area.1, 0.0, 1e4)?;
        within("limits: length", self.length.0, 0.0, self.length.1)?;
        within("limits: length", self.length.1, 0.0, 1e4)?;
        within("limits: min_top", self.min_top, 0.0, 10.0)?;
        within("limits: max_occluded", self.max_occluded, 0.0, 1.0)?;
        within("limits: hidden", self.hidden, 0.0, 1.0)
    }
}

/// What lengths are measured in: metres (`f32`) or 1/128 mm (`i32`).
pub trait Length: Copy {
    /// No length.
    const ZERO: Self;
}

impl Length for f32 {
    const ZERO: Self = 0.0;
}

impl Length for i32 {
    const ZERO: Self = 0;
}

/// A cluster: the pixels whose floor projection lies within one contour. Lengths in metres; in the fixed-point stages
/// in 1/128 mm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Cluster<T = f32> {
    /// Number of pixels.
    pub pixels: u32,
    /// First column, first row, last column, last row of its pixels.
    pub bbox: [u16; 4],
    /// Mean of its points on the floor: right and forward.
    pub centroid: [T; 2],
    /// Height of its highest point above the floor.
    pub top: T,
    /// Centre of the box around it in the camera frame. The box stands on the floor and faces the sensor.
    pub center: [T; 3],
    /// Width (across the line of sight), height and depth (along it) of that box.
    pub size: [T; 3],
    /// Why it is no candidate; `None` for candidates.
    pub rejection: Option<Rejection>,
}

impl<T: Length> Cluster<T> {
    /// A cluster without pixels.
    pub const EMPTY: Self = Self {
        pixels: 0,
        bbox: [u16::MAX, u16::MAX, 0, 0],
        centroid: [T::ZERO; 2],
        top: T::ZERO,
        center: [T::ZERO; 3],
        size: [T::ZERO; 3],
        rejection: None,
    };

    /// Whether it was rejected as noise.
    pub fn is_noise(&self) -> bool {
        self.rejection == Some(Rejection::Noise)
    }
}

/// Turns the image of cell numbers into the image of cluster numbers (1, 2, ..., 0 = none), and gathers each
/// cluster's pixels. `clusters` holds one entry per contour.
///
/// This is the depth culling of the paper: a pixel is an object's when its projection falls within the contour of the
/// object's footprint and it is above the floor (pixels of the floor have no cell).
pub fn gather<const W: usize, const H: usize>(
    cells: &mut Image<u16, W, H>,
    labels: &Map<u8>,
    depth: &Image<f32, W, H>,
    rays: &Rays<W, H>,
    axes: &FloorAxes,
    clusters: &mut [Cluster],
) {
    clusters.fill(Cluster::EMPTY);
    let labels = labels.as_flattened();
    for (v, (line, depths)) in cells.iter_mut().zip(depth).enumerate() {
        for (u, (cell, &z)) in line.iter_mut().zip(depths).enumerate() {
            let label =
                if *cell == NO_CELL { 0 } else { labels.get(usize::from(*cell)).map_or(0, |l| usize::from(*l)) };
            *cell = label as u16;
            let Some(cluster) = label.checked_sub(1).and_then(|i| clusters.get_mut(i)) else { continue };
            let [right, forward, height] = axes.to_floor(rays.point(u, v, z));
            let (u, v) = (u as u16, v as u16);
            cluster.pixels += 1;
            let [u0, v0, u1, v1] = cluster.bbox;
            cluster.bbox = [u0.min(u), v0.min(v), u1.max(u), v1.max(v)];
            cluster.centroid[0] += right;
            cluster.centroid[1] += forward;
            cluster.top = cluster.top.max(height);
        }
    }
    for cluster in clusters {
        let scale = 1.0 / cluster.pixels.max(1) as f32;
        cluster.centroid = cluster.centroid.map(|v| v * scale);
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
        let share = occlusion::occluded_share(i, clusters, contour, points, labels, axes.floor.height, limits.hidden);
        share > limits.max_occluded
    });
}

/// Rejects the clusters left by the tests that need no other cluster, where `occluded` says so.
pub(super) fn reject_occluded<T>(
    clusters: &mut [Cluster<T>],
    contours: &[Contour],
    occluded: impl Fn(usize, &[Cluster<T>], &Contour) -> bool,
) {
    for (i, contour) in contours.iter().enumerate().take(clusters.len()) {
        if clusters[i].rejection.is_none() && occluded(i, clusters, contour) {
            clusters[i].rejection = Some(Rejection::Occluded);
        }
    }
}

/// Whether an object is cut by the image's left, right or lower border (or reaches their margin). The upper border cuts
/// whatever is taller than the view; templates are cut there as well.
pub(super) fn cut<const W: usize, const H: usize>(bbox: [u16; 4], margin: u16) -> bool {
    let ([u0, _, u1, v1], margin) = (bbox.map(usize::from), usize::from(margin));
    u0 < margin || u1 + margin >= W || v1 + margin >= H
}

/// The box around a cluster, from its footprint and its height.
fn measure(cluster: &mut Cluster, contour: &[ContourPoint], axes: &FloorAxes) {
    let [x, y] = cluster.centroid;
    let length = math::sqrt(x * x + y * y).max(1e-6);
    let along = [x / length, y / length];
    let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
    for point in contour {
        let [x, y] = cell_centre(usize::from(point.column), usize::from(point.row));
        let across = [x * along[1] - y * along[0], x * along[0] + y * along[1]];
        for k in 0..2 {
            low[k] = low[k].min(across[k]);
            high[k] = high[k].max(across[k]);
        }
    }
    if contour.is_empty() {
        return;
    }
    let (a, b) = (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]));
    let (right, forward) = (a * along[1] + b * along[0], b * along[1] - a * along[0]);
    cluster.center = axes.to_camera([right, forward, 0.5 * cluster.top]);
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
    // Pixels as many as a QVGA image would have.
    let qvga = cluster.pixels as f32 * (320.0 * 320.0 / (W * W) as f32);
    let (ground, length) = (contour.area(), contour.length());
    Rejection::first(
        qvga < limits.min_pixels as f32,
        || {
            cut::<W, H>(cluster.bbox, limits.margin)
                || points.iter().any(|p| area.at_border(usize::from(p.column), usize::from(p.row)))
        },
        ground < limits.area.0 || length < limits.length.0 || cluster.top < limits.min_top,
        ground > limits.area.1 || length > limits.length.1,
    )
}

const _: () = assert!(MAP_WIDTH <= u16::MAX as usize);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Floor, Intrinsics};

    fn setting() -> (FloorAxes, SensoryArea) {
        let floor = Floor::from_pose(1.0, 0.0, 0.0).unwrap();
        (floor.axes(), SensoryArea::new(&super::super::AreaParams::DEFAULT, &Intrinsics::KINECT_QVGA, &floor))
    }

    fn contour_of(points: &[ContourPoint], cells: u32, straight: u16) -> Contour {
        Contour { start: 0, points: points.len() as u16, cells, straight, diagonal: 0 }
    }

    fn judged(cluster: Cluster, row: u8, cells: u32) -> Option<Rejection> {
        let points = [ContourPoint { column: 128, row }];
        let steps = 4 * cells.isqrt() as u16;
        judge_alone::<320, 240>(&cluster, &contour_of(&points, cells, steps), &points, &setting().1, &Limits::DEFAULT)
    }

    const GOOD: Cluster = Cluster { pixels: 900, bbox: [100, 50, 140, 120], top: 0.7, ..Cluster::EMPTY };

    #[test]
    fn each_test_has_its_reason() {
        assert_eq!(judged(GOOD, 100, 400), None);
        assert_eq!(judged(Cluster { pixels: 59, ..GOOD }, 100, 400), Some(Rejection::Noise));
        assert_eq!(judged(GOOD, 199, 400), Some(Rejection::AtBorder));
        assert_eq!(judged(Cluster { bbox: [1, 50, 140, 120], ..GOOD }, 100, 400), Some(Rejection::AtBorder));
        assert_eq!(judged(Cluster { bbox: [9, 50, 140, 239], ..GOOD }, 100, 400), Some(Rejection::AtBorder));
        assert_eq!(judged(Cluster { bbox: [9, 0, 140, 120], ..GOOD }, 100, 400), None);
        assert_eq!(judged(GOOD, 100, 10), Some(Rejection::TooSmall));
        assert_eq!(judged(Cluster { top: 0.1, ..GOOD }, 100, 400), Some(Rejection::TooSmall));
        assert_eq!(judged(GOOD, 100, 20_000), Some(Rejection::TooLarge));
    }

    #[test]
    fn the_box_faces_the_sensor_and_stands_on_the_floor() {
        let (axes, _) = setting();
        let mut cluster = Cluster { centroid: [0.0, 2.0], top: 0.8, ..GOOD };
        // Cells 118..=137 and 95..=104: 40 cm by 20 cm around (0, 2).
        let corners = [(118, 95), (137, 95), (137, 104), (118, 104)];
        let points = corners.map(|(column, row)| ContourPoint { column, row });
        measure(&mut cluster, &points, &axes);
        for (got, want) in cluster.size.iter().zip([0.4, 0.8, 0.2]) {
            assert!((got - want).abs() < 1e-5, "{:?}", cluster.size);
        }
        for (got, want) in cluster.center.iter().zip([0.0, 0.6, 2.0]) {
            assert!((got - want).abs() < 1e-5, "{:?}", cluster.center);
        }
    }
}
