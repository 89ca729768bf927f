//! All that is measured, cut into jobs for several threads.

use std::collections::BTreeMap;
use std::path::PathBuf;

use pldi_host::parallel;

use crate::errors::{Errors, Key, Tally};
use crate::inputs::{analytic, extremes, random, real, recordings, views};
use crate::rows::Set;
use crate::stages::{Tools, fixed, frame, numbers, object};

/// What a job does.
enum Job {
    /// Numbers, or a few small things.
    Plain(Set, fn(&mut Tally)),
    /// A frame.
    Frame(Set, fn(usize) -> crate::inputs::Scene, usize),
    /// A generated recording.
    Recording(usize),
    /// All views of an object.
    Views(usize),
    /// A real recording.
    Real(PathBuf),
}

impl Job {
    fn set(&self) -> Set {
        match self {
            Self::Plain(set, _) | Self::Frame(set, ..) => *set,
            Self::Recording(_) => Set::Recordings,
            Self::Views(_) => Set::Views,
            Self::Real(_) => Set::Real,
        }
    }

    fn run(&self, tools: &mut Tools) -> Tally {
        let mut tally = Tally::new(self.set());
        match self {
            Self::Plain(_, measure) => measure(&mut tally),
            Self::Frame(_, scene, i) => frame::measure(&scene(*i), tools, &mut tally),
            Self::Recording(i) => {
                recordings::scenes(*i).iter().for_each(|scene| frame::measure(scene, tools, &mut tally));
            }
            Self::Views(i) => object::views(*i, tools, &mut tally),
            Self::Real(folder) => {
                real::scenes(folder).iter().for_each(|scene| frame::measure(scene, tools, &mut tally));
            }
        }
        tally
    }
}

/// All jobs.
fn jobs() -> Vec<Job> {
    let plain = numbers::JOBS.iter().chain(fixed::JOBS).map(|job| Job::Plain(Set::Numbers, *job));
    let mut out: Vec<Job> = plain.collect();
    out.push(Job::Plain(Set::Numbers, object::canberra));
    out.push(Job::Plain(Set::Analytic, object::pattern));
    out.push(Job::Plain(Set::Extremes, object::extreme_views));
    out.extend((0..analytic::SCENES.len()).map(|i| Job::Frame(Set::Analytic, |i| analytic::SCENES[i](), i)));
    out.extend((0..extremes::COUNT).map(|i| Job::Frame(Set::Extremes, extremes::scene, i)));
    out.extend((0..random::COUNT).map(|i| Job::Frame(Set::Random, random::scene, i)));
    out.extend((0..=recordings::ROOMS as usize).map(Job::Recording));
    out.extend((0..views::OBJECTS).map(Job::Views));
    out.extend(real::folders().into_iter().map(Job::Real));
    out
}

/// Runs the jobs (those on one set of inputs where it is given) on `threads` threads and adds up what they measured, in the
/// jobs' order: the sums are the same for any number of threads.
pub fn run(only: Option<Set>, threads: usize) -> BTreeMap<Key, Errors> {
    let mut jobs = jobs();
    jobs.retain(|job| only.is_none_or(|set| job.set() == set));
    let mut all = BTreeMap::new();
    let work = |tools: &mut Tools, _, job: Job| job.run(tools);
    let sink = |_, tally: Tally| {
        tally.merge_into(&mut all);
        Ok::<_, std::convert::Infallible>(true)
    };
    let Ok(()) = parallel::for_each_ordered(jobs, threads, Tools::new, work, sink);
    all
}
