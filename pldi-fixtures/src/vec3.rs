//! Arithmetic on 3-vectors, in both float widths.

use core::ops::{Add, Mul, Sub};

/// a + b.
pub(crate) fn add<T: Copy + Add<Output = T>>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// a - b.
pub(crate) fn sub<T: Copy + Sub<Output = T>>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a s.
pub(crate) fn scale<T: Copy + Mul<Output = T>>(a: [T; 3], s: T) -> [T; 3] {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// a . b.
pub(crate) fn dot<T: Copy + Mul<Output = T> + Add<Output = T>>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a x b.
pub(crate) fn cross<T: Copy + Mul<Output = T> + Sub<Output = T>>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a / |a|, or `None` for a vector too short to have a direction.
pub(crate) fn unit(a: [f32; 3]) -> Option<[f32; 3]> {
    let norm = dot(a, a).sqrt();
    (norm > 1e-12).then(|| scale(a, 1.0 / norm))
}

/// The point between a (t = 0) and b (t = 1).
pub(crate) fn lerp(a: [f32; 3], b: [f32; 3], t: f32) -> [f32; 3] {
    add(a, scale(sub(b, a), t))
}

/// Two unit vectors that complete the unit vector `axis` to a right-handed frame (first, second, axis).
pub(crate) fn frame(axis: [f32; 3]) -> ([f32; 3], [f32; 3]) {
    // Any vector far from the axis will do as the start.
    let reference = if axis[2].abs() < 0.9 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
    let first = unit(cross(reference, axis)).unwrap_or([1.0, 0.0, 0.0]);
    (first, cross(axis, first))
}
