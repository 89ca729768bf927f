//! Errors as they add up over a stage's values, and the bounds that they must keep without slack.

/// How far a stage's values are from the truth.
#[derive(Debug, Clone, Copy, Default)]
pub struct Errors {
    largest: f64,
    signal: f64,
    noise: f64,
    values: u64,
    apart: u64,
}

impl Errors {
    /// Takes in a value and its truth.
    pub fn add(&mut self, found: f64, truth: f64) {
        let error = (found - truth).abs();
        assert!(error.is_finite(), "{found} {truth}");
        self.largest = self.largest.max(error);
        self.signal += truth * truth;
        self.noise += error * error;
        self.values += 1;
    }

    /// Takes in many values and their truths.
    pub fn add_all(&mut self, found: &[f32], truth: &[f64]) {
        assert_eq!(found.len(), truth.len());
        found.iter().zip(truth).for_each(|(f, t)| self.add(f64::from(*f), *t));
    }

    /// Takes in a decision (is there a value at all, does a value belong to another cell) that came out otherwise: it has
    /// no size, it counts.
    pub fn add_apart(&mut self) {
        self.values += 1;
        self.apart += 1;
    }

    /// Takes in a value that may be missing on either side.
    pub fn add_option(&mut self, found: Option<f64>, truth: Option<f64>) {
        match (found, truth) {
            (Some(found), Some(truth)) => self.add(found, truth),
            (None, None) => self.values += 1,
            _ => self.add_apart(),
        }
    }

    /// The largest absolute error.
    pub fn largest(&self) -> f64 {
        self.largest
    }

    /// Signal to noise in dB; infinite without any error.
    pub fn snr(&self) -> f64 {
        if self.noise > 0.0 { 10.0 * libm::log10(self.signal / self.noise) } else { f64::INFINITY }
    }

    /// The share of decisions that came out otherwise.
    pub fn share(&self) -> f64 {
        self.apart as f64 / self.values.max(1) as f64
    }
}

/// How much better than its bound a stage may be before the bound no longer tells the truth.
const SLACK: f64 = 4.0;

/// A line of the table.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// The stage: its module, a colon, and which part or form of it.
    pub stage: &'static str,
    /// Unit of the error.
    pub unit: &'static str,
    /// Largest absolute error allowed.
    pub largest: f64,
    /// Least signal to noise allowed, in dB, where that means anything.
    pub snr: Option<f64>,
    /// Largest share allowed of decisions that come out otherwise.
    pub share: f64,
    /// Measures the stage.
    pub measure: fn() -> Errors,
}

impl Row {
    /// The line as it is printed: bounds with what was measured beside them.
    pub fn line(&self, errors: &Errors) -> String {
        let snr = self.snr.map_or(String::new(), |snr| format!("{snr:.0} ({:.1})", errors.snr()));
        let share = if self.share > 0.0 || errors.share() > 0.0 {
            format!("{:.1e} ({:.1e})", self.share, errors.share())
        } else {
            String::new()
        };
        format!(
            "{:<36} {:<5} {:>8.1e} ({:.2e})   {snr:<12} {share}",
            self.stage,
            self.unit,
            self.largest,
            errors.largest()
        )
    }

    /// What is wrong: bounds that are exceeded, and bounds that are looser than they need to be.
    pub fn complaints(&self, errors: &Errors) -> Vec<String> {
        let mut out = Vec::new();
        let mut at_most = |what: &str, bound: f64, measured: f64| {
            let stage = self.stage;
            // Written so that NaN fails the test.
            if !(measured <= bound) {
                out.push(format!("{stage}: {what} is {measured:.3e}, above its bound {bound:.1e}"));
            } else if bound > SLACK * measured {
                out.push(format!("{stage}: {what} is {measured:.3e}, its bound {bound:.1e} is too loose: tighten it"));
            }
        };
        at_most(&format!("the largest error [{}]", self.unit), self.largest, errors.largest());
        at_most("the share of other decisions", self.share, errors.share());
        if let Some(snr) = self.snr {
            // As amplitudes, so that the same slack holds.
            let noise = |db: f64| libm::exp10(-db / 20.0);
            at_most(
                &format!("noise to signal ({:.1} dB, bound {snr} dB)", errors.snr()),
                noise(snr),
                noise(errors.snr()),
            );
        }
        out
    }
}
