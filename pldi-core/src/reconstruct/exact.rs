//! The joint bilateral filter of equation 1 as it is written: a weighted mean over a window, three Gaussians.
//!
//! It costs seconds where the domain transform costs a millisecond, and serves as the reference that the
//! approximation is judged by.

use super::{FilterKind, FilterParams};
use crate::{DepthRange, Frame, Image, math};

/// Fills `depth` with the filtered depth in metres, 0 where the weights' sum stays below the weight floor.
///
/// The window reaches two spatial standard deviations. Colour enters as the Euclidean distance of (r, g, b). At a
/// pixel without a reading the depth's Gaussian is left out: there is no J_p to compare with.
/// Colour is left out for `FilterKind::Bilateral`; every other kind counts as `Exact`.
pub fn exact<const W: usize, const H: usize>(
    frame: &Frame<'_, W, H>,
    range: DepthRange,
    params: &FilterParams,
    depth: &mut Image<f32, W, H>,
) {
    let metres = |x: usize, y: usize| f32::from(range.apply(frame.depth[y][x])) * 1e-3;
    let colour = frame.colour.filter(|_| params.kind != FilterKind::Bilateral);
    let exponent = |sigma: f32| -0.5 / (sigma * sigma);
    let (space, hue, step) =
        (exponent(params.sigma_space), exponent(params.sigma_colour), exponent(params.sigma_depth));
    let reach = math::floor(2.0 * params.sigma_space) as usize;
    for (y, row) in depth.iter_mut().enumerate() {
        for (x, out) in row.iter_mut().enumerate() {
            let here = metres(x, y);
            let (mut sum, mut weights) = (0.0, 0.0);
            for v in y.saturating_sub(reach)..(y + reach + 1).min(H) {
                for u in x.saturating_sub(reach)..(x + reach + 1).min(W) {
                    let there = metres(u, v);
                    if there <= 0.0 {
                        continue;
                    }
                    let (dx, dy) = (u.abs_diff(x) as f32, v.abs_diff(y) as f32);
                    let mut e = space * (dx * dx + dy * dy);
                    if let Some(colour) = colour {
                        let square = |c: usize| {
                            let d = f32::from(colour[y][x][c]) - f32::from(colour[v][u][c]);
                            d * d
                        };
                        e += hue * (square(0) + square(1) + square(2));
                    }
                    if here > 0.0 {
                        e += step * (here - there) * (here - there);
                    }
                    let w = math::exp(e);
                    sum += w * there;
                    weights += w;
                }
            }
            *out = if weights > params.weight_floor { sum / weights } else { 0.0 };
        }
    }
}
