//! What the pipeline says about a frame.

use crate::Floor;
use crate::descriptor::Descriptor;
use crate::ground::{Cluster, Contour, ContourPoint, MAX_CLUSTERS, MAX_CONTOUR_POINTS};
use crate::matching::{Hypothesis, MAX_HYPOTHESES};
use heapless::Vec;

/// Most candidates of one frame.
pub const MAX_DETECTIONS: usize = 32;

/// A candidate and what it may be.
#[derive(Debug, Clone, PartialEq)]
pub struct Detection {
    /// Index of its cluster.
    pub cluster: u16,
    /// Its 58 numbers.
    pub descriptor: Descriptor,
    /// Its possible classes, best first; empty for an empty template set.
    pub hypotheses: Vec<Hypothesis, MAX_HYPOTHESES>,
}

/// The result of a frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Report {
    /// The floor, `None` where none was found (then there is nothing else).
    pub floor: Option<Floor>,
    /// All clusters; those with a rejection are no candidates.
    pub clusters: Vec<Cluster, MAX_CLUSTERS>,
    /// The clusters' contours on the ground map, in the same order.
    pub contours: Vec<Contour, MAX_CLUSTERS>,
    /// The contours' points.
    pub points: Vec<ContourPoint, MAX_CONTOUR_POINTS>,
    /// The candidates.
    pub detections: Vec<Detection, MAX_DETECTIONS>,
}

impl Report {
    /// An empty report.
    pub const fn new() -> Self {
        Self { floor: None, clusters: Vec::new(), contours: Vec::new(), points: Vec::new(), detections: Vec::new() }
    }

    /// Forgets the frame before.
    pub fn clear(&mut self) {
        self.floor = None;
        self.clusters.clear();
        self.contours.clear();
        self.points.clear();
        self.detections.clear();
    }
}
