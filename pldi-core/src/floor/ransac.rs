//! The dominant plane below the camera by random sample consensus (Fischler and Bolles 1981), seeded and bounded: the
//! same frame has the same floor on every machine.

use super::Floor;
use crate::eigen::{self, cross, dot};
use crate::{Error, Image, Rays, math};
use heapless::Vec;

/// Points that the search looks at, at most: a regular grid over the image.
pub(super) const MAX_POINTS: usize = 2200;

/// Hypotheses that are refined at the end.
pub(super) const FINALISTS: usize = 3;

/// Rounds of refinement by least squares over the points within so many tolerances of the plane: from wide to narrow,
/// because a sampled plane is tilted by its points' noise, and in the end the feet of walls should not tilt it. The last
/// rounds bring the plane to rest: then it does not depend on which sample it came from.
pub(super) const REACHES: [f32; 8] = [2.0, 1.0, 0.6, 0.6, 0.6, 0.6, 0.6, 0.6];

/// Parameters of the floor's search.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RansacParams {
    /// Seed of the random numbers. Default 1.
    pub seed: u32,
    /// Samples that are drawn, 1 to 10,000. Default 1500.
    pub samples: u16,
    /// Distance to the plane within which a point belongs to it, at the camera, in metres. Default 0.01.
    pub tolerance: f32,
    /// The tolerance grows by this times z^2 (metres per square metre): the sensor's axial error. Default 0.0015.
    pub tolerance_per_z2: f32,
    /// Smallest and largest height of the camera above the floor in metres. Default 0.2 to 2.5.
    pub height: (f32, f32),
    /// Smallest and largest pitch (looking down is positive) in radians. Default -0.35 to 1.31 (-20 to 75 degrees).
    pub pitch: (f32, f32),
    /// From this pitch on (radians) a plane counts for a fifth: a slanted wall looks like the floor of a camera that looks
    /// steeply down, and such cameras are rare. Default 0.87 (50 degrees).
    pub steep: f32,
    /// Largest tilt to a side, the angle between the image's rows and the floor, in radians. Default 0.35 (20 degrees).
    pub tilt: f32,
    /// Share of the points with depth that must lie on the floor, 0..1. Default 0.03.
    pub support: f32,
    /// Points beyond this depth in metres are not looked at. Default 6.
    pub far: f32,
}

impl RansacParams {
    /// Values for cameras on mobile robots and hand-held ones.
    pub const DEFAULT: Self = Self {
        seed: 1,
        samples: 1500,
        tolerance: 0.01,
        tolerance_per_z2: 0.0015,
        height: (0.2, 2.5),
        pitch: (-0.35, 1.31),
        steep: 0.87,
        tilt: 0.35,
        support: 0.03,
        far: 6.0,
    };

    /// Checks every number against its stated range.
    ///
    /// # Errors
    /// `OutOfRange` with the parameter's name.
    pub fn validate(&self) -> Result<(), Error> {
        use crate::error::within;
        within("floor: samples", f32::from(self.samples), 1.0, 10_000.0)?;
        within("floor: tolerance", self.tolerance, 1e-4, 0.5)?;
        within("floor: tolerance_per_z2", self.tolerance_per_z2, 0.0, 0.5)?;
        within("floor: height", self.height.0, 0.01, self.height.1)?;
        within("floor: height", self.height.1, 0.01, 10.0)?;
        within("floor: pitch", self.pitch.0, -1.6, self.pitch.1)?;
        within("floor: pitch", self.pitch.1, -1.6, 1.6)?;
        within("floor: steep", self.steep, -1.6, 1.6)?;
        within("floor: tilt", self.tilt, 0.0, 1.6)?;
        within("floor: support", self.support, 0.0, 1.0)?;
        within("floor: far", self.far, 0.1, 100.0)
    }

    fn plausible(&self, floor: &Floor) -> bool {
        (self.height.0..=self.height.1).contains(&floor.height)
            && (self.pitch.0..=self.pitch.1).contains(&floor.pitch())
            && math::asin(floor.normal[0]).abs() <= self.tilt
    }

    fn tolerance_at(&self, z: f32) -> f32 {
        self.tolerance + self.tolerance_per_z2 * z * z
    }
}

/// Finds the floor in a depth image (metres, 0 = none); `None` where no plausible plane has enough support.
///
/// A plane counts for the points on it and against those below it: a table top, with the floor seen below, loses
/// to the floor. Walls fail the limits of pitch and tilt.
pub fn find<const W: usize, const H: usize>(
    depth: &Image<f32, W, H>,
    rays: &Rays<W, H>,
    params: &RansacParams,
) -> Option<Floor> {
    let mut points: Vec<[f32; 3], MAX_POINTS> = Vec::new();
    let step = step_of(W, H)?;
    for v in (step / 2..H).step_by(step) {
        for u in (step / 2..W).step_by(step) {
            let z = depth[v][u];
            if z > 0.0 && z <= params.far && points.push(rays.point(u, v, z)).is_err() {
                break;
            }
        }
    }
    let mut random = Random::new(params.seed);
    let mut finalists: [(i32, Option<Floor>); FINALISTS] = [(0, None); FINALISTS];
    for _ in 0..params.samples {
        let Some(floor) = sample(&points, &mut random, W.div_ceil(step)) else { continue };
        if !params.plausible(&floor) {
            continue;
        }
        // A quarter of the points tells which planes have no chance to be a finalist.
        let rough = 4 * score(points.iter().step_by(4), &floor, params) + points.len() as i32 / 10;
        if finalists.last().is_some_and(|last| rough < last.0) {
            continue;
        }
        let mut entry = (score(points.iter(), &floor, params), Some(floor));
        for place in &mut finalists {
            if entry.0 > place.0 {
                core::mem::swap(place, &mut entry);
            }
        }
    }
    let mut best: (i32, Option<Floor>) = (0, None);
    for floor in finalists.iter().filter_map(|(_, floor)| *floor) {
        let floor = refine(&points, floor, params);
        let score = score(points.iter(), &floor, params);
        if params.plausible(&floor) && score > best.0 {
            best = (score, Some(floor));
        }
    }
    let (score, floor) = best;
    let steep = floor?.pitch() > params.steep;
    let enough = params.support * points.len() as f32;
    if (if steep { 5 * score } else { score }) as f32 >= enough { floor } else { None }
}

/// Distance of the grid's points in pixels.
pub(super) fn step_of(width: usize, height: usize) -> Option<usize> {
    (1..).find(|s| width.div_ceil(*s) * height.div_ceil(*s) <= MAX_POINTS)
}

/// A plane through three points that stand near each other in the grid (near points often share a surface, points
/// from anywhere seldom do).
fn sample(points: &[[f32; 3]], random: &mut Random, per_row: usize) -> Option<Floor> {
    let window = 12 * per_row.max(1);
    let first = random.below(points.len())?;
    let start = first.saturating_sub(window / 2);
    let length = window.min(points.len() - start);
    let [a, b, c] =
        [points.get(first)?, points.get(start + random.below(length)?)?, points.get(start + random.below(length)?)?];
    let side = |p: &[f32; 3]| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
    let normal = cross(side(b), side(c));
    let length2 = dot(normal, normal);
    // Less than a square decimetre is too little to tell a plane by.
    (length2 > 1e-4).then(|| oriented(normal, *a))
}

/// The plane through a point, its normal turned towards the camera.
fn oriented(normal: [f32; 3], point: [f32; 3]) -> Floor {
    let scale = 1.0 / math::sqrt(dot(normal, normal));
    let sign = if dot(normal, point) > 0.0 { -scale } else { scale };
    let normal = normal.map(|v| v * sign);
    Floor { normal, height: -dot(normal, point) }
}

/// Points on the plane, less three times those clearly below it; a fifth of that for steep views.
fn score<'a>(points: impl Iterator<Item = &'a [f32; 3]>, floor: &Floor, params: &RansacParams) -> i32 {
    let (mut on, mut below) = (0, 0);
    for p in points {
        let (distance, tolerance) = (floor.height_of(*p), params.tolerance_at(p[2]));
        on += i32::from(distance.abs() <= tolerance);
        below += i32::from(distance < -2.0 * tolerance);
    }
    let score = on - 3 * below;
    if floor.pitch() > params.steep { score / 5 } else { score }
}

/// Least squares over the points near the plane, each weighted by the inverse square of its tolerance.
fn refine(points: &[[f32; 3]], mut floor: Floor, params: &RansacParams) -> Floor {
    for reach in REACHES {
        let near = |p: &&[f32; 3]| floor.height_of(**p).abs() <= reach * params.tolerance_at(p[2]);
        let weight = |p: &[f32; 3]| {
            let t = params.tolerance / params.tolerance_at(p[2]);
            t * t
        };
        let (mut total, mut mean) = (0.0, [0.0; 3]);
        for p in points.iter().filter(near) {
            let w = weight(p);
            total += w;
            (0..3).for_each(|i| mean[i] += w * p[i]);
        }
        if !(total > 0.0) {
            return floor;
        }
        let mean = mean.map(|v| v / total);
        let mut c = [0.0; 6];
        for p in points.iter().filter(near) {
            let (w, d) = (weight(p), [p[0] - mean[0], p[1] - mean[1], p[2] - mean[2]]);
            for (sum, product) in
                c.iter_mut().zip([d[0] * d[0], d[0] * d[1], d[0] * d[2], d[1] * d[1], d[1] * d[2], d[2] * d[2]])
            {
                *sum += w * product;
            }
        }
        match eigen::least_normal(&c) {
            Some(normal) => floor = oriented(normal, mean),
            None => return floor,
        }
    }
    floor
}

/// Marsaglia's xorshift with 32 bits of state.
pub(super) struct Random(u32);

impl Random {
    pub(super) const fn new(seed: u32) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9) | 1)
    }

    /// A number below `n`; `None` where there is none.
    pub(super) fn below(&mut self, n: usize) -> Option<usize> {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        (self.0 as usize).checked_rem(n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Intrinsics;
    use crate::frame::{QVGA_HEIGHT as H, QVGA_WIDTH as W};

    type Depth = Box<Image<f32, W, H>>;

    /// A plane, and where it is.
    type Part = (Floor, fn([f32; 3]) -> bool);

    /// The nearest of some planes along each ray, each where its limit holds.
    fn render(planes: &[Part]) -> (Depth, Rays<W, H>) {
        let rays = Rays::new(&Intrinsics::KINECT_QVGA).unwrap();
        let mut depth: Depth = vec![[0.0f32; W]; H].into_boxed_slice().try_into().unwrap();
        for (v, row) in depth.iter_mut().enumerate() {
            for (u, out) in row.iter_mut().enumerate() {
                for (plane, limit) in planes {
                    let ray = rays.point(u, v, 1.0);
                    let z = -plane.height / dot(plane.normal, ray);
                    if z > 0.0 && z < 8.0 && (*out == 0.0 || z < *out) && limit(rays.point(u, v, z)) {
                        *out = z;
                    }
                }
            }
        }
        (depth, rays)
    }

    #[test]
    fn the_floor_is_found_below_a_larger_table_and_before_a_wall() {
        let floor = Floor::from_pose(1.3, 0.5, 0.05).unwrap();
        let table = Floor { height: 0.55, ..floor };
        let wall = Floor { normal: [0.0, 0.0, -1.0], height: 3.0 };
        let (depth, rays) = render(&[(floor, |_| true), (table, |p| p[0] > -0.3 && p[2] < 2.0), (wall, |_| true)]);
        let found = find(&depth, &rays, &RansacParams::DEFAULT).unwrap();
        assert!((found.height - 1.3).abs() < 5e-3, "{found:?}");
        assert!(dot(found.normal, floor.normal) > 0.9999);
    }

    #[test]
    fn walls_and_nothing_are_no_floor() {
        let wall = Floor { normal: [0.0, 0.0, -1.0], height: 2.0 };
        let (depth, rays) = render(&[(wall, |_| true)]);
        assert_eq!(find(&depth, &rays, &RansacParams::DEFAULT), None);
        let (depth, rays) = render(&[]);
        assert_eq!(find(&depth, &rays, &RansacParams::DEFAULT), None);
    }

    #[test]
    fn a_plane_at_an_impossible_height_is_no_floor() {
        let low = Floor::from_pose(0.1, 0.3, 0.0).unwrap();
        let (depth, rays) = render(&[(low, |_| true)]);
        assert_eq!(find(&depth, &rays, &RansacParams::DEFAULT), None);
    }
}
