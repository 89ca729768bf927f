//! The nearest neighbours in fixed point: distances and scores in Q16.
//!
//! |a - b| / (|a| + |b|) of two numbers with the same sign is tanh(|ln a - ln b| / 2): between the logarithms that
//! [`fixed::Descriptor`](crate::descriptor::fixed::Descriptor) holds it is a subtraction and a table.

use super::{Hypothesis, MAX_HYPOTHESES, Measure, search};
use crate::TemplateError;
use crate::descriptor::LENGTH;
use crate::descriptor::fixed::{Descriptor, SIGN};
use crate::fixed::exp_neg;
use crate::templates::{Encoding, Templates, Values};
use heapless::Vec;
use zerocopy::little_endian::U16;

/// 1 in Q16.
const ONE: u32 = 1 << 16;

/// Terms after which a sum is compared with the limit, and what is left of a descriptor in the end.
const STRIDE: usize = 16;
const REST: usize = LENGTH % STRIDE;

/// The same for the sums of [`LEAST`].
const LEAST_STRIDE: usize = 8;

/// Differences up to here (two octaves) have an entry each.
const FINE: u16 = 2 << 10;

/// From [`FINE`] to here (eight octaves) one entry stands for 4 differences; beyond, for 128.
const COARSE: u16 = 8 << 10;

/// What places the coarser parts of the table behind the finer ones.
const FINE_OFFSET: u16 = FINE - (FINE >> 2);
const COARSE_OFFSET: u16 = FINE_OFFSET + (COARSE >> 2) - (COARSE >> 7);

/// The largest difference: also that of numbers with different signs, and to 0.
const APART: u16 = i16::MAX as u16;

/// A power of two, so that a mask keeps indices within; those beyond the largest difference's are never used.
const ENTRIES: usize = ((COARSE_OFFSET + (APART >> 7) + 1) as usize).next_power_of_two();

/// tanh(ln 2 / 2 * d / 1024) in Q15, for the middle of the differences d of each entry.
static TERMS: [u16; ENTRIES] = {
    let mut table = [0; ENTRIES];
    let mut i = 0;
    while i < ENTRIES {
        // In half units of the codes.
        let twice = if i < FINE as usize {
            2 * i
        } else if i < (FINE_OFFSET + (COARSE >> 2)) as usize {
            8 * (i - FINE_OFFSET as usize) + 3
        } else {
            256 * (i - COARSE_OFFSET as usize) + 127
        };
        table[i] = tanh(twice as u64);
        i += 1;
    }
    table
};

/// tanh(ln 2 / 2 * d / 2048) in Q15, rounded to nearest: (1 - e) / (1 + e), where e = 2^-(d / 2048).
const fn tanh(d: u64) -> u16 {
    // ln 2 in Q30, times d in Q11, gives Q41.
    const LN_2: u64 = 744_261_118;
    let e = if d == 0 { 1 << 32 } else { exp_neg(((d * LN_2) >> 17) as u32) as u64 };
    let (one, sum) = (1u64 << 32, (1u64 << 32) + e);
    ((((one - e) << 15) + sum / 2) / sum) as u16
}

/// The index of a difference: concave pieces, so that the least of them is the right one.
#[inline(always)]
const fn index(d: u16) -> u16 {
    let (a, b) = (FINE_OFFSET + (d >> 2), COARSE_OFFSET + (d >> 7));
    let least = if a < b { a } else { b };
    if d < least { d } else { least }
}

/// Differences of one entry of [`LEAST`] as a shift, and the place of the difference 0.
const LEAST_SHIFT: u32 = 3;
const LEAST_MIDDLE: i32 = 1 << 10;

/// What the terms of 8 differences are at least, from -2^13 on, in Q15. The outermost stand for all beyond them too.
static LEAST: [u16; 2 * LEAST_MIDDLE as usize] = {
    let mut table = [0; 2 * LEAST_MIDDLE as usize];
    let mut i = 0;
    while i < 2 * LEAST_MIDDLE {
        let low = (i - LEAST_MIDDLE) << LEAST_SHIFT;
        // The end that is nearer to 0: terms rise with the difference.
        let nearest = if low < 0 { -(low + (1 << LEAST_SHIFT) - 1) } else { low };
        table[i as usize] = TERMS[index(nearest as u16) as usize];
        i += 1;
    }
    table
};

/// A descriptor whose distances to many are asked for.
struct Query {
    codes: Descriptor,
    /// What is taken from a code to get the place of their difference in [`LEAST`], before the shift.
    bases: [i32; LENGTH],
}

impl Query {
    fn new(codes: &Descriptor) -> Self {
        let mut bases = [0; LENGTH];
        for (base, code) in bases.iter_mut().zip(codes) {
            *base = i32::from(*code) - (LEAST_MIDDLE << LEAST_SHIFT);
        }
        Self { codes: *codes, bases }
    }

    /// The distance; `None` where it exceeds `limit`.
    #[inline(always)]
    fn within(&self, codes: &[U16; LENGTH], limit: u32) -> Option<u32> {
        // Few templates are so near that their distance matters. Machines that compute one number at a time find the others
        // with one look at a table per term; those that compute several at once have the distance itself as soon.
        if !cfg!(target_arch = "x86_64") && self.exceeds(codes, limit) {
            return None;
        }
        self.distance(codes, limit)
    }

    /// Whether the distance certainly exceeds `limit`.
    ///
    /// Terms of numbers that are apart, which differences of codes know nothing of, are 1: no entry is more.
    #[inline(always)]
    fn exceeds(&self, codes: &[U16; LENGTH], limit: u32) -> bool {
        let mut sum = 0;
        for (bases, codes) in self.bases.as_chunks::<LEAST_STRIDE>().0.iter().zip(codes.as_chunks::<LEAST_STRIDE>().0) {
            for (base, code) in bases.iter().zip(codes) {
                let place = ((i32::from(code.get()) - base) >> LEAST_SHIFT).clamp(0, 2 * LEAST_MIDDLE - 1);
                sum += LEAST.get(place as usize).copied().map_or(0, u32::from);
            }
            // 2^21.9 at most.
            if 2 * sum > limit {
                return true;
            }
        }
        false
    }

    /// The distance; `None` as soon as it is certain to exceed `limit`.
    #[inline(never)]
    fn distance(&self, codes: &[U16; LENGTH], limit: u32) -> Option<u32> {
        let ((a, a_rest), (b, b_rest)) = (self.codes.as_chunks::<STRIDE>(), codes.as_chunks::<STRIDE>());
        let mut sum = 0;
        for (a, b) in a.iter().zip(b) {
            sum += terms(a, b);
            if sum > limit {
                return None;
            }
        }
        let (Some(a), Some(b)) = (a_rest.first_chunk::<REST>(), b_rest.first_chunk::<REST>()) else { return None };
        Some(sum + terms(a, b)).filter(|sum| *sum <= limit)
    }
}

/// The sum of some terms in Q16.
#[inline(always)]
fn terms<const N: usize>(a: &[u16; N], b: &[U16; N]) -> u32 {
    let mut at = [0; N];
    for i in 0..N {
        let (a, b) = (a[i], b[i].get());
        // All ones where the numbers have different signs, or one of them is 0.
        let signs = ((a ^ b) as i16 >> 15) as u16;
        let zeros = u16::from(a == 0).wrapping_neg() ^ u16::from(b == 0).wrapping_neg();
        let apart = (signs | zeros) & APART;
        at[i] = index((a & !SIGN).abs_diff(b & !SIGN) | apart);
    }
    // Q15: 2^19 at most.
    at.iter().map(|at| u32::from(TERMS[usize::from(*at) % ENTRIES])).sum::<u32>() << 1
}

/// The Canberra distance in Q16, 0..=58 << 16: the sum of |a - b| / (|a| + |b|), where a term with both zero is 0.
///
/// A term is at most 30 units off (0.00046) that of the decoded numbers, in the mean 2.
pub fn canberra(a: &Descriptor, b: &Descriptor) -> u32 {
    Query::new(a).distance(&b.map(U16::new), u32::MAX).unwrap_or(0)
}

impl Measure for u32 {
    const FAR: Self = Self::MAX;

    /// Q16, rounded to nearest.
    fn margin(distance: Self, other: Self) -> Self {
        if other == Self::FAR {
            return ONE;
        }
        // Distances are below 2^22.
        let (sum, other) = (distance.saturating_add(other), u64::from(other));
        if sum == 0 { ONE / 2 } else { (((other << 16) + u64::from(sum / 2)) / u64::from(sum)) as Self }
    }
}

/// The nearest template of each of the best classes, best first, at most [`MAX_HYPOTHESES`]; empty for an empty set.
/// Of equally near templates the first in the file counts. Distances and scores in Q16.
///
/// # Errors
/// `Encoding` where the set's numbers are no codes.
pub fn nearest(
    templates: &Templates<'_>,
    descriptor: &Descriptor,
) -> Result<Vec<Hypothesis<u32>, MAX_HYPOTHESES>, TemplateError> {
    templates.require_encoding(Encoding::Logarithmic)?;
    let query = Query::new(descriptor);
    Ok(search(templates, |template, limit| match template.values {
        Values::Logarithmic(values) => query.within(values, limit),
        Values::Float(_) => None,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::descriptor::fixed::decode;
    use proptest::prelude::*;

    /// The term of two codes, in units of 2^-16, exactly.
    fn exact(a: u16, b: u16) -> f64 {
        let value = |code: u16| {
            let magnitude = libm::exp2(f64::from(code & !SIGN) / 1024.0 - 26.0);
            if code == 0 {
                0.0
            } else if code & SIGN == 0 {
                magnitude
            } else {
                -magnitude
            }
        };
        let (a, b) = (value(a), value(b));
        if a == b { 0.0 } else { (a - b).abs() / (a.abs() + b.abs()) * 65_536.0 }
    }

    fn term(a: u16, b: u16) -> u32 {
        let with = |code| core::array::from_fn(|i| if i == 17 { code } else { 0 });
        canberra(&with(a), &with(b))
    }

    #[test]
    fn every_difference_has_the_right_term() {
        let (mut worst, mut sum) = (0.0f64, 0.0);
        for d in 0..=32_766u16 {
            let error = (f64::from(term(1, 1 + d)) - exact(1, 1 + d)).abs();
            worst = worst.max(error);
            sum += error;
            if d < FINE {
                assert!(error <= 1.1, "{d}: {error}");
            }
        }
        assert!(worst <= 30.0, "{worst}");
        assert!(sum / 32_767.0 <= 2.0, "{}", sum / 32_767.0);
    }

    #[test]
    fn signs_and_zeros() {
        assert_eq!([term(0, 0), term(0, 1), term(32_767, 0), term(SIGN | 5, 0)], [0, ONE, ONE, ONE]);
        assert_eq!([term(SIGN | 5, 5), term(1, u16::MAX), term(u16::MAX, u16::MAX)], [ONE, ONE, 0]);
        assert_eq!(canberra(&[7; LENGTH], &[SIGN | 7; LENGTH]), 58 * ONE);
        // 1 and 3: 0.5.
        let (one, three) = (crate::descriptor::fixed::encode(1.0), crate::descriptor::fixed::encode(3.0));
        assert!(canberra(&[one; LENGTH], &[three; LENGTH]).abs_diff(29 * ONE) < 58 * 12);
    }

    #[test]
    fn margins() {
        let margin = <u32 as Measure>::margin;
        assert_eq!(
            [margin(1, 3), margin(3, 1), margin(0, 0), margin(2, u32::MAX), margin(0, 58 * ONE)],
            [ONE / 4 * 3, ONE / 4, ONE / 2, ONE, ONE]
        );
    }

    proptest! {
        #[test]
        fn the_distance_is_symmetric_and_near_the_exact_one(
            a in proptest::collection::vec(any::<u16>(), LENGTH), b in proptest::collection::vec(any::<u16>(), LENGTH),
            limit in 0u32..58 << 16,
        ) {
            let [a, b]: [Descriptor; 2] =
                [a, b].map(|codes| core::array::from_fn(|i| if codes[i] == SIGN { 0 } else { codes[i] }));
            let d = canberra(&a, &b);
            prop_assert_eq!(d, canberra(&b, &a));
            prop_assert!(d <= 58 << 16);
            prop_assert_eq!(canberra(&a, &a), 0);
            let truth: f64 = a.iter().zip(b).map(|(a, b)| exact(*a, b)).sum();
            prop_assert!((f64::from(d) - truth).abs() <= 58.0 * 30.0);
            let float = crate::matching::canberra(&a.map(decode), &b.map(decode));
            prop_assert!((f64::from(d) / 65_536.0 - f64::from(float)).abs() <= 58.0 * 0.00046);
            let (query, b) = (Query::new(&a), b.map(U16::new));
            prop_assert_eq!(query.distance(&b, limit), (d <= limit).then_some(d));
            prop_assert!(!query.exceeds(&b, limit) || d > limit);
        }
    }
}
