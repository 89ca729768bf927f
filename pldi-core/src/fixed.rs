//! Arithmetic without floating point: what `math` is to the float stages, this is to their fixed-point twins.
//!
//! A number in format Qn is an integer that counts units of 2^-n. The units between the stages:
//!
//! | quantity | type | unit |
//! |---|---|---|
//! | depth | u16 | 1/8 mm, 0 = none, saturates at 8191.875 mm |
//! | lengths on the floor and in the camera frame | i32 | 1/128 mm ([`METRE`] = 1 m) |
//! | x and y of a ray per unit of depth | i32 | Q26, below 32 in absolute value |
//! | unit vectors | i32 | Q30 |
//! | slopes on the floor | i32 | Q16 |
//! | N | u16 | 1/65535 |
//! | wavelet coefficients | i32 | 1/128 of N's unit |
//! | descriptors | u16 | sign and base-2 logarithm, see `descriptor::fixed` |
//! | distances and scores | u32 | Q16 |
//!
//! Integers wrap and divide alike everywhere, so every result has the same bits on every target.

/// One metre in units of 1/128 mm.
pub const METRE: i32 = 128_000;

/// One metre in units of 1/8 mm.
pub const METRE_OF_DEPTH: i32 = 8_000;

/// 1 in Q30.
pub const ONE_Q30: i32 = 1 << 30;

/// A float parameter in units of 1/`scale`, rounded to nearest (halves away from 0); `None` unless it lies within
/// `min..=max` (NaN lies nowhere).
///
/// For constants: where it is evaluated at compile time, no float is left in the program.
pub const fn quantise(value: f32, min: f32, max: f32, scale: f64) -> Option<i64> {
    if !(min <= value && value <= max) {
        return None;
    }
    let scaled = value as f64 * scale;
    Some(if scaled < 0.0 { (scaled - 0.5) as i64 } else { (scaled + 0.5) as i64 })
}

/// e^(-2^(4-i)) in Q32, for i = 0..: what each bit of [`exp_neg`]'s argument contributes.
const EXP_OF_BIT: [u32; 29] = [
    483,
    1_440_801,
    78_665_070,
    581_260_615,
    1_580_030_169,
    2_605_029_347,
    3_344_923_893,
    3_790_295_335,
    4_034_748_382,
    4_162_825_044,
    4_228_380_000,
    4_261_543_595,
    4_278_222_805,
    4_286_586_875,
    4_290_775_039,
    4_292_870_656,
    4_293_918_848,
    4_294_443_040,
    4_294_705_160,
    4_294_836_226,
    4_294_901_760,
    4_294_934_528,
    4_294_950_912,
    4_294_959_104,
    4_294_963_200,
    4_294_965_248,
    4_294_966_272,
    4_294_966_784,
    4_294_967_040,
];

/// e^-x in Q32 for x in Q24 (below 32; larger ones give 0). At most 12 units off; e^0 is `u32::MAX`.
pub const fn exp_neg(x: u32) -> u32 {
    if x >> 29 != 0 {
        return 0;
    }
    let mut product = u32::MAX as u64;
    let mut i = 0;
    while i < EXP_OF_BIT.len() {
        if x >> (28 - i) & 1 == 1 {
            product = (product * EXP_OF_BIT[i] as u64 + (1 << 31)) >> 32;
        }
        i += 1;
    }
    product as u32
}

/// The base-2 logarithm in Q16 of an integer, rounded down (and at most 2 units off); `None` for 0.
pub const fn log2(x: u64) -> Option<i32> {
    if x == 0 {
        return None;
    }
    let exponent = 63 - x.leading_zeros();
    // The mantissa in Q31, 1 <= m < 2; each squaring brings out the next bit of its logarithm.
    let mut m = (x << x.leading_zeros()) >> 32;
    let mut log = exponent as i32;
    let mut i = 0;
    while i < 16 {
        m = (m * m) >> 31;
        let carry = m >> 32;
        m >>= carry;
        log = (log << 1) | carry as i32;
        i += 1;
    }
    Some(log)
}

/// Sine and cosine in Q30 of an angle in radians, Q28, within -pi/2..=pi/2 (others are clamped). At most 8 units off.
pub const fn sin_cos(angle: i32) -> (i32, i32) {
    const QUARTER: i32 = 421_657_428;
    let angle = if angle > QUARTER {
        QUARTER
    } else if angle < -QUARTER {
        -QUARTER
    } else {
        angle
    };
    // Half the angle in Q31, at most 0.79: Taylor's series shrink from the start.
    let x = (angle as i64) << 2;
    let square = (x * x) >> 31;
    let (mut sine, mut cosine) = (0, 0);
    let (mut odd, mut even) = (x, 1i64 << 31);
    let mut k = 1;
    while k < 14 {
        cosine += even;
        sine += odd;
        even = -((even * square) >> 31) / (k * (k + 1));
        odd = -((odd * square) >> 31) / ((k + 1) * (k + 2));
        k += 2;
    }
    // sin 2x = 2 sin x cos x, cos 2x = 1 - 2 sin^2 x
    let sin = (sine * cosine + (1 << 30)) >> 31;
    let cos = (1i64 << 30) - ((sine * sine + (1 << 30)) >> 31);
    (sin as i32, cos as i32)
}

/// 2^16 / (1 + (i + 1/2) / 256): the reciprocals of 1..2, to 9 bits.
const RECIPROCALS: [u16; 256] = {
    let mut table = [0; 256];
    let mut i = 0;
    while i < 256 {
        let twice = 2 * (256 + i as u32) + 1;
        table[i] = (((1 << 26) / twice + 1) >> 1) as u16;
        i += 1;
    }
    table
};

/// 1/x of a positive integer as (mantissa, shift): 1/x is mantissa * 2^-shift with a mantissa of 32 bits (2^31 to
/// 2^32 - 1), at most 4 units of it off, and a shift of 32..=63. 1/0 counts as 1/1.
///
/// No division: they are slow, of 64 bits on 32-bit machines and of any size on many hosts.
#[inline(always)]
pub const fn reciprocal(x: u32) -> (u32, u32) {
    let zeros = (x | 1).leading_zeros();
    let m = if x == 0 { 1 << 31 } else { x << zeros };
    // With m in Q31 (1..2) and r close to 1/m: 1/m = r / (1 - e) = r (1 + e) (1 + e^2) (1 + e^4)..., where e = 1 - m r.
    // Numbers of 32 bits wherever they fit: others cost several instructions each on 32-bit machines.
    let r = RECIPROCALS[(m >> 23 & 0xFF) as usize] as u32;
    let e = (1i64 << 47) - (m as u64 * r as u64) as i64; // Q47, below 2^-8
    let rough = (e >> 16) as i32;
    let square = ((rough as i64 * rough as i64) >> 31) as u32; // Q31, below 2^-16
    // Q32; like each sum of the first terms with an even number of them, not above 1/m.
    let r = (r << 16).wrapping_add(((r as i64 * e) >> 31) as u32);
    let r = r.saturating_add(((r as u64 * square as u64) >> 31) as u32);
    (r, 63 - zeros)
}

/// 1/x for x in Q31 (1..2), in Q16: at most 2^-8.9 of it off.
#[inline(always)]
pub(crate) const fn reciprocal_of_16_bits(x: u32) -> u32 {
    RECIPROCALS[(x >> 23 & 0xFF) as usize] as u32
}

/// The product of a 32-bit number and a Q30 number, rounded to nearest.
#[inline(always)]
pub const fn mul_q30(a: i32, b: i32) -> i32 {
    ((a as i64 * b as i64 + (1 << 29)) >> 30) as i32
}

/// A vector of any length scaled to length 1 in Q30; `None` for the zero vector. At most 3 units off in each component.
pub const fn unit(v: [i64; 3]) -> Option<[i32; 3]> {
    let largest = v[0].unsigned_abs() | v[1].unsigned_abs() | v[2].unsigned_abs();
    if largest == 0 {
        return None;
    }
    // Components below 2^30, so that the sum of squares fits 62 bits.
    let bits = 64 - largest.leading_zeros() as i32;
    let v = if bits > 30 {
        [v[0] >> (bits - 30), v[1] >> (bits - 30), v[2] >> (bits - 30)]
    } else {
        [v[0] << (30 - bits), v[1] << (30 - bits), v[2] << (30 - bits)]
    };
    let length = ((v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) as u64).isqrt() as i64;
    if length == 0 {
        return None;
    }
    Some([((v[0] << 30) / length) as i32, ((v[1] << 30) / length) as i32, ((v[2] << 30) / length) as i32])
}

/// The high half of a product: x * y * 2^-32, rounded down.
#[inline(always)]
pub(crate) const fn mul_high(x: i32, y: i32) -> i32 {
    ((x as i64 * y as i64) >> 32) as i32
}

/// The i of 0..count for which a + b i is not negative, as first and behind the last.
///
/// Exact for numbers below 2^31; larger ones are cut to 31 bits alike, which moves an end by at most one, and only where
/// a + b i is next to nothing: below count * 2^-30 of the larger of a and b.
pub(crate) fn where_not_negative(a: i64, b: i64, count: usize) -> (usize, usize) {
    let bits = 64 - (a.unsigned_abs() | b.unsigned_abs()).leading_zeros();
    let shift = bits.saturating_sub(31);
    // -2^31 at least.
    let (a, b) = ((a >> shift) as i32, (b >> shift) as i32);
    let (size, slope) = (a.unsigned_abs(), b.unsigned_abs());
    let least = |i: u32| if (i as usize) < count { i as usize } else { count };
    if a >= 0 {
        if b >= 0 { (0, count) } else { (0, least(size / slope + 1)) }
    } else if b > 0 {
        (least(size.div_ceil(slope)), count)
    } else {
        (count, count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_table_of_exponentials_is_right() {
        for (i, e) in EXP_OF_BIT.iter().enumerate() {
            let truth = libm::exp(-(16.0 / (1u64 << i) as f64)) * 4_294_967_296.0;
            assert!((f64::from(*e) - truth).abs() <= 0.5, "{i}: {e} {truth}");
        }
    }

    #[test]
    fn the_ends_of_the_ranges() {
        assert_eq!(exp_neg(0), u32::MAX);
        assert_eq!(exp_neg(u32::MAX), 0);
        assert_eq!((log2(0), log2(1), log2(1 << 40)), (None, Some(0), Some(40 << 16)));
        assert_eq!(sin_cos(0), (0, ONE_Q30));
        let (sin, cos) = sin_cos(i32::MAX);
        assert!((sin - ONE_Q30).abs() <= 8 && cos.abs() <= 8, "{sin} {cos}");
        assert_eq!(unit([0; 3]), None);
        assert_eq!(unit([i64::MAX, 0, 0]).map(|v| v[0] >= ONE_Q30 - 3), Some(true));
        assert_eq!(quantise(f32::NAN, -1.0, 1.0, 8.0), None);
        assert_eq!(quantise(-0.3, -1.0, 1.0, 100.0), Some(-30));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn exponentials(x in 0u32..1 << 29) {
            let truth = libm::exp(-f64::from(x) / 16_777_216.0) * 4_294_967_296.0;
            prop_assert!((f64::from(exp_neg(x)) - truth).abs() <= 12.0);
        }

        #[test]
        fn spans(a in -1000i64..1000, b in -40i64..40) {
            let (first, end) = where_not_negative(a, b, 50);
            for i in 0..50usize {
                prop_assert_eq!(a + b * i as i64 >= 0, (first..end).contains(&i), "{}", i);
            }
        }

        #[test]
        fn spans_of_large_numbers(a in any::<i64>(), root in 0i64..60, shift in 2u32..40) {
            let a = a >> shift;
            let b = -a / (2 * root + 1) * 2;
            let (first, end) = where_not_negative(a, b, 50);
            for i in 0..50usize {
                let value = i128::from(a) + i128::from(b) * i as i128;
                let clear = value.abs() > i128::from(a.unsigned_abs().max(b.unsigned_abs())) * 50 / (1 << 30);
                prop_assert!(!clear || (value >= 0) == (first..end).contains(&i), "{}", i);
            }
        }

        #[test]
        fn logarithms(x in 1u64.., shift in 0u32..64) {
            let x = (x >> shift).max(1);
            let truth = libm::log2(x as f64) * 65_536.0;
            let error = truth - f64::from(log2(x).unwrap());
            prop_assert!((-0.01..=2.0).contains(&error), "{error}");
        }

        #[test]
        fn angles(angle in -421_657_428i32..=421_657_428) {
            let (sin, cos) = sin_cos(angle);
            let truth = f64::from(angle) / 268_435_456.0;
            prop_assert!((f64::from(sin) - libm::sin(truth) * 1_073_741_824.0).abs() <= 8.0);
            prop_assert!((f64::from(cos) - libm::cos(truth) * 1_073_741_824.0).abs() <= 8.0);
        }

        #[test]
        fn reciprocals(x in 1u32.., shift in 0u32..32) {
            let x = (x >> shift).max(1);
            let (m, s) = reciprocal(x);
            let truth = libm::ldexp(1.0, s as i32) / f64::from(x);
            prop_assert!((f64::from(m) - truth).abs() <= 4.0, "{m} {truth}");
        }

        #[test]
        fn unit_vectors(v in proptest::array::uniform3(-1i64 << 40..1 << 40), shift in 0u32..40) {
            let v = v.map(|c| c >> shift);
            prop_assume!(v != [0; 3]);
            let length = v.iter().map(|c| (*c as f64) * (*c as f64)).sum::<f64>().sqrt();
            for (got, c) in unit(v).unwrap().iter().zip(v) {
                prop_assert!((f64::from(*got) - c as f64 / length * 1_073_741_824.0).abs() <= 3.0);
            }
        }
    }
}
