//! The 128x128 view in fixed point: bilinear sampling of N through a homography.

use super::{Frontal, Homography};
use crate::Image;
use crate::fixed::{reciprocal, where_not_negative};
use crate::wavelet::SIZE;
use crate::wavelet::fixed::{Plane, SHIFT};
use core::ops::Range;

/// Fills the plane that the wavelet transform works on with the view, N shifted by [`SHIFT`]: row 0 is the square's upper side, column 0
/// the left one.
///
/// Pixels that do not carry `label` (not 0) count as 0, in the interpolation too: the object stands on black. Positions are
/// within 2^-12 pixels, the weights have 12 bits, N is rounded to nearest.
pub fn warp<const W: usize, const H: usize>(
    n: &Image<u16, W, H>,
    labels: &Image<u8, W, H>,
    label: u8,
    frontal: &Frontal,
    plane: &mut Plane,
) {
    let scan = Scan::new(frontal);
    for (j, row) in plane.iter_mut().enumerate() {
        row.fill(0);
        let start = scan.row(j);
        let columns = scan.columns(start, frontal.bbox);
        let mut at: [i64; 3] =
            core::array::from_fn(|k| start[k].wrapping_add(scan.right[k].wrapping_mul(columns.start as i64)));
        for out in row.get_mut(columns).unwrap_or(&mut []) {
            let [u, v, w] = at.map(|c| (c >> 32) as i32);
            // Positive w of 2^9 and more: below, it is rounding errors that would be divided by.
            if w >= 1 << 9 {
                let inverse = reciprocal(w as u32);
                if let (Some(u), Some(v)) = (position(u, inverse), position(v, inverse)) {
                    *out = i32::from(sample(n, labels, label, u, v)) << SHIFT;
                }
            }
            at = core::array::from_fn(|k| at[k].wrapping_add(scan.right[k]));
        }
    }
}

/// A coordinate over the last one (of 2^9 and more) in Q12; `None` far beside any image.
#[inline(always)]
fn position(coordinate: i32, (mantissa, shift): (u32, u32)) -> Option<i32> {
    // Below 2^31 * 2^32; the shift is 41 at least.
    let product = i64::from(coordinate) * i64::from(mantissa);
    let shift = shift - 12;
    if shift >= 32 {
        // Shifts of 64 bits are slow where numbers have 32.
        return Some((product >> 32) as i32 >> (shift - 32));
    }
    i32::try_from(product >> shift).ok()
}

/// The homogeneous pixel coordinates of the view's samples: linear in row and column.
struct Scan {
    /// Of the sample at the upper left.
    first: [i64; 3],
    /// To the next column.
    right: [i64; 3],
    /// To the next row.
    down: [i64; 3],
}

impl Scan {
    /// All coordinates are scaled alike so that the largest within the view has 61 or 62 bits.
    fn new(frontal: &Frontal) -> Self {
        let Homography(map) = frontal.to_image;
        // Entries times Q26, halved so that what follows stays below 2^63: steps (half/64) below 2^54, the middle below 2^61.1,
        // corners below 2^62.1.
        let half = i64::from(frontal.half);
        let right = map.map(|r| (i64::from(r[0]) * half) >> 7);
        let down = map.map(|r| (i64::from(r[1]) * half) >> 7);
        let first: [i64; 3] = core::array::from_fn(|k| {
            let [x, y] = frontal.centre.map(i64::from);
            let middle =
                ((i64::from(map[k][0]) * x) >> 1) + ((i64::from(map[k][1]) * y) >> 1) + (i64::from(map[k][2]) << 25);
            // 63.5 steps up and to the left.
            middle - (right[k] * 127 + down[k] * 127) / 2
        });
        let corners = |k: usize| {
            let across = right[k] * (SIZE as i64 - 1);
            let below = first[k] + down[k] * (SIZE as i64 - 1);
            first[k].unsigned_abs()
                | (first[k] + across).unsigned_abs()
                | below.unsigned_abs()
                | (below + across).unsigned_abs()
        };
        let bits = 64 - (corners(0) | corners(1) | corners(2)).leading_zeros();
        let scaled = |v: [i64; 3]| v.map(|v| if bits > 62 { v >> (bits - 62) } else { v << (62 - bits) });
        Self { first: scaled(first), right: scaled(right), down: scaled(down) }
    }

    /// The first sample of row `j`.
    fn row(&self, j: usize) -> [i64; 3] {
        core::array::from_fn(|k| self.first[k] + self.down[k] * j as i64)
    }

    /// The columns of a row (by its first sample) that may lie less than a pixel beside `bbox`.
    fn columns(&self, start: [i64; 3], bbox: [u16; 4]) -> Range<usize> {
        let [left, top, right, bottom] = bbox.map(i64::from);
        let (mut first, mut end) = (0, SIZE);
        // The first or the second coordinate over the last one is at least (side 1) or at most (side -1) the bound: in 2^-16
        // of the numbers, so that a bound below 2^17 fits.
        for (first_one, side, bound) in
            [(true, 1, left - 1), (false, 1, top - 1), (true, -1, right + 1), (false, -1, bottom + 1)]
        {
            let beyond = |[u, v, w]: [i64; 3]| {
                let coordinate = if first_one { u } else { v };
                side * ((coordinate >> 18) - bound * (w >> 18))
            };
            let (a, b) = where_not_negative(beyond(start), beyond(self.right), SIZE);
            (first, end) = (first.max(a), end.min(b));
        }
        first..end.max(first)
    }
}

/// N at a position between pixels in Q12, rounded to nearest; 0 beside the object and beside the image.
#[inline(always)]
fn sample<const W: usize, const H: usize>(
    n: &Image<u16, W, H>,
    labels: &Image<u8, W, H>,
    label: u8,
    u: i32,
    v: i32,
) -> u16 {
    let (column, row) = (u >> 12, v >> 12);
    let (a, b) = ((u & 0xFFF) as u32, (v & 0xFFF) as u32);
    let inside = usize::try_from(column).ok().zip(usize::try_from(row).ok());
    let square = inside.and_then(|(x, y)| Some((pair(labels, x, y)?, pair(n, x, y)?)));
    let [[upper_left, upper_right], [lower_left, lower_right]] = match square {
        Some(([upper, lower], n)) => {
            // A byte is 0 where a pixel carries the label.
            let four = u32::from(u16::from_le_bytes(upper)) | u32::from(u16::from_le_bytes(lower)) << 16;
            let others = four ^ (u32::from(label) * 0x0101_0101);
            if others == 0 {
                [[u32::from(n[0][0]), u32::from(n[0][1])], [u32::from(n[1][0]), u32::from(n[1][1])]]
            } else if others.wrapping_sub(0x0101_0101) & !others & 0x8080_8080 == 0 {
                // No byte is 0.
                return 0;
            } else {
                let of = |carries: u8, n: u16| if carries == label { u32::from(n) } else { 0 };
                [[of(upper[0], n[0][0]), of(upper[1], n[0][1])], [of(lower[0], n[1][0]), of(lower[1], n[1][1])]]
            }
        }
        // At the image's border, pixel by pixel.
        None => core::array::from_fn(|j| {
            core::array::from_fn(|i| {
                let (x, y) = (column.wrapping_add(i as i32) as usize, row.wrapping_add(j as i32) as usize);
                match (labels.get(y).and_then(|r| r.get(x)), n.get(y).and_then(|r| r.get(x))) {
                    (Some(l), Some(n)) if *l == label => u32::from(*n),
                    _ => 0,
                }
            })
        }),
    };
    // Q12, kept in Q4; times Q12 it is N in Q16 and at most 65535 * 2^16.
    let upper = (upper_left * (4096 - a) + upper_right * a + (1 << 7)) >> 8;
    let lower = (lower_left * (4096 - a) + lower_right * a + (1 << 7)) >> 8;
    ((upper * (4096 - b) + lower * b + (1 << 15)) >> 16) as u16
}

/// The 2x2 pixels from column `x` and row `y` on; `None` where they are not all inside of the image.
#[inline(always)]
fn pair<T: Copy, const W: usize, const H: usize>(image: &Image<T, W, H>, x: usize, y: usize) -> Option<[[T; 2]; 2]> {
    let rows: &[[T; W]; 2] = image.get(y..)?.first_chunk()?;
    Some([*rows[0].get(x..)?.first_chunk()?, *rows[1].get(x..)?.first_chunk()?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view;
    use crate::view::fixed::framing::{Framing, frontal};
    use crate::view::fixed::homography::tests::axes;
    use proptest::prelude::*;

    const W: usize = 320;
    const H: usize = 240;

    fn boxed<T: Copy, const W: usize, const H: usize>(value: T) -> Box<Image<T, W, H>> {
        vec![[value; W]; H].into_boxed_slice().try_into().ok().unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        /// The view of a textured panel in both arithmetics, cut by the image's border now and then.
        #[test]
        fn views_agree_with_the_float_ones(
            pitch in 0.0f32..0.6, roll in -0.1f32..0.1, right in -1.8f32..1.8, forward in 1.0f32..3.8,
            width in 0.1f32..1.2, height in 0.2f32..1.6, fit in any::<bool>(), bits in any::<u16>(),
        ) {
            let camera = crate::Intrinsics::PRIMESENSE_QVGA;
            let rays = crate::rays::fixed::Rays::<W, H>::new(&crate::rays::fixed::Intrinsics::new(&camera).unwrap()).unwrap();
            let (float_axes, fixed_axes) = axes(pitch, roll);
            let to_image = view::Homography::plane_to_image(&float_axes, &camera, [right, forward]).unwrap();
            let to_plane = to_image.inverse().unwrap();
            let (mut n, mut labels, mut wide) = (boxed(0u16), boxed(0u8), boxed(0u16));
            let mut bbox = [u16::MAX, u16::MAX, 0, 0];
            for v in 0..H {
                for u in 0..W {
                    n[v][u] = bits.wrapping_mul((u * 7 + v * 13) as u16) | 0x8000;
                    if let Some([s, t]) = to_plane.apply(u as f32, v as f32)
                        && s.abs() <= width / 2.0 && (0.0..=height).contains(&t)
                    {
                        (labels[v][u], wide[v][u]) = (7, 7);
                        bbox = [bbox[0].min(u as u16), bbox[1].min(v as u16), bbox[2].max(u as u16), bbox[3].max(v as u16)];
                    }
                }
            }
            prop_assume!(bbox[0] < bbox[2] && bbox[1] < bbox[3]);
            let framing = if fit { view::Framing::Fit } else { view::Framing::Metric { side: 2.0 } };
            let float = view::framing::frontal(framing, &wide, 7, bbox, &to_image, 1.2, 1.0 / camera.fx).unwrap();
            let mut expected: Box<crate::descriptor::View> = boxed(0);
            view::warp::warp(&n, &wide, 7, &float, &mut expected);
            let framing = if fit { Framing::Fit } else { Framing::Metric { side: 256_000 } };
            let plane_to_rays = Homography::plane_to_rays(&fixed_axes, [right, forward].map(|v| (v * 128_000.0) as i32)).unwrap();
            let fixed = frontal(framing, &labels, 7, bbox, &rays, &plane_to_rays, 153_600).unwrap();
            let mut plane = boxed(-1);
            warp(&n, &labels, 7, &fixed, &mut plane);
            let mut sum = 0.0;
            for (a, b) in expected.as_flattened().iter().zip(plane.as_flattened()) {
                prop_assert!(*b >= 0 && *b % 128 == 0);
                let difference = f64::from(*a) - f64::from(*b >> SHIFT);
                sum += difference * difference;
            }
            let rms = (sum / (SIZE * SIZE) as f64).sqrt() / 65_535.0;
            prop_assert!(rms < 0.002, "{rms}");
        }

        /// Whatever the map and the square: no overflow.
        #[test]
        fn extremes(
            entries in proptest::array::uniform9(-(1i32 << 30) + 1..1 << 30), centre in proptest::array::uniform2(any::<i32>()),
            half in 1i32.., bbox in proptest::array::uniform4(any::<u16>()), shift in 0u32..31,
        ) {
            let e = entries.map(|v| v >> shift);
            let to_image = Homography([[e[0], e[1], e[2]], [e[3], e[4], e[5]], [e[6], e[7], entries[8]]]);
            let (n, labels, mut plane) = (boxed::<_, W, H>(u16::MAX), boxed(1), boxed(0));
            warp(&n, &labels, 1, &Frontal { to_image, centre, half, bbox }, &mut plane);
            prop_assert!(plane.as_flattened().iter().all(|v| (0..=65_535 << SHIFT).contains(v)));
        }
    }
}
