//! Points in time.

use std::fmt;
use std::str::FromStr;

/// Nanoseconds in a second.
const SECOND: i64 = 1_000_000_000;

/// A point in time on a source's clock, in nanoseconds: stamps go through without losing digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Stamp(pub i64);

impl Stamp {
    /// From seconds, rounded to nanoseconds; `None` where that is not finite or lies 292 years or more from 0.
    pub fn from_seconds(seconds: f64) -> Option<Self> {
        let ns = libm::rint(seconds * SECOND as f64);
        // Written so that NaN fails the test.
        (ns > i64::MIN as f64 && ns < i64::MAX as f64).then_some(Self(ns as i64))
    }

    /// In seconds: the `f64` nearest to the decimal number.
    pub fn seconds(self) -> f64 {
        self.to_string().parse().unwrap_or(f64::NAN)
    }

    /// By how many nanoseconds two stamps differ.
    pub fn apart(self, other: Self) -> u64 {
        self.0.abs_diff(other.0)
    }
}

impl fmt::Display for Stamp {
    /// Seconds with all nine decimals.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (sign, ns) = (if self.0 < 0 { "-" } else { "" }, self.0.unsigned_abs());
        write!(f, "{sign}{}.{:09}", ns / SECOND as u64, ns % SECOND as u64)
    }
}

impl FromStr for Stamp {
    type Err = ();

    /// Seconds as a decimal number, exactly up to nine decimals; or in any form that `f64` takes.
    fn from_str(text: &str) -> Result<Self, ()> {
        exact(text).or_else(|| Self::from_seconds(text.parse().ok()?)).ok_or(())
    }
}

/// A number of the form `123`, `123.45` or `-123.45` with at most nine decimals.
fn exact(text: &str) -> Option<Stamp> {
    let (negative, digits) = match text.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, text),
    };
    let (whole, decimals) = digits.split_once('.').unwrap_or((digits, ""));
    let all_digits = |s: &str| s.bytes().all(|b| b.is_ascii_digit());
    if whole.is_empty() || decimals.len() > 9 || !all_digits(whole) || !all_digits(decimals) {
        return None;
    }
    let fraction: i64 = format!("{decimals:0<9}").parse().ok()?;
    let ns = whole.parse::<i64>().ok()?.checked_mul(SECOND)?.checked_add(fraction)?;
    Some(Stamp(if negative { -ns } else { ns }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn decimal_seconds_are_exact() {
        for (text, ns) in [
            ("0", 0),
            ("1.5", 1_500_000_000),
            ("1305031102.175304", 1_305_031_102_175_304_000),
            ("1700000000.123456789", 1_700_000_000_123_456_789),
            ("-0.000000001", -1),
            ("2.", 2_000_000_000),
            ("1e3", 1_000_000_000_000),
            ("0.0333333333333", 33_333_333),
        ] {
            assert_eq!(text.parse(), Ok(Stamp(ns)), "{text}");
        }
        for text in ["", "x", "nan", "inf", "1e300", "--1", "1.2.3", "99999999999999999999"] {
            assert_eq!(text.parse::<Stamp>(), Err(()), "{text}");
        }
        assert_eq!(Stamp(-1_500_000_000).to_string(), "-1.500000000");
        assert_eq!(Stamp(1_305_031_102_175_304_000).seconds(), 1_305_031_102.175_304);
    }

    proptest! {
        #[test]
        fn text_and_back(ns in any::<i64>()) {
            prop_assume!(ns != i64::MIN);
            prop_assert_eq!(Stamp(ns).to_string().parse(), Ok(Stamp(ns)));
        }

        #[test]
        fn no_text_panics(text in "[-+0-9.einfa]{0,30}|\\PC{0,20}") {
            let _ = text.parse::<Stamp>();
        }
    }
}
