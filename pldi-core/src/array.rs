//! Small matrices.

/// Rows become columns.
#[inline(always)]
pub(crate) const fn transposed<T: Copy>([a, b, c]: [[T; 3]; 3]) -> [[T; 3]; 3] {
    [[a[0], b[0], c[0]], [a[1], b[1], c[1]], [a[2], b[2], c[2]]]
}
