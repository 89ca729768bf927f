//! Canberra distance and the nearest neighbours among templates (paper, section 5).

use crate::descriptor::{Descriptor, LENGTH};
use crate::templates::Templates;
use heapless::Vec;

/// Classes that a template set can have at most.
pub const MAX_CLASSES: usize = 64;

/// Hypotheses that are kept for an object at most, one per class.
pub const MAX_HYPOTHESES: usize = 5;

/// One possible class of an object.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Hypothesis {
    /// Index of the class in the template set.
    pub class: u16,
    /// Index of the object whose template is nearest.
    pub object: u16,
    /// View number of that template.
    pub view: u16,
    /// Canberra distance to that template, 0..=58.
    pub distance: f32,
    /// Margin in 0..=1: d'/(d + d'), where d is the distance and d' the smallest distance to any other class. Above
    /// 0.5 only for the best class; 1 if it fits exactly; 0.5 where two classes are equally near; 1 if there is no other.
    pub score: f32,
}

/// The Canberra distance: the sum of |a - b| / (|a| + |b|), where a term with both zero is 0. In 0..=58.
pub fn canberra(a: &Descriptor, b: &Descriptor) -> f32 {
    canberra_with(a, |i| b[i])
}

/// The distance to a descriptor that is read number by number (from flash, in its byte order).
#[inline(always)]
pub(crate) fn canberra_with(a: &Descriptor, b: impl Fn(usize) -> f32) -> f32 {
    const LANES: usize = 4;
    let term = |i: usize| {
        let b = b(i);
        let sum = a[i].abs() + b.abs();
        (a[i] - b).abs() / if sum > 0.0 { sum } else { 1.0 }
    };
    let mut lanes = [0.0f32; LANES];
    for i in (0..LENGTH - LENGTH % LANES).step_by(LANES) {
        for (k, lane) in lanes.iter_mut().enumerate() {
            *lane += term(i + k);
        }
    }
    for (k, lane) in lanes.iter_mut().enumerate().take(LENGTH % LANES) {
        *lane += term(LENGTH - LENGTH % LANES + k);
    }
    (lanes[0] + lanes[2]) + (lanes[1] + lanes[3])
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
    use proptest::prelude::*;

    #[test]
    fn terms_with_both_zero_are_zero() {
        let mut a = [0.0; LENGTH];
        assert_eq!(canberra(&a, &[0.0; LENGTH]), 0.0);
        a[3] = 2.0;
        assert_eq!(canberra(&a, &[0.0; LENGTH]), 1.0);
        a[57] = -1.0;
        assert_eq!(canberra(&a, &a.map(|v| -v)), 2.0);
        assert_eq!(canberra(&[1.0; LENGTH], &[3.0; LENGTH]), 29.0);
    }

    #[test]
    fn margins() {
        assert_eq!(
            [margin(1.0, 3.0), margin(3.0, 1.0), margin(0.0, 0.0), margin(2.0, f32::INFINITY)],
            [0.75, 0.25, 0.5, 1.0]
        );
    }

    proptest! {
        #[test]
        fn the_distance_is_symmetric_and_bounded(
            a in proptest::collection::vec(-1.0f32..1.0, LENGTH), b in proptest::collection::vec(-1.0f32..1.0, LENGTH),
        ) {
            let a: Descriptor = a.try_into().unwrap();
            let b: Descriptor = b.try_into().unwrap();
            let d = canberra(&a, &b);
            prop_assert_eq!(d, canberra(&b, &a));
            prop_assert!((0.0..=58.0).contains(&d));
            prop_assert_eq!(canberra(&a, &a), 0.0);
        }
    }
}
