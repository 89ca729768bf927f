//! What `pldi run` says about a frame: one JSON object, which maps one to one on ROS' `Detection3DArray`.

use pldi_core::matching::Hypothesis;
use pldi_core::pipeline::Report;
use pldi_core::templates::Templates;
use serde::{Deserialize, Serialize};

use crate::input::QvgaFrame;
use crate::{ArithmeticKind, Engine};

/// A frame's line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrameReport {
    /// Number of the frame in its source, from 0.
    pub frame: usize,
    /// Time of the depth image in seconds, on the source's clock.
    pub stamp: f64,
    /// The floor; `None` where none was found (then there are no clusters either).
    pub floor: Option<FloorReport>,
    /// The candidates and what they may be.
    pub detections: Vec<DetectionReport>,
    /// The clusters that are no candidates.
    pub rejected: Vec<RejectedReport>,
    /// CRC-32 of all parameters, 8 hexadecimal digits: lines with equal ones were made with equal parameters.
    pub params: String,
    /// CRC-32 of the template file, 8 hexadecimal digits; of the file of codes where one of floats was converted.
    pub templates: String,
    /// What was computed in: `float` or `fixed`.
    pub arithmetic: ArithmeticKind,
    /// Version of this crate.
    pub version: String,
}

/// The floor in the camera's frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FloorReport {
    /// Unit normal, pointing up.
    pub normal: [f32; 3],
    /// Height of the camera above it in metres.
    pub height: f32,
}

/// A candidate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DetectionReport {
    /// Number of its cluster within the frame, from 1.
    pub id: usize,
    /// Its possible classes, best first; empty for an empty template set.
    pub results: Vec<HypothesisReport>,
    /// Centre of its box in the camera's frame (x right, y down, z forward), in metres.
    pub center: [f32; 3],
    /// Width (across the line of sight), height and depth (along it) of its box in metres.
    pub size: [f32; 3],
    /// First column, first row, last column, last row of its pixels in the source's images, inclusive.
    pub bbox: [u32; 4],
}

/// A possible class.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HypothesisReport {
    /// Name of the class.
    pub class_id: String,
    /// Margin to the nearest other class, 0..1, above 0.5 only for the best.
    pub score: f32,
    /// Canberra distance to the nearest template of the class, 0..58.
    pub distance: f32,
    /// Name of that template's object.
    pub object: String,
    /// Number of that template's view.
    pub view: u16,
}

/// A cluster that is no candidate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RejectedReport {
    /// Number of the cluster within the frame, from 1.
    pub id: usize,
    /// Why it is none.
    pub reason: String,
    /// As a candidate's.
    pub bbox: [u32; 4],
    /// As a candidate's.
    pub center: [f32; 3],
}

impl FrameReport {
    /// The line for what the core says about a frame.
    pub fn new(frame: &QvgaFrame, report: &Report, engine: &Engine, templates: &Templates<'_>) -> Self {
        let bbox = |cluster: usize| original_box(report.clusters[cluster].bbox, frame.factor);
        let detections = report.detections.iter().filter(|d| usize::from(d.cluster) < report.clusters.len()).map(|d| {
            let i = usize::from(d.cluster);
            let cluster = &report.clusters[i];
            let results = d.hypotheses.iter().map(|h| hypothesis(h, templates)).collect();
            DetectionReport { id: i + 1, results, center: cluster.center, size: cluster.size, bbox: bbox(i) }
        });
        // A cluster without pixels has no box.
        let seen = report.clusters.iter().enumerate().filter(|(_, c)| c.pixels > 0);
        let rejected = seen.filter_map(|(i, cluster)| {
            let reason = match cluster.rejection {
                Some(rejection) => rejection.name(),
                None if report.detections.iter().any(|d| usize::from(d.cluster) == i) => return None,
                None => "no view",
            };
            Some(RejectedReport { id: i + 1, reason: reason.to_owned(), bbox: bbox(i), center: cluster.center })
        });
        Self {
            frame: frame.index,
            stamp: frame.stamp,
            floor: report.floor.map(|f| FloorReport { normal: f.normal, height: f.height }),
            detections: detections.collect(),
            rejected: rejected.collect(),
            params: format!("{:08x}", engine.params().hash()),
            templates: format!("{:08x}", templates.checksum()),
            arithmetic: engine.kind(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        }
    }
}

fn hypothesis(h: &Hypothesis, templates: &Templates<'_>) -> HypothesisReport {
    HypothesisReport {
        class_id: templates.class_name(h.class).to_owned(),
        score: h.score,
        distance: h.distance,
        object: templates.object_name(h.object).to_owned(),
        view: h.view,
    }
}

/// A box of QVGA pixels in the pixels of an image `factor` times as large: all of each block belongs to it.
fn original_box(bbox: [u16; 4], factor: u16) -> [u32; 4] {
    let k = u32::from(factor);
    let [u0, v0, u1, v1] = bbox.map(u32::from);
    [u0 * k, v0 * k, u1 * k + k - 1, v1 * k + k - 1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_cover_whole_blocks() {
        assert_eq!(original_box([3, 4, 3, 5], 1), [3, 4, 3, 5]);
        assert_eq!(original_box([0, 1, 319, 239], 2), [0, 2, 639, 479]);
    }

    #[test]
    fn floats_keep_their_short_form() {
        let floor = FloorReport { normal: [0.1, -0.3, 0.7], height: 1.2 };
        assert_eq!(serde_json::to_string(&floor).unwrap(), r#"{"normal":[0.1,-0.3,0.7],"height":1.2}"#);
    }
}
