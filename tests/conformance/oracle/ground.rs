//! The truth of the ground map and its clusters, in float64: regions by flooding instead of following borders, lengths by
//! counting squares of four cells.

use super::geometry::Pose;
use super::image::point;
use pldi_core::Intrinsics;
use pldi_core::ground::Rejection;

/// Columns of the map.
pub const COLUMNS: usize = 256;
/// Rows of the map.
pub const ROWS: usize = 208;
/// Side of a cell in metres.
const CELL: f64 = 0.02;

/// The sensory area: forward distances and the outermost rays of a level camera on the floor.
#[derive(Debug, Clone, Copy)]
pub struct Area {
    left: f64,
    right: f64,
}

impl Area {
    /// For a camera in a pose.
    pub fn new(camera: &Intrinsics, pose: &Pose) -> Self {
        let side = |u: f64| (u - f64::from(camera.cx)) / f64::from(camera.fx) / pose.horizontal();
        let widest = libm::tan(1.5);
        Self { left: side(0.0).max(-widest), right: side(f64::from(camera.width) - 1.0).min(widest) }
    }

    fn contains(&self, right: f64, forward: f64) -> bool {
        (0.5..=4.0).contains(&forward) && (self.left * forward..=self.right * forward).contains(&right)
    }
}

/// The cell that a pixel's point falls into, if it is above the floor and in the area.
pub fn cell(camera: &Intrinsics, pose: &Pose, area: &Area, (u, v): (usize, usize), z: f64) -> Option<usize> {
    let [right, forward, up] = pose.to_floor(point(camera, u, v, z));
    let inside = z > 0.0 && (0.02 + 0.004 * z * z..=2.2).contains(&up) && area.contains(right, forward);
    let (column, row) = (libm::floor(right / CELL) as i64 + 128, libm::floor(forward / CELL) as i64);
    let inside = inside && (0..COLUMNS as i64).contains(&column) && (0..ROWS as i64).contains(&row);
    inside.then(|| row as usize * COLUMNS + column as usize)
}

/// The centre of a cell (right, forward) in cells.
fn centre(i: usize) -> [f64; 2] {
    [(i % COLUMNS) as f64 + 0.5 - 128.0, (i / COLUMNS) as f64 + 0.5]
}

/// The density of some counts, by the Gaussian itself.
pub fn spread(counts: &[f64], focal: f64) -> Vec<f64> {
    let mut density = vec![0.0; COLUMNS * ROWS];
    for (i, count) in counts.iter().enumerate().filter(|(_, count)| **count > 0.0) {
        let (column, row) = (i % COLUMNS, i / COLUMNS);
        let [x, y] = centre(i);
        // Variances along and across the ray, in square cells; a quarter for the cells themselves.
        let along = libm::pow(1.425e-3 * y * y * CELL, 2.0) + 0.25;
        let across = libm::pow(0.8 * y / focal, 2.0) + 0.25;
        let length = (x * x + y * y).sqrt();
        let peak = count / (core::f64::consts::TAU * (along * across).sqrt());
        for r in row.saturating_sub(12)..(row + 13).min(ROWS) {
            for c in column.saturating_sub(12)..(column + 13).min(COLUMNS) {
                let (dx, dy) = (c as f64 - column as f64, r as f64 - row as f64);
                let (a, b) = ((dx * x + dy * y) / length, (dx * y - dy * x) / length);
                let q = a * a / along + b * b / across;
                if q < 9.0 {
                    density[r * COLUMNS + c] += peak * libm::exp(-0.5 * q);
                }
            }
        }
    }
    density
}

/// The region of each cell, from 1, 0 for none, and the number of regions: 8-connected occupied cells with all that they
/// enclose, which is all that 4-connected empty cells do not reach from outside.
fn regions(density: &[f64]) -> (Vec<usize>, usize) {
    // With an empty cell all round.
    let width = COLUMNS + 2;
    let inner = |c: usize, r: usize| (1..=COLUMNS).contains(&c) && (1..=ROWS).contains(&r);
    let full = |i: usize| {
        let (c, r) = (i % width, i / width);
        inner(c, r) && density[(r - 1) * COLUMNS + c - 1] >= 1.0
    };
    let cells = width * (ROWS + 2);
    let flood = |from: usize, mark: usize, marks: &mut [usize], steps: &[[i64; 2]], free: &dyn Fn(usize) -> bool| {
        let mut open = vec![from];
        marks[from] = mark;
        while let Some(i) = open.pop() {
            for [dx, dy] in steps {
                let (c, r) = ((i % width) as i64 + dx, (i / width) as i64 + dy);
                if (0..width as i64).contains(&c) && (0..ROWS as i64 + 2).contains(&r) {
                    let there = r as usize * width + c as usize;
                    if marks[there] == 0 && free(there) {
                        marks[there] = mark;
                        open.push(there);
                    }
                }
            }
        }
    };
    let four = [[1, 0], [-1, 0], [0, 1], [0, -1]];
    let eight = [[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [1, -1], [-1, 1], [-1, -1]];
    let outside = usize::MAX;
    let mut marks = vec![0; cells];
    flood(0, outside, &mut marks, &four, &|i| !full(i));
    let mut count = 0;
    for i in 0..cells {
        if marks[i] == 0 {
            count += 1;
            flood(i, count, &mut marks, &eight, &|_| true);
        }
    }
    let mark = |i: usize| marks[(i / COLUMNS + 1) * width + i % COLUMNS + 1];
    ((0..COLUMNS * ROWS).map(mark).map(|m| if m == outside { 0 } else { m }).collect(), count)
}

/// A cluster.
#[derive(Debug, Clone)]
pub struct Cluster {
    /// Its pixels' number.
    pub pixels: u32,
    bbox: [usize; 4],
    /// Mean of its points on the floor, in metres.
    pub centroid: [f64; 2],
    /// Its greatest height in metres.
    pub top: f64,
    /// Extent across and along the line of sight in metres.
    pub size: [f64; 2],
    /// Why it is no candidate.
    pub rejection: Option<Rejection>,
}

/// The number of the cluster of each pixel, from 1, 0 for none; and the clusters.
pub fn clusters(depth: &[f64], camera: &Intrinsics, pose: &Pose) -> (Vec<u16>, Vec<Cluster>) {
    let (w, h) = (usize::from(camera.width), usize::from(camera.height));
    let area = Area::new(camera, pose);
    let cells: Vec<_> = (0..w * h).map(|i| cell(camera, pose, &area, (i % w, i / w), depth[i])).collect();
    let mut counts = vec![0.0; COLUMNS * ROWS];
    for (cell, z) in cells.iter().zip(depth) {
        if let Some(cell) = cell {
            counts[*cell] += z * z / 4.0;
        }
    }
    let (map, count) = regions(&spread(&counts, f64::from(camera.fx)));
    let none = Cluster { pixels: 0, bbox: [w, h, 0, 0], centroid: [0.0; 2], top: 0.0, size: [0.0; 2], rejection: None };
    let mut clusters = vec![none; count];
    let labels: Vec<u16> = cells.iter().map(|cell| cell.map_or(0, |cell| map[cell] as u16)).collect();
    for (i, label) in labels.iter().enumerate().filter(|(_, label)| **label > 0) {
        let cluster = &mut clusters[usize::from(*label) - 1];
        let [right, forward, up] = pose.to_floor(point(camera, i % w, i / w, depth[i]));
        let [a, b, c, d] = cluster.bbox;
        cluster.bbox = [a.min(i % w), b.min(i / w), c.max(i % w), d.max(i / w)];
        cluster.pixels += 1;
        cluster.centroid = [cluster.centroid[0] + right, cluster.centroid[1] + forward];
        cluster.top = cluster.top.max(up);
    }
    for cluster in &mut clusters {
        cluster.centroid = cluster.centroid.map(|v| v / f64::from(cluster.pixels.max(1)));
    }
    judge(&mut clusters, &map, &area, (w, h), pose.height);
    (labels, clusters)
}

/// Puts the box around each cluster and finds the first reason against it.
fn judge(clusters: &mut [Cluster], map: &[usize], area: &Area, (w, h): (usize, usize), sensor: f64) {
    for (i, cluster) in clusters.iter_mut().enumerate() {
        let cells: Vec<usize> = (0..map.len()).filter(|c| map[*c] == i + 1).collect();
        let [x, y] = cluster.centroid;
        let length = (x * x + y * y).sqrt().max(1e-6);
        for (k, direction) in [[y, -x], [x, y]].into_iter().enumerate() {
            let along = cells.iter().map(|c| {
                let p = centre(*c);
                (p[0] * direction[0] + p[1] * direction[1]) * CELL / length
            });
            let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
            cluster.size[k] = high - low + CELL;
        }
        let [left, _, right, lower] = cluster.bbox;
        let cut = left < 2 || right + 2 >= w || lower + 2 >= h;
        let footprint = cells.len() as f64 * CELL * CELL;
        let around = contour_length(&cells, map, i + 1);
        cluster.rejection = if cluster.pixels < 60 {
            Some(Rejection::Noise)
        } else if cut || cells.iter().any(|c| touches(*c, area)) {
            Some(Rejection::AtBorder)
        } else if footprint < 0.01 || around < 0.3 || cluster.top < 0.15 {
            Some(Rejection::TooSmall)
        } else if footprint > 6.0 || around > 24.0 {
            Some(Rejection::TooLarge)
        } else {
            None
        };
    }
    let hidden: Vec<f64> = (0..clusters.len()).map(|i| occluded(i, clusters, map, sensor)).collect();
    for (cluster, hidden) in clusters.iter_mut().zip(hidden) {
        if cluster.rejection.is_none() && hidden > 0.1 {
            cluster.rejection = Some(Rejection::Occluded);
        }
    }
}

/// Whether a cell or one of its four neighbours lies outside of the area or of the map.
fn touches(cell: usize, area: &Area) -> bool {
    let [x, y] = centre(cell).map(|v| v * CELL);
    let beside = [[CELL, 0.0], [-CELL, 0.0], [0.0, CELL], [0.0, -CELL]];
    let column = cell % COLUMNS;
    column == 0 || column == COLUMNS - 1 || beside.iter().any(|[dx, dy]| !area.contains(x + dx, y + dy))
}

/// Whether a cell (column, row, outside of the map as well) belongs to a region.
fn is_in(map: &[usize], label: usize, c: i64, r: i64) -> bool {
    let inside = (0..COLUMNS as i64).contains(&c) && (0..ROWS as i64).contains(&r);
    inside && map[r as usize * COLUMNS + c as usize] == label
}

/// Length of the way around a region through its outermost cells' centres: of the squares of four neighbouring cells, one
/// with two cells side by side holds a straight step, one with three a diagonal step, one with two opposite ones a
/// diagonal step there and one back.
fn contour_length(cells: &[usize], map: &[usize], label: usize) -> f64 {
    let (mut straight, mut diagonal) = (0, 0);
    for square in squares(cells) {
        let [c, r] = square;
        let four = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[dx, dy]| is_in(map, label, c + dx, r + dy));
        match four.iter().filter(|v| **v).count() {
            2 if four[0] == four[3] => diagonal += 2,
            2 => straight += 1,
            3 => diagonal += 1,
            _ => {}
        }
    }
    CELL * (f64::from(straight) + 2.0f64.sqrt() * f64::from(diagonal))
}

/// The squares of four cells (by their first) that hold one of the cells.
fn squares(cells: &[usize]) -> std::collections::BTreeSet<[i64; 2]> {
    let place = |i: &usize| [(i % COLUMNS) as i64, (i / COLUMNS) as i64];
    cells.iter().map(place).flat_map(|[c, r]| [[c, r], [c - 1, r], [c, r - 1], [c - 1, r - 1]]).collect()
}

/// How often the way around a region passes a cell: as often as empty cells beside it lie together.
fn passes(map: &[usize], label: usize, cell: usize) -> usize {
    let around = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]];
    let (c, r) = ((cell % COLUMNS) as i64, (cell / COLUMNS) as i64);
    let full = around.map(|[dx, dy]| is_in(map, label, c + dx, r + dy));
    if !full.contains(&true) {
        return 1;
    }
    // Gaps, each begun by an empty cell after a full one, that hold a cell beside (an even one).
    let begins = (0..8).filter(|k| !full[*k] && full[(k + 7) % 8]);
    let beside = |k: usize| (0..8).map(|i| (k + i) % 8).take_while(|i| !full[*i]).any(|i| i % 2 == 0);
    begins.filter(|k| beside(*k)).count()
}

/// The share of a region's contour whose rays from the sensor pass over another cluster that hides it.
fn occluded(index: usize, clusters: &[Cluster], map: &[usize], sensor: f64) -> f64 {
    let (mut all, mut blocked) = (0, 0);
    for cell in (0..map.len()).filter(|c| map[*c] == index + 1) {
        let times = passes(map, index + 1, cell);
        all += times;
        let [x, y] = centre(cell);
        let distance = (x * x + y * y).sqrt();
        // One look per cell's length along the ray.
        let hides = (1..libm::floor(distance) as i64).any(|step| {
            let t = step as f64 / distance;
            let (c, r) = (libm::floor(x * t + 128.0) as usize, libm::floor(y * t) as usize);
            let label = map[r * COLUMNS + c];
            if label == 0 || label == index + 1 {
                return false;
            }
            let other = &clusters[label - 1];
            let line = sensor - (sensor - other.top) / t;
            other.rejection != Some(Rejection::Noise) && (other.top >= sensor || line > 0.25 * clusters[index].top)
        });
        blocked += if hides { times } else { 0 };
    }
    blocked as f64 / all.max(1) as f64
}
