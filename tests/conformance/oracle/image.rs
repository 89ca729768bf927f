//! The truth of the stages that work on images, in float64: filters, normals and N, densities.

use pldi_core::Intrinsics;

/// Numbers of the filter (Table II).
pub const SIGMA_SPACE: f64 = 12.0;
/// In levels.
pub const SIGMA_COLOUR: f64 = 10.0;
/// In metres.
pub const SIGMA_DEPTH: f64 = 0.04;
/// A pixel is valid above this.
pub const WEIGHT_FLOOR: f64 = 1e-3;

/// Joint reconstruction by the domain transform: equation 2 with the ratios of Gastal and Oliveira (2011), their
/// recursive filter on depth times mask and on the mask, 0 where the mask stays below the floor.
pub fn domain_transform(depth: &[f64], colour: Option<&[u8]>, w: usize, h: usize) -> Vec<f64> {
    let apart = |p: usize, q: usize| {
        let contrast =
            colour.map_or(0.0, |c| (0..3).map(|k| (f64::from(c[3 * p + k]) - f64::from(c[3 * q + k])).abs()).sum());
        let step = if depth[p] > 0.0 && depth[q] > 0.0 { (depth[p] - depth[q]).abs() } else { 0.0 };
        1.0 + SIGMA_SPACE / SIGMA_COLOUR * contrast + SIGMA_SPACE / SIGMA_DEPTH * step
    };
    let mut lines: Vec<Vec<usize>> = (0..h).map(|y| (0..w).map(|x| y * w + x).collect()).collect();
    lines.extend((0..w).map(|x| (0..h).map(|y| y * w + x).collect::<Vec<_>>()));
    let mut images = [depth.to_vec(), depth.iter().map(|z| f64::from(u8::from(*z > 0.0))).collect()];
    for power in [4.0, 2.0, 1.0] {
        let sigma = SIGMA_SPACE * 3.0f64.sqrt() * power / 63.0f64.sqrt();
        for line in &lines {
            for image in &mut images {
                let towards = |image: &mut Vec<f64>, from: usize, to: usize| {
                    let feedback = libm::exp(-(2.0f64.sqrt()) / sigma * apart(from, to));
                    image[to] += feedback * (image[from] - image[to]);
                };
                line.windows(2).for_each(|pair| towards(image, pair[0], pair[1]));
                line.windows(2).rev().for_each(|pair| towards(image, pair[1], pair[0]));
            }
        }
    }
    let [sum, mask] = images;
    sum.iter().zip(&mask).map(|(s, m)| if *m > WEIGHT_FLOOR { s / m } else { 0.0 }).collect()
}

/// Equation 1 in a window of two standard deviations.
pub fn bilateral(depth: &[f64], colour: &[u8], w: usize, h: usize) -> Vec<f64> {
    let gauss = |square: f64, sigma: f64| libm::exp(-square / (2.0 * sigma * sigma));
    let place = |i: usize| ((i % w) as f64, (i / w) as f64);
    let mean = |p: usize| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for q in (0..w * h).filter(|q| depth[*q] > 0.0) {
            let (dx, dy) = (place(p).0 - place(q).0, place(p).1 - place(q).1);
            if dx.abs().max(dy.abs()) > 2.0 * SIGMA_SPACE {
                continue;
            }
            let hue = (0..3).map(|k| f64::from(colour[3 * p + k]) - f64::from(colour[3 * q + k])).map(|d| d * d).sum();
            let mut weight = gauss(dx * dx + dy * dy, SIGMA_SPACE) * gauss(hue, SIGMA_COLOUR);
            if depth[p] > 0.0 {
                let step = depth[p] - depth[q];
                weight *= gauss(step * step, SIGMA_DEPTH);
            }
            sum += weight * depth[q];
            weights += weight;
        }
        if weights > WEIGHT_FLOOR { sum / weights } else { 0.0 }
    };
    (0..w * h).map(mean).collect()
}

/// The point seen at a pixel.
pub fn point(k: &Intrinsics, u: usize, v: usize, z: f64) -> [f64; 3] {
    let axis = |i: usize, c: f32, f: f32| (i as f64 - f64::from(c)) / f64::from(f) * z;
    [axis(u, k.cx, k.fx), axis(v, k.cy, k.fy), z]
}

/// Equation 3 at one pixel: principal components of all points within `radius` of the pixel's point; 0 where they
/// determine no normal.
pub fn light(depth: &[f64], k: &Intrinsics, radius: f64, u: usize, v: usize) -> f64 {
    let (w, h) = (usize::from(k.width), usize::from(k.height));
    let z = depth[v * w + u];
    if z <= radius {
        return 0.0; // within the radius of the camera itself
    }
    let here = point(k, u, v, z);
    // The whole image where it must be.
    let reach = (radius * f64::from(k.fx.max(k.fy)) / (z - radius)).min(1000.0) as usize + 2;
    let mut near = Vec::new();
    for y in v.saturating_sub(reach)..(v + reach + 1).min(h) {
        for x in u.saturating_sub(reach)..(u + reach + 1).min(w) {
            let there = point(k, x, y, depth[y * w + x]);
            let offset: [f64; 3] = core::array::from_fn(|i| there[i] - here[i]);
            if there[2] > 0.0 && dot(offset, offset) <= radius * radius {
                near.push(offset);
            }
        }
    }
    if near.len() < 3 {
        return 0.0;
    }
    let count = near.len() as f64;
    let mean: [f64; 3] = core::array::from_fn(|i| near.iter().map(|p| p[i]).sum::<f64>() / count);
    let covariance = core::array::from_fn(|i| {
        core::array::from_fn(|j| near.iter().map(|p| (p[i] - mean[i]) * (p[j] - mean[j])).sum::<f64>() / count)
    });
    let [(_, n), (middle, _), (largest, _)] = jacobi(covariance);
    if middle <= 1e-6 * largest {
        return 0.0; // a line
    }
    dot(n, here).abs() / dot(here, here).sqrt()
}

/// The scalar product.
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Eigenvalues, smallest first, and unit eigenvectors of a symmetric matrix: Jacobi's rotations, a fixed number of them.
fn jacobi(mut a: [[f64; 3]; 3]) -> [(f64, [f64; 3]); 3] {
    let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..12 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q] == 0.0 {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let t = if theta >= 0.0 { 1.0 } else { -1.0 } / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            for row in &mut a {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            let (ap, aq) = (a[p], a[q]);
            a[p] = core::array::from_fn(|k| c * ap[k] - s * aq[k]);
            a[q] = core::array::from_fn(|k| s * ap[k] + c * aq[k]);
            let (vp, vq) = (vectors[p], vectors[q]);
            vectors[p] = core::array::from_fn(|k| c * vp[k] - s * vq[k]);
            vectors[q] = core::array::from_fn(|k| s * vp[k] + c * vq[k]);
        }
    }
    let mut pairs = core::array::from_fn(|i| (a[i][i], vectors[i]));
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    pairs
}
