//! What a line of the table is, and when it holds.

use crate::errors::Errors;

/// What is compared with what.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Pair {
    /// The float stage with the truth in float64.
    Float,
    /// The fixed-point stage with the truth in float64: where there is no float one.
    Fixed,
    /// The fixed-point stage with the float stage, on the same input.
    Twins,
}

impl Pair {
    /// As the table prints it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Float => "float, truth",
            Self::Fixed => "fixed, truth",
            Self::Twins => "fixed, float",
        }
    }
}

/// Inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Set {
    /// Numbers from a seed, spread over a stage's range.
    Numbers,
    /// Surfaces given by formulas.
    Analytic,
    /// Generated recordings.
    Recordings,
    /// Rendered views of single objects.
    Views,
    /// Frames and views at the ends of all ranges.
    Extremes,
    /// Frames from a seed.
    Random,
    /// Recordings of real sensors, which lie beside the checkout or are missing.
    Real,
}

impl Set {
    /// As the table prints it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Numbers => "numbers",
            Self::Analytic => "analytic",
            Self::Recordings => "recordings",
            Self::Views => "views",
            Self::Extremes => "extremes",
            Self::Random => "random",
            Self::Real => "real",
        }
    }
}

/// What is measured of a stage.
#[derive(Debug, Clone, Copy)]
pub struct Stage {
    /// Its module, a colon, and which part or form of it.
    pub name: &'static str,
    /// Unit of the error.
    pub unit: &'static str,
    /// One unit of the fixed-point format, in that unit; 0 where there is none.
    pub lsb: f64,
    /// Whether the ratio of signal to noise means anything.
    pub snr: bool,
    /// What counts as a changed decision; empty where there is none to take.
    pub decision: &'static str,
}

/// A line: bounds of what is measured of a stage on a set of inputs.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// The stage's name.
    pub stage: &'static str,
    /// What is compared with what.
    pub pair: Pair,
    /// On which inputs.
    pub set: Set,
    /// Largest absolute error allowed.
    pub largest: f64,
    /// Largest share allowed of decisions that come out otherwise.
    pub share: f64,
    /// Least signal to noise allowed in dB; infinite where nothing may be off, `None` where it means nothing.
    pub snr: Option<f64>,
}

/// What must hold of a stage whatever else changes, on each of some sets of inputs (where they are there).
#[derive(Debug, Clone, Copy)]
pub struct Requirement {
    /// The stage's name.
    pub stage: &'static str,
    /// What is compared with what.
    pub pair: Pair,
    /// The sets.
    pub sets: &'static [Set],
    /// Largest share of changed decisions.
    pub share: f64,
    /// Largest root mean square of the errors.
    pub rms: f64,
    /// The sets on which it is not met yet, which the document says. It is an error if it is met on them after all.
    pub open: &'static [Set],
}

impl Requirement {
    /// Whether it is met.
    pub fn is_met(&self, errors: &Errors) -> bool {
        errors.share() <= self.share && errors.rms() <= self.rms
    }

    /// What is wrong: not met where it should be, or met where it is said to be open.
    pub fn complaint(&self, set: Set, errors: &Errors) -> Option<String> {
        let Self { stage, pair, share, rms, .. } = self;
        let name = format!("{stage} ({}; {})", pair.name(), set.name());
        match (self.is_met(errors), self.open.contains(&set)) {
            (false, false) => Some(format!(
                "{name}: required are {share:.1e} changed decisions and {rms:.1e} root mean square at most, there are {:.3e} and {:.3e}",
                errors.share(),
                errors.rms()
            )),
            (true, true) => Some(format!("{name}: the requirement is met, but listed as open")),
            _ => None,
        }
    }
}

/// How much better than its bound a stage may be before the bound no longer tells the truth.
pub const SLACK: f64 = 2.0;

/// The quantities that a row bounds.
pub const QUANTITIES: [Quantity; 3] = [Quantity::Largest, Quantity::Share, Quantity::Snr];

/// A quantity that a row bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// The largest absolute error.
    Largest,
    /// The share of changed decisions.
    Share,
    /// Noise to signal, as amplitudes, so that the same slack holds.
    Snr,
}

impl Quantity {
    /// The bound and what was measured; `None` where the row does not bound it.
    fn of(self, row: &Row, errors: &Errors) -> Option<(f64, f64)> {
        let noise = |db: f64| libm::exp10(-db / 20.0);
        match self {
            Self::Largest => Some((row.largest, errors.largest())),
            Self::Share => Some((row.share, errors.share())),
            Self::Snr => row.snr.map(|snr| (noise(snr), noise(errors.snr()))),
        }
    }
}

/// What is wrong with a bound, in words; `None` where it holds and is tight.
fn complaint(bound: f64, measured: f64) -> Option<String> {
    // Written so that NaN fails.
    if !(measured <= bound) {
        Some(format!("is {measured:.3e}, above its bound {bound:.2e}"))
    } else if bound > SLACK * measured {
        Some(format!("is {measured:.3e}, its bound {bound:.2e} is more than {SLACK} times looser: tighten it"))
    } else {
        None
    }
}

impl Row {
    /// Which of its bounds do not hold or are too loose.
    pub fn complaints(&self, errors: &Errors) -> Vec<String> {
        let mut out = Vec::new();
        for quantity in QUANTITIES {
            let what = match quantity {
                Quantity::Largest => "largest error",
                Quantity::Share => "share of changed decisions",
                Quantity::Snr => "noise to signal",
            };
            let found = quantity.of(self, errors).and_then(|(bound, measured)| complaint(bound, measured));
            let (stage, pair, set) = (self.stage, self.pair.name(), self.set.name());
            out.extend(found.map(|words| format!("{stage} ({pair}; {set}): the {what} {words}")));
        }
        out
    }

    /// The row with one of its bounds `factor` times as loose (a bound of 0: next to 0); `None` where it has no such bound.
    pub fn loosened(&self, quantity: Quantity, factor: f64) -> Option<Self> {
        let loose = |bound: f64| if bound > 0.0 { bound * factor } else { f64::MIN_POSITIVE };
        match quantity {
            Quantity::Largest => Some(Self { largest: loose(self.largest), ..*self }),
            Quantity::Share => Some(Self { share: loose(self.share), ..*self }),
            Quantity::Snr => {
                let snr = self.snr?;
                let looser = if snr.is_finite() { snr - 20.0 * libm::log10(factor) } else { 6000.0 };
                Some(Self { snr: Some(looser), ..*self })
            }
        }
    }

    /// A row that fits what was measured: bounds a fifth above it, rounded to two digits.
    pub fn fitting(stage: &Stage, pair: Pair, set: Set, errors: &Errors) -> Self {
        let snr = stage.snr.then(|| libm::floor(errors.snr() - 1.0));
        Self { stage: stage.name, pair, set, largest: above(errors.largest()), share: above(errors.share()), snr }
    }

    /// The line of the table's source that gives this row.
    pub fn source(&self) -> String {
        let Self { stage, pair, set, largest, share, snr } = self;
        let number = |v: f64| if v == 0.0 { "0.0".into() } else { format!("{v:.1e}") };
        let snr = match snr {
            None => "NONE".into(),
            Some(snr) if snr.is_finite() => format!("db({snr:.0})"),
            Some(_) => "EXACT".into(),
        };
        format!("    row({stage:?}, {pair:?}, {set:?}, {}, {}, {snr}),", number(*largest), number(*share))
    }
}

/// A number of two digits, 15 to 30 % above this one.
fn above(measured: f64) -> f64 {
    if measured == 0.0 {
        return 0.0;
    }
    let step = libm::exp10(libm::floor(libm::log10(measured * 1.15)) - 1.0);
    // Read back, so that it is the number that its two digits stand for.
    format!("{:.1e}", libm::ceil(measured * 1.15 / step) * step).parse().unwrap_or(f64::NAN)
}
