//! A device's answers, owned.

use pldi_core::serial::wire::{self, FrameResult, Hypothesis, Rejected};
use pldi_core::serial::{self};

/// What a device said. The numbers are as they came, see [`wire`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// What the device is.
    Info(wire::Info),
    /// How it fares.
    Pong(wire::Pong),
    /// A class' name.
    Class(wire::Class),
    /// Why a frame has no result.
    Status(wire::Status),
    /// The result of a frame.
    Detections(Detections),
}

/// The result of a frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Detections {
    /// Everything but the lists.
    pub result: FrameResult,
    /// The candidates.
    pub detections: Vec<Detection>,
    /// The clusters that are no candidates, where they are listed.
    pub rejected: Vec<Rejected>,
}

/// A candidate and what it may be.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Detection {
    /// Where it is.
    pub place: wire::Detection,
    /// What it may be, best first.
    pub hypotheses: Vec<Hypothesis>,
}

impl From<serial::Answer<'_>> for Answer {
    fn from(answer: serial::Answer<'_>) -> Self {
        match answer {
            serial::Answer::Info(info) => Self::Info(info),
            serial::Answer::Pong(pong) => Self::Pong(pong),
            serial::Answer::Class(class) => Self::Class(class),
            serial::Answer::Status(status) => Self::Status(status),
            serial::Answer::Detections(found) => Self::Detections(Detections {
                result: found.result,
                detections: found
                    .iter()
                    .map(|(place, hypotheses)| Detection { place: *place, hypotheses: hypotheses.to_vec() })
                    .collect(),
                rejected: found.rejected().to_vec(),
            }),
        }
    }
}
