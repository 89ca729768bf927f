//! The recursive filter of the domain transform, both ways along rows and columns, on two images at a time
//! (Gastal and Oliveira 2011, section 5): `F[x] += a^d[x] (F[x-1] - F[x])` forth, then the same back.

use crate::Image;

/// Rows that are filtered side by side: a single row is one chain of dependent operations, eight chains keep a
/// superscalar core busy.
const ROWS: usize = 8;

/// Filters the rows of two images in place with the weights `w[y][x]` between the pixels x - 1 and x.
pub fn rows<const W: usize, const H: usize>(a: &mut Image<f32, W, H>, b: &mut Image<f32, W, H>, w: &Image<f32, W, H>) {
    let (a, a_rest) = a.as_chunks_mut::<ROWS>();
    let (b, b_rest) = b.as_chunks_mut::<ROWS>();
    let (w, w_rest) = w.as_chunks::<ROWS>();
    for ((a, b), w) in a.iter_mut().zip(b).zip(w) {
        block(a, b, w);
    }
    for ((a, b), w) in a_rest.iter_mut().zip(b_rest).zip(w_rest) {
        block(core::array::from_mut(a), core::array::from_mut(b), core::array::from_ref(w));
    }
}

/// Filters `R` rows at once.
fn block<const W: usize, const R: usize>(a: &mut [[f32; W]; R], b: &mut [[f32; W]; R], w: &[[f32; W]; R]) {
    if W == 0 {
        return;
    }
    let mut fa: [f32; R] = core::array::from_fn(|r| a[r][0]);
    let mut fb: [f32; R] = core::array::from_fn(|r| b[r][0]);
    for x in 1..W {
        for r in 0..R {
            fa[r] = a[r][x] + w[r][x] * (fa[r] - a[r][x]);
            fb[r] = b[r][x] + w[r][x] * (fb[r] - b[r][x]);
            a[r][x] = fa[r];
            b[r][x] = fb[r];
        }
    }
    for x in (1..W).rev() {
        for r in 0..R {
            fa[r] = a[r][x - 1] + w[r][x] * (fa[r] - a[r][x - 1]);
            fb[r] = b[r][x - 1] + w[r][x] * (fb[r] - b[r][x - 1]);
            a[r][x - 1] = fa[r];
            b[r][x - 1] = fb[r];
        }
    }
}

/// Filters the columns of two images in place with the weights `w[y][x]` between the rows y - 1 and y.
pub fn columns<const W: usize, const H: usize>(
    a: &mut Image<f32, W, H>,
    b: &mut Image<f32, W, H>,
    w: &Image<f32, W, H>,
) {
    for y in 1..H {
        if let ([.., a0], [a1, ..]) = a.split_at_mut(y) {
            blend(a1, a0, &w[y]);
        }
        if let ([.., b0], [b1, ..]) = b.split_at_mut(y) {
            blend(b1, b0, &w[y]);
        }
    }
    for y in (1..H).rev() {
        if let ([.., a0], [a1, ..]) = a.split_at_mut(y) {
            blend(a0, a1, &w[y]);
        }
        if let ([.., b0], [b1, ..]) = b.split_at_mut(y) {
            blend(b0, b1, &w[y]);
        }
    }
}

/// to += w (from - to), element by element.
fn blend<const W: usize>(to: &mut [f32; W], from: &[f32; W], w: &[f32; W]) {
    for x in 0..W {
        to[x] += w[x] * (from[x] - to[x]);
    }
}
