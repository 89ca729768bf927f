//! What the pipeline says about a frame.

use super::{Arithmetic, Float};
use crate::ground::{Cluster, Contour, MAX_CLUSTERS};
use crate::matching::{Hypothesis, MAX_HYPOTHESES};
use heapless::Vec;

/// Most candidates of one frame.
pub const MAX_DETECTIONS: usize = 32;

/// Possible classes, best first.
pub type Hypotheses<A = Float> = Vec<Hypothesis<<A as Arithmetic>::Distance>, MAX_HYPOTHESES>;

/// A candidate and what it may be.
#[derive(Debug, Clone, PartialEq)]
pub struct Detection<A: Arithmetic = Float> {
    /// Index of its cluster.
    pub cluster: u16,
    /// Its 58 numbers.
    pub descriptor: A::Descriptor,
    /// Its possible classes, best first; empty for an empty template set.
    pub hypotheses: Hypotheses<A>,
}

/// The result of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Report<A: Arithmetic = Float> {
    /// The floor, `None` where none was found (then there is nothing else).
    pub floor: Option<A::Floor>,
    /// All clusters; those with a rejection are no candidates.
    pub clusters: Vec<Cluster<A::Length>, MAX_CLUSTERS>,
    /// The clusters' contours on the ground map, in the same order. Their points are with the images.
    pub contours: Vec<Contour, MAX_CLUSTERS>,
    /// The candidates.
    pub detections: Vec<Detection<A>, MAX_DETECTIONS>,
}

impl<A: Arithmetic> Default for Report<A> {
    fn default() -> Self {
        Self::new()
    }
}

impl<A: Arithmetic> Report<A> {
    /// An empty report.
    pub const fn new() -> Self {
        Self { floor: None, clusters: Vec::new(), contours: Vec::new(), detections: Vec::new() }
    }

    /// Forgets the frame before.
    pub fn clear(&mut self) {
        self.floor = None;
        self.clusters.clear();
        self.contours.clear();
        self.detections.clear();
    }
}
