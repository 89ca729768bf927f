//! The Canberra distance between descriptors (paper, section 5).

use crate::descriptor::{Descriptor, LENGTH};

/// The Canberra distance: the sum of |a - b| / (|a| + |b|), where a term with both zero is 0. In 0..=58.
pub fn canberra(a: &Descriptor, b: &Descriptor) -> f32 {
    canberra_with(a, |i| b[i])
}

/// The distance to a descriptor that is read number by number (from flash, in its byte order).
#[inline(always)]
pub(super) fn canberra_with(a: &Descriptor, b: impl Fn(usize) -> f32) -> f32 {
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
