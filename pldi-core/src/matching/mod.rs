//! The nearest neighbours among templates (paper, section 5).

mod canberra;
pub mod fixed;

use crate::TemplateError;
use crate::descriptor::Descriptor;
use crate::templates::{Encoding, MAX_CLASSES, Template, Templates, Values};
use heapless::Vec;

pub use canberra::canberra;

/// Hypotheses that are kept for an object at most, one per class.
pub const MAX_HYPOTHESES: usize = 5;

/// One possible class of an object. Distance and score are floats, or in fixed point u32 in Q16.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Hypothesis<D = f32> {
    /// Index of the class in the template set.
    pub class: u16,
    /// Index of the object whose template is nearest.
    pub object: u16,
    /// View number of that template.
    pub view: u16,
    /// Canberra distance to that template, 0..=58.
    pub distance: D,
    /// Margin in 0..=1: d'/(d + d'), where d is the distance and d' the smallest distance to any other class. Above
    /// 0.5 only for the best class; 1 if it fits exactly; 0.5 where two classes are equally near; 1 if there is no other.
    pub score: D,
}

/// What distances and scores are measured in.
trait Measure: Copy + PartialOrd {
    /// Beyond all distances.
    const FAR: Self;

    /// d'/(d + d'), 1 without another class (d' is `FAR`), 0.5 where both fit exactly.
    fn margin(distance: Self, other: Self) -> Self;
}

impl Measure for f32 {
    const FAR: Self = Self::INFINITY;

    fn margin(distance: Self, other: Self) -> Self {
        if other.is_infinite() {
            1.0
        } else if distance + other > 0.0 {
            other / (distance + other)
        } else {
            0.5
        }
    }
}

/// The nearest template of each of the best classes, best first, at most [`MAX_HYPOTHESES`]; empty for an empty set.
/// Of equally near templates the first in the file counts.
///
/// # Errors
/// `Encoding` where the set's numbers are no floats.
pub fn nearest(
    templates: &Templates<'_>,
    descriptor: &Descriptor,
) -> Result<Vec<Hypothesis, MAX_HYPOTHESES>, TemplateError> {
    templates.require_encoding(Encoding::Float)?;
    // Sums of floats are not left early: the divisions run four at a time, and a wrong guess costs more than it saves.
    Ok(search(templates, |template, _| match template.values {
        Values::Float(values) => Some(canberra::canberra_with(descriptor, |i| values[i].get())),
        Values::Logarithmic(_) => None,
    }))
}

/// Templates that are passed over after each: the whole set is seen in as many rounds. The first round meets nearly every
/// object, so that the limits are close to the final ones before most templates are looked at.
const STEP: usize = 37;

/// The nearest template of a class so far.
#[derive(Clone, Copy)]
struct Nearest<D> {
    distance: D,
    /// Its index in the set.
    index: usize,
}

/// The search in any measure. `within` tells the distance of a template, at least where it does not exceed a limit.
#[inline(always)]
fn search<D: Measure>(
    templates: &Templates<'_>,
    within: impl Fn(&Template<'_>, D) -> Option<D>,
) -> Vec<Hypothesis<D>, MAX_HYPOTHESES> {
    let mut best = [Nearest { distance: D::FAR, index: usize::MAX }; MAX_CLASSES];
    // A class whose templates are all farther than the last of the kept ones will not be kept.
    let mut last_kept = D::FAR;
    for first in 0..STEP {
        for index in (first..templates.len()).step_by(STEP) {
            let Some(template) = templates.get(index) else { continue };
            let Some(best_of_class) = best.get_mut(usize::from(template.class())) else { continue };
            let Nearest { distance: least, index: least_index } = *best_of_class;
            let limit = if least < last_kept { least } else { last_kept };
            let Some(distance) = within(&template, limit) else { continue };
            if distance < least || (distance == least && index < least_index) {
                *best_of_class = Nearest { distance, index };
                last_kept = last_of_kept(&best);
            }
        }
    }
    kept(templates, &mut best)
}

/// The distance that is the last of the [`MAX_HYPOTHESES`] least.
fn last_of_kept<D: Measure>(best: &[Nearest<D>]) -> D {
    let mut least = [D::FAR; MAX_HYPOTHESES];
    let mut last = D::FAR;
    for nearest in best {
        let mut distance = nearest.distance;
        if distance < last {
            for place in &mut least {
                if distance < *place {
                    core::mem::swap(place, &mut distance);
                }
                last = *place;
            }
        }
    }
    last
}

/// The hypotheses in their order, with their scores; takes what it keeps out of `best`.
fn kept<D: Measure>(templates: &Templates<'_>, best: &mut [Nearest<D>]) -> Vec<Hypothesis<D>, MAX_HYPOTHESES> {
    let mut order: Vec<Hypothesis<D>, MAX_HYPOTHESES> = Vec::new();
    while !order.is_full() {
        let mut next = Nearest { distance: D::FAR, index: usize::MAX };
        let mut place = None;
        // Of equally near classes the first.
        for nearest in best.iter_mut() {
            if nearest.distance < next.distance {
                next = *nearest;
                place = Some(nearest);
            }
        }
        let (Some(place), Some(template)) = (place, templates.get(next.index)) else { break };
        place.distance = D::FAR;
        let (class, object, view) = (template.class(), template.object(), template.view());
        // It is not full.
        let _ = order.push(Hypothesis { class, object, view, distance: next.distance, score: D::FAR });
    }
    let first = order.first().map_or(D::FAR, |h| h.distance);
    let second = order.get(1).map_or(D::FAR, |h| h.distance);
    for (rank, h) in order.iter_mut().enumerate() {
        h.score = D::margin(h.distance, if rank == 0 { second } else { first });
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn margins() {
        let margin = <f32 as Measure>::margin;
        assert_eq!(
            [margin(1.0, 3.0), margin(3.0, 1.0), margin(0.0, 0.0), margin(2.0, f32::INFINITY)],
            [0.75, 0.25, 0.5, 1.0]
        );
    }
}
