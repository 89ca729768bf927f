//! The dominant plane below the camera by random sample consensus in integers: the same grid of points, the same random
//! samples and the same rounds of refinement as in [`crate::floor::ransac`].
//!
//! Points are kept in 1/4 mm and 16 bits, planes for the scoring in Q14: a point's distance is three products of 16 bits,
//! below 2^31 in all (|p| < 14.2 m, height at most 10 m: 24.2 m in 1/4 mm times 2^14 is 1.6 * 10^9).

use super::{Floor, QUARTER};
use crate::eigen::fixed::least_normal;
use crate::fixed::{METRE, quantise, sin_cos, unit};
use crate::floor::ransac::{FINALISTS, REACHES, Random, grid_step, triple};
use crate::rays::fixed::Rays;
use crate::{Error, Image};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// Points that the search looks at, at most.
pub const MAX_POINTS: usize = crate::floor::ransac::MAX_POINTS;

/// A point of the search: x, y, z in 1/4 mm and the tolerance there in 1/32 mm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub struct Point {
    /// Position in the camera frame in 1/4 mm.
    pub position: [i16; 3],
    /// Distance from a plane within which the point belongs to it, in 1/32 mm.
    pub tolerance: i16,
}

/// Parameters of the floor's search in integers, see [`crate::floor::RansacParams`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RansacParams {
    /// Seed of the random numbers.
    pub seed: u32,
    /// Samples that are drawn, 1 to 10,000.
    pub samples: u16,
    /// Distance to the plane within which a point belongs to it, at the camera, in 1/128 mm.
    pub tolerance: i32,
    /// The tolerance grows by this times z^2, metres per square metre in Q24, 0 to 0.5.
    pub tolerance_per_z2: u32,
    /// Smallest and largest height of the camera above the floor in 1/128 mm, 1 cm to 10 m.
    pub height: (i32, i32),
    /// Smallest and largest pitch (looking down is positive) in radians, Q28.
    pub pitch: (i32, i32),
    /// From this pitch on (radians, Q28) a plane counts for a fifth.
    pub steep: i32,
    /// Largest tilt to a side in radians, Q28.
    pub tilt: i32,
    /// Share of the points with depth that must lie on the floor, Q16.
    pub support: u32,
    /// Points beyond this depth in 1/128 mm are not looked at.
    pub far: i32,
}

impl RansacParams {
    /// The float parameters, rounded.
    ///
    /// # Errors
    /// `OutOfRange` with the parameter's name.
    pub const fn new(float: &crate::floor::RansacParams) -> Result<Self, Error> {
        const LENGTH: f64 = METRE as f64;
        const ANGLE: f64 = 268_435_456.0;
        macro_rules! number {
            ($name:literal, $value:expr, $min:expr, $max:expr, $scale:expr) => {
                match quantise($value, $min, $max, $scale) {
                    Some(value) => value as i32,
                    None => return Err(Error::OutOfRange($name)),
                }
            };
        }
        let params = Self {
            seed: float.seed,
            samples: float.samples,
            tolerance: number!("floor: tolerance", float.tolerance, 1e-4, 0.5, LENGTH),
            tolerance_per_z2: number!("floor: tolerance_per_z2", float.tolerance_per_z2, 0.0, 0.5, 16_777_216.0) as u32,
            height: (
                number!("floor: height", float.height.0, 0.01, 10.0, LENGTH),
                number!("floor: height", float.height.1, 0.01, 10.0, LENGTH),
            ),
            pitch: (
                number!("floor: pitch", float.pitch.0, -1.6, 1.6, ANGLE),
                number!("floor: pitch", float.pitch.1, -1.6, 1.6, ANGLE),
            ),
            steep: number!("floor: steep", float.steep, -1.6, 1.6, ANGLE),
            tilt: number!("floor: tilt", float.tilt, 0.0, 1.6, ANGLE),
            support: number!("floor: support", float.support, 0.0, 1.0, 65_536.0) as u32,
            far: number!("floor: far", float.far, 0.1, 100.0, LENGTH),
        };
        match params.validate() {
            Ok(()) => Ok(params),
            Err(error) => Err(error),
        }
    }

    /// Checks every number against its stated range.
    ///
    /// # Errors
    /// `OutOfRange` with the parameter's name.
    pub const fn validate(&self) -> Result<(), Error> {
        const TURN: i32 = 429_496_730;
        if self.samples == 0 || self.samples > 10_000 {
            return Err(Error::OutOfRange("floor: samples"));
        }
        if self.tolerance < METRE / 10_000 || self.tolerance > METRE / 2 {
            return Err(Error::OutOfRange("floor: tolerance"));
        }
        if self.tolerance_per_z2 > 1 << 23 {
            return Err(Error::OutOfRange("floor: tolerance_per_z2"));
        }
        if self.height.0 < METRE / 100 || self.height.0 > self.height.1 || self.height.1 > 10 * METRE {
            return Err(Error::OutOfRange("floor: height"));
        }
        if self.pitch.0 < -TURN || self.pitch.0 > self.pitch.1 || self.pitch.1 > TURN {
            return Err(Error::OutOfRange("floor: pitch"));
        }
        if self.steep < -TURN || self.steep > TURN {
            return Err(Error::OutOfRange("floor: steep"));
        }
        if self.tilt < 0 || self.tilt > TURN {
            return Err(Error::OutOfRange("floor: tilt"));
        }
        if self.support > 1 << 16 {
            return Err(Error::OutOfRange("floor: support"));
        }
        if self.far < METRE / 10 || self.far > 100 * METRE {
            return Err(Error::OutOfRange("floor: far"));
        }
        Ok(())
    }

    /// Tolerance at depth `z` (1/8 mm) in 1/32 mm, rounded to nearest, saturated at a metre.
    fn tolerance_at(&self, z: u16) -> i16 {
        // k z^2 in metres is k Q24 z^2 / 8000^2 / 2^24; times 32,000: less than 2^23 2^32 / 2000.
        let growth = ((u64::from(z) * u64::from(z) * u64::from(self.tolerance_per_z2)) >> 24) / 2000;
        let tolerance = (u64::from(self.tolerance.unsigned_abs()) + 2) / 4 + growth;
        i16::try_from(tolerance).unwrap_or(i16::MAX)
    }
}

/// The limits of a plane's normal: sines of the angles, Q30.
struct Limits {
    height: (i32, i32),
    pitch: (i32, i32),
    steep: i32,
    tilt: i32,
}

impl Limits {
    fn new(params: &RansacParams) -> Self {
        // Beyond a quarter turn a limit limits nothing.
        let sine = |angle: i32| match angle {
            _ if angle >= QUARTER => i32::MAX,
            _ if angle <= -QUARTER => i32::MIN,
            _ => sin_cos(angle).0,
        };
        Self {
            height: params.height,
            pitch: (sine(params.pitch.0), sine(params.pitch.1)),
            steep: sine(params.steep),
            tilt: sine(params.tilt),
        }
    }

    fn plausible(&self, floor: &Floor) -> bool {
        (self.height.0..=self.height.1).contains(&floor.height)
            && (self.pitch.0..=self.pitch.1).contains(&-floor.normal[2])
            && floor.normal[0].abs() <= self.tilt
    }

    fn steep(&self, floor: &Floor) -> bool {
        -floor.normal[2] > self.steep
    }
}

/// Finds the floor in a depth image (1/8 mm, 0 = none); `None` where no plausible plane has enough support.
///
/// `room` takes up to [`MAX_POINTS`] points; where it is smaller, only the first points of the grid are looked at.
pub fn find<const W: usize, const H: usize>(
    depth: &Image<u16, W, H>,
    rays: &Rays<W, H>,
    params: &RansacParams,
    room: &mut [Point],
) -> Option<Floor> {
    let step = grid_step(W, H);
    let count = gather(depth, rays, params, step, room);
    let points: &[Point] = room.get(..count)?;
    let limits = Limits::new(params);
    let mut random = Random::new(params.seed);
    let mut finalists: [(i32, Option<Floor>); FINALISTS] = [(0, None); FINALISTS];
    for _ in 0..params.samples {
        let Some(floor) = sample(points, &mut random, W.div_ceil(step)) else { continue };
        if !limits.plausible(&floor) {
            continue;
        }
        // A quarter of the points tells which planes have no chance to be a finalist.
        let rough = 4 * score(points.iter().step_by(4), &floor, &limits) + count as i32 / 10;
        if finalists.last().is_some_and(|last| rough < last.0) {
            continue;
        }
        let mut entry = (score(points.iter(), &floor, &limits), Some(floor));
        for place in &mut finalists {
            if entry.0 > place.0 {
                core::mem::swap(place, &mut entry);
            }
        }
    }
    let mut best: (i32, Option<Floor>) = (0, None);
    for floor in finalists.iter().filter_map(|(_, floor)| *floor) {
        let floor = refine(points, floor, params);
        let score = score(points.iter(), &floor, &limits);
        if limits.plausible(&floor) && score > best.0 {
            best = (score, Some(floor));
        }
    }
    let (score, floor) = best;
    let score = if limits.steep(&floor?) { 5 * score } else { score };
    let enough = u64::from(params.support) * count as u64;
    if u64::try_from(score).is_ok_and(|score| score << 16 >= enough) { floor } else { None }
}

/// The grid's points with depth; returns how many.
fn gather<const W: usize, const H: usize>(
    depth: &Image<u16, W, H>,
    rays: &Rays<W, H>,
    params: &RansacParams,
    step: usize,
    room: &mut [Point],
) -> usize {
    let mut slots = room.iter_mut();
    let mut count = 0;
    for (row, y) in depth.iter().zip(rays.y()).skip(step / 2).step_by(step) {
        for (&z, x) in row.iter().zip(rays.x()).skip(step / 2).step_by(step) {
            if z == 0 || i32::from(z) << 4 > params.far {
                continue;
            }
            // Q26 times 1/8 mm is 1/4 mm in Q27.
            let across = |slope: i32| i16::try_from((i64::from(slope) * i64::from(z) + (1 << 26)) >> 27);
            // Points more than 8 m to a side are no help.
            let (Ok(x), Ok(y)) = (across(*x), across(*y)) else { continue };
            let Some(slot) = slots.next() else { return count };
            *slot = Point { position: [x, y, (z >> 1) as i16], tolerance: params.tolerance_at(z) };
            count += 1;
        }
    }
    count
}

/// A plane through three points that stand near each other.
fn sample(points: &[Point], random: &mut Random, per_row: usize) -> Option<Floor> {
    let [a, b, c] = triple(random, points.len(), per_row)?.map(|i| points.get(i));
    let (a, b, c) = (a?.position.map(i64::from), b?.position.map(i64::from), c?.position.map(i64::from));
    let side = |p: [i64; 3]| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
    let (b, c) = (side(b), side(c));
    let normal = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
    // A square decimetre in square units of 1/4 mm, as in the float search. Components are below 2^34; a large one says enough.
    const LEAST: i64 = 160_000;
    let largest = normal.map(i64::abs).into_iter().fold(0, i64::max);
    let enough = largest > LEAST || normal.iter().map(|v| v * v).sum::<i64>() > LEAST * LEAST;
    enough.then(|| oriented(normal, a.map(|v| v << 8))).flatten()
}

/// The plane through a point (1/1024 mm), its normal turned towards the camera; `None` without a normal.
fn oriented(normal: [i64; 3], point: [i64; 3]) -> Option<Floor> {
    let normal = unit(normal)?;
    // Q30 times 1/1024 mm (below 2^24): below 2^56.
    let along: i64 = (0..3).map(|i| i64::from(normal[i]) * point[i]).sum();
    let normal = if along > 0 { normal.map(|v| -v) } else { normal };
    Some(Floor { normal, height: ((along.abs() + (1 << 32)) >> 33) as i32 })
}

/// Points on the plane, less three times those clearly below it; a fifth of that for steep views.
fn score<'a>(points: impl Iterator<Item = &'a Point>, floor: &Floor, limits: &Limits) -> i32 {
    let n = floor.normal.map(|v| i32::from(((v + (1 << 15)) >> 16) as i16));
    // 1/128 mm is 1/32 of 1/4 mm.
    let height = floor.height << 9;
    let (mut on, mut below) = (0, 0);
    for Point { position: [x, y, z], tolerance } in points {
        let distance = n[0] * i32::from(*x) + n[1] * i32::from(*y) + n[2] * i32::from(*z) + height;
        let tolerance = i32::from(*tolerance) << 11;
        on += i32::from(distance.abs() <= tolerance);
        below += i32::from(distance < -2 * tolerance);
    }
    let score = on - 3 * below;
    if limits.steep(floor) { score / 5 } else { score }
}

/// [`REACHES`] in Q8.
const REACHES_Q8: [i64; REACHES.len()] = {
    let mut reaches = [0; REACHES.len()];
    let mut i = 0;
    while i < reaches.len() {
        if let Some(reach) = quantise(REACHES[i], 0.0, 16.0, 256.0) {
            reaches[i] = reach;
        }
        i += 1;
    }
    reaches
};

/// Least squares over the points near the plane, each weighted by the inverse square of its tolerance.
fn refine(points: &[Point], mut floor: Floor, params: &RansacParams) -> Floor {
    let least = i64::from(params.tolerance_at(0).max(1));
    for reach in REACHES_Q8 {
        let near = |p: &&Point| {
            // Q30 times 1/4 mm and 1/128 mm: in 1/128 mm. Tolerances: 1/32 mm in Q8.
            let along: i64 = (0..3).map(|i| i64::from(floor.normal[i]) * i64::from(p.position[i])).sum();
            let distance = ((along + (1 << 24)) >> 25) + i64::from(floor.height);
            distance.abs() << 6 <= reach * i64::from(p.tolerance)
        };
        // Q14.
        let weight = |p: &Point| {
            let t = (least << 14) / i64::from(p.tolerance.max(1));
            (t * t) >> 14
        };
        let (mut total, mut sum) = (0i64, [0i64; 3]);
        for p in points.iter().filter(near) {
            let w = weight(p);
            total += w;
            (0..3).for_each(|i| sum[i] += w * i64::from(p.position[i]));
        }
        if total == 0 {
            return floor;
        }
        // Weights 2^14, positions 2^15, points 2^12: below 2^41. The mean in 1/1024 mm.
        let mean = sum.map(|v| (v << 8) / total);
        let mut c = [0i64; 6];
        for p in points.iter().filter(near) {
            // 1/16 mm, below 2^18: products below 2^36, less 2, weighted 2^48, 2200 of them 2^60.
            let (w, d): (i64, [i64; 3]) =
                (weight(p), core::array::from_fn(|i| ((i64::from(p.position[i]) << 8) - mean[i]) >> 6));
            for (sum, product) in
                c.iter_mut().zip([d[0] * d[0], d[0] * d[1], d[0] * d[2], d[1] * d[1], d[1] * d[2], d[2] * d[2]])
            {
                *sum += w * (product >> 2);
            }
        }
        match least_normal(&c).and_then(|normal| oriented(normal.map(i64::from), mean)) {
            Some(found) => floor = found,
            None => return floor,
        }
    }
    floor
}

#[cfg(test)]
mod tests;
