//! The transform for machines that compute one number at a time: line by line, with signed products that are added as they
//! are made, and without the black that surrounds an object.

use super::{HIGH, LOW, Plane};
use crate::wavelet::{HALF, SIZE};

/// Both filters' taps by pairs of samples: two of the scaling filter, two of the wavelet filter.
type Taps = [[i32; 4]; 4];

static TAPS: Taps = [
    [LOW[0], LOW[1], HIGH[0], HIGH[1]],
    [LOW[2], LOW[3], HIGH[2], HIGH[3]],
    [LOW[4], LOW[5], HIGH[4], HIGH[5]],
    [LOW[6], LOW[7], HIGH[6], HIGH[7]],
];

/// Samples that come before the first output's own.
const BEFORE: usize = 3;

/// Samples beyond both ends of a line.
const BEYOND: usize = 6;

/// A line of up to [`SIZE`] samples, continued periodically, in pairs: output o weighs the pairs o to o + 3.
struct Line([[i32; 2]; (SIZE + BEYOND) / 2]);

/// What [`transform`](super::transform) does.
pub fn transform(plane: &mut Plane) {
    // Taps are cheaper to load in pairs than to build where they are used.
    let taps = core::hint::black_box(&TAPS);
    let mut line = Line([[0; 2]; (SIZE + BEYOND) / 2]);
    let mut size = SIZE;
    while size >= 2 {
        // Never larger; the compiler does not see it.
        let half = (size / 2).min(HALF);
        for row in plane.iter_mut().take(size) {
            line.fill(row.iter().take(size));
            let (low, high) = row.split_at_mut(half);
            line.weigh(taps, size, low.iter_mut().zip(high));
        }
        for x in 0..size {
            // Within the row, for the compiler too.
            let x = x % SIZE;
            line.fill(plane.iter().take(size).map(|row| &row[x]));
            let (low, high) = plane.split_at_mut(half);
            line.weigh(taps, size, low.iter_mut().zip(high).map(|(low, high)| (&mut low[x], &mut high[x])));
        }
        size /= 2;
    }
}

impl Line {
    /// Takes the samples of a line, without their continuation.
    #[inline(always)]
    fn fill<'a>(&mut self, samples: impl Iterator<Item = &'a i32>) {
        for (to, from) in self.0.as_flattened_mut()[BEFORE..].iter_mut().zip(samples) {
            *to = *from;
        }
    }

    /// Continues the line beyond its ends.
    #[inline(always)]
    fn close(&mut self, size: usize) {
        let samples = self.0.as_flattened_mut();
        for i in (0..BEFORE).chain(size + BEFORE..size + BEYOND) {
            let from = BEFORE + ((i + 4 * size - BEFORE) & (size - 1));
            let sample = samples.get(from).copied().unwrap_or(0);
            if let Some(to) = samples.get_mut(i) {
                *to = sample;
            }
        }
    }

    /// Writes the outputs of both filters.
    #[inline(always)]
    fn weigh<'a>(&mut self, taps: &Taps, size: usize, mut outputs: impl Iterator<Item = (&'a mut i32, &'a mut i32)>) {
        self.close(size);
        let used = self.0.get(..(size + BEYOND) / 2).unwrap_or(&[]);
        let black = |pair: &[i32; 2]| pair[0] | pair[1] == 0;
        let leading = used.iter().take_while(|pair| black(pair)).count();
        if leading == used.len() {
            // Zeros they are.
            return;
        }
        let trailing = used.iter().rev().take_while(|pair| black(pair)).count();
        let skipped = leading.saturating_sub(3);
        let inside = used.get(skipped..used.len() - trailing.saturating_sub(3)).unwrap_or(&[]);
        for (low, high) in outputs.by_ref().take(skipped) {
            (*low, *high) = (0, 0);
        }
        for (pairs, (low, high)) in inside.windows(4).zip(&mut outputs) {
            (*low, *high) = weigh(taps, pairs);
        }
        for (low, high) in outputs {
            (*low, *high) = (0, 0);
        }
    }
}

/// One output of each filter: sums of products below 2^62, rounded to nearest.
#[inline(always)]
fn weigh(taps: &Taps, pairs: &[[i32; 2]]) -> (i32, i32) {
    let (mut low, mut high) = (1i64 << 29, 1i64 << 29);
    for ([a, b], taps) in pairs.iter().zip(taps) {
        low += i64::from(*a) * i64::from(taps[0]);
        low += i64::from(*b) * i64::from(taps[1]);
        high += i64::from(*a) * i64::from(taps[2]);
        high += i64::from(*b) * i64::from(taps[3]);
    }
    ((low >> 30) as i32, (high >> 30) as i32)
}
