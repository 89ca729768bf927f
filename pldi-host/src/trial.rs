//! A trial on generated recordings, where the truth is known: which objects are found, and what they are taken for.

mod judge;

use pldi_core::pipeline::QvgaWorkspace;
use pldi_core::templates::Templates;
use pldi_core::{Frame, Params};
use pldi_fixtures::rng::{Rng, derive};
use pldi_fixtures::{Class, Drive, HELD_OUT_SEEDS, RecordedFrame, Recording, RoomPlan, Sensor};

use crate::input::reduce;
use crate::templates::Confusion;
use crate::{ArithmeticKind, Engine, Error, parallel};

pub use judge::{FrameTruth, Standing, Verdict, judge};

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
        Self { rooms: 48, frames: 12, seed: 1 }
    }
}

/// What became of one object that could be recognised: seen whole, not occluded, within the sensory area.
#[derive(Debug, Clone, PartialEq)]
pub struct Sighting {
    /// Number of the room.
    pub room: u32,
    /// Number of the frame.
    pub frame: usize,
    /// The object and the answer.
    pub verdict: Verdict,
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
        let found = self.sightings.iter().filter(|s| s.verdict.answer.is_some()).count();
        found as f64 / self.sightings.len().max(1) as f64
    }

    /// Truth against answers; sightings without a candidate are not in it.
    pub fn confusion(&self, classes: &[String]) -> Confusion {
        let mut confusion = Confusion::new(classes.to_vec());
        let index = |name: &str| classes.iter().position(|c| c == name);
        for s in &self.sightings {
            if let (Some(truth), Some(answer)) =
                (index(&s.verdict.truth.class), s.verdict.answer.as_ref().and_then(|a| index(&a.0)))
            {
                confusion.counts[truth][answer] += 1;
            }
        }
        confusion
    }

    /// Macro average of the recall with objects that were not found counted as missed.
    pub fn strict_recall(&self, classes: &[String]) -> f64 {
        let of_class = |class: &str| {
            let all: Vec<&Sighting> = self.sightings.iter().filter(|s| s.verdict.truth.class == class).collect();
            let right = all.iter().filter(|s| s.verdict.is_right()).count();
            (!all.is_empty()).then(|| right as f64 / all.len() as f64)
        };
        let recalls: Vec<f64> = classes.iter().filter_map(|c| of_class(c)).collect();
        recalls.iter().sum::<f64>() / recalls.len().max(1) as f64
    }
}

impl Trial {
    /// Runs the trial in floats or integers; `done` is called after each room (from several threads) and stops the work by returning `false`.
    ///
    /// # Errors
    /// As [`Engine::new`] and [`Engine::run`]; `Interrupted`.
    pub fn run(
        &self,
        arithmetic: ArithmeticKind,
        params: &Params,
        templates: &Templates<'_>,
        threads: usize,
        done: impl Fn() -> bool + Sync,
    ) -> Result<Outcome, Error> {
        Engine::check(arithmetic, params)?;
        let rooms = parallel::map_ordered(
            self.rooms as usize,
            threads,
            || Box::new(QvgaWorkspace::new()),
            |workspace, room| {
                let outcome = self.room(room as u32, arithmetic, params, templates, workspace)?;
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
        arithmetic: ArithmeticKind,
        params: &Params,
        templates: &Templates<'_>,
        workspace: &mut QvgaWorkspace,
    ) -> Result<Outcome, Error> {
        let recording = self.recording(room);
        let mut outcome = Outcome { sightings: Vec::new(), strays: 0, frames: 0 };
        let intrinsics = recording.sensor.intrinsics.reduced(2).map_err(Error::core)?;
        let mut engine = Engine::new(arithmetic, params, &intrinsics)?;
        for (i, frame) in recording.frames().enumerate() {
            let RecordedFrame { capture, truth, camera, .. } = frame;
            let seen = FrameTruth::new(truth, camera, &capture, 2);
            let (depth, colour) = reduce(&capture.depth, &capture.colour, 2);
            let qvga = Frame::new(&depth, Some(&colour)).map_err(Error::core)?;
            engine.run(&qvga, templates, workspace)?;
            let (verdicts, strays) = judge(&seen, &depth, &engine, templates, workspace).map_err(Error::core)?;
            let whole = verdicts.into_iter().filter(|v| v.standing == Standing::Whole);
            outcome.sightings.extend(whole.map(|verdict| Sighting { room, frame: i, verdict }));
            outcome.strays += strays;
            outcome.frames += 1;
        }
        Ok(outcome)
    }
}
