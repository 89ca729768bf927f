//! The search for the floor in integers, see the float twin: the same grid, the same random numbers, the same order of
//! events.
//!
//! Points count quarters of a millimetre in 16 bits, normals Q15 in the scores: a sum of products is below 2^31 wherever the
//! plane is near, and wraps back into range from partial sums that are not.

pub use super::plane::Points;
use super::plane::{BLOCK, FIRST, Plane, TOLERANCE, count};
use super::{Floor, RansacParams};
use crate::Image;
use crate::eigen::fixed as eigen;
use crate::fixed::{sin_cos, unit};
use crate::floor::ransac::{FINALISTS, MAX_POINTS, Random, step_of};
use crate::rays::fixed::Rays;

/// [`crate::floor::ransac::REACHES`] in fifths.
const REACHES: [i32; 8] = [10, 5, 3, 3, 3, 3, 3, 3];

/// Blocks that the scratch of [`find`] should have.
pub const SCRATCH: usize = MAX_POINTS.div_ceil(BLOCK);

/// Blocks after which it is seen whether a plane has a chance.
const CHECK: usize = 8;

/// Farthest coordinate of a point, in 1/4 mm: 8 m.
const FAR: i32 = 32_000;

/// One of the points.
#[derive(Debug, Clone, Copy)]
struct Point {
    place: [i16; 3],
    tolerance: i16,
}

/// The points that there are.
#[derive(Clone, Copy)]
struct Cloud<'a> {
    blocks: &'a [Points],
    count: usize,
}

/// Where the `i`-th point of a block stands in it.
const fn lane(i: usize) -> usize {
    (i % 4 * FIRST + i / 4) % BLOCK
}

impl Cloud<'_> {
    fn get(&self, i: usize) -> Option<Point> {
        let (block, i) = (self.blocks.get(i / BLOCK)?, lane(i % BLOCK));
        Some(Point { place: [block.x[i], block.y[i], block.z[i]], tolerance: block.tolerance[i] })
    }

    fn iter(&self) -> impl Iterator<Item = Point> {
        (0..self.count).filter_map(|i| self.get(i))
    }
}

/// What the limits come to: sines in Q30, lengths in the search's units.
struct Limits {
    /// Sines of the pitch.
    pitch: (i32, i32),
    steep: i32,
    tilt: i32,
    height: (i32, i32),
    far: i32,
    /// The tolerance at the camera, and its growth: times (z / 64)^2 (z in 1/4 mm), in 2^-16 of 1/32 mm.
    tolerance: [i64; 2],
}

impl Limits {
    fn new(params: &RansacParams) -> Self {
        let sine = |angle: i32| sin_cos(angle).0;
        // 1/1024 mm per m^2 is 2^-5 of 1/32 mm per (4000 / 64)^2 of (z / 64)^2: in 2^-16, 2^11 64^2 / 4000^2 = 0.524288.
        let growth = (i64::from(params.tolerance_per_z2) * 524_288 + 500_000) / 1_000_000;
        Self {
            pitch: (sine(params.pitch.0), sine(params.pitch.1)),
            steep: sine(params.steep),
            tilt: sine(params.tilt),
            height: params.height,
            far: (params.far >> 5).min(FAR),
            tolerance: [i64::from(params.tolerance) << 14, growth],
        }
    }

    fn tolerance_at(&self, z: i32) -> i16 {
        let z = i64::from(z);
        ((self.tolerance[0] + self.tolerance[1] * ((z * z) >> 12) + (1 << 15)) >> 16).min(16_383) as i16
    }

    fn plausible(&self, floor: &Floor) -> bool {
        (self.height.0..=self.height.1).contains(&floor.height)
            && (self.pitch.0..=self.pitch.1).contains(&-floor.normal[2])
            && floor.normal[0].abs() <= self.tilt
    }

    fn weigh(&self, score: i32, floor: &Floor) -> i32 {
        if self.is_steep(floor) { score / 5 } else { score }
    }

    fn is_steep(&self, floor: &Floor) -> bool {
        -floor.normal[2] > self.steep
    }
}

/// Finds the floor in a depth image (1/8 mm, 0 = none); `None` where no plausible plane has enough support.
///
/// `scratch` holds the points, best [`SCRATCH`] blocks of them; with fewer the rest of the image is not looked at. Points
/// more than 8 m to any side are left out. See [`crate::floor::ransac::find`].
pub fn find<const W: usize, const H: usize>(
    depth: &Image<u16, W, H>,
    rays: &Rays<W, H>,
    params: &RansacParams,
    scratch: &mut [Points],
) -> Option<Floor> {
    let limits = Limits::new(params);
    let step = step_of(W, H)?;
    scratch.fill(Points::NONE);
    let mut found = 0;
    for v in (step / 2..H).step_by(step) {
        for u in (step / 2..W).step_by(step) {
            let z = depth[v][u];
            let [x, y, z] = rays.point(u, v, z).map(|c| (c + 16) >> 5);
            if z > 0 && z <= limits.far && x.abs() <= FAR && y.abs() <= FAR {
                let Some(block) = scratch.get_mut(found / BLOCK) else { break };
                let i = lane(found % BLOCK);
                (block.x[i], block.y[i], block.z[i]) = (x as i16, y as i16, z as i16);
                block.tolerance[i] = limits.tolerance_at(z);
                found += 1;
            }
        }
    }
    let points = Cloud { blocks: scratch.get(..found.div_ceil(BLOCK)).unwrap_or(&[]), count: found };
    let mut random = Random::new(params.seed);
    let mut finalists: [(i32, Option<Floor>); FINALISTS] = [(0, None); FINALISTS];
    for _ in 0..params.samples {
        let Some(floor) = sample(&points, &mut random, W.div_ceil(step)) else { continue };
        if !limits.plausible(&floor) {
            continue;
        }
        // A quarter of the points tells which planes have no chance to be a finalist.
        if finalists.last().is_some_and(|last| !may_reach(last.0, &points, &floor, &limits)) {
            continue;
        }
        let mut entry = (score(&points, &floor, &limits), Some(floor));
        for place in &mut finalists {
            if entry.0 > place.0 {
                core::mem::swap(place, &mut entry);
            }
        }
    }
    let mut best: (i32, Option<Floor>) = (0, None);
    for floor in finalists.iter().filter_map(|(_, floor)| *floor) {
        let floor = refine(&points, floor);
        let score = score(&points, &floor, &limits);
        if limits.plausible(&floor) && score > best.0 {
            best = (score, Some(floor));
        }
    }
    let (score, floor) = best;
    let steep = limits.is_steep(&floor?);
    let enough = i64::from(params.support) * points.count as i64;
    if i64::from(if steep { 5 * score } else { score }) << 16 >= enough { floor } else { None }
}

/// A plane through three points that stand near each other in the grid.
fn sample(points: &Cloud<'_>, random: &mut Random, per_row: usize) -> Option<Floor> {
    let window = 12 * per_row.max(1);
    let first = random.below(points.count)?;
    let start = first.saturating_sub(window / 2);
    let length = window.min(points.count - start);
    let [a, b, c] =
        [points.get(first)?, points.get(start + random.below(length)?)?, points.get(start + random.below(length)?)?];
    // Below 2^16; products below 2^33.
    let side = |p: Point| -> [i64; 3] { core::array::from_fn(|i| i64::from(p.place[i]) - i64::from(a.place[i])) };
    let (p, q) = (side(b), side(c));
    let normal = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
    // Less than a square decimetre is too little to tell a plane by: 160,000 squares of 1/4 mm.
    let length2: u64 = normal.iter().fold(0, |sum, v| sum.saturating_add((v * v) as u64));
    if length2 <= 160_000 * 160_000 {
        return None;
    }
    oriented(normal, a.place.map(|c| i64::from(c) << 10))
}

/// The plane through a point (1/4096 mm), its normal turned towards the camera.
fn oriented(normal: [i64; 3], point: [i64; 3]) -> Option<Floor> {
    let n = unit(normal)?;
    // Coordinates below 2^26: below 2^58.
    let along = i64::from(n[0]) * point[0] + i64::from(n[1]) * point[1] + i64::from(n[2]) * point[2];
    let height = ((along.abs() + (1 << 34)) >> 35) as i32;
    Some(Floor { normal: if along > 0 { n.map(|v| -v) } else { n }, height })
}

/// Points on the plane, less three times those clearly below it; a fifth of that for steep views.
fn score(points: &Cloud<'_>, floor: &Floor, limits: &Limits) -> i32 {
    let [on, below] = count(&Plane::new(floor), points.blocks.iter().flat_map(Points::eights));
    limits.weigh(on - 3 * below, floor)
}

/// Whether four times the score of every fourth point and a tenth of the points reach `least`; stops as soon as all points that
/// are left would not do.
fn may_reach(least: i32, points: &Cloud<'_>, floor: &Floor, limits: &Limits) -> bool {
    let plane = Plane::new(floor);
    let enough = |score: i32| 4 * limits.weigh(score, floor) + points.count as i32 / 10 >= least;
    let (mut score, mut left) = (0, (points.blocks.len() * FIRST) as i32);
    for blocks in points.blocks.chunks(CHECK) {
        let [on, below] = count(&plane, blocks.iter().filter_map(|block| block.eights().next()));
        score += on - 3 * below;
        left -= (blocks.len() * FIRST) as i32;
        if !enough(score + left) {
            return false;
        }
    }
    enough(score)
}

/// Least squares over the points near the plane, each weighted by the inverse square of its tolerance.
fn refine(points: &Cloud<'_>, mut floor: Floor) -> Floor {
    let least = points.iter().map(|p| p.tolerance).min().unwrap_or(1).max(1);
    // Q12, at most 1.
    let weight = |p: Point| {
        let t = (u32::from(least as u16) << 12) / u32::from(p.tolerance.max(1) as u16);
        i64::from((t * t) >> 12)
    };
    for reach in REACHES {
        let plane = Plane::new(&floor);
        let near = |p: &Point| {
            i64::from(plane.height_of(p.place)).abs() * 5 <= i64::from(reach * i32::from(p.tolerance)) << TOLERANCE
        };
        // At most 2^12 points: weights sum up to 2^24, with coordinates to 2^39.
        let (mut total, mut sum) = (0i64, [0i64; 3]);
        for p in points.iter().filter(near) {
            let w = weight(p);
            total += w;
            for (sum, c) in sum.iter_mut().zip(p.place) {
                *sum += w * i64::from(c);
            }
        }
        if total < 1 {
            return floor;
        }
        // In 1/4096 mm; for the moments, below 2^32 each and 2^56 in all, 1/4 mm suffice.
        let mean = sum.map(|v| (v << 10).div_euclid(total));
        let centre = mean.map(|v| (v + 512) >> 10);
        let mut c = [0i64; 6];
        for p in points.iter().filter(near) {
            let w = weight(p);
            let d: [i64; 3] = core::array::from_fn(|i| i64::from(p.place[i]) - centre[i]);
            let products = [d[0] * d[0], d[0] * d[1], d[0] * d[2], d[1] * d[1], d[1] * d[2], d[2] * d[2]];
            for (sum, product) in c.iter_mut().zip(products) {
                *sum += w * product;
            }
        }
        match eigen::least_normal(&c).and_then(|n| oriented(n.map(i64::from), mean)) {
            Some(found) => floor = found,
            None => return floor,
        }
    }
    floor
}

#[cfg(test)]
mod tests;
