//! The direction of least spread in integers, see the module above: the same steps, with products of 62 bits and
//! divisions of 32.

use crate::fixed::unit;

/// Newton steps at most, see the float twin's.
const STEPS: usize = 12;

/// The last step: below 2^-20 of the trace, what is left is about its square.
const LAST_STEP: i64 = 1 << 12;

/// Ratio of the middle to the largest eigenvalue in Q32 below which the points lie on a line: 2e-6.
const LINE: i64 = 8590;

/// A symmetric 3x3 matrix: xx, xy, xz, yy, yz, zz, in any common unit; beyond 2^60 in absolute value they saturate.
pub type Symmetric3 = [i64; 6];

/// The direction of the smallest eigenvalue of a positive semi-definite matrix, of either sign; its largest component
/// lies within 2^28..2^29 in absolute value. `None` where the rank is below 2 (points on a line, or one point).
///
/// Entries count to 2^-30 of the trace: the error of the angle is about 2^-29 of the trace over the difference of the two
/// smaller eigenvalues. A matrix that is not positive semi-definite has some direction or none.
pub fn least_direction(c: &Symmetric3) -> Option<[i32; 3]> {
    const MOST: i64 = 1 << 60;
    let mut c = *c;
    if c.iter().fold(0, |all, v| all | v.unsigned_abs()) >= MOST as u64 {
        c = c.map(|v| v.clamp(-MOST, MOST));
    }
    let trace = c[0] + c[3] + c[5];
    // No entry of a semi-definite matrix exceeds the trace; this bounds everything below.
    if trace <= 0 || c.iter().any(|v| v.abs() > trace) {
        return None;
    }
    // Trace below 2^30 and at least 2^29 (Q30; rounding down may take 3 units).
    let bits = 64 - trace.leading_zeros();
    let c = c.map(|v| (if bits > 30 { v >> (bits - 30) } else { v << (30 - bits) }) as i32);
    let [xx, xy, xz, yy, yz, zz] = c;
    let trace = xx + yy + zz;

    // Products Q60, at most 2^60; differences of two at most 2^61.
    let cross = |a: i32, b: i32, c: i32, d: i32| wide(a, b) - wide(c, d);
    let (mxx, mxy, mxz) = (cross(yy, zz, yz, yz), cross(xz, yz, xy, zz), cross(xy, yz, xz, yy));
    let minors = mxx + cross(xx, zz, xz, xz) + cross(xx, yy, xy, xy);
    if minors <= 0 || minors > MOST {
        return None;
    }
    // Minors Q(62 + up), the more bits the nearer to a line. Rows of cofactors are no longer than their trace.
    let up = (minors.leading_zeros() - 1).saturating_sub(4).min(28);
    let minors = (minors << 2) << up;
    let down = 28 - up;
    let determinant = (i64::from(xx).wrapping_mul(mxx >> down))
        .wrapping_add(i64::from(xy).wrapping_mul(mxy >> down))
        .wrapping_add(i64::from(xz).wrapping_mul(mxz >> down));

    // f(l) = determinant - minors l + trace l^2 - l^3, l in Q32, below half of the trace. Wrapping only where the matrix is
    // not semi-definite: l (trace - l) is at most the minors up to the smallest root. Halved factors below 2^32.
    let all = i64::from(trace) << 2;
    let times = |a: i64, b: i64| ((u64::from((a >> 1) as u32) * u64::from((b >> 1) as u32)) as i64) << up;
    let mut least = 0i64;
    let mut rest = minors;
    for _ in 0..STEPS {
        let value = determinant.wrapping_sub(wide((rest >> 30) as i32, least as i32) >> 2);
        let slope = minors.wrapping_sub(times(least, 2 * all - 3 * least));
        if value <= 0 || slope <= value {
            break;
        }
        // value / slope in Q32, rounded down to about 15 bits, so that no step overshoots.
        let (zv, zs) = (value.leading_zeros(), slope.leading_zeros());
        let quotient = ((value << zv) as u64 >> 32) as u32 / (((slope << zs) as u64 >> 48) as u32 + 1);
        let step = (u64::from(quotient) << 16 >> (zv - zs)) as i64;
        least += step;
        if 3 * least >= all {
            least = all / 3;
            rest = minors.wrapping_sub(times(least, all - least));
            break;
        }
        rest = minors.wrapping_sub(times(least, all - least));
        if step < LAST_STEP {
            break;
        }
    }
    // The two others have the sum trace - least and this product.
    let sum = (all - least) >> 2;
    if rest >> up <= ((sum * sum) >> 30) * LINE {
        return None;
    }

    // The longest column of the adjugate of C - least is that of its largest diagonal entry.
    let l = ((least + 2) >> 2) as i32;
    let (dx, dy, dz) = (xx - l, yy - l, zz - l);
    let (ax, ay, az) = (cross(dy, dz, yz, yz), cross(dx, dz, xz, xz), cross(dx, dy, xy, xy));
    let best = if ax >= ay && ax >= az {
        [ax, cross(xz, yz, xy, dz), cross(xy, yz, xz, dy)]
    } else if ay >= az {
        [cross(xz, yz, xy, dz), ay, cross(xy, xz, yz, dx)]
    } else {
        [cross(xy, yz, xz, dy), cross(xy, xz, yz, dx), az]
    };
    let largest = best[0].unsigned_abs() | best[1].unsigned_abs() | best[2].unsigned_abs();
    // 1e-12 in Q60: all directions are alike.
    if largest < 1 << 20 {
        return None;
    }
    let bits = 64 - largest.leading_zeros();
    Some(if bits > 29 { best.map(|v| (v >> (bits - 29)) as i32) } else { best.map(|v| (v << (29 - bits)) as i32) })
}

/// The whole product.
#[inline(always)]
fn wide(a: i32, b: i32) -> i64 {
    i64::from(a) * i64::from(b)
}

/// The direction of [`least_direction`] with length 1, Q30.
pub fn least_normal(c: &Symmetric3) -> Option<[i32; 3]> {
    unit(least_direction(c)?.map(i64::from))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Q diag(values) Q^T with the rotation of a quaternion, and the axis of the first value.
    fn matrix(values: [f64; 3], q: [f64; 4]) -> (Symmetric3, [f64; 3]) {
        let s = 1.0 / q.iter().map(|v| v * v).sum::<f64>().sqrt();
        let [w, x, y, z] = q.map(|v| v * s);
        let axes = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)],
            [2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)],
            [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)],
        ];
        let entry =
            |i: usize, j: usize| (0..3).map(|k| values[k] * axes[k][i] * axes[k][j]).sum::<f64>().round() as i64;
        ([entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)], axes[0])
    }

    /// Sine of the angle between two lines.
    fn sine(n: [i32; 3], axis: [f64; 3]) -> f64 {
        let n = n.map(|v| f64::from(v) / f64::from(1 << 30));
        let cross = [n[1] * axis[2] - n[2] * axis[1], n[2] * axis[0] - n[0] * axis[2], n[0] * axis[1] - n[1] * axis[0]];
        cross.iter().map(|v| v * v).sum::<f64>().sqrt()
    }

    #[test]
    fn lines_and_points_have_no_normal() {
        for big in [1i64, 3, 1000, 1 << 30, 1 << 57] {
            assert_eq!(least_normal(&[big, 0, 0, 0, 0, 0]), None);
            assert_eq!(least_normal(&[big, big, big, big, big, big]), None);
            assert_eq!(least_normal(&[big, -2 * big, 0, 4 * big, 0, 0]), None);
        }
        assert_eq!(least_normal(&[0; 6]), None);
        assert_eq!(least_normal(&[-5, 0, 0, 1, 0, 1]), None);
        assert_eq!(least_normal(&[1 << 40, 0, 0, 1 << 20, 0, 0]), None);
    }

    #[test]
    fn exact_planes_have_their_normals() {
        assert_eq!(least_normal(&[2000, 0, 0, 0, 0, 3000]).map(|n| n[1].abs()), Some(1 << 30));
        // Two equal eigenvalues beside a zero, and a plane through a diagonal.
        assert_eq!(least_normal(&[1 << 59, 0, 0, 1 << 59, 0, 0]).map(|n| n[2].abs()), Some(1 << 30));
        let n = least_normal(&[2, -1, -1, 2, -1, 2]).unwrap();
        assert!(n.iter().all(|v| (v.abs() - 619_925_131).abs() < 200), "{n:?}");
        // A flat line: the middle eigenvalue is 1e-4 of the largest.
        assert_eq!(least_normal(&[1_000_000, 0, 0, 100, 0, 0]).map(|n| n[2].abs()), Some(1 << 30));
    }

    #[test]
    fn equal_spread_in_all_directions_ends() {
        for one in [1i64, 1000, 1 << 40, 1 << 60] {
            if let Some(n) = least_normal(&[one, 0, 0, one, 0, one]) {
                assert!(n.iter().any(|v| v.abs() > 1 << 29), "{n:?}");
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        #[test]
        fn the_axis_of_the_smallest_eigenvalue_is_found(
            q in proptest::array::uniform4(-1.0f64..1.0),
            thin in 0.0f64..0.4, middle in 0.5f64..1.0, bits in 34.0f64..59.0,
        ) {
            prop_assume!(q.iter().map(|v| v * v).sum::<f64>() > 0.01);
            let scale = libm::exp2(bits);
            let (c, axis) = matrix([thin * scale, middle * scale, scale], q);
            let n = least_normal(&c).unwrap();
            prop_assert!(sine(n, axis) < 1e-6, "{n:?} {axis:?} {}", sine(n, axis));
        }

        #[test]
        fn narrow_strips_have_a_normal(
            q in proptest::array::uniform4(-1.0f64..1.0), thin in 0.0f64..0.5, middle in 1e-4f64..1.0,
        ) {
            prop_assume!(q.iter().map(|v| v * v).sum::<f64>() > 0.01);
            let scale = (1u64 << 50) as f64;
            let (c, axis) = matrix([thin * middle * scale, middle * scale, scale], q);
            let n = least_normal(&c).unwrap();
            prop_assert!(sine(n, axis) < 3e-8 / middle + 1e-7, "{n:?} {axis:?} {}", sine(n, axis));
        }

        #[test]
        fn the_float_twin_agrees(q in proptest::array::uniform4(-1.0f64..1.0), thin in 0.0f64..0.6, middle in 0.05f64..1.0) {
            prop_assume!(q.iter().map(|v| v * v).sum::<f64>() > 0.01);
            let (c, _) = matrix([thin * middle * 1e12, middle * 1e12, 1e12], q);
            let float = super::super::least_normal(&c.map(|v| v as f32 * 1e-12)).unwrap();
            prop_assert!(sine(least_normal(&c).unwrap(), float.map(f64::from)) < 1e-4);
        }

        #[test]
        fn any_matrix_ends(c in proptest::array::uniform6(any::<i64>()), shift in 0u32..64) {
            let c = c.map(|v| v >> shift);
            if let Some(d) = least_direction(&c) {
                let largest = d.iter().map(|v| v.unsigned_abs()).max().unwrap();
                prop_assert!((1 << 28..=1 << 29).contains(&largest), "{d:?}");
            }
        }
    }
}
