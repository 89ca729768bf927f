//! A device's results as the lines that `pldi run` prints.

use std::collections::BTreeMap;

use pldi_core::fixed::METRE;
use pldi_core::floor::fixed::Floor;
use pldi_core::serial::answer::reason_name;
use pldi_core::serial::wire::{self, Hypothesis};
use pldi_core::templates::{Templates, layout};
use serde::{Deserialize, Serialize};
use zerocopy::little_endian::I32;

use super::Detections;
use crate::ArithmeticKind;
use crate::report::{DetectionReport, FloorReport, FrameReport, HypothesisReport, RejectedReport};

/// A frame's line. `frame` and `stamp` are those that the frame was sent with; boxes are in the pixels of the rows that were
/// sent; `params` is 00000000 where the device does not tell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SerialReport {
    /// `serial`.
    pub source: String,
    /// As for a recording.
    #[serde(flatten)]
    pub report: FrameReport,
    /// Number of the clusters that are no candidates. They are listed only where the frame's sender asked for it.
    pub rejected_count: u16,
}

/// What the device's numbers of classes and objects mean.
#[derive(Debug, Clone, Default)]
pub struct Names<'a> {
    templates: Option<Templates<'a>>,
    told: BTreeMap<u16, String>,
}

impl<'a> Names<'a> {
    /// Names of a template file, which count where the device has the same file; those that the device tells otherwise.
    pub fn new(templates: Option<Templates<'a>>) -> Self {
        Self { templates, told: BTreeMap::new() }
    }

    /// Takes a name that the device told.
    pub fn learn(&mut self, class: &wire::Class) {
        if let Some(name) = layout::text(&class.name).filter(|_| class.class < class.classes) {
            self.told.insert(class.class.get(), name.to_owned());
        }
    }

    /// Whether the device has this template file.
    pub fn known(&self, templates_hash: u32) -> bool {
        self.templates.is_some_and(|set| set.checksum() == templates_hash)
    }

    fn hypothesis(&self, h: &Hypothesis, templates_hash: u32) -> HypothesisReport {
        let (class, object) = (h.class.get(), h.object.get());
        let set = self.templates.filter(|_| self.known(templates_hash));
        let q16 = |value: u32| value as f32 / 65_536.0;
        HypothesisReport {
            class_id: match (set, self.told.get(&class)) {
                (Some(set), _) => set.class_name(class).to_owned(),
                (None, Some(name)) => name.clone(),
                (None, None) => format!("class {class}"),
            },
            score: q16(h.score.get()),
            distance: q16(h.distance.get()),
            object: set.map_or_else(|| format!("object {object}"), |set| set.object_name(object).to_owned()),
            view: h.view.get(),
        }
    }
}

impl SerialReport {
    /// The line for what a device says about a frame.
    pub fn new(found: &Detections, names: &Names<'_>) -> Self {
        let result = &found.result;
        let hash = result.templates_hash.get();
        let metres = |v: [I32; 3]| v.map(|v| v.get() as f32 / METRE as f32);
        let detections = found.detections.iter().map(|d| DetectionReport {
            id: d.place.id.get().into(),
            results: d.hypotheses.iter().map(|h| names.hypothesis(h, hash)).collect(),
            center: metres(d.place.centre),
            size: metres(d.place.size),
            bbox: d.place.bbox.map(|v| v.get().into()),
        });
        let rejected = found.rejected.iter().map(|r| RejectedReport {
            id: r.id.get().into(),
            reason: reason_name(r.reason).to_owned(),
            bbox: r.bbox.map(|v| v.get().into()),
            center: metres(r.centre),
        });
        let floor = (result.flags & pldi_core::serial::answer::FLOOR != 0).then(|| {
            let floor = Floor { normal: result.normal.map(I32::get), height: result.height.get() }.to_float();
            FloorReport { normal: floor.normal, height: floor.height }
        });
        let [major, minor, patch] = result.version;
        let report = FrameReport {
            frame: result.frame.get() as usize,
            stamp: result.stamp.get() as f64 / 1e6,
            floor,
            detections: detections.collect(),
            rejected: rejected.collect(),
            params: format!("{:08x}", result.params_hash.get()),
            templates: format!("{hash:08x}"),
            arithmetic: ArithmeticKind::Fixed,
            version: format!("{major}.{minor}.{patch}"),
        };
        Self { source: "serial".to_owned(), report, rejected_count: result.rejected.get() }
    }
}
