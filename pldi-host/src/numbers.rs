//! What the host needs of either arithmetic to work with both: the way from floats into its numbers.

use pldi_core::descriptor::Descriptor;
use pldi_core::pipeline::{
    Arithmetic, Fixed, FixedParams, Float, Params, QvgaFixedWorkspace, QvgaWorkspace, Workspace,
};
use pldi_core::templates::Encoding;
use pldi_core::templates::layout::{LogRecord, Record};
use pldi_core::{Floor, Intrinsics};
use pldi_core::{floor, rays};
use serde::{Deserialize, Serialize};
use zerocopy::IntoBytes;

use crate::Error;

/// Which arithmetic the pipeline runs in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ArithmeticKind {
    /// Single precision.
    #[default]
    Float,
    /// Integers alone.
    Fixed,
}

impl ArithmeticKind {
    /// How templates are written that this arithmetic searches.
    pub const fn encoding(self) -> Encoding {
        match self {
            Self::Float => Encoding::Float,
            Self::Fixed => Encoding::Logarithmic,
        }
    }
}

/// An arithmetic with its way from floats.
pub trait Numbers: Arithmetic<Descriptor: Send> {
    /// Its name.
    const KIND: ArithmeticKind;

    /// The parameters.
    ///
    /// # Errors
    /// `Core` with the first that is out of range.
    fn params(params: &Params) -> Result<Self::Params, Error>;

    /// The camera.
    ///
    /// # Errors
    /// `Core` with the number that is out of range.
    fn intrinsics(intrinsics: &Intrinsics) -> Result<Self::Intrinsics, Error>;

    /// The floor.
    ///
    /// # Errors
    /// `Core` with what is out of range.
    fn floor(floor: &Floor) -> Result<Self::Floor, Error>;

    /// An empty workspace.
    fn workspace() -> Box<Workspace<Self>>;

    /// Puts a reconstructed depth in: metres, row by row.
    fn set_depth(workspace: &mut Workspace<Self>, metres: &[f32]);

    /// A template as it stands in a file of this arithmetic's [encoding](ArithmeticKind::encoding).
    fn record(object: u16, view: u16, descriptor: &Self::Descriptor) -> Vec<u8>;
}

impl Numbers for Float {
    const KIND: ArithmeticKind = ArithmeticKind::Float;

    fn params(params: &Params) -> Result<Params, Error> {
        params.validate().map_err(Error::core)?;
        Ok(*params)
    }

    fn intrinsics(intrinsics: &Intrinsics) -> Result<Intrinsics, Error> {
        Ok(*intrinsics)
    }

    fn floor(floor: &Floor) -> Result<Floor, Error> {
        Ok(*floor)
    }

    fn workspace() -> Box<QvgaWorkspace> {
        Box::default()
    }

    fn set_depth(workspace: &mut QvgaWorkspace, metres: &[f32]) {
        for (to, from) in workspace.images.depth.as_flattened_mut().iter_mut().zip(metres) {
            *to = *from;
        }
    }

    fn record(object: u16, view: u16, descriptor: &Descriptor) -> Vec<u8> {
        let record = Record { object: object.into(), view: view.into(), values: descriptor.map(Into::into) };
        record.as_bytes().to_vec()
    }
}

impl Numbers for Fixed {
    const KIND: ArithmeticKind = ArithmeticKind::Fixed;

    fn params(params: &Params) -> Result<FixedParams, Error> {
        params.validate().map_err(Error::core)?;
        FixedParams::new(params).map_err(Error::core)
    }

    fn intrinsics(intrinsics: &Intrinsics) -> Result<rays::fixed::Intrinsics, Error> {
        rays::fixed::Intrinsics::new(intrinsics).map_err(Error::core)
    }

    fn floor(floor: &Floor) -> Result<floor::fixed::Floor, Error> {
        floor::fixed::Floor::new(floor).map_err(Error::core)
    }

    fn workspace() -> Box<QvgaFixedWorkspace> {
        Box::default()
    }

    fn set_depth(workspace: &mut QvgaFixedWorkspace, metres: &[f32]) {
        let mut metres = metres.iter();
        workspace.images.set_depth(|_, _| metres.next().copied().map_or(0, eighths));
    }

    fn record(object: u16, view: u16, descriptor: &Self::Descriptor) -> Vec<u8> {
        let record = LogRecord { object: object.into(), view: view.into(), values: descriptor.map(Into::into) };
        record.as_bytes().to_vec()
    }
}

/// A depth in 1/8 mm, rounded to nearest, saturated.
pub(crate) fn eighths(metres: f32) -> u16 {
    (metres * 8000.0 + 0.5) as u16
}
