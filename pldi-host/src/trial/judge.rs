//! What the pipeline made of a frame whose truth is known.

use pldi_core::ground::SensoryArea;
use pldi_core::pipeline::QvgaWorkspace;
use pldi_core::templates::Templates;
use pldi_core::{Error, Floor};
use pldi_fixtures::{CameraPose, Capture, ObjectTruth};

use crate::Engine;

/// A cluster counts for an object where they share at least half of the pixels of both together.
const OVERLAP: f64 = 0.5;

/// An object is within the area where its footprint keeps so far from the area's borders, in metres: the density on the
/// floor is spread by the sensor's error and by the cells' size, and the core leaves out what touches a border.
const CLEARANCE: f32 = 0.15;

/// An object can be recognised where at least this share of its pixels has a reading: there is none in direct sunlight.
const MEASURED: f64 = 0.6;

/// Whether an object can be recognised; if not, the first of the reasons that holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// Seen whole, in front of everything else, within the sensory area.
    Whole,
    /// More than 3 % of it are hidden.
    Occluded,
    /// It reaches the border of the image.
    Cut,
    /// Its footprint reaches beyond the sensory area, or nearer to its border than 0.15 m.
    Outside,
    /// The sensor has no reading of more than 40 % of its pixels.
    Unmeasured,
}

impl Standing {
    /// The name used in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Whole => "whole",
            Self::Occluded => "occluded",
            Self::Cut => "cut by the image",
            Self::Outside => "outside the area",
            Self::Unmeasured => "not measured",
        }
    }
}

/// The truth about a frame in the pipeline's resolution.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameTruth {
    /// The objects in view.
    pub objects: Vec<ObjectTruth>,
    /// Where the camera was.
    pub camera: CameraPose,
    /// 0, or an object's instance + 1, for each pixel of a QVGA image.
    pub labels: Vec<u8>,
}

impl FrameTruth {
    /// The truth about a capture of `factor` times QVGA, reduced as depth is.
    pub fn new(objects: Vec<ObjectTruth>, camera: CameraPose, capture: &Capture, factor: usize) -> Self {
        let rows = capture.labels.chunks(capture.width.max(1)).step_by(factor.max(1));
        let labels = rows.flat_map(|row| row.iter().step_by(factor.max(1)).copied()).collect();
        Self { objects, camera, labels }
    }
}

/// What became of one object.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// The object.
    pub truth: ObjectTruth,
    /// Whether it could be recognised.
    pub standing: Standing,
    /// The answer's class and score; `None` where no candidate covers the object.
    pub answer: Option<(String, f32)>,
    /// The reason of the rejected cluster that covers it, where one does.
    pub reason: Option<&'static str>,
}

impl Verdict {
    /// Whether the answer is the object's class.
    pub fn is_right(&self) -> bool {
        self.answer.as_ref().is_some_and(|(class, _)| *class == self.truth.class)
    }
}

/// What became of each object of a frame that went through the pipeline, and the number of candidates that are no whole
/// object: parts of occluded or cut ones, furniture that merged, walls. `depth` is the frame's, in mm.
///
/// # Errors
/// What the core says about the camera's pose.
pub fn judge(
    seen: &FrameTruth,
    depth: &[u16],
    engine: &Engine,
    templates: &Templates<'_>,
    workspace: &QvgaWorkspace,
) -> Result<(Vec<Verdict>, u32), Error> {
    let camera = &seen.camera;
    let floor = Floor::from_pose(camera.height, camera.pitch, camera.roll)?;
    let area = SensoryArea::new(&engine.params().area, engine.intrinsics(), &floor);
    let report = &workspace.report;
    let overlaps = Overlaps::new(seen, depth, workspace);
    let mut used = Vec::new();
    let mut verdicts = Vec::new();
    for truth in &seen.objects {
        let label = truth.instance + 1;
        let standing = if truth.occluded {
            Standing::Occluded
        } else if truth.cut_by_frame {
            Standing::Cut
        } else if !within_area(truth, camera, &area) {
            Standing::Outside
        } else if overlaps.measured(label) < MEASURED {
            Standing::Unmeasured
        } else {
            Standing::Whole
        };
        let shares = (0..report.clusters.len()).map(|c| (overlaps.share(label, c), c));
        let best = shares.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(share, _)| *share >= OVERLAP);
        let covering = best.map(|(_, c)| c);
        let detection = covering.and_then(|c| report.detections.iter().find(|d| usize::from(d.cluster) == c));
        if standing == Standing::Whole {
            used.extend(detection.map(|d| d.cluster));
        }
        let hypothesis = detection.and_then(|d| d.hypotheses.first());
        verdicts.push(Verdict {
            truth: truth.clone(),
            standing,
            answer: hypothesis.map(|h| (templates.class_name(h.class).to_owned(), h.score)),
            reason: covering.and_then(|c| report.clusters[c].rejection).map(|r| r.name()),
        });
    }
    let strays = report.detections.iter().filter(|d| !used.contains(&d.cluster)).count() as u32;
    Ok((verdicts, strays))
}

/// Pixels of true objects and of clusters, and what they share.
struct Overlaps {
    clusters: usize,
    /// Pixels with a reading by true label and cluster (from 1; 0 = none).
    both: Vec<u32>,
    /// Pixels by true label.
    objects: [u32; 256],
}

impl Overlaps {
    fn new(seen: &FrameTruth, depth: &[u16], workspace: &QvgaWorkspace) -> Self {
        let clusters = workspace.report.clusters.len();
        let mut both = vec![0; 256 * (clusters + 1)];
        let mut objects = [0; 256];
        let pixels = seen.labels.iter().zip(depth).zip(workspace.images.labels.as_flattened());
        for ((&object, &mm), &cluster) in pixels {
            objects[usize::from(object)] += 1;
            // Filled holes belong to no object.
            let object = if mm > 0 { usize::from(object) } else { 0 };
            // Without a floor the labels are those of the frame before.
            let cluster = usize::from(cluster);
            both[object * (clusters + 1) + if cluster > clusters { 0 } else { cluster }] += 1;
        }
        Self { clusters, both, objects }
    }

    fn with_reading(&self, label: usize) -> u32 {
        let n = self.clusters + 1;
        self.both.get(label * n..(label + 1) * n).map_or(0, |row| row.iter().sum())
    }

    /// The share of an object's pixels that have a reading.
    fn measured(&self, label: usize) -> f64 {
        f64::from(self.with_reading(label)) / f64::from(self.objects.get(label).copied().unwrap_or(0).max(1))
    }

    /// Pixels of both an object and a cluster, of those of either.
    fn share(&self, label: usize, cluster: usize) -> f64 {
        let n = self.clusters + 1;
        let both = self.both.get(label * n + cluster + 1).copied().unwrap_or(0);
        let whole: u32 = self.both.iter().skip(cluster + 1).step_by(n).sum();
        f64::from(both) / f64::from((self.with_reading(label) + whole - both).max(1))
    }
}

/// Whether an object's footprint (its bounding box's) lies well within the sensory area.
fn within_area(object: &ObjectTruth, camera: &CameraPose, area: &SensoryArea) -> bool {
    let (sin_turn, cos_turn) = libm::sincosf(object.yaw);
    let (sin_lean, cos_lean) = libm::sincosf(camera.pitch);
    let [x, y, z] = object.centre;
    let forward = z * cos_lean - y * sin_lean;
    [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].into_iter().all(|(a, b)| {
        let (front, left) = (0.5 * a * object.size[0], 0.5 * b * object.size[1]);
        let ahead = forward + front * cos_turn - left * sin_turn;
        let right = x - front * sin_turn - left * cos_turn;
        let c = CLEARANCE;
        [(c, c), (c, -c), (-c, c), (-c, -c)].into_iter().all(|(dx, dy)| area.contains(right + dx, ahead + dy))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use pldi_core::Intrinsics;
    use pldi_core::ground::AreaParams;

    #[test]
    fn footprints_are_turned_and_placed_on_the_floor() {
        let camera = CameraPose::new(0.0, 0.0, 0.0, 1.2, 0.3);
        let floor = Floor::from_pose(1.2, 0.3, 0.0).unwrap();
        let area = SensoryArea::new(&AreaParams::DEFAULT, &Intrinsics::PRIMESENSE_QVGA, &floor);
        let within = |x: f32, y: f32, yaw: f32| {
            let truth = ObjectTruth {
                class: "bed".to_owned(),
                object: 1,
                instance: 0,
                centre: camera.to_camera([x, y, 0.3]),
                size: [2.0, 1.0, 0.6],
                yaw,
                distance: x,
                visible: 1,
                alone: 1,
                unclipped: 1,
                occluded: false,
                cut_by_frame: false,
                bbox: [0; 4],
            };
            within_area(&truth, &camera, &area)
        };
        // Lengthwise it ends a metre behind its middle, across half a metre.
        assert!(within(2.84, 0.0, 0.0) && !within(2.86, 0.0, 0.0));
        assert!(within(3.34, 0.0, 1.5707964) && !within(3.36, 0.0, 1.5707964));
        // Across, its sides: 1 m to each side, at a near edge of 2.5 m under a slope of 0.585.
        assert!(within(3.0, 0.2, 1.5707964) && !within(3.0, 0.5, 1.5707964) && !within(3.0, -0.5, 1.5707964));
    }
}
