//! What the two arithmetics have in common: the same stages, with the same meaning, on their own numbers.

use super::digest::Bits;
use super::{Hypotheses, Report, Settings};
use crate::log::Loggable;
use crate::templates::Templates;
use crate::{Error, Frame};
use core::fmt::Debug;

/// An arithmetic that the pipeline can run in: [`super::Float`] or [`super::Fixed`].
///
/// Everything that is not arithmetic (the order of the stages, the report, border following, the search among templates) is
/// written once, for both.
pub trait Arithmetic: Copy + Debug + PartialEq + sealed::Sealed {
    /// The parameters of all stages.
    type Params: Copy + Debug + Loggable + PartialEq;
    /// The camera.
    type Intrinsics: Copy + Debug + Loggable + PartialEq;
    /// What is computed once for a camera and a set of parameters.
    type Tables<const W: usize, const H: usize>: Clone + Debug;
    /// The images between the stages.
    type Images<const W: usize, const H: usize>: Clone + Debug;
    /// The floor plane.
    type Floor: Bits + Copy + Debug + Loggable + PartialEq;
    /// A length or a coordinate.
    type Length: Bits + Copy + Debug + Loggable + PartialEq;
    /// The 58 numbers.
    type Descriptor: Bits + Copy + Debug + Loggable + PartialEq;
    /// A distance between descriptors, or a score.
    type Distance: Bits + Copy + Debug + Loggable + PartialEq;

    /// Checks the parameters and fills the tables.
    ///
    /// # Errors
    /// The first parameter that is out of range, by its name; intrinsics of another size than `W` x `H`.
    fn tables<const W: usize, const H: usize>(
        params: &Self::Params,
        intrinsics: &Self::Intrinsics,
    ) -> Result<Self::Tables<W, H>, Error>;

    /// Checks that templates were made with the same view parameters and hold this arithmetic's numbers.
    ///
    /// # Errors
    /// `Templates` with what does not fit.
    fn require(params: &Self::Params, templates: &Templates<'_>) -> Result<(), Error>;

    /// The reconstructed depth of a frame.
    fn reconstruct<const W: usize, const H: usize>(
        settings: Settings<'_, Self, W, H>,
        frame: &Frame<'_, W, H>,
        images: &mut Self::Images<W, H>,
    );

    /// The floor, from the pose or the reconstructed depth.
    fn find_floor<const W: usize, const H: usize>(
        settings: Settings<'_, Self, W, H>,
        images: &mut Self::Images<W, H>,
    ) -> Option<Self::Floor>;

    /// The ground map, its clusters and their tests: fills the report's clusters and contours.
    ///
    /// # Errors
    /// `Capacity` where the frame has more clusters or contour points than there is room for.
    fn find_candidates<const W: usize, const H: usize>(
        settings: Settings<'_, Self, W, H>,
        floor: &Self::Floor,
        images: &mut Self::Images<W, H>,
        report: &mut Report<Self>,
    ) -> Result<(), Error>;

    /// Makes the pixels where `mask` holds, and which have depth, the report's only cluster.
    fn gather_mask<const W: usize, const H: usize>(
        settings: Settings<'_, Self, W, H>,
        floor: &Self::Floor,
        mask: impl Fn(usize, usize) -> bool,
        images: &mut Self::Images<W, H>,
        report: &mut Report<Self>,
    );

    /// N at the pixels of candidates, 0 elsewhere.
    fn diffuse_candidates<const W: usize, const H: usize>(
        settings: Settings<'_, Self, W, H>,
        images: &mut Self::Images<W, H>,
        report: &Report<Self>,
    );

    /// N of the whole image.
    fn diffuse_all<const W: usize, const H: usize>(settings: Settings<'_, Self, W, H>, images: &mut Self::Images<W, H>);

    /// The view of a cluster; `None` where it has no pixels.
    fn frame_view<const W: usize, const H: usize>(
        settings: Settings<'_, Self, W, H>,
        cluster: usize,
        floor: &Self::Floor,
        images: &mut Self::Images<W, H>,
        report: &Report<Self>,
    ) -> Option<()>;

    /// The descriptor of the view that [`Arithmetic::frame_view`] left.
    fn describe_view<const W: usize, const H: usize>(
        settings: Settings<'_, Self, W, H>,
        images: &mut Self::Images<W, H>,
    ) -> Self::Descriptor;

    /// The nearest template of each of the best classes.
    ///
    /// # Errors
    /// `Templates` where the set does not hold this arithmetic's numbers.
    fn nearest(templates: &Templates<'_>, descriptor: &Self::Descriptor) -> Result<Hypotheses<Self>, Error>;

    /// The check sum of the reconstructed depth, continued from `crc`.
    fn feed_depth<const W: usize, const H: usize>(images: &Self::Images<W, H>, crc: u32) -> u32;

    /// The check sum of the density and of the pixels' labels, continued from `crc`.
    fn feed_ground<const W: usize, const H: usize>(images: &Self::Images<W, H>, crc: u32) -> u32;

    /// The check sum of N, continued from `crc`.
    fn feed_n<const W: usize, const H: usize>(images: &Self::Images<W, H>, crc: u32) -> u32;

    /// The check sum of the last view's coefficients, continued from `crc`.
    fn feed_coefficients<const W: usize, const H: usize>(images: &Self::Images<W, H>, crc: u32) -> u32;
}

pub(super) mod sealed {
    /// Nobody else's arithmetic: the stages' functions are not part of the public promise.
    pub trait Sealed {}
}
