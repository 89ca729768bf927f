//! The sums over the neighbours of one centre after the other: the form for machines with few registers and no instructions
//! for several numbers at once.

use super::group::{Centres, FRACTION, Group, Moments, SLOPE_BITS, high};
use super::normals::LANES;

/// Columns that are worked on at a time.
const CHUNK: usize = 64;

/// Offsets at a time: all lanes' neighbours lie in the chunk.
const OFFSETS: usize = CHUNK - LANES;

/// x, y and z of a point in fine units, and nothing.
type Point = [i16; 4];

/// [`Moments`] of all centres.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Sums([Moments; LANES]);

impl Sums {
    /// Those of one centre.
    #[inline(always)]
    pub fn lane(&self, i: usize) -> Moments {
        self.0.get(i).copied().unwrap_or_default()
    }
}

/// Memory for a part of a row: filling it with zeros for each group would cost as much as some centres.
#[derive(Debug)]
#[allow(missing_copy_implementations, reason = "not to be copied by accident")]
pub struct Scratch {
    factors: [i32; CHUNK],
    points: [Point; CHUNK],
}

impl Default for Scratch {
    fn default() -> Self {
        Self { factors: [0; CHUNK], points: [[0; 4]; CHUNK] }
    }
}

/// The sums over the neighbours of a group's centres.
#[inline(always)]
pub fn sums<const W: usize, const H: usize>(group: &Group<'_, W, H>, scratch: &mut Scratch) -> Sums {
    let mut sums = Sums::default();
    let Scratch { factors, points } = scratch;
    // The lanes that have a centre.
    let mut lanes = [Lane { point: [0; 3], limit: -1, depth: 0, lane: 0 }; LANES];
    let mut taken = 0;
    for i in 0..LANES {
        if group.centres.limit[i] >= 0
            && let Some(lane) = lanes.get_mut(taken)
        {
            *lane = Lane::new(&group.centres, i);
            taken += 1;
        }
    }
    let lanes = lanes.get(..taken).unwrap_or(&[]);
    let last = lanes.last().map_or(0, |lane| lane.lane);
    let columns = group.window.columns;
    let offsets = 2 * columns + 1;
    let mut chunk = 0;
    while chunk < offsets {
        // The column of the chunk's first place; may lie outside of the image.
        let base = group.u as i32 - columns + chunk;
        let places = CHUNK.min((offsets - chunk) as usize + LANES);
        for (i, factor) in factors.iter_mut().enumerate().take(places) {
            *factor = usize::try_from(base + i as i32).map_or(0, |column| group.x_factor(column));
        }
        for row in group.rows() {
            let reach = row.reach as i32;
            // Offsets of the chunk that are in reach, and at which a lane is inside of the image.
            let from = (columns - reach - chunk).max(0).max(1 - LANES as i32 - base);
            let to = (columns + reach + 1 - chunk).min(OFFSETS as i32).min(W as i32 - base);
            if from >= to {
                continue;
            }
            let count = (to - from) as usize;
            let (Some(factors), Some(points)) =
                (factors.get(from as usize..), points.get_mut(..(count + last).min(CHUNK)))
            else {
                continue;
            };
            project(row.depths, base + from, factors, [row.factor, group.z_factor], group.kept, points);
            let row = Slope { step: row.step, y: i32::from(row.y), shift: group.centres.shift };
            for lane in lanes {
                let i = lane.lane;
                if let (Some(points), Some(moments)) = (points.get(i..i + count), sums.0.get_mut(i)) {
                    add(points, lane, &row, moments);
                }
            }
        }
        chunk += OFFSETS as i32;
    }
    sums
}

/// A centre.
#[derive(Clone, Copy)]
struct Lane {
    point: [i32; 3],
    limit: i32,
    depth: u16,
    lane: usize,
}

impl Lane {
    fn new(centres: &Centres, i: usize) -> Self {
        let point = centres.point.map(|c| i32::from(c[i]));
        Self { point, limit: i32::from(centres.limit[i]), depth: centres.depth[i], lane: i }
    }
}

/// What y is in a row, see [`super::group::Row`], and the moments' unit.
struct Slope {
    step: i32,
    y: i32,
    shift: u32,
}

/// Brings pixels of a row, from column `first` on, to the fine unit: depths clamped, times the rays' factors (x; y, z). What
/// lies outside of the image counts as too near.
#[inline(never)]
fn project<const W: usize>(
    depths: &[u16; W],
    first: i32,
    x: &[i32],
    [y, z]: [i32; 2],
    [nearest, farthest]: [u16; 2],
    points: &mut [Point],
) {
    let outside = (-first).max(0) as usize;
    let nothing = [0, 0, high(z, nearest), 0];
    points.iter_mut().take(outside).for_each(|point| *point = nothing);
    let depths = depths.get((first + outside as i32) as usize..).unwrap_or(&[]);
    let inside = depths.len();
    for ((depth, x), point) in depths.iter().zip(x.iter().skip(outside)).zip(points.iter_mut().skip(outside)) {
        let depth = (*depth).max(nearest).min(farthest);
        *point = [high(*x, depth), high(y, depth), high(z, depth), 0];
    }
    points.iter_mut().skip(outside + inside).for_each(|point| *point = nothing);
}

/// Adds a lane's neighbours in a row. A function of its own: what is live in its loop just fits the registers.
#[inline(never)]
fn add(points: &[Point], lane: &Lane, row: &Slope, sums: &mut Moments) {
    let ([cx, cy, cz], shift) = (lane.point, row.shift);
    // Sums of x are below 2^14: the count goes above them.
    let (mut np, mut b, mut pp, mut pb, mut bb) = (1 << 15, 0, 0, 0, 0);
    for [x, y, z, _] in points {
        let [dx, dy, dz] = [i32::from(*x) - cx, i32::from(*y) - cy, i32::from(*z) - cz].map(|v| v as i16);
        let square = |v: i16| (i32::from(v) * i32::from(v)) >> 16;
        if square(dx) + square(dy) + square(dz) <= lane.limit {
            let (dx, dz) = (i32::from(dx) >> shift, i32::from(dz) >> shift);
            np += dx + (1 << 16);
            b += dz;
            pp += dx * dx;
            pb += dx * dz;
            bb += dz * dz;
        }
    }
    let (n, p) = (np >> 16, (np & 0xFFFF) - (1 << 15));
    if n == 0 {
        return;
    }
    // q = q0 + y b for all neighbours in the row.
    let q0 = i32::from(high(row.step, lane.depth));
    let short = |v: i32| (v + (1 << (SLOPE_BITS - 1))) >> SLOPE_BITS;
    let q = n * q0 + ((b * row.y) >> SLOPE_BITS);
    let qb = b * q0 + short(bb) * row.y;
    sums.n += n;
    sums.p += p;
    sums.q += q;
    sums.b += b;
    sums.pp += pp;
    sums.pq += p * q0 + short(pb) * row.y;
    sums.pb += pb;
    sums.qq += (q >> FRACTION) * q0 + (qb >> (SLOPE_BITS + FRACTION)) * row.y;
    sums.qb += qb;
    sums.bb += bb;
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::super::lanes;
    use super::super::normals::Normals;
    use super::*;
    use crate::rays::fixed::{Intrinsics, Rays};
    use proptest::prelude::*;

    const W: usize = 80;
    const H: usize = 60;

    proptest! {
        #[test]
        fn one_centre_after_the_other_is_as_eight_at_once(
            base in 900u16..30_000, lean in -40i32..40, noise in proptest::collection::vec(0u16..200, W * H),
            holes in proptest::collection::vec(0u8..12, W * H), radius in prop_oneof![Just(320u16), 40u16..4000],
            u in 0usize..W, v in 0usize..H, focal in 30i32..90,
        ) {
            let camera = Intrinsics {
                width: W as u16, height: H as u16, fx: focal << 16, fy: focal << 16, cx: 39 << 16, cy: 30 << 16,
            };
            let rays = Rays::<W, H>::new(&camera).unwrap();
            let mut depth = [[0u16; W]; H];
            for (i, z) in depth.as_flattened_mut().iter_mut().enumerate() {
                let far = if holes[i] == 1 { 5000 } else { 0 };
                let plane = i32::from(base) + lean * (i % W) as i32;
                *z = if holes[i] == 0 { 0 } else { (plane.max(0) as u16).saturating_add(noise[i] + far) };
            }
            let normals = Normals::new(&depth, &rays, radius);
            let mut z = core::array::from_fn(|i| normals.depth_at(u + i, v));
            let nearest = z.iter().copied().filter(|z| *z > 0).min().unwrap_or(0);
            for z in &mut z {
                if z.saturating_sub(nearest) > 400 {
                    *z = 0;
                }
            }
            if let Some(group) = Group::new(&normals, z, u, v) {
                let (one, eight) = (sums(&group, &mut Scratch::default()), lanes::sums(&group, &mut lanes::Scratch));
                for i in 0..LANES {
                    prop_assert_eq!(one.lane(i), eight.lane(i), "{}", i);
                }
            }
        }
    }
}
