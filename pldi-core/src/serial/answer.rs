//! What a device sends.

use super::kind;
use super::packet::{self, Packet, Reject};
use super::request::{put, whole};
use super::wire::{Class, Detection, FrameBegin, FrameResult, Hypothesis, Info, Pong, Rejected, Status};
use crate::ground::{self, MAX_CLUSTERS, Rejection};
use crate::matching::MAX_HYPOTHESES;
use crate::pipeline::{Fixed, MAX_DETECTIONS, Report};
use zerocopy::{FromBytes, IntoBytes};

/// Bit of [`FrameResult::flags`]: a floor was found.
pub const FLOOR: u8 = 1;

/// Bit of [`FrameResult::flags`] and of [`FrameBegin::options`]: the clusters that are no candidates are listed.
pub const LIST_REJECTED: u8 = 2;

/// Bytes of the longest result.
pub const LONGEST_RESULT: usize = size_of::<FrameResult>()
    + MAX_DETECTIONS * (size_of::<Detection>() + MAX_HYPOTHESES * size_of::<Hypothesis>())
    + MAX_CLUSTERS * size_of::<Rejected>();

/// Why a frame has no result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StatusCode {
    /// The frame ended before all rows were in.
    Incomplete = 1,
    /// The frame ended, but its beginning did not come in.
    NotBegun = 2,
    /// The next frame began before this one ended.
    Abandoned = 3,
    /// The frame's number is not above that of the frame before.
    Stale = 4,
    /// Another size than the device's, or a format that it does not know.
    Format = 5,
    /// More clusters, contour points or candidates than there is room for.
    Capacity = 6,
    /// The pipeline refused the frame for another reason.
    Refused = 7,
}

impl StatusCode {
    /// The code of a number.
    pub const fn from_number(number: u8) -> Option<Self> {
        Some(match number {
            1 => Self::Incomplete,
            2 => Self::NotBegun,
            3 => Self::Abandoned,
            4 => Self::Stale,
            5 => Self::Format,
            6 => Self::Capacity,
            7 => Self::Refused,
            _ => return None,
        })
    }

    /// The name used in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Incomplete => "incomplete",
            Self::NotBegun => "its beginning was lost",
            Self::Abandoned => "its end was lost",
            Self::Stale => "its number is not above that of the frame before",
            Self::Format => "size or format is not the device's",
            Self::Capacity => "more clusters or candidates than there is room for",
            Self::Refused => "the pipeline refused it",
        }
    }
}

/// A message from the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answer<'a> {
    /// What the device is.
    Info(Info),
    /// How it fares.
    Pong(Pong),
    /// A class' name.
    Class(Class),
    /// Why a frame has no result.
    Status(Status),
    /// The result of a frame.
    Detections(Detections<'a>),
}

/// The result of a frame, as it lies in the packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Detections<'a> {
    /// Everything but the lists.
    pub result: FrameResult,
    detections: &'a [u8],
    rejected: &'a [Rejected],
}

/// What is the same in the results of all frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Origin {
    /// CRC-32 of the template file.
    pub templates_hash: u32,
    /// CRC-32 of all parameters, or 0.
    pub params_hash: u32,
}

impl<'a> Answer<'a> {
    /// The message of a packet.
    ///
    /// # Errors
    /// `Kind` for a packet that is no answer, `Payload` for one whose lengths and counts do not fit together.
    pub fn parse(packet: &Packet<'a>) -> Result<Self, Reject> {
        let payload = packet.payload;
        Ok(match packet.kind {
            kind::INFO => Self::Info(whole(payload)?),
            kind::PONG => Self::Pong(whole(payload)?),
            kind::CLASS => Self::Class(whole(payload)?),
            kind::STATUS => Self::Status(whole(payload)?),
            kind::DETECTIONS => Self::Detections(Detections::parse(payload).ok_or(Reject::Payload)?),
            _ => return Err(Reject::Kind),
        })
    }

    /// Writes an answer with one structure; a result is written by [`write_result`] alone.
    pub(super) fn write_info(info: &Info, sequence: u16, sink: &mut impl FnMut(&[u8])) {
        put(sink, kind::INFO, sequence, info);
    }

    /// As above.
    pub(super) fn write_pong(pong: &Pong, sequence: u16, sink: &mut impl FnMut(&[u8])) {
        put(sink, kind::PONG, sequence, pong);
    }

    /// As above.
    pub(super) fn write_class(class: &Class, sequence: u16, sink: &mut impl FnMut(&[u8])) {
        put(sink, kind::CLASS, sequence, class);
    }

    /// As above.
    pub(super) fn write_status(status: &Status, sequence: u16, sink: &mut impl FnMut(&[u8])) {
        put(sink, kind::STATUS, sequence, status);
    }
}

impl<'a> Detections<'a> {
    fn parse(payload: &'a [u8]) -> Option<Self> {
        let (result, lists) = FrameResult::ref_from_prefix(payload).ok()?;
        let mut rest = lists;
        for _ in 0..result.detections.get() {
            (_, rest) = detection(rest)?;
        }
        let listed = if result.flags & LIST_REJECTED == 0 { 0 } else { usize::from(result.rejected.get()) };
        let rejected = <[Rejected]>::ref_from_bytes_with_elems(rest, listed).ok()?;
        let detections = lists.get(..lists.len() - rest.len())?;
        Some(Self { result: *result, detections, rejected })
    }

    /// The detections, each with its hypotheses, best first.
    pub fn iter(&self) -> impl Iterator<Item = (&'a Detection, &'a [Hypothesis])> + use<'a> {
        let mut rest = self.detections;
        core::iter::from_fn(move || {
            let (found, behind) = detection(rest)?;
            rest = behind;
            Some(found)
        })
    }

    /// The clusters that are no candidates, where they are listed.
    pub fn rejected(&self) -> &'a [Rejected] {
        self.rejected
    }

    /// Whether a floor was found.
    pub fn has_floor(&self) -> bool {
        self.result.flags & FLOOR != 0
    }
}

/// The first detection of a list, and what follows it.
type First<'a> = ((&'a Detection, &'a [Hypothesis]), &'a [u8]);

fn detection(list: &[u8]) -> Option<First<'_>> {
    let (detection, rest) = Detection::ref_from_prefix(list).ok()?;
    let count = usize::from(detection.hypotheses.get());
    let (hypotheses, rest) = <[Hypothesis]>::ref_from_prefix_with_elems(rest, count).ok()?;
    Some(((detection, hypotheses), rest))
}

/// Writes the result of a frame that began with `begin`, from the pipeline's report: [`LONGEST_RESULT`] bytes of payload at
/// most.
pub fn write_result(
    report: &Report<Fixed>,
    begin: &FrameBegin,
    origin: Origin,
    sequence: u16,
    sink: &mut impl FnMut(&[u8]),
) {
    let most = if begin.hypotheses == 0 { MAX_HYPOTHESES } else { usize::from(begin.hypotheses) };
    let detections = || {
        let found = report.detections.iter();
        found.filter_map(|found| Some((found, report.clusters.get(usize::from(found.cluster))?)))
    };
    // A cluster without pixels has no box.
    let rejected = || {
        let clusters = report.clusters.iter().enumerate().filter(|(_, cluster)| cluster.pixels > 0);
        clusters.filter(|(i, cluster)| {
            cluster.rejection.is_some() || report.detections.iter().all(|found| usize::from(found.cluster) != *i)
        })
    };
    let list = begin.options & LIST_REJECTED != 0;
    let (floor, listed) = (report.floor.map_or(0, |_| FLOOR), if list { LIST_REJECTED } else { 0 });
    // Counts are below 2^8, lengths below 2^13: see `LONGEST_RESULT`.
    let result = FrameResult {
        frame: begin.frame,
        stamp: begin.stamp,
        templates_hash: origin.templates_hash.into(),
        params_hash: origin.params_hash.into(),
        version: super::LIBRARY_VERSION,
        flags: floor | listed,
        normal: report.floor.map_or([0; 3], |floor| floor.normal).map(Into::into),
        height: report.floor.map_or(0, |floor| floor.height).into(),
        detections: (detections().count() as u16).into(),
        rejected: (rejected().count() as u16).into(),
    };
    let lists = detections().fold(0, |sum, (found, _)| {
        sum + size_of::<Detection>() + found.hypotheses.len().min(most) * size_of::<Hypothesis>()
    }) + if list { rejected().count() * size_of::<Rejected>() } else { 0 };
    let length = (size_of::<FrameResult>() + lists) as u16;
    packet::write(sink, kind::DETECTIONS, sequence, length, |body| {
        body.put(result.as_bytes());
        for (found, cluster) in detections() {
            let detection = Detection {
                id: (found.cluster + 1).into(),
                hypotheses: (found.hypotheses.len().min(most) as u16).into(),
                centre: cluster.center.map(Into::into),
                size: cluster.size.map(Into::into),
                bbox: cluster.bbox.map(Into::into),
            };
            body.put(detection.as_bytes());
            for hypothesis in found.hypotheses.iter().take(most) {
                let hypothesis = Hypothesis {
                    class: hypothesis.class.into(),
                    object: hypothesis.object.into(),
                    view: hypothesis.view.into(),
                    distance: hypothesis.distance.into(),
                    score: hypothesis.score.into(),
                };
                body.put(hypothesis.as_bytes());
            }
        }
        if list {
            for (i, cluster) in rejected() {
                body.put(no_candidate(i, cluster).as_bytes());
            }
        }
    });
}

fn no_candidate(i: usize, cluster: &ground::fixed::Cluster) -> Rejected {
    Rejected {
        id: (i as u16 + 1).into(),
        reason: cluster.rejection.map_or(0, |reason| reason as u8 + 1),
        reserved: 0,
        centre: cluster.center.map(Into::into),
        bbox: cluster.bbox.map(Into::into),
    }
}

/// The name of a [`Rejected::reason`] as it is used in reports.
pub const fn reason_name(reason: u8) -> &'static str {
    match reason {
        0 => "no view",
        1 => Rejection::Noise.name(),
        2 => Rejection::AtBorder.name(),
        3 => Rejection::TooSmall.name(),
        4 => Rejection::TooLarge.name(),
        5 => Rejection::Occluded.name(),
        _ => "unknown",
    }
}

#[cfg(test)]
mod tests;
