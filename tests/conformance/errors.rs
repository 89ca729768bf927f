//! Errors as they add up over a stage's values.

use std::collections::BTreeMap;

use crate::rows::{Pair, Set};

/// As good as nothing, with room for ratios.
const TINY: f64 = 1e-200;

/// How far values are from those they are compared with.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Errors {
    largest: f64,
    signal: f64,
    noise: f64,
    samples: u64,
    changed: u64,
}

impl Errors {
    /// Takes in a value and what it should be.
    pub fn add(&mut self, found: f64, truth: f64) {
        let error = (found - truth).abs();
        assert!(error.is_finite(), "{found} {truth}");
        self.largest = self.largest.max(error);
        self.signal += truth * truth;
        self.noise += error * error;
        self.samples += 1;
    }

    /// Takes in a value that belongs to a decision, so that the share of changed decisions is that of the decisions.
    pub fn add_value(&mut self, found: f64, truth: f64) {
        self.add(found, truth);
        self.samples -= 1;
    }

    /// Takes in many values and what they should be.
    pub fn add_all(&mut self, found: &[f32], truth: &[f64]) {
        assert_eq!(found.len(), truth.len());
        found.iter().zip(truth).for_each(|(f, t)| self.add(f64::from(*f), *t));
    }

    /// Takes in a decision (is there a value at all, which cell does a value belong to), which has no size: it counts.
    pub fn decide(&mut self, same: bool) {
        self.samples += 1;
        self.changed += u64::from(!same);
    }

    /// Takes in a value that may be missing on either side.
    pub fn add_option(&mut self, found: Option<f64>, truth: Option<f64>) {
        match (found, truth) {
            (Some(found), Some(truth)) => self.add(found, truth),
            (found, truth) => self.decide(found.is_none() && truth.is_none()),
        }
    }

    /// The same, where an error beyond `limit` counts as a changed decision, too.
    pub fn add_within(&mut self, found: Option<f64>, truth: Option<f64>, limit: f64) {
        self.add_option(found, truth);
        if let (Some(found), Some(truth)) = (found, truth) {
            self.changed += u64::from((found - truth).abs() > limit);
        }
    }

    /// Takes in what was measured elsewhere.
    pub fn merge(&mut self, other: &Self) {
        self.largest = self.largest.max(other.largest);
        self.signal += other.signal;
        self.noise += other.noise;
        self.samples += other.samples;
        self.changed += other.changed;
    }

    /// The same errors, `factor` times as large and as frequent; where there are none, some.
    pub fn scaled(&self, factor: f64) -> Self {
        let largest = if self.largest > 0.0 { self.largest * factor } else { TINY };
        let noise = if self.noise > 0.0 { self.noise * factor * factor } else { TINY };
        let changed = if self.changed > 0 { (self.changed as f64 * factor) as u64 } else { 1 };
        Self { largest, noise, changed, ..*self }
    }

    /// Values and decisions taken in.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The largest absolute error.
    pub fn largest(&self) -> f64 {
        self.largest
    }

    /// The errors' root mean square.
    pub fn rms(&self) -> f64 {
        (self.noise / self.samples.max(1) as f64).sqrt()
    }

    /// Signal to noise in dB; infinite without any error.
    pub fn snr(&self) -> f64 {
        if self.noise > 0.0 { 10.0 * libm::log10(self.signal / self.noise) } else { f64::INFINITY }
    }

    /// The share of decisions that came out otherwise.
    pub fn share(&self) -> f64 {
        self.changed as f64 / self.samples.max(1) as f64
    }
}

/// What an [`Errors`] is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// Name of the stage, see [`crate::rows::STAGES`].
    pub stage: &'static str,
    /// What is compared with what.
    pub pair: Pair,
    /// On which inputs.
    pub set: Set,
}

/// The errors of many stages on one set of inputs.
#[derive(Debug, Clone)]
pub struct Tally {
    set: Set,
    rows: BTreeMap<Key, Errors>,
}

impl Tally {
    /// Nothing measured yet.
    pub fn new(set: Set) -> Self {
        Self { set, rows: BTreeMap::new() }
    }

    /// The inputs that it is about.
    pub fn set(&self) -> Set {
        self.set
    }

    /// The errors of a stage, to add to.
    pub fn at(&mut self, stage: &'static str, pair: Pair) -> &mut Errors {
        self.rows.entry(Key { stage, pair, set: self.set }).or_default()
    }

    /// Adds what was measured to all that was measured before.
    pub fn merge_into(self, all: &mut BTreeMap<Key, Errors>) {
        for (key, errors) in self.rows {
            all.entry(key).or_default().merge(&errors);
        }
    }
}
