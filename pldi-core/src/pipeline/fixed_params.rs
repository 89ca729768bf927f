//! All parameters of the pipeline in integers.

use super::Params;
use crate::floor::fixed::FloorMode;
use crate::ground::fixed::{AreaParams, DensityParams, Limits};
use crate::reconstruct::fixed::FilterParams;
use crate::view::fixed::ViewParams;
use crate::{DepthRange, Error};

/// The value, or the function's error: `?` is not to be had in constants.
macro_rules! attempt {
    ($result:expr) => {
        match $result {
            Ok(value) => value,
            Err(error) => return Err(error),
        }
    };
}
pub(super) use attempt;

/// All parameters in integers, in the order of the stages.
///
/// As a constant, made of [`Params`] by the compiler, it leaves no float in the program:
///
/// ```
/// use pldi_core::pipeline::{FixedParams, Params};
///
/// const PARAMS: FixedParams = match FixedParams::new(&Params::DEFAULT) {
///     Ok(params) => params,
///     Err(_) => panic!("a parameter is out of range"),
/// };
/// assert_eq!(PARAMS.view.radius, 320); // 4 cm in 1/8 mm
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FixedParams {
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

impl FixedParams {
    /// The float parameters, rounded.
    ///
    /// # Errors
    /// The first that is out of range, by its name. Some ranges are narrower than those of floats, see each stage.
    pub const fn new(params: &Params) -> Result<Self, Error> {
        let Params { range, filter, floor, area, density, limits, view } = params;
        if range.min == 0 || range.min > range.max {
            return Err(Error::OutOfRange("depth range"));
        }
        Ok(Self {
            range: *range,
            filter: attempt!(FilterParams::new(filter)),
            floor: attempt!(FloorMode::new(floor)),
            area: attempt!(AreaParams::new(area)),
            density: attempt!(DensityParams::new(density)),
            limits: attempt!(Limits::new(limits)),
            view: attempt!(ViewParams::new(view)),
        })
    }
}
