//! The 128x128 view: bilinear sampling of N through a homography.

use super::framing::Frontal;
use crate::Image;
use crate::descriptor::View;
use crate::math;
use crate::wavelet::SIZE;

/// Fills the view: its row 0 is the square's upper side, its column 0 the left one.
///
/// Pixels that do not carry `label` count as 0, in the interpolation too: the object stands on black.
pub fn warp<const W: usize, const H: usize>(
    n: &Image<u16, W, H>,
    labels: &Image<u16, W, H>,
    label: u16,
    frontal: &Frontal,
    view: &mut View,
) {
    let step = 2.0 * frontal.half / SIZE as f32;
    let offset = |i: usize| (i as f32 + 0.5 - SIZE as f32 / 2.0) * step;
    let [left, top, right, bottom] = frontal.bbox.map(f32::from);
    for (j, row) in view.iter_mut().enumerate() {
        for (i, out) in row.iter_mut().enumerate() {
            let at = frontal.to_image.apply(frontal.centre[0] + offset(i), frontal.centre[1] + offset(j));
            // Beside the object's pixels there is nothing to interpolate. Written so that NaN is beside them.
            *out = match at {
                Some([u, v]) if u > left - 1.0 && v > top - 1.0 && u < right + 1.0 && v < bottom + 1.0 => {
                    sample(n, labels, label, u, v)
                }
                _ => 0,
            };
        }
    }
}

/// N at a position between pixels, rounded to nearest; 0 beside the object and beside the image.
#[inline(always)]
fn sample<const W: usize, const H: usize>(
    n: &Image<u16, W, H>,
    labels: &Image<u16, W, H>,
    label: u16,
    u: f32,
    v: f32,
) -> u16 {
    let (column, row) = (math::floor(u), math::floor(v));
    let (a, b) = (u - column as f32, v - row as f32);
    let inside = usize::try_from(column).ok().zip(usize::try_from(row).ok());
    let square = inside.and_then(|(x, y)| Some((pair(labels, x, y)?, pair(n, x, y)?)));
    let [[upper_left, upper_right], [lower_left, lower_right]] = match square {
        Some((labels, n)) => core::array::from_fn(|j| {
            core::array::from_fn(|i| if labels[j][i] == label { f32::from(n[j][i]) } else { 0.0 })
        }),
        // At the image's border, pixel by pixel.
        None => core::array::from_fn(|j| {
            core::array::from_fn(|i| {
                let (x, y) = ((column + i as i32) as usize, (row + j as i32) as usize);
                match (labels.get(y).and_then(|r| r.get(x)), n.get(y).and_then(|r| r.get(x))) {
                    (Some(l), Some(n)) if *l == label => f32::from(*n),
                    _ => 0.0,
                }
            })
        }),
    };
    let upper = upper_left + a * (upper_right - upper_left);
    let lower = lower_left + a * (lower_right - lower_left);
    (upper + b * (lower - upper) + 0.5) as u16
}

/// The 2x2 pixels from column `x` and row `y` on; `None` where they are not all inside of the image.
#[inline(always)]
fn pair<const W: usize, const H: usize>(image: &Image<u16, W, H>, x: usize, y: usize) -> Option<[[u16; 2]; 2]> {
    let rows: &[[u16; W]; 2] = image.get(y..)?.first_chunk()?;
    Some([*rows[0].get(x..)?.first_chunk()?, *rows[1].get(x..)?.first_chunk()?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::Homography;
    use crate::view::framing::{Framing, frontal};
    use crate::{Floor, Intrinsics};
    use proptest::prelude::*;

    const W: usize = 320;
    const H: usize = 240;
    type Plane16 = Box<Image<u16, W, H>>;

    /// Pixels of the rectangle s in -w/2..w/2, t in 0..h on the plane through a floor point, N growing with t.
    fn panel(pitch: f32, centroid: [f32; 2], w: f32, h: f32) -> (Plane16, Plane16, Homography, [u16; 4]) {
        let axes = Floor::from_pose(1.2, pitch, 0.0).unwrap().axes();
        let to_image = Homography::plane_to_image(&axes, &Intrinsics::PRIMESENSE_QVGA, centroid).unwrap();
        let to_plane = to_image.inverse().unwrap();
        let image = || -> Plane16 { vec![[0; W]; H].into_boxed_slice().try_into().unwrap() };
        let (mut n, mut labels, mut bbox) = (image(), image(), [u16::MAX, u16::MAX, 0, 0]);
        for v in 0..H {
            for u in 0..W {
                if let Some([s, t]) = to_plane.apply(u as f32, v as f32)
                    && s.abs() <= w / 2.0
                    && (0.0..=h).contains(&t)
                {
                    labels[v][u] = 7;
                    n[v][u] = 20_000 + (30_000.0 * t / h) as u16;
                    bbox = [bbox[0].min(u as u16), bbox[1].min(v as u16), bbox[2].max(u as u16), bbox[3].max(v as u16)];
                }
            }
        }
        (n, labels, to_image, bbox)
    }

    fn view_of(framing: Framing, pitch: f32, centroid: [f32; 2], w: f32, h: f32) -> Box<View> {
        let (n, labels, to_image, bbox) = panel(pitch, centroid, w, h);
        let frontal = frontal(framing, &labels, 7, bbox, &to_image, 1.2, 0.0035).unwrap();
        let mut view: Box<View> = vec![[0; SIZE]; SIZE].into_boxed_slice().try_into().unwrap();
        warp(&n, &labels, 7, &frontal, &mut view);
        view
    }

    fn mean_difference(a: &View, b: &View) -> f32 {
        let sum: f32 = a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| f32::from(a.abs_diff(*b))).sum();
        sum / (SIZE * SIZE) as f32 / 65535.0
    }

    #[test]
    fn a_metric_view_has_the_objects_size_in_its_place() {
        let view = view_of(Framing::Metric { side: 2.0 }, 0.3, [0.4, 2.0], 0.5, 1.0);
        // 1 m is 64 pixels: columns 48..80, rows 64..128.
        assert!(view[100][50] > 0 && view[100][77] > 0 && view[66][64] > 0);
        assert!(view[100][46] == 0 && view[100][81] == 0 && view[61][64] == 0);
        // N of 20000 + 30000 t at t = 0.5 m.
        assert!((f32::from(view[96][64]) - 35_000.0).abs() < 1000.0, "{}", view[96][64]);
    }

    #[test]
    fn a_fitted_view_leaves_a_margin_around_the_object() {
        let view = view_of(Framing::Fit, 0.2, [0.0, 2.0], 0.4, 0.9);
        // The farthest pixel lies at 1/1.25 of the half side: 12.8 pixels from the border, 13 and something with the
        // pixel's own size.
        let seen = |j: usize| view[j].iter().any(|v| *v > 0);
        let first = (0..SIZE).find(|j| seen(*j)).unwrap().min(127 - (0..SIZE).rfind(|j| seen(*j)).unwrap());
        assert!((12..=15).contains(&first), "{first}");
        assert!(view.as_flattened().iter().filter(|v| **v > 0).count() > 3200);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]

        /// Distance, bearing and the camera's pitch are taken out, as far as pixels allow.
        #[test]
        fn views_do_not_depend_on_where_the_object_stands(
            right in -0.9f32..0.9, forward in 2.3f32..3.2, pitch in 0.2f32..0.4, fit in any::<bool>(),
        ) {
            let framing = if fit { Framing::Fit } else { Framing::Metric { side: 2.0 } };
            let here = view_of(framing, 0.3, [0.0, 2.0], 0.6, 0.8);
            let there = view_of(framing, pitch, [right, forward], 0.6, 0.8);
            prop_assert!(mean_difference(&here, &there) < 0.035, "{}", mean_difference(&here, &there));
        }
    }
}
