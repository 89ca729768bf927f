//! The nearest neighbours among templates (paper, section 5).

use crate::descriptor::Descriptor;
use crate::templates::{MAX_CLASSES, Templates};
use heapless::Vec;

pub use crate::canberra::canberra;

/// Hypotheses that are kept for an object at most, one per class.
pub const MAX_HYPOTHESES: usize = 5;

/// One possible class of an object.
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

/// The nearest template of each of the best classes, best first, at most [`MAX_HYPOTHESES`]; empty for an empty set.
/// Of equally near templates the first in the file counts.
pub fn nearest(templates: &Templates<'_>, descriptor: &Descriptor) -> Vec<Hypothesis, MAX_HYPOTHESES> {
    let none = Hypothesis { class: 0, object: 0, view: 0, distance: f32::INFINITY, score: 0.0 };
    let mut best = [none; MAX_CLASSES];
    for template in templates.iter() {
        let distance = template.distance(descriptor);
        if let Some(best) = best.get_mut(usize::from(template.class()))
            && distance < best.distance
        {
            *best = Hypothesis {
                class: template.class(),
                object: template.object(),
                view: template.view(),
                distance,
                score: 0.0,
            };
        }
    }
    let mut order: Vec<Hypothesis, MAX_CLASSES> = best.iter().copied().filter(|h| h.distance.is_finite()).collect();
    order.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.class.cmp(&b.class)));
    let first = order.first().map_or(f32::INFINITY, |h| h.distance);
    let second = order.get(1).map_or(f32::INFINITY, |h| h.distance);
    let scored = order.iter().enumerate().map(|(rank, h)| {
        let other = if rank == 0 { second } else { first };
        Hypothesis { score: margin(h.distance, other), ..*h }
    });
    scored.take(MAX_HYPOTHESES).collect()
}

/// d'/(d + d'), 1 without another class, 0.5 where both fit exactly.
fn margin(distance: f32, other: f32) -> f32 {
    if other.is_infinite() {
        1.0
    } else if distance + other > 0.0 {
        other / (distance + other)
    } else {
        0.5
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn margins() {
        assert_eq!(
            [margin(1.0, 3.0), margin(3.0, 1.0), margin(0.0, 0.0), margin(2.0, f32::INFINITY)],
            [0.75, 0.25, 0.5, 1.0]
        );
    }
}
