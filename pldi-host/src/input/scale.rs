//! What the numbers in a depth image mean.

use std::fmt;
use std::str::FromStr;

use pldi_core::DepthRange;

use crate::Error;

/// Unit of the values of a depth image. A wrong one is the commonest mistake with recordings, so it has a name.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum DepthScale {
    /// Millimetres (ROS REP-118, most recorders).
    #[default]
    Millimetres,
    /// 1/5000 m, as in the TUM RGB-D benchmark.
    Tum,
    /// Millimetres rotated left by three bits, as in SUN3D (the lowest three bits of the word hold the highest ones).
    Sun3d,
    /// So many units per metre: positive and finite.
    PerMetre(f64),
}

impl DepthScale {
    /// A raw value in mm, rounded to nearest (half up), 0 where it is no valid reading: what does not fit
    /// [`DepthRange::KINECT`] is no reading.
    #[inline]
    pub fn to_mm(self, raw: u16) -> u16 {
        DepthRange::KINECT.apply(self.millimetres(raw))
    }

    /// A raw value in mm, rounded to nearest (half up), whatever its range; 0 where it is none or does not fit 16 bits.
    #[inline]
    pub fn millimetres(self, raw: u16) -> u16 {
        match self {
            Self::Millimetres => raw,
            // raw + 2 in 32 bits: 65535 must not wrap.
            Self::Tum => ((u32::from(raw) + 2) / 5) as u16,
            Self::Sun3d => raw.rotate_right(3),
            Self::PerMetre(units) => {
                let mm = libm::floor(f64::from(raw) * 1000.0 / units + 0.5);
                // Written so that NaN fails the test.
                if (0.0..=f64::from(u16::MAX)).contains(&mm) { mm as u16 } else { 0 }
            }
        }
    }
}

impl FromStr for DepthScale {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        match text.trim() {
            "mm" => Ok(Self::Millimetres),
            "tum" => Ok(Self::Tum),
            "sun3d" => Ok(Self::Sun3d),
            number => match number.parse::<f64>() {
                Ok(units) if units > 0.0 && units.is_finite() => Ok(Self::PerMetre(units)),
                _ => Err(Error::Usage(format!(
                    "depth scale {text:?}: give mm, tum (1/5000 m), sun3d, or a positive number of units per metre"
                ))),
            },
        }
    }
}

impl fmt::Display for DepthScale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Millimetres => f.write_str("mm"),
            Self::Tum => f.write_str("tum"),
            Self::Sun3d => f.write_str("sun3d"),
            Self::PerMetre(units) => write!(f, "{units}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scale_at_its_extremes() {
        let cases: [(DepthScale, &[(u16, u16)]); 5] = [
            (DepthScale::Millimetres, &[(0, 0), (1, 1), (10_000, 10_000), (10_001, 0), (u16::MAX, 0)]),
            (DepthScale::Tum, &[(0, 0), (2, 0), (3, 1), (7, 1), (8, 2), (50_000, 10_000), (50_003, 0), (u16::MAX, 0)]),
            (DepthScale::Sun3d, &[(0, 0), (8, 1), (1, 8192), (7 << 3 | 1, 8199), (u16::MAX, 0)]),
            (DepthScale::PerMetre(1000.0), &[(0, 0), (1234, 1234), (u16::MAX, 0)]),
            (DepthScale::PerMetre(2000.0), &[(1, 1), (2, 1), (3, 2), (20_000, 10_000), (20_001, 0)]),
        ];
        for (scale, pairs) in cases {
            for &(raw, mm) in pairs {
                assert_eq!(scale.to_mm(raw), mm, "{scale} {raw}");
            }
        }
        for units in [1e-300, f64::MIN_POSITIVE, 1e300] {
            assert_eq!(DepthScale::PerMetre(units).to_mm(u16::MAX), 0);
        }
    }

    #[test]
    fn sun3d_rotation_is_that_of_its_toolbox() {
        for raw in 0..=u16::MAX {
            let mm = (u32::from(raw) >> 3 | u32::from(raw) << 13) as u16;
            assert_eq!(DepthScale::Sun3d.to_mm(raw), DepthRange::KINECT.apply(mm));
        }
    }

    #[test]
    fn names_and_numbers_parse_and_print_alike() {
        for text in ["mm", "tum", "sun3d", "5000", "0.5", "1000.25"] {
            assert_eq!(text.parse::<DepthScale>().unwrap().to_string(), text);
        }
        for text in ["", "0", "-1", "nan", "inf", "1e999", "metres", "MM"] {
            let error = text.parse::<DepthScale>().unwrap_err();
            assert!(error.is_usage() && error.to_string().contains("units per metre"), "{error}");
        }
    }
}
