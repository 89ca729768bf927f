//! The left half: what the camera saw, with the clusters' outlines.

use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::*;
use embedded_graphics::primitives::Rectangle;

use super::text::{LABEL_HEIGHT, Labels};
use super::{Canvas, GREY, colour_of};
use crate::runner::Processed;

/// Width of this part in pixels.
pub(super) const WIDTH: u32 = 640;
/// Height of this part in pixels.
pub(super) const HEIGHT: u32 = 480;
/// Pixels of this part per pixel of the pipeline's images.
const SCALE: i32 = 2;

/// Greys of the thin outlines, in turn: one of them is seen on any ground.
const DASHES: [[u8; 3]; 2] = [[205; 3], [75; 3]];

/// Fewest pixels (of QVGA) of a rejected cluster whose reason is written.
const WORTH_A_LABEL: u32 = 400;

/// Draws the image, the outlines and the labels.
pub(super) fn draw(canvas: &mut Canvas, processed: &Processed<'_>) {
    let images = &processed.frame.images;
    match &images.colour {
        Some(colour) => photograph(canvas, colour, images.size),
        None => depth(canvas, &images.depth_mm(), images.size),
    }
    if processed.workspace.report.floor.is_none() {
        // Nothing after the floor belongs to this frame.
        return;
    }
    outlines(canvas, processed);
    labels(canvas, processed);
}

/// For each column or row of the canvas the range of the image's, `from` of them onto `to`.
fn ranges(from: u16, to: u32) -> Vec<(usize, usize)> {
    let (from, to) = (usize::from(from), to as usize);
    (0..to).map(|i| (i * from / to, ((i + 1) * from).div_ceil(to))).collect()
}

/// The colour image at this part's size: means of what falls into a pixel.
fn photograph(canvas: &mut Canvas, rgb: &[u8], size: (u16, u16)) {
    let (columns, rows) = (ranges(size.0, WIDTH), ranges(size.1, HEIGHT));
    let pixels = rgb.as_chunks::<3>().0;
    let at = |x: usize, y: usize| pixels.get(y * usize::from(size.0) + x).copied().unwrap_or_default();
    for (y, &(top, bottom)) in rows.iter().enumerate() {
        for (x, &(left, right)) in columns.iter().enumerate() {
            let mut sum = [0u32; 3];
            for (v, u) in (top..bottom).flat_map(|v| (left..right).map(move |u| (v, u))) {
                for (sum, value) in sum.iter_mut().zip(at(u, v)) {
                    *sum += u32::from(value);
                }
            }
            let count = ((bottom - top) * (right - left)) as u32;
            canvas.set(x as i32, y as i32, sum.map(|s| (s / count.max(1)) as u8));
        }
    }
}

/// The depth in grey where there is no colour: near is bright, no reading dark blue.
fn depth(canvas: &mut Canvas, mm: &[u16], size: (u16, u16)) {
    let (columns, rows) = (ranges(size.0, WIDTH), ranges(size.1, HEIGHT));
    for (y, &(v, _)) in rows.iter().enumerate() {
        for (x, &(u, _)) in columns.iter().enumerate() {
            let colour = match mm.get(v * usize::from(size.0) + u).copied().unwrap_or(0) {
                0 => [10, 10, 45],
                mm => [(230 - (u32::from(mm) / 28).min(190)) as u8; 3],
            };
            canvas.set(x as i32, y as i32, colour);
        }
    }
}

/// The border of each cluster's pixels: wide and coloured for candidates, thin and grey for the rejected.
fn outlines(canvas: &mut Canvas, processed: &Processed<'_>) {
    let (labels, clusters) = (&processed.workspace.images.labels, &processed.workspace.report.clusters);
    let colours: Vec<Option<Rgb888>> = (0..clusters.len()).map(|i| colour_of(processed.report, i)).collect();
    let filled = fill_pinholes(labels);
    let at = |u: i32, v: i32| {
        let row = usize::try_from(v).ok().and_then(|v| filled.get(v));
        row.and_then(|row| row.get(usize::try_from(u).ok()?)).copied().unwrap_or(0)
    };
    for (v, row) in filled.iter().enumerate() {
        for (u, &label) in row.iter().enumerate() {
            let Some(index) = usize::from(label).checked_sub(1) else { continue };
            if clusters.get(index).is_none_or(|c| c.is_noise()) {
                continue;
            }
            let (u, v) = (u as i32, v as i32);
            let (left, right, above, below) =
                (at(u - 1, v) != label, at(u + 1, v) != label, at(u, v - 1) != label, at(u, v + 1) != label);
            let (x, y) = (SCALE * u, SCALE * v);
            for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let on_side = (left && dx == 0) || (right && dx == 1) || (above && dy == 0) || (below && dy == 1);
                match colours[index] {
                    Some(c) if left || right || above || below => canvas.set(x + dx, y + dy, [c.r(), c.g(), c.b()]),
                    None if on_side => canvas.set(x + dx, y + dy, DASHES[((x / 4 + y / 4) & 1) as usize]),
                    _ => {}
                }
            }
        }
    }
}

/// The labels with single missing pixels given to the cluster around them: speckles would be drawn as borders.
fn fill_pinholes(labels: &[[u16; 320]; 240]) -> Vec<[u16; 320]> {
    let mut filled = labels.to_vec();
    for _ in 0..2 {
        let before = filled.clone();
        for v in 1..239 {
            for u in 1..319 {
                if before[v][u] != 0 {
                    continue;
                }
                let around = [before[v][u - 1], before[v][u + 1], before[v - 1][u], before[v + 1][u]];
                let most = around.into_iter().max().unwrap_or(0);
                if around.iter().filter(|&&l| l == most).count() >= 3 {
                    filled[v][u] = most;
                }
            }
        }
    }
    filled
}

/// Number, best class and score of each candidate, above it; the reason of each larger rejected cluster, within it.
fn labels(canvas: &mut Canvas, processed: &Processed<'_>) {
    let mut labels = Labels::new(Rectangle::new(Point::zero(), Size::new(WIDTH, HEIGHT)));
    let clusters = &processed.workspace.report.clusters;
    for detection in &processed.report.detections {
        let index = detection.id - 1;
        let (Some(cluster), Some(colour)) = (clusters.get(index), colour_of(processed.report, index)) else { continue };
        let [u0, v0, u1, _] = cluster.bbox.map(|c| SCALE * i32::from(c));
        let text = match detection.results.first() {
            Some(best) => format!("{} {} {:.2}", detection.id, best.class_id, best.score),
            None => detection.id.to_string(),
        };
        labels.write(canvas, &text, (u0 + u1) / 2, v0 - LABEL_HEIGHT as i32 - 1, colour);
    }
    for rejected in &processed.report.rejected {
        let Some(cluster) = clusters.get(rejected.id - 1).filter(|c| c.pixels >= WORTH_A_LABEL) else { continue };
        let [u0, v0, u1, v1] = cluster.bbox.map(|c| SCALE * i32::from(c));
        let text = format!("{} {}", rejected.id, rejected.reason);
        labels.write(canvas, &text, (u0 + u1) / 2, (v0 + v1) / 2, GREY);
    }
}
