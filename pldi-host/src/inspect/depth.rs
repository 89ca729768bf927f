//! What depths a recording holds.

use serde::{Deserialize, Serialize};

/// Depths over all pixels looked at, in metres. Without any reading the distances are `None`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DepthSummary {
    /// Smallest.
    pub min: Option<f32>,
    /// 1 % are nearer.
    pub p1: Option<f32>,
    /// The median.
    pub p50: Option<f32>,
    /// 1 % are farther.
    pub p99: Option<f32>,
    /// Largest.
    pub max: Option<f32>,
    /// Share of pixels without a valid reading, 0..1.
    pub invalid: f32,
}

/// How often each depth occurs, in mm.
#[derive(Debug, Clone)]
pub(super) struct Histogram {
    counts: Vec<u64>,
}

impl Histogram {
    pub(super) fn new() -> Self {
        Self { counts: vec![0; 1 << 16] }
    }

    pub(super) fn add(&mut self, depth: &[u16]) {
        for &mm in depth {
            self.counts[usize::from(mm)] += 1;
        }
    }

    pub(super) fn summary(&self) -> DepthSummary {
        let (invalid, valid) = (self.counts[0], self.counts[1..].iter().sum::<u64>());
        // The smallest depth that at least `rank` readings do not exceed.
        let at = |rank: u64| {
            let mut sum = 0;
            let mut upwards = self.counts.iter().enumerate().skip(1);
            let found = upwards.find(|(_, n)| {
                sum += **n;
                sum >= rank.max(1)
            });
            found.map(|(mm, _)| mm as f32 / 1000.0)
        };
        let share = |percent: u64| at((valid * percent).div_ceil(100));
        let invalid = invalid as f64 / (invalid + valid).max(1) as f64;
        DepthSummary {
            min: at(1),
            p1: share(1),
            p50: share(50),
            p99: share(99),
            max: at(valid),
            invalid: invalid as f32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_readings() {
        let mut histogram = Histogram::new();
        let depth: Vec<u16> = (0..=100).map(|i| i * 10).collect();
        histogram.add(&depth);
        let s = histogram.summary();
        assert_eq!([s.min, s.p1, s.p50, s.p99, s.max], [0.01, 0.01, 0.5, 0.99, 1.0].map(Some));
        assert!((s.invalid - 1.0 / 101.0).abs() < 1e-6);
    }

    #[test]
    fn no_reading_has_no_range() {
        let mut histogram = Histogram::new();
        assert_eq!(histogram.summary().invalid, 0.0);
        histogram.add(&[0; 5]);
        let s = histogram.summary();
        assert_eq!((s.min, s.p50, s.max, s.invalid), (None, None, None, 1.0));
    }
}
