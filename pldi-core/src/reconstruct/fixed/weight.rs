//! Mask weights in 16 bits: an unsigned floating-point number of our own, made of integers.
//!
//! Weights of the filtered mask go down to a thousandth and below, and the depth of a pixel is a mean weighted by them:
//! what must be small is their relative error. Four bits of exponent and twelve of mantissa (an implicit one before
//! them, but for exponent 0) keep it below 2^-13 from 2^-15 on; a linear format would be off by a percent at the floor.

/// The weight of a pixel with a reading: the largest there is, 8191/8192. Only ratios of weights count.
pub const ONE: u16 = u16::MAX;

/// The weight in Q30, below 2^30: a multiple of 2^-27.
#[inline(always)]
pub const fn decode(code: u16) -> i32 {
    let (exponent, mantissa) = ((code >> 12) as u32, (code & 0xFFF) as i32);
    if exponent == 0 { mantissa << 3 } else { (mantissa | 0x1000) << (exponent + 2) }
}

/// The code of a weight in Q30 (0 to the largest, `decode(ONE)`), rounded to nearest.
#[inline(always)]
pub const fn encode(weight: i32) -> u16 {
    let exponent = 16 - (weight | 1 << 15).leading_zeros();
    // Continuous from exponent 0 on, and a carry out of the mantissa goes where it belongs, as in IEEE 754.
    ((exponent << 12) as i32 + ((weight + (4 << exponent)) >> (exponent + 3))) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_comes_back() {
        for code in 0..=u16::MAX {
            assert_eq!(encode(decode(code)), code);
        }
        assert_eq!(decode(ONE), 8191 << 17);
    }

    #[test]
    fn the_relative_error_is_below_a_hundredth_of_a_percent() {
        let mut weight = 4096 << 3;
        while weight < decode(ONE) {
            let error = (f64::from(decode(encode(weight))) / f64::from(weight) - 1.0).abs();
            assert!(error <= 1.0 / 8192.0, "{weight}: {error}");
            weight += 1 + weight / 999;
        }
    }
}
