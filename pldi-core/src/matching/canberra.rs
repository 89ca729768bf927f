//! The Canberra distance between descriptors (paper, section 5).

use crate::descriptor::{Descriptor, LENGTH};

/// Sums that run side by side.
const LANES: usize = 4;

/// Terms after which a sum is compared with the limit.
const STRIDE: usize = 16;

/// The Canberra distance: the sum of |a - b| / (|a| + |b|), where a term with both zero is 0. In 0..=58.
pub fn canberra(a: &Descriptor, b: &Descriptor) -> f32 {
    let mut lanes = [0.0; LANES];
    add_terms(&mut lanes, a, |i| b[i], 0, LENGTH);
    total(lanes)
}

/// The distance to a descriptor that is read number by number (from flash, in its byte order); `None` as soon as it is
/// certain not to lie below `limit`: terms are not negative and sums are rounded monotonically.
#[inline(always)]
pub(super) fn canberra_below(a: &Descriptor, b: impl Fn(usize) -> f32 + Copy, limit: f32) -> Option<f32> {
    let mut lanes = [0.0; LANES];
    for from in (0..LENGTH).step_by(STRIDE) {
        add_terms(&mut lanes, a, b, from, LENGTH.min(from + STRIDE));
        if total(lanes) >= limit {
            return None;
        }
    }
    Some(total(lanes))
}

/// Adds the terms `from..to`, where `from` is a multiple of [`LANES`]. The same order of additions on every target.
#[inline(always)]
fn add_terms(lanes: &mut [f32; LANES], a: &Descriptor, b: impl Fn(usize) -> f32, from: usize, to: usize) {
    let term = |i: usize| {
        let b = b(i);
        let sum = a[i].abs() + b.abs();
        (a[i] - b).abs() / if sum > 0.0 { sum } else { 1.0 }
    };
    let whole = to - to % LANES;
    for i in (from..whole).step_by(LANES) {
        for (k, lane) in lanes.iter_mut().enumerate() {
            *lane += term(i + k);
        }
    }
    for (k, lane) in lanes.iter_mut().enumerate().take(to - whole) {
        *lane += term(whole + k);
    }
}

fn total(lanes: [f32; LANES]) -> f32 {
    (lanes[0] + lanes[2]) + (lanes[1] + lanes[3])
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

    proptest! {
        #[test]
        fn the_distance_is_symmetric_and_bounded(
            a in proptest::collection::vec(-1.0f32..1.0, LENGTH), b in proptest::collection::vec(-1.0f32..1.0, LENGTH),
            limit in 0.0f32..58.0,
        ) {
            let a: Descriptor = a.try_into().unwrap();
            let b: Descriptor = b.try_into().unwrap();
            let d = canberra(&a, &b);
            prop_assert_eq!(d, canberra(&b, &a));
            prop_assert!((0.0..=58.0).contains(&d));
            prop_assert_eq!(canberra(&a, &a), 0.0);
            prop_assert_eq!(canberra_below(&a, |i| b[i], limit), (d < limit).then_some(d));
            prop_assert_eq!(canberra_below(&a, |i| b[i], d), None);
        }
    }
}
