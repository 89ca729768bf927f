//! Clusters in common terms, whoever found them.

use crate::errors::Errors;
use crate::oracle::ground as truth;
use pldi_core::ground::{Cluster, Rejection};
use pldi_core::pipeline::{QvgaFixedWorkspace, QvgaWorkspace, mix};

/// A cluster.
#[derive(Debug, Clone, Copy)]
pub struct Found {
    /// Its pixels' number.
    pub pixels: u32,
    /// Why it is no candidate.
    pub rejection: Option<Rejection>,
    /// Centroid (right, forward), greatest height, extent across and along the line of sight, in metres.
    pub numbers: [f64; 5],
}

impl Found {
    fn is_noise(&self) -> bool {
        self.rejection == Some(Rejection::Noise)
    }
}

/// All clusters of a frame.
#[derive(Debug, Clone)]
pub struct Clusters {
    /// The number of each pixel's cluster, from 1, 0 for none.
    pub labels: Vec<u16>,
    /// The clusters.
    pub found: Vec<Found>,
}

fn found(cluster: &Cluster) -> Found {
    let Cluster { pixels, centroid, top, size, rejection, .. } = *cluster;
    Found { pixels, rejection, numbers: [centroid[0], centroid[1], top, size[0], size[2]].map(f64::from) }
}

impl Clusters {
    /// What the float pipeline left.
    pub fn float(workspace: &QvgaWorkspace) -> Self {
        let labels = workspace.images.labels.as_flattened().to_vec();
        Self { labels, found: workspace.report.clusters.iter().map(found).collect() }
    }

    /// What the fixed-point pipeline left.
    pub fn fixed(workspace: &QvgaFixedWorkspace) -> Self {
        let labels = workspace.images.labels().expect("the ground map was made");
        let clusters = workspace.report.clusters.iter();
        Self {
            labels: labels.as_flattened().iter().map(|label| u16::from(*label)).collect(),
            found: clusters.map(|cluster| found(&mix::cluster_to_float(cluster))).collect(),
        }
    }

    /// What they should be.
    pub fn truth((labels, clusters): (Vec<u16>, Vec<truth::Cluster>)) -> Self {
        let found = |c: &truth::Cluster| Found {
            pixels: c.pixels,
            rejection: c.rejection,
            numbers: [c.centroid[0], c.centroid[1], c.top, c.size[0], c.size[1]],
        };
        Self { labels, found: clusters.iter().map(found).collect() }
    }

    /// Pairs these clusters with those that they should be, by the pixels that they share (more than half of both together).
    /// A cluster without a partner, or with another reason, is another decision; but noise is no object, so that it may
    /// be noise in the one and nothing in the other. Returns the pairs.
    pub fn compare(&self, expected: &Self, errors: &mut Errors) -> Vec<(usize, usize)> {
        let (rows, columns) = (expected.found.len(), self.found.len());
        let mut shared = vec![0u32; rows * columns];
        for (a, b) in expected.labels.iter().zip(&self.labels) {
            let (a, b) = (usize::from(*a), usize::from(*b));
            if a > 0 && b > 0 {
                shared[(a - 1) * columns + b - 1] += 1;
            }
        }
        let mut pairs = Vec::new();
        for (i, a) in expected.found.iter().enumerate().filter(|(_, a)| a.pixels > 0) {
            let both = |j: usize| shared[i * columns + j];
            let partner = self.found.iter().enumerate().find(|(j, b)| 3 * both(*j) > a.pixels + b.pixels);
            let Some((j, b)) = partner else {
                if !a.is_noise() {
                    errors.decide(false);
                }
                continue;
            };
            pairs.push((i, j));
            if a.is_noise() && b.is_noise() {
                continue;
            }
            errors.decide(a.rejection == b.rejection);
            b.numbers.iter().zip(a.numbers).for_each(|(b, a)| errors.add_value(*b, a));
        }
        let alone = |j: usize| pairs.iter().all(|(_, partner)| *partner != j);
        let lonely = self.found.iter().enumerate().filter(|(j, b)| b.pixels > 0 && !b.is_noise() && alone(*j)).count();
        (0..lonely).for_each(|_| errors.decide(false));
        pairs
    }
}
