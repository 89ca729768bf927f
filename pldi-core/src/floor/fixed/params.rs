//! The parameters of the floor's search in integers.

use crate::Error;
use crate::fixed::{METRE, quantise};

/// Parameters of the floor's search in integers, see [`crate::floor::RansacParams`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RansacParams {
    /// Seed of the random numbers.
    pub seed: u32,
    /// Samples that are drawn, 1 to 10,000.
    pub samples: u16,
    /// Tolerance at the camera in 1/128 mm, 0.1 mm to 0.5 m.
    pub tolerance: i32,
    /// Growth of the tolerance with z^2, in 1/1024 mm per square metre, up to 0.5 m.
    pub tolerance_per_z2: i32,
    /// Smallest and largest height of the camera above the floor in 1/128 mm, 1 cm to 10 m.
    pub height: (i32, i32),
    /// Smallest and largest pitch in Q28 radians, within 1.6.
    pub pitch: (i32, i32),
    /// From this pitch on (Q28 radians) a plane counts for a fifth.
    pub steep: i32,
    /// Largest tilt to a side in Q28 radians, 0 to 1.6.
    pub tilt: i32,
    /// Share of the points with depth that must lie on the floor, Q16.
    pub support: i32,
    /// Points beyond this depth in 1/128 mm are not looked at, 0.1 m to 100 m (none is beyond 8 m).
    pub far: i32,
}

impl RansacParams {
    /// Values for cameras on mobile robots and hand-held ones.
    pub const DEFAULT: Self = match Self::new(&crate::floor::RansacParams::DEFAULT) {
        Ok(params) => params,
        Err(_) => panic!("the float parameters are in range"),
    };

    /// The parameters rounded to nearest; at compile time in a `const`.
    ///
    /// # Errors
    /// `OutOfRange` with the parameter's name, for ranges as in [`crate::floor::RansacParams::validate`].
    pub const fn new(float: &crate::floor::RansacParams) -> Result<Self, Error> {
        const LENGTH: f64 = METRE as f64;
        const ANGLE: f64 = 268_435_456.0;
        macro_rules! number {
            ($value:expr, $min:expr, $max:expr, $scale:expr, $name:literal) => {
                match quantise($value, $min, $max, $scale) {
                    Some(value) => value as i32,
                    None => return Err(Error::OutOfRange(concat!("floor: ", $name))),
                }
            };
        }
        let params = Self {
            seed: float.seed,
            samples: float.samples,
            tolerance: number!(float.tolerance, 1e-4, 0.5, LENGTH, "tolerance"),
            tolerance_per_z2: number!(float.tolerance_per_z2, 0.0, 0.5, 1_024_000.0, "tolerance_per_z2"),
            height: (
                number!(float.height.0, 0.01, 10.0, LENGTH, "height"),
                number!(float.height.1, 0.01, 10.0, LENGTH, "height"),
            ),
            pitch: (
                number!(float.pitch.0, -1.6, 1.6, ANGLE, "pitch"),
                number!(float.pitch.1, -1.6, 1.6, ANGLE, "pitch"),
            ),
            steep: number!(float.steep, -1.6, 1.6, ANGLE, "steep"),
            tilt: number!(float.tilt, 0.0, 1.6, ANGLE, "tilt"),
            support: number!(float.support, 0.0, 1.0, 65_536.0, "support"),
            far: number!(float.far, 0.1, 100.0, LENGTH, "far"),
        };
        match params.validate() {
            Ok(()) => Ok(params),
            Err(error) => Err(error),
        }
    }

    /// Checks every number against its stated range.
    ///
    /// # Errors
    /// `OutOfRange` with the parameter's name.
    pub const fn validate(&self) -> Result<(), Error> {
        const ANGLE: i32 = 429_496_731;
        const fn within(value: i32, min: i32, max: i32) -> bool {
            min <= value && value <= max
        }
        let checks = [
            (within(self.samples as i32, 1, 10_000), "floor: samples"),
            (within(self.tolerance, METRE / 10_000, METRE / 2), "floor: tolerance"),
            (within(self.tolerance_per_z2, 0, 512_000), "floor: tolerance_per_z2"),
            (within(self.height.0, METRE / 100, self.height.1), "floor: height"),
            (within(self.height.1, METRE / 100, 10 * METRE), "floor: height"),
            (within(self.pitch.0, -ANGLE, self.pitch.1), "floor: pitch"),
            (within(self.pitch.1, -ANGLE, ANGLE), "floor: pitch"),
            (within(self.steep, -ANGLE, ANGLE), "floor: steep"),
            (within(self.tilt, 0, ANGLE), "floor: tilt"),
            (within(self.support, 0, 1 << 16), "floor: support"),
            (within(self.far, METRE / 10, 100 * METRE), "floor: far"),
        ];
        let mut i = 0;
        while i < checks.len() {
            if !checks[i].0 {
                return Err(Error::OutOfRange(checks[i].1));
            }
            i += 1;
        }
        Ok(())
    }
}
