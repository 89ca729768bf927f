//! The search for the floor in integers, see the float twin: the same grid, the same random numbers, the same finalists' way
//! to rest. But hypotheses are compared by a quarter of the points, and most are given up after a sixteenth: the best of them
//! are compared by all points, and finalists again when they are refined.
//!
//! Points count quarters of a millimetre in 16 bits, normals Q15 in the scores: a sum of products is below 2^31 wherever the
//! plane is near, and wraps back into range from partial sums that are not.

pub use super::plane::Points;
use super::plane::{BLOCK, Plane, Point, TOLERANCE};
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

/// The fours of each block that the hypotheses are scored by, in this order: every 16th, 8th and 4th of the points.
const ROUGH: [usize; 4] = [0, 8, 4, 12];

/// So many are kept by the rough scores, to be compared by all points.
const ROUGHLY_BEST: usize = 6;

/// Farthest coordinate of a point, in 1/4 mm: 8 m.
const FAR: i32 = 32_000;

/// The points that there are.
#[derive(Clone, Copy)]
struct Cloud<'a> {
    blocks: &'a [Points],
    count: usize,
}

impl Cloud<'_> {
    fn get(&self, i: usize) -> Option<Point> {
        self.blocks.get(i / BLOCK).map(|block| block.get(i))
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
                let place = [x as i16, y as i16, z as i16];
                block.set(found, Point { place, tolerance: limits.tolerance_at(z) });
                found += 1;
            }
        }
    }
    let points = Cloud { blocks: scratch.get(..found.div_ceil(BLOCK)).unwrap_or(&[]), count: found };
    let mut random = Random::new(params.seed);
    let mut rough: [(i32, Option<Floor>); ROUGHLY_BEST] = [(0, None); ROUGHLY_BEST];
    for _ in 0..params.samples {
        let Some(floor) = sample(&points, &mut random, W.div_ceil(step)) else { continue };
        if !limits.plausible(&floor) {
            continue;
        }
        let least = rough.last().map_or(0, |last| last.0);
        if let Some(score) = rough_score(least, &points, &floor, &limits) {
            enter(&mut rough, score, floor);
        }
    }
    // With all points those may change places that are nearly as good as each other.
    let mut finalists: [(i32, Option<Floor>); FINALISTS] = [(0, None); FINALISTS];
    for floor in rough.iter().filter_map(|(_, floor)| *floor) {
        enter(&mut finalists, fair_score(&points, &floor, &limits), floor);
    }
    let least = least_tolerance(points.blocks);
    let mut best: (i32, Option<Floor>) = (0, None);
    for floor in finalists.iter().filter_map(|(_, floor)| *floor) {
        let floor = refine(&points, least, floor);
        let score = fair_score(&points, &floor, &limits);
        if limits.plausible(&floor) && score > best.0 {
            best = (score, Some(floor));
        }
    }
    let (score, floor) = best;
    let steep = limits.is_steep(&floor?);
    let enough = i64::from(params.support) * points.count as i64;
    if i64::from(if steep { 5 * score } else { score }) << 16 >= enough { floor } else { None }
}

/// Enters a plane among the best, the first of equals before the others.
fn enter(best: &mut [(i32, Option<Floor>)], score: i32, floor: Floor) {
    let mut entry = (score, Some(floor));
    for place in best {
        if entry.0 > place.0 {
            core::mem::swap(place, &mut entry);
        }
    }
}

/// The score by all points, a fifth of it for steep views.
fn fair_score(points: &Cloud<'_>, floor: &Floor, limits: &Limits) -> i32 {
    score(points, floor) / if limits.is_steep(floor) { 5 } else { 1 }
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
    roughly_oriented(normal, a.place)
}

/// The plane through a point, to 15 bits: it is only to be scored and refined. `None` where the normal is shorter than a
/// square decimetre (160,000 squares of 1/4 mm), too little to tell a plane by.
fn roughly_oriented(normal: [i64; 3], point: [i16; 3]) -> Option<Floor> {
    let all = normal.iter().fold(0, |all, v| all | v.unsigned_abs());
    // Products of the points' coordinates are below 2^34: at most 19.
    let shift = (64 - all.leading_zeros()).saturating_sub(15);
    // Below 2^15 (-2^15 at most): the squares' sum is below 2^32.
    let normal = normal.map(|v| (v >> shift) as i32);
    let square: u32 = normal.iter().map(|v| v.unsigned_abs() * v.unsigned_abs()).sum();
    if u64::from(square) <= (160_000 * 160_000) >> (2 * shift) {
        return None;
    }
    let length = square.isqrt() as i32;
    let normal = normal.map(|v| (v << 15) / length.max(1));
    // Coordinates below 2^15: less than 2^31, as in [`Plane::height_of`].
    let [along, y, z]: [i32; 3] = core::array::from_fn(|i| normal[i] * i32::from(point[i]));
    let along = along + y + z;
    let normal = normal.map(|v| if along > 0 { -v << 15 } else { v << 15 });
    Some(Floor { normal, height: (along.abs() + (1 << 9)) >> 10 })
}

/// The plane through a point (1/4096 mm), its normal turned towards the camera.
fn oriented(normal: [i64; 3], point: [i64; 3]) -> Option<Floor> {
    let n = unit(normal)?;
    // Coordinates below 2^26: below 2^58.
    let along = i64::from(n[0]) * point[0] + i64::from(n[1]) * point[1] + i64::from(n[2]) * point[2];
    let height = ((along.abs() + (1 << 34)) >> 35) as i32;
    Some(Floor { normal: if along > 0 { n.map(|v| -v) } else { n }, height })
}

/// Points on the plane, less three times those clearly below it.
fn score(points: &Cloud<'_>, floor: &Floor) -> i32 {
    super::plane::score(&Plane::new(floor), points.blocks.iter().flat_map(|block| block.fours()))
}

/// The score by every fourth point, a fifth of it for steep views; `None` as soon as it will hardly exceed `least`.
fn rough_score(least: i32, points: &Cloud<'_>, floor: &Floor, limits: &Limits) -> Option<i32> {
    let plane = Plane::new(floor);
    let steep = limits.is_steep(floor);
    let enough = if steep { 5 * least } else { least };
    let (count, mut score) = (points.count as i32, 0);
    // All points on the plane would not do.
    if enough > count / 4 + 1 {
        return None;
    }
    for (row, seen) in ROUGH.into_iter().zip(1..) {
        score += super::plane::score(&plane, points.blocks.iter().map(|block| block.four(row)));
        // The other points may score better: by a tenth of all after every 16th point, by less and less then.
        if 4 * score + count / 40 < seen * enough {
            return None;
        }
    }
    let score = if steep { score / 5 } else { score };
    (score > least).then_some(score)
}

/// Least squares over the points near the plane, each weighted by the inverse square of its tolerance. `least` is the
/// least tolerance that there is.
fn refine(points: &Cloud<'_>, least: u32, mut floor: Floor) -> Floor {
    let mut last = None;
    for reach in REACHES {
        let plane = Plane::new(&floor);
        // The same points make the same plane.
        if last.replace((plane, reach)) == Some((plane, reach)) {
            break;
        }
        let Some(found) = fit(points.blocks, &plane, reach, least) else { break };
        floor = found;
    }
    floor
}

fn least_tolerance(blocks: &[Points]) -> u32 {
    let all = blocks.iter().flat_map(Points::iter).map(|p| p.tolerance).filter(|t| *t > 0);
    all.min().unwrap_or(1).unsigned_abs().into()
}

/// The plane that fits best to the points within `reach` fifths of their tolerance.
fn fit(blocks: &[Points], plane: &Plane, reach: i32, least: u32) -> Option<Floor> {
    // At most 2^12 points, weights in Q12: they sum up to 2^24, with coordinates to 2^39, with two to 2^54.
    let (mut total, mut sum, mut square) = (0u32, [0i64; 3], [0i64; 6]);
    for block in blocks {
        for p in block.iter() {
            // Below 10 2^14 2^12.
            let limit = ((reach * i32::from(p.tolerance)) << TOLERANCE) as u32 / 5;
            if plane.height_of(p.place).unsigned_abs() > limit || p.tolerance <= 0 {
                continue;
            }
            let t = (least << 12) / u32::from(p.tolerance.unsigned_abs()).max(1);
            let w = (t * t) >> 12;
            let [x, y, z] = p.place.map(i32::from);
            let product = |a: i32, b: i32| i64::from(a) * i64::from(b);
            let [wx, wy, wz] = [w as i32 * x, w as i32 * y, w as i32 * z];
            total += w;
            sum[0] += i64::from(wx);
            sum[1] += i64::from(wy);
            sum[2] += i64::from(wz);
            square[0] += product(wx, x);
            square[1] += product(wx, y);
            square[2] += product(wx, z);
            square[3] += product(wy, y);
            square[4] += product(wy, z);
            square[5] += product(wz, z);
        }
    }
    if total == 0 {
        return None;
    }
    let total = i64::from(total);
    // In 1/4096 mm; for the moments, below 2^56 in all, 1/4 mm suffice.
    let mean = sum.map(|v| (v << 10).div_euclid(total));
    let c = mean.map(|v| (v + 512) >> 10);
    // The sum of w (a - ca) (b - cb).
    let about = |i: usize, a: usize, b: usize| square[i] - c[a] * sum[b] - c[b] * sum[a] + c[a] * c[b] * total;
    let moments = [about(0, 0, 0), about(1, 0, 1), about(2, 0, 2), about(3, 1, 1), about(4, 1, 2), about(5, 2, 2)];
    oriented(eigen::least_normal(&moments)?.map(i64::from), mean)
}

#[cfg(test)]
mod tests;
