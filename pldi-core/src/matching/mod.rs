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

/// The search in any measure. `below` tells the distance of a template, at least where it is less than a limit.
fn search<D: Measure>(
    templates: &Templates<'_>,
    below: impl Fn(&Template<'_>, D) -> Option<D>,
) -> Vec<Hypothesis<D>, MAX_HYPOTHESES> {
    let none = Hypothesis { class: 0, object: 0, view: 0, distance: D::FAR, score: D::FAR };
    let mut best = [none; MAX_CLASSES];
    for template in templates.iter() {
        if let Some(best) = best.get_mut(usize::from(template.class()))
            && let Some(distance) = below(&template, best.distance)
            && distance < best.distance
        {
            let (class, object, view) = (template.class(), template.object(), template.view());
            *best = Hypothesis { class, object, view, distance, score: D::FAR };
        }
    }
    let order = nearest_classes(&best, none);
    let [first, second, ..] = order.map(|h| h.distance);
    let mut hypotheses = Vec::new();
    for (rank, h) in order.iter().enumerate().filter(|(_, h)| h.distance < D::FAR) {
        let other = if rank == 0 { second } else { first };
        // As many fit as there are.
        let _ = hypotheses.push(Hypothesis { score: D::margin(h.distance, other), ..*h });
    }
    hypotheses
}

/// The nearest of all classes, best first, of equally near ones the first; where there are fewer, `none` follows.
fn nearest_classes<D: Measure>(classes: &[Hypothesis<D>], none: Hypothesis<D>) -> [Hypothesis<D>; MAX_HYPOTHESES] {
    let mut order = [none; MAX_HYPOTHESES];
    for class in classes {
        let (mut moved, mut nearer) = (*class, false);
        for place in &mut order {
            // From the first farther one on, all move up.
            nearer |= moved.distance < place.distance;
            if nearer {
                core::mem::swap(place, &mut moved);
            }
        }
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
