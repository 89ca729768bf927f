//! Whether depth and colour are registered: do the depth's jumps lie where the colour has edges, and would they fit better
//! if the depth were shifted?
//!
//! A jump counts at the pixel of the nearer surface: there the object ends, and there its colour does. The colour's edges
//! are ranked within their image, so that contrast does not matter: random places have a mean of 0.5.

use crate::input::Images;

/// Shifts up to so many pixels of QVGA each way are tried.
const REACH: i32 = 12;
/// Least jump in mm, and as a share of the depth in percent: noise and slanted surfaces stay below.
const JUMP: (u16, u16) = (80, 6);
/// The two sides of a jump may lie so many pixels of QVGA apart: the nearer one's shadow is between them.
const SHADOW: usize = 8;
/// Farther surfaces have ragged borders, in mm.
const FARTHEST: u16 = 5000;
/// Fewest jumps that say anything.
const FEWEST: u64 = 300;
/// A best shift must exceed the mean of all shifts by so much to mean anything...
const ABOVE_MEAN: f64 = 0.06;
/// ... and the best shift that is not beside it by so much.
const ABOVE_REST: f64 = 0.02;
/// What is beside a shift: so many pixels of QVGA each way.
const BESIDE: i32 = 4;

/// How well depth and colour fit, over the frames added.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Agreement {
    /// Pixels of the images as given per pixel of the images compared (larger ones than 640x480 are thinned).
    step: u16,
    reach: i32,
    /// Sum of the colour's ranks at the jumps, for each shift, row by row.
    sums: Vec<f64>,
    jumps: u64,
}

/// What the sums say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Finding {
    /// Number of jumps looked at.
    pub(super) jumps: u64,
    /// Mean rank at the jumps, without a shift.
    pub(super) here: f64,
    /// Mean rank at the jumps with the best shift.
    pub(super) best: f64,
    /// Mean rank at the jumps over all shifts.
    pub(super) mean: f64,
    /// The best shift of the depth in pixels, right and down.
    pub(super) shift: [i32; 2],
    /// Whether that shift stands out from the others.
    pub(super) clear: bool,
    /// Whether it is no more than what a sensor's ragged outlines make.
    pub(super) small: bool,
}

impl Agreement {
    /// For images `factor` times as large as QVGA.
    pub(super) fn new(factor: u16) -> Self {
        let reach = REACH * i32::from(factor.clamp(1, 2));
        let side = (2 * reach + 1) as usize;
        Self { step: (factor / 2).max(1), reach, sums: vec![0.0; side * side], jumps: 0 }
    }

    /// Adds a frame; one without colour says nothing.
    pub(super) fn add(&mut self, images: &Images) {
        let Some(colour) = &images.colour else { return };
        let step = usize::from(self.step);
        let (wide, high) = (usize::from(images.size.0), usize::from(images.size.1));
        let thin = |v: usize| (0..wide).step_by(step).map(move |u| v * wide + u);
        let places: Vec<usize> = (0..high).step_by(step).flat_map(thin).collect();
        let (width, height) = (wide.div_ceil(step), high.div_ceil(step));
        let rgb = colour.as_chunks::<3>().0;
        let depth: Vec<u16> = places.iter().map(|&i| images.depth.get(i).copied().unwrap_or(0)).collect();
        let colour: Vec<[u8; 3]> = places.iter().map(|&i| rgb.get(i).copied().unwrap_or_default()).collect();
        for across in [true, false] {
            // Jumps along rows belong to edges that cross the rows, and likewise for columns.
            let ranks = ranks(&edges(&colour, width, height, across));
            let jumps = jumps(&depth, width, height, across, SHADOW * self.reach as usize / REACH as usize);
            self.sum(&ranks, &jumps, width, height);
        }
    }

    fn sum(&mut self, ranks: &[f32], jumps: &[(usize, usize)], width: usize, height: usize) {
        let reach = self.reach as usize;
        let inside = |&&(u, v): &&(usize, usize)| u >= reach && v >= reach && u + reach < width && v + reach < height;
        let side = 2 * reach + 1;
        for &(u, v) in jumps.iter().filter(inside) {
            self.jumps += 1;
            for (dy, sums) in self.sums.chunks_exact_mut(side).enumerate() {
                let start = (v + dy - reach) * width + u - reach;
                let Some(line) = ranks.get(start..start + side) else { continue };
                for (sum, rank) in sums.iter_mut().zip(line) {
                    *sum += f64::from(*rank);
                }
            }
        }
    }

    /// What the frames say together; `None` where there are too few jumps.
    pub(super) fn finding(&self) -> Option<Finding> {
        if self.jumps < FEWEST {
            return None;
        }
        let side = 2 * self.reach + 1;
        let share = |i: usize| self.sums[i] / self.jumps as f64;
        let shift = |i: usize| [i as i32 % side - self.reach, i as i32 / side - self.reach];
        let all = 0..self.sums.len();
        // Of equal ones the smallest shift.
        let better = |a: &usize, b: &usize| {
            let length = |i: usize| shift(i).iter().map(|c| c * c).sum::<i32>();
            share(*a).total_cmp(&share(*b)).then(length(*b).cmp(&length(*a)))
        };
        let best = all.clone().max_by(better)?;
        let [dx, dy] = shift(best);
        let beside = BESIDE * self.reach / REACH;
        let away = |i: &usize| (shift(*i)[0] - dx).abs().max((shift(*i)[1] - dy).abs()) > beside;
        let rest = all.clone().filter(away).map(share).fold(0.0, f64::max);
        let mean = all.map(share).sum::<f64>() / self.sums.len() as f64;
        let at_end = dx.abs().max(dy.abs()) >= self.reach - 1;
        let step = i32::from(self.step);
        Some(Finding {
            jumps: self.jumps,
            here: share(self.sums.len() / 2),
            best: share(best),
            mean,
            shift: [dx * step, dy * step],
            clear: !at_end && share(best) - mean >= ABOVE_MEAN && share(best) - rest >= ABOVE_REST,
            // 1.5 pixels of QVGA.
            small: 2 * REACH * dx.abs().max(dy.abs()) <= 3 * self.reach,
        })
    }
}

/// How much the colour changes at each pixel, along the rows or along the columns.
fn edges(colour: &[[u8; 3]], width: usize, height: usize, across: bool) -> Vec<u8> {
    let mut out = vec![0; colour.len()];
    let (dx, dy) = if across { (1, 0) } else { (0, 1) };
    for v in dy..height.saturating_sub(dy) {
        for u in dx..width.saturating_sub(dx) {
            let (before, behind) = (colour[(v - dy) * width + u - dx], colour[(v + dy) * width + u + dx]);
            let change = (0..3).map(|c| before[c].abs_diff(behind[c]));
            out[v * width + u] = change.max().unwrap_or(0);
        }
    }
    out
}

/// The share of pixels whose value is below each pixel's, those of the same value counted by half.
fn ranks(values: &[u8]) -> Vec<f32> {
    let mut counts = [0u32; 256];
    for &value in values {
        counts[usize::from(value)] += 1;
    }
    let mut below = 0;
    let ranks = counts.map(|count| {
        let middle = below as f32 + 0.5 * count as f32;
        below += count;
        middle / values.len().max(1) as f32
    });
    values.iter().map(|&v| ranks[usize::from(v)]).collect()
}

/// The pixels at which a nearer surface ends, along the rows or along the columns.
fn jumps(depth: &[u16], width: usize, height: usize, across: bool, shadow: usize) -> Vec<(usize, usize)> {
    let (lines, length) = if across { (height, width) } else { (width, height) };
    let place = |line: usize, i: usize| if across { (i, line) } else { (line, i) };
    let mut out = Vec::new();
    for line in 0..lines {
        let mut last: Option<(usize, u16)> = None;
        for i in 0..length {
            let (u, v) = place(line, i);
            let z = depth[v * width + u];
            if z == 0 {
                continue;
            }
            if let Some((j, before)) = last {
                let (near, at) = if before < z { (before, j) } else { (z, i) };
                let least = JUMP.0.max((u32::from(near) * u32::from(JUMP.1) / 100) as u16);
                if z.abs_diff(before) > least && i - j <= shadow && near < FARTHEST {
                    out.push(place(line, at));
                }
            }
            last = Some((i, z));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::DepthScale;

    /// A near square on a far wall, with colours to match, the depth `shift` to the left and up; every colour the same
    /// where `plain`.
    fn frame(shift: (i32, i32), plain: bool) -> Images {
        let inside = |x: i32, y: i32| (60..260).contains(&x) && (60..180).contains(&y);
        let pixels = || (0..240).flat_map(|y| (0..320).map(move |x| (x, y)));
        let depth = pixels().map(|(x, y)| if inside(x + shift.0, y + shift.1) { 1500 } else { 3000 }).collect();
        // Texture everywhere, so that ranks are spread.
        let texture = |x: i32, y: i32| ((x * 79 + y * y * 113 + x * x * y) % 37) as u8;
        let colour = pixels().flat_map(|(x, y)| match (plain, inside(x, y)) {
            (true, _) => [90; 3],
            (false, true) => [180 + texture(x, y), 60, 60],
            (false, false) => [texture(x, y), 120, 90],
        });
        Images { size: (320, 240), depth, scale: DepthScale::Millimetres, colour: Some(colour.collect()) }
    }

    fn finding(frame: &Images) -> Finding {
        let mut agreement = Agreement::new(1);
        agreement.add(frame);
        agreement.finding().unwrap()
    }

    #[test]
    fn registered_images_fit_best_as_they_are() {
        let found = finding(&frame((0, 0), false));
        assert!(found.clear && found.small && found.best > 0.95, "{found:?}");
    }

    #[test]
    fn a_shift_is_measured() {
        for shift in [(5, 0), (0, -4), (-7, 6)] {
            let found = finding(&frame(shift, false));
            assert!(found.clear && !found.small, "{found:?}");
            let [dx, dy] = found.shift;
            // The edge is between two pixels: either fits.
            assert!((dx - shift.0).abs() <= 1 && (dy - shift.1).abs() <= 1, "{shift:?} {found:?}");
        }
    }

    #[test]
    fn plain_images_and_flat_depth_say_nothing() {
        assert!(!finding(&frame((0, 0), true)).clear);
        let mut agreement = Agreement::new(1);
        agreement.add(&Images { depth: vec![1000; 320 * 240], ..frame((0, 0), false) });
        agreement.add(&Images { colour: None, ..frame((0, 0), false) });
        assert_eq!(agreement.finding(), None);
    }
}
