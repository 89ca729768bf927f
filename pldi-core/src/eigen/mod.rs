//! The direction in which a set of points spreads least: the eigenvector of the smallest eigenvalue of a symmetric
//! 3x3 matrix, in a bounded number of operations.
//!
//! The smallest root of the characteristic polynomial of a positive semi-definite matrix is reached from 0 by
//! Newton's method from below, without overshooting; the eigenvector is then orthogonal to the rows of C - lambda I.

pub mod fixed;

use crate::math;

/// Newton steps at most. A separated root needs four or five; a double root halves its error each step, and
/// then the direction is undetermined anyway.
const STEPS: usize = 10;

/// Below this ratio of the middle to the largest eigenvalue the points lie on a line, as far as f32 can tell.
const LINE: f32 = 2e-6;

/// A symmetric 3x3 matrix: xx, xy, xz, yy, yz, zz.
pub type Symmetric3 = [f32; 6];

/// The direction (not normalised, of either sign) of the smallest eigenvalue of a positive semi-definite matrix;
/// `None` where the rank is below 2 (points on a line, or one point) and no direction is determined.
pub fn least_direction(c: &Symmetric3) -> Option<[f32; 3]> {
    let [xx, xy, xz, yy, yz, zz] = *c;
    let trace = xx + yy + zz;
    // Written so that NaN fails the test.
    if !(trace > 1e-18) {
        return None;
    }
    // Scaled to a trace of 1, so that no product leaves the range of f32.
    let s = 1.0 / trace;
    let [xx, xy, xz, yy, yz, zz] = [xx * s, xy * s, xz * s, yy * s, yz * s, zz * s];
    let (mxx, myy, mzz) = (yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy);
    let minors = mxx + myy + mzz;
    let determinant = xx * mxx + xy * (xz * yz - xy * zz) + xz * (xy * yz - xz * yy);

    // f(l) = determinant - minors l + l^2 - l^3
    let mut least = 0.0f32;
    for _ in 0..STEPS {
        let value = determinant - least * (minors - least * (1.0 - least));
        let slope = minors - least * (2.0 - 3.0 * least);
        if !(value > 0.0 && slope > 0.0) {
            break;
        }
        let step = value / slope;
        least += step;
        if step <= 1e-7 * least {
            break;
        }
    }
    // The two others have the sum 1 - least and this product.
    let (sum, product) = (1.0 - least, minors - least * (1.0 - least));
    if !(product > LINE * sum * sum) {
        return None;
    }

    let rows = [[xx - least, xy, xz], [xy, yy - least, yz], [xz, yz, zz - least]];
    let candidates = [cross(rows[0], rows[1]), cross(rows[0], rows[2]), cross(rows[1], rows[2])];
    let mut best = candidates[0];
    for candidate in &candidates[1..] {
        if dot(*candidate, *candidate) > dot(best, best) {
            best = *candidate;
        }
    }
    // Scaled to about 1, because squares of products of the matrix's entries come near the subnormal numbers.
    let largest = best[0].abs().max(best[1].abs()).max(best[2].abs());
    if !(largest > 1e-12) {
        return None;
    }
    Some(best.map(|v| v / largest))
}

/// The direction of [`least_direction`] with length 1.
pub fn least_normal(c: &Symmetric3) -> Option<[f32; 3]> {
    let d = least_direction(c)?;
    let s = 1.0 / math::sqrt(dot(d, d));
    Some(d.map(|v| v * s))
}

/// Scalar product.
#[inline(always)]
pub(crate) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product.
#[inline(always)]
pub(crate) fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Q diag(values) Q^T with the rotation of a unit quaternion, and the axis of the smallest value.
    fn matrix(values: [f32; 3], q: [f32; 4]) -> (Symmetric3, [f32; 3]) {
        let s = 1.0 / q.iter().map(|v| v * v).sum::<f32>().sqrt();
        let [w, x, y, z] = q.map(|v| v * s);
        let axes = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)],
            [2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)],
            [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)],
        ];
        let entry = |i: usize, j: usize| (0..3).map(|k| values[k] * axes[k][i] * axes[k][j]).sum();
        ([entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)], axes[0])
    }

    #[test]
    fn lines_and_points_have_no_normal() {
        assert_eq!(least_normal(&[0.0; 6]), None);
        assert_eq!(least_normal(&[1e-4, 0.0, 0.0, 0.0, 0.0, 0.0]), None);
        assert_eq!(least_normal(&[1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4]), None);
        assert_eq!(least_normal(&[f32::NAN, 0.0, 0.0, 1.0, 0.0, 1.0]), None);
    }

    #[test]
    fn an_exact_plane_has_its_normal() {
        assert_eq!(least_normal(&[2e-4, 0.0, 0.0, 0.0, 0.0, 3e-4]).map(|n| n[1].abs()), Some(1.0));
    }

    proptest! {
        #[test]
        fn the_axis_of_the_smallest_eigenvalue_is_found(
            q in proptest::array::uniform4(-1.0f32..1.0),
            thin in 0.0f32..0.4, middle in 0.5f32..1.0, scale in 1e-8f32..1e3,
        ) {
            prop_assume!(q.iter().map(|v| v * v).sum::<f32>() > 0.01);
            let (c, axis) = matrix([thin * scale, middle * scale, scale], q);
            let n = least_normal(&c).unwrap();
            prop_assert!(dot(n, axis).abs() > 1.0 - 1e-5, "{n:?} {axis:?}");
        }

        #[test]
        fn any_matrix_ends_without_a_nan(c in proptest::array::uniform6(any::<f32>())) {
            if let Some(n) = least_direction(&c) {
                prop_assert!(n.iter().all(|v| v.is_finite()));
            }
        }
    }
}
