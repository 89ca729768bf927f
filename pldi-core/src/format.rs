//! How defmt shows what is too long to be shown whole.

use crate::pipeline::{Arithmetic, Detection, Report};
use crate::reconstruct::fixed::{ColourRow, DepthRow};
use crate::serial::Packet;
use crate::templates::{Template, Templates};
use crate::{Frame, ground, matching};
use defmt::{Format, Formatter, write};

/// Without the 58 numbers.
impl<A: Arithmetic> Format for Detection<A> {
    fn format(&self, f: Formatter<'_>) {
        let Self { cluster, descriptor: _, hypotheses } = self;
        write!(f, "Detection {{ cluster: {}, hypotheses: {} }}", cluster, hypotheses.as_slice());
    }
}

/// Counts in place of the lists.
impl<A: Arithmetic> Format for Report<A> {
    fn format(&self, f: Formatter<'_>) {
        let Self { floor, clusters, contours: _, detections } = self;
        let candidates = clusters.iter().filter(|cluster| cluster.rejection.is_none()).count();
        write!(
            f,
            "Report {{ floor: {}, clusters: {}, candidates: {}, detections: {} }}",
            floor,
            clusters.len(),
            candidates,
            detections.len()
        );
    }
}

/// Without the pixels.
impl<const W: usize, const H: usize> Format for Frame<'_, W, H> {
    fn format(&self, f: Formatter<'_>) {
        write!(f, "Frame {{ width: {}, height: {}, colour: {} }}", W, H, self.colour.is_some());
    }
}

/// Without the values.
impl Format for DepthRow<'_> {
    fn format(&self, f: Formatter<'_>) {
        match self {
            Self::Millimetres(values) => write!(f, "Millimetres({} values)", values.len()),
            Self::Raw(values, disparity) => write!(f, "Raw({} values, {})", values.len(), disparity),
        }
    }
}

/// Without the pixels.
impl Format for ColourRow<'_> {
    fn format(&self, f: Formatter<'_>) {
        match self {
            Self::Rgb888(rows) => write!(f, "Rgb888({} rows)", rows.len()),
            Self::Rgb565(rows) => write!(f, "Rgb565({} rows)", rows.len()),
            Self::Yuyv(rows) => write!(f, "Yuyv({} rows)", rows.len()),
            Self::Bayer(rows, mosaic) => write!(f, "Bayer({} rows, {})", rows.len(), mosaic),
        }
    }
}

/// Counts and the check sum.
impl Format for Templates<'_> {
    fn format(&self, f: Formatter<'_>) {
        let (classes, count, checksum) = (self.classes().len(), self.len(), self.checksum());
        write!(f, "Templates {{ classes: {}, templates: {}, checksum: {=u32:#010x} }}", classes, count, checksum);
    }
}

/// Without the 58 numbers.
impl Format for Template<'_> {
    fn format(&self, f: Formatter<'_>) {
        let (class, object, view) = (self.class(), self.object(), self.view());
        write!(f, "Template {{ class: {}, object: {}, view: {} }}", class, object, view);
    }
}

/// Without the payload.
impl Format for Packet<'_> {
    fn format(&self, f: Formatter<'_>) {
        let Self { kind, sequence, payload, checksum: _ } = self;
        write!(f, "Packet {{ kind: {}, sequence: {}, payload: {} bytes }}", kind, sequence, payload.len());
    }
}

/// What a firmware may log has a `Format`: this compiles, or it has not.
const _: fn() = || {
    fn logged<T: Format + ?Sized>() {}
    fn all_of<A: Arithmetic>() {
        logged::<A::Floor>();
        logged::<A::Length>();
        logged::<A::Descriptor>();
        logged::<A::Distance>();
        logged::<A::Params>();
        logged::<A::Intrinsics>();
        logged::<ground::Cluster<A::Length>>();
        logged::<matching::Hypothesis<A::Distance>>();
        logged::<Detection<A>>();
        logged::<Report<A>>();
    }
    macro_rules! all {
        ($($logged:ty),* $(,)?) => { $(logged::<$logged>();)* };
    }
    all_of::<crate::Float>();
    all_of::<crate::Fixed>();
    all!(
        crate::Error,
        crate::TemplateError,
        crate::Float,
        crate::Fixed,
        crate::DepthRange,
        Frame<'_, 320, 240>,
        crate::Intrinsics,
        crate::rays::fixed::Intrinsics,
        DepthRow<'_>,
        ColourRow<'_>,
        crate::reconstruct::fixed::Bayer,
        crate::reconstruct::fixed::Disparity,
        crate::reconstruct::FilterKind,
        crate::reconstruct::FilterParams,
        crate::reconstruct::fixed::FilterParams,
        crate::Floor,
        crate::floor::FloorAxes,
        crate::floor::FloorMode,
        crate::floor::RansacParams,
        crate::floor::fixed::Floor,
        crate::floor::fixed::FloorAxes,
        crate::floor::fixed::FloorMode,
        crate::floor::fixed::RansacParams,
        ground::AreaParams,
        ground::SensoryArea,
        ground::DensityParams,
        ground::Limits,
        ground::Rejection,
        ground::Contour,
        ground::ContourPoint,
        ground::fixed::AreaParams,
        ground::fixed::SensoryArea,
        ground::fixed::DensityParams,
        ground::fixed::Limits,
        crate::view::Framing,
        crate::view::framing::Frontal,
        crate::view::Homography,
        crate::view::ViewParams,
        crate::view::fixed::Framing,
        crate::view::fixed::Frontal,
        crate::view::fixed::Homography,
        crate::view::fixed::ViewParams,
        crate::descriptor::DescriptorKind,
        crate::templates::Encoding,
        Templates<'_>,
        Template<'_>,
        crate::pipeline::Params,
        crate::pipeline::FixedParams,
        crate::pipeline::plan::Buffer,
        crate::pipeline::plan::Stage,
        crate::pipeline::plan::Place,
        Packet<'_>,
        crate::serial::Reject,
        crate::serial::packet::Rejects,
        crate::serial::StatusCode,
        crate::serial::answer::Origin,
        crate::serial::cobs::Step<'_>,
        crate::serial::device::Telemetry,
    );
};
