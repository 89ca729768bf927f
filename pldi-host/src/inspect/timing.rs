//! When the frames were taken.

use serde::{Deserialize, Serialize};

/// An interval this many times the usual one is a gap.
const GAP: f64 = 1.5;

/// Duration, rate and gaps, from the stamps as listed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// From the first to the last stamp in seconds.
    pub duration: f64,
    /// Frames per second: by the median interval. `None` for a single frame, or where stamps are all alike.
    pub rate: Option<f64>,
    /// Number of intervals that are more than 1.5 times the median.
    pub gaps: usize,
    /// The longest interval in seconds and the frame that it follows.
    pub longest: Option<(f64, usize)>,
    /// Number of frames that are not later than the one before.
    pub backwards: usize,
}

impl Timing {
    /// From the frames' stamps in seconds.
    pub fn new(stamps: &[f64]) -> Self {
        let intervals: Vec<f64> = stamps.windows(2).map(|w| w[1] - w[0]).collect();
        let mut sorted = intervals.clone();
        sorted.sort_by(f64::total_cmp);
        let median = sorted.get(sorted.len() / 2).copied().filter(|m| *m > 0.0);
        let longest = intervals.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, t)| (t, i));
        Self {
            duration: stamps.last().copied().unwrap_or(0.0) - stamps.first().copied().unwrap_or(0.0),
            rate: median.map(|m| 1.0 / m),
            gaps: median.map_or(0, |m| intervals.iter().filter(|t| **t > GAP * m).count()),
            longest,
            backwards: intervals.iter().filter(|t| **t <= 0.0).count(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_is_found_and_does_not_change_the_rate() {
        let timing = Timing::new(&[0.0, 0.5, 1.0, 3.0, 3.5]);
        assert_eq!((timing.duration, timing.rate, timing.gaps, timing.longest), (3.5, Some(2.0), 1, Some((2.0, 2))));
        assert_eq!(timing.backwards, 0);
    }

    #[test]
    fn few_or_equal_stamps_have_no_rate() {
        assert_eq!(Timing::new(&[]).rate, None);
        assert_eq!(Timing::new(&[4.0]), Timing { duration: 0.0, rate: None, gaps: 0, longest: None, backwards: 0 });
        let same = Timing::new(&[1.0; 3]);
        assert_eq!((same.rate, same.backwards), (None, 2));
    }
}
