//! All parameters of the pipeline.

use crate::crc::crc32;
use crate::floor::FloorMode;
use crate::ground::{AreaParams, DensityParams, Limits};
use crate::reconstruct::{FilterKind, FilterParams};
use crate::view::ViewParams;
use crate::{DepthRange, Error};

/// All parameters, in the order of the stages. The defaults are the paper's where it gives any.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Params {
    /// Which depths are readings.
    pub range: DepthRange,
    /// Reconstruction of the depth.
    pub filter: FilterParams,
    /// Where the floor comes from.
    pub floor: FloorMode,
    /// Where objects are looked for.
    pub area: AreaParams,
    /// The points' density on the floor.
    pub density: DensityParams,
    /// Which clusters are candidates.
    pub limits: Limits,
    /// What the descriptor is made of; the templates' must be the same.
    pub view: ViewParams,
}

impl Default for Params {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Params {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        range: DepthRange::KINECT,
        filter: FilterParams::DEFAULT,
        floor: FloorMode::Ransac(crate::floor::RansacParams::DEFAULT),
        area: AreaParams::DEFAULT,
        density: DensityParams::DEFAULT,
        limits: Limits::DEFAULT,
        view: ViewParams::DEFAULT,
    };

    /// Checks every number against its stated range.
    ///
    /// # Errors
    /// The first that is out of range, by its name.
    pub fn validate(&self) -> Result<(), Error> {
        if self.range.min == 0 || self.range.min > self.range.max {
            return Err(Error::OutOfRange("depth range"));
        }
        self.filter.validate()?;
        match &self.floor {
            FloorMode::Fixed(floor) => floor.validate()?,
            FloorMode::Ransac(ransac) => ransac.validate()?,
        }
        self.area.validate()?;
        self.density.validate()?;
        self.limits.validate()?;
        self.view.validate()
    }

    /// CRC-32 over all parameters (numbers little-endian, in the order of the fields): results with equal hashes were
    /// made with equal parameters.
    pub fn hash(&self) -> u32 {
        let Self { range, filter, floor, area, density, limits, view } = self;
        let kind = match filter.kind {
            FilterKind::Joint => 0.0,
            FilterKind::Bilateral => 1.0,
            FilterKind::None => 2.0,
            FilterKind::Exact => 3.0,
        };
        let mut hash = floats(
            view.hash(),
            &[
                f32::from(range.min),
                f32::from(range.max),
                kind,
                filter.sigma_space,
                filter.sigma_colour,
                filter.sigma_depth,
                f32::from(filter.iterations),
                filter.weight_floor,
            ],
        );
        hash = match floor {
            FloorMode::Fixed(f) => floats(hash, &[f.normal[0], f.normal[1], f.normal[2], f.height]),
            FloorMode::Ransac(r) => floats(
                crc32(hash, &r.seed.to_le_bytes()),
                &[
                    f32::from(r.samples),
                    r.tolerance,
                    r.tolerance_per_z2,
                    r.height.0,
                    r.height.1,
                    r.pitch.0,
                    r.pitch.1,
                    r.steep,
                    r.tilt,
                    r.support,
                    r.far,
                ],
            ),
        };
        hash = floats(hash, &[area.near, area.far, area.left, area.right]);
        hash = floats(
            hash,
            &[
                density.min_height,
                density.min_height_per_z2,
                density.max_height,
                density.axial,
                density.lateral,
                density.bandwidth,
                density.threshold,
            ],
        );
        hash = crc32(hash, &limits.min_pixels.to_le_bytes());
        floats(
            hash,
            &[
                limits.area.0,
                limits.area.1,
                limits.length.0,
                limits.length.1,
                limits.min_top,
                limits.max_occluded,
                limits.hidden,
                f32::from(limits.margin),
            ],
        )
    }
}

fn floats(hash: u32, values: &[f32]) -> u32 {
    values.iter().fold(hash, |hash, v| crc32(hash, &v.to_le_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_valid_and_every_stage_is_checked() {
        assert_eq!(Params::DEFAULT.validate(), Ok(()));
        let p = Params { range: DepthRange { min: 0, max: 9 }, ..Params::DEFAULT };
        assert_eq!(p.validate(), Err(Error::OutOfRange("depth range")));
        let p = Params { limits: Limits { hidden: 2.0, ..Limits::DEFAULT }, ..Params::DEFAULT };
        assert_eq!(p.validate(), Err(Error::OutOfRange("limits: hidden")));
    }

    #[test]
    fn any_change_changes_the_hash() {
        let d = Params::DEFAULT;
        let changed = [
            Params { range: DepthRange { max: 9000, ..d.range }, ..d },
            Params { filter: FilterParams { iterations: 2, ..d.filter }, ..d },
            Params { floor: FloorMode::Fixed(crate::Floor::from_pose(1.0, 0.2, 0.0).unwrap()), ..d },
            Params { area: AreaParams { near: 0.6, ..d.area }, ..d },
            Params { density: DensityParams { threshold: 9.0, ..d.density }, ..d },
            Params { limits: Limits { margin: 3, ..d.limits }, ..d },
            Params { view: ViewParams { radius: 0.05, ..d.view }, ..d },
        ];
        for p in changed {
            assert_ne!(p.hash(), d.hash(), "{p:?}");
        }
    }
}
