//! The projective light diffusion image in integers, see the module above.

mod group;
#[cfg(target_arch = "x86_64")]
mod lanes;
pub mod normals;
#[cfg_attr(target_arch = "x86_64", allow(dead_code, reason = "the twin is in use; the tests compare them"))]
mod single;
mod window;

use core::ops::RangeInclusive;

use crate::Image;
use crate::rays::fixed::Rays;
use normals::{LANES, Normals, Scratch};

/// Fills `n` within `bounds` (first and last column and row) where `wanted(column, row)` holds, and puts 0 elsewhere and
/// where no normal is determined.
///
/// `depth` is the reconstructed depth in 1/8 mm (0 = none), `radius` the normals' r_max in 1/8 mm (40..=4000, others are
/// clamped; 320 is 4 cm). Every pixel with depth counts as a neighbour, wanted or not. The value is in units of 1/65535,
/// rounded to nearest. Any depths and rays are taken; no sum overflows, see [`normals`].
pub fn diffusion<const W: usize, const H: usize>(
    depth: &Image<u16, W, H>,
    rays: &Rays<W, H>,
    radius: u16,
    bounds: [RangeInclusive<usize>; 2],
    wanted: impl Fn(usize, usize) -> bool,
    n: &mut Image<u16, W, H>,
) {
    let normals = Normals::new(depth, rays, radius);
    let mut scratch: Scratch = Default::default();
    let [columns, rows] = bounds;
    let end = (columns.end() + 1).min(W);
    for (v, out) in n.iter_mut().enumerate() {
        out.fill(0);
        if !rows.contains(&v) {
            continue;
        }
        let y = rays.y().get(v).copied().unwrap_or(0);
        let mut u = *columns.start();
        while u < end {
            // From the next wanted pixel on, so that fewer lanes are idle.
            if !wanted(u, v) || normals.depth_at(u, v) == 0 {
                u += 1;
                continue;
            }
            let mut z = [0; LANES];
            for (i, z) in z.iter_mut().enumerate().take(end - u) {
                if wanted(u + i, v) {
                    *z = normals.depth_at(u + i, v);
                }
            }
            let directions = normals.directions(z, u, v, &mut scratch);
            let lanes = out.iter_mut().zip(rays.x()).skip(u).zip(directions);
            for ((out, x), direction) in lanes {
                *out = direction.map_or(0, |direction| cosine(direction, *x, y));
            }
            u += LANES;
        }
    }
}

/// |n . v| / (|n| |v|) in units of 1/65535, rounded (equation 3): of a normal with components of at most 2^29 and the ray
/// (x, y, 1), Q26. At most 1 unit off.
fn cosine(normal: [i32; 3], x: i32, y: i32) -> u16 {
    let (n, v) = (normal.map(i64::from), [i64::from(x), i64::from(y), 1 << 26]);
    // |x|, |y| < 2^31: below 2^62.
    let along = (n[0] * v[0] + n[1] * v[1] + n[2] * v[2]).unsigned_abs();
    if along == 0 {
        return 0;
    }
    let n2 = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) as u64;
    let v2 = (v[0] * v[0]) as u64 + (v[1] * v[1]) as u64 + (v[2] * v[2]) as u64;
    // Each as a mantissa of 32 bits; their exponents sum up to the quotient's.
    let mantissa = |x: u64| (x << x.leading_zeros()) >> 32;
    let (zn, zv, za) = (n2.leading_zeros(), v2.leading_zeros(), along.leading_zeros());
    let lengths = mantissa(n2) * mantissa(v2);
    let square = mantissa(along) * mantissa(along);
    let (zl, zs) = (lengths.leading_zeros(), square.leading_zeros());
    // Mantissas of 32 and 16 bits: the quotient, N^2 times a power of 2, has 16 or 17.
    let divisor = ((((lengths << zl) >> 47) + 1) >> 1) as u32;
    let quotient = ((square << zs) >> 32) as u32 / divisor.max(1);
    // N^2 = square 2^(-2 za) / (lengths 2^(-zn - zv)) = quotient 2^-16 2^(zn + zv + zl - 2 za - zs), in Q32:
    let exponent = 16 + (zn + zv + zl) as i32 - (2 * za + zs) as i32;
    let square = if exponent >= 0 {
        u64::from(quotient) << exponent.min(40)
    } else {
        u64::from(quotient) >> (-exponent).min(40)
    };
    // N in Q16.
    let root = u32::try_from(square).map_or(1 << 16, |square| {
        let root = square.isqrt();
        root + u32::from(square - root * root > root)
    });
    ((u64::from(root) * 65_535 + (1 << 15)) >> 16).min(65_535) as u16
}

#[cfg(test)]
mod tests;
