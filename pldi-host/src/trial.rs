//! A trial on generated recordings, where the truth is known: which objects are found, and what they are taken for.

use pldi_core::ground::SensoryArea;
use pldi_core::pipeline::{QvgaPipeline, QvgaWorkspace};
use pldi_core::templates::Templates;
use pldi_core::{Floor, Frame, Params};
use pldi_fixtures::rng::{Rng, derive};
use pldi_fixtures::{
    CameraPose, Class, Drive, HELD_OUT_SEEDS, ObjectTruth, RecordedFrame, Recording, RoomPlan, Sensor,
};

use crate::input::reduce;
use crate::templates::Confusion;
use crate::{Error, parallel};

/// Which recordings are generated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// Rooms, each with objects of its own out of the held-out seeds.
    pub rooms: u32,
    /// Frames of each room's drive.
    pub frames: usize,
    /// Seed of rooms, paths and noise.
    pub seed: u64,
}

impl Default for Trial {
    fn default() -> Self {
        Self { rooms: 40, frames: 12, seed: 1 }
    }
}

/// What became of one object that could be recognised: seen whole, not occluded, within the sensory area.
#[derive(Debug, Clone, PartialEq)]
pub struct Sighting {
    /// Number of the room.
    pub room: u32,
    /// Number of the frame.
    pub frame: usize,
    /// The object.
    pub truth: ObjectTruth,
    /// The answer's class and score; `None` where no candidate covers the object.
    pub answer: Option<(String, f32)>,
    /// The reason of the rejected cluster that covers it, where one does.
    pub reason: Option<&'static str>,
}

/// The outcome of a trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Every object that could be recognised, in every frame.
    pub sightings: Vec<Sighting>,
    /// Candidates that are no whole object: parts of occluded or cut ones, furniture that merged, walls.
    pub strays: u32,
    /// Frames in all.
    pub frames: u32,
}

impl Outcome {
    /// Share of the sightings that a candidate covers.
    pub fn found_share(&self) -> f64 {
        let found = self.sightings.iter().filter(|s| s.answer.is_some()).count();
        found as f64 / self.sightings.len().max(1) as f64
    }

    /// Truth against answers; sightings without a candidate are not in it.
    pub fn confusion(&self, classes: &[String]) -> Confusion {
        let mut confusion = Confusion::new(classes.to_vec());
        let index = |name: &str| classes.iter().position(|c| c == name);
        for s in &self.sightings {
            if let (Some(truth), Some(answer)) = (index(&s.truth.class), s.answer.as_ref().and_then(|a| index(&a.0))) {
                confusion.counts[truth][answer] += 1;
            }
        }
        confusion
    }

    /// Macro average of the recall with objects that were not found counted as missed.
    pub fn strict_recall(&self, classes: &[String]) -> f64 {
        let of_class = |class: &str| {
            let all: Vec<&Sighting> = self.sightings.iter().filter(|s| s.truth.class == class).collect();
            let right = all.iter().filter(|s| s.answer.as_ref().is_some_and(|a| a.0 == class)).count();
            (!all.is_empty()).then(|| right as f64 / all.len() as f64)
        };
        let recalls: Vec<f64> = classes.iter().filter_map(|c| of_class(c)).collect();
        recalls.iter().sum::<f64>() / recalls.len().max(1) as f64
    }
}

/// A cluster counts for an object where they share at least half of the pixels of both together.
const OVERLAP: f64 = 0.5;

/// An object is within the area where its footprint keeps so far from the area's borders, in metres: the density on the
/// floor is spread by the sensor's error and by the cells' size, and the core leaves out what touches a border.
const CLEARANCE: f32 = 0.15;

impl Trial {
    /// Runs the trial; `done` is called after each room (from several threads) and stops the work by returning `false`.
    ///
    /// # Errors
    /// What the core says; `Interrupted`.
    pub fn run(
        &self,
        params: &Params,
        templates: &Templates<'_>,
        threads: usize,
        done: impl Fn() -> bool + Sync,
    ) -> Result<Outcome, Error> {
        let rooms = parallel::map_ordered(
            self.rooms as usize,
            threads,
            || Box::new(QvgaWorkspace::new()),
            |workspace, room| {
                let outcome = self.room(room as u32, params, templates, workspace)?;
                if done() { Ok(outcome) } else { Err(Error::Interrupted) }
            },
        )?;
        let mut all = Outcome { sightings: Vec::new(), strays: 0, frames: 0 };
        for room in rooms {
            all.sightings.extend(room.sightings);
            all.strays += room.strays;
            all.frames += room.frames;
        }
        Ok(all)
    }

    /// The objects of a room, 4 to 6. All rooms together draw from one deck after the other of all classes, shuffled, so
    /// that every class comes up equally often; no two rooms share an object.
    fn furniture(&self, room: u32) -> Vec<(Class, u64)> {
        // The first card of the next rooms: 4, 5, 6 and 5 cards are dealt in turn.
        let first = |room: u32| 5 * u64::from(room) - u64::from(matches!(room % 4, 1 | 2));
        let n = Class::ALL.len();
        let card = |i: u64| {
            let mut deck = Class::ALL;
            let mut rng = Rng::new(derive(self.seed, (2 << 32) + i / n as u64));
            for k in (1..n).rev() {
                deck.swap(k, rng.below(k + 1));
            }
            (deck[(i % n as u64) as usize], HELD_OUT_SEEDS + i)
        };
        (first(room)..first(room + 1)).map(card).collect()
    }

    /// The drive through a room.
    pub fn recording(&self, room: u32) -> Recording {
        let plan = RoomPlan::furnish(derive(self.seed, u64::from(room)), &self.furniture(room));
        let seed = derive(self.seed, u64::from(room) + (1 << 32));
        Recording::new(plan, Sensor::kinect_v1(), Drive::stops(self.frames), seed)
    }

    fn room(
        &self,
        room: u32,
        params: &Params,
        templates: &Templates<'_>,
        workspace: &mut QvgaWorkspace,
    ) -> Result<Outcome, Error> {
        let recording = self.recording(room);
        let mut outcome = Outcome { sightings: Vec::new(), strays: 0, frames: 0 };
        let intrinsics = recording.sensor.intrinsics.reduced(2).map_err(Error::core)?;
        let pipeline = QvgaPipeline::new(params, &intrinsics).map_err(Error::core)?;
        for (i, frame) in recording.frames().enumerate() {
            let (sightings, strays) = judge(&pipeline, templates, frame, workspace)?;
            outcome.sightings.extend(sightings.into_iter().map(|(truth, answer, reason)| Sighting {
                room,
                frame: i,
                truth,
                answer,
                reason,
            }));
            outcome.strays += strays;
            outcome.frames += 1;
        }
        Ok(outcome)
    }
}

/// Whether an object's footprint (its bounding box's) lies well within the sensory area.
fn within_area(object: &ObjectTruth, camera: &CameraPose, area: &SensoryArea) -> bool {
    let (turn, lean) = (libm::sincosf(object.yaw), libm::sincosf(camera.pitch));
    let [x, y, z] = object.centre;
    let (ahead, aside) = (z * lean.1 - y * lean.0, x);
    [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].into_iter().all(|(a, b)| {
        let (front, left) = (0.5 * a * object.size[0], 0.5 * b * object.size[1]);
        let forward = ahead + front * turn.1 - left * turn.0;
        let right = aside - front * turn.0 - left * turn.1;
        let c = CLEARANCE;
        [(c, c), (c, -c), (-c, c), (-c, -c)].into_iter().all(|(dx, dy)| area.contains(right + dx, forward + dy))
    })
}

type Judged = (ObjectTruth, Option<(String, f32)>, Option<&'static str>);

/// Runs the pipeline on a frame with truth: what became of each object that could be recognised, and the number of
/// candidates that are no whole object.
pub fn judge(
    pipeline: &QvgaPipeline,
    templates: &Templates<'_>,
    frame: RecordedFrame,
    workspace: &mut QvgaWorkspace,
) -> Result<(Vec<Judged>, u32), Error> {
    let RecordedFrame { capture, truth, camera, .. } = frame;
    let floor = Floor::from_pose(camera.height, camera.pitch, camera.roll).map_err(Error::core)?;
    let area = SensoryArea::new(&pipeline.params().area, pipeline.rays().intrinsics(), &floor);
    let (depth, colour) = reduce(&capture.depth, capture.colour, 2);
    let qvga = Frame::new(&depth, Some(&colour)).map_err(Error::core)?;
    pipeline.run(&qvga, templates, workspace).map_err(Error::core)?;
    let (report, labels) = (&workspace.report, workspace.labels.as_flattened());
    let truths: Vec<u8> =
        capture.labels.chunks(2 * capture.width).flat_map(|r| r[..capture.width].iter().step_by(2).copied()).collect();
    let measured = |i: usize| depth[i] > 0;
    let overlap = |label: u8, cluster: usize| {
        let (mut both, mut either) = (0u32, 0u32);
        for (i, (t, l)) in truths.iter().zip(labels).enumerate() {
            let (a, b) = (*t == label && measured(i), usize::from(*l) == cluster + 1);
            both += u32::from(a && b);
            either += u32::from(a || b);
        }
        f64::from(both) / f64::from(either.max(1))
    };
    let mut used = Vec::new();
    let mut out = Vec::new();
    for object in truth {
        let whole = !object.occluded && !object.cut_by_frame && within_area(&object, &camera, &area);
        let label = object.instance as u8 + 1;
        let covering = (0..report.clusters.len())
            .map(|c| (overlap(label, c), c))
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .filter(|(share, _)| *share >= OVERLAP)
            .map(|(_, c)| c);
        let detection = covering.and_then(|c| report.detections.iter().find(|d| usize::from(d.cluster) == c));
        if whole {
            used.extend(detection.map(|d| d.cluster));
            let best = detection.and_then(|d| d.hypotheses.first());
            let answer = best.map(|h| (templates.class_name(h.class).to_owned(), h.score));
            let reason = covering.and_then(|c| report.clusters[c].rejection).map(|r| r.name());
            out.push((object, answer, reason));
        }
    }
    let strays = report.detections.iter().filter(|d| !used.contains(&d.cluster)).count() as u32;
    Ok((out, strays))
}
