//! The only door to floating-point functions that `core` does not have.
//!
//! Everything here gives the same bits on every target: square roots are correctly rounded by IEEE 754 whether
//! hardware or software computes them, and the others are `libm`'s software. The opt-in `approx-math` feature
//! gives that up for `micromath`'s estimate on cores without an FPU.

/// Square root, correctly rounded (unless `approx-math` is on and the target has no FPU instruction for it).
#[inline(always)]
pub fn sqrt(x: f32) -> f32 {
    imp::sqrt(x)
}

/// e to the power of x (`libm`, at most 1 ulp off).
#[inline]
pub fn exp(x: f32) -> f32 {
    libm::expf(x)
}

/// Sine and cosine of an angle in radians (`libm`).
#[inline]
pub fn sin_cos(x: f32) -> (f32, f32) {
    libm::sincosf(x)
}

/// The angle of the point (x, y) in radians, -pi..=pi (`libm`).
#[inline]
pub fn atan2(y: f32, x: f32) -> f32 {
    libm::atan2f(y, x)
}

/// Arc sine in radians of a value clamped to -1..=1 (`libm`).
#[inline]
pub fn asin(x: f32) -> f32 {
    libm::asinf(x.clamp(-1.0, 1.0))
}

/// The largest integer not above x, for values that fit an `i32`; others saturate, NaN gives 0.
#[inline(always)]
pub fn floor(x: f32) -> i32 {
    let t = x as i32;
    t - i32::from((t as f32) > x)
}

/// The nearest integer (halves upwards), for values that fit an `i32`; others saturate, NaN gives 0.
#[inline(always)]
pub fn round(x: f32) -> i32 {
    floor(x + 0.5)
}

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code, reason = "the compiler's call to sqrtf is hidden behind std; SSE2 has an instruction for it")]
mod imp {
    use core::arch::x86_64::{_mm_cvtss_f32, _mm_set_ss, _mm_sqrt_ss};

    #[inline(always)]
    pub(super) fn sqrt(x: f32) -> f32 {
        // SAFETY: SSE2 is part of the x86-64 architecture.
        unsafe { _mm_cvtss_f32(_mm_sqrt_ss(_mm_set_ss(x))) }
    }
}

#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
#[allow(unsafe_code, reason = "libm's square root is software on Cortex-M; the FPU has an instruction for it")]
mod imp {
    #[inline(always)]
    pub(super) fn sqrt(x: f32) -> f32 {
        let mut root = x.to_bits();
        // SAFETY: the target has an FPU with this instruction. The compiler offers no class of float registers for cores
        // with single precision alone, so one is borrowed by hand: s0 is as before at the end.
        unsafe {
            core::arch::asm!(
                "vmov {saved}, s0",
                "vmov s0, {root}",
                "vsqrt.f32 s0, s0",
                "vmov {root}, s0",
                "vmov s0, {saved}",
                root = inout(reg) root,
                saved = out(reg) _,
                options(pure, nomem, nostack, preserves_flags),
            );
        }
        f32::from_bits(root)
    }
}

#[cfg(not(any(target_arch = "x86_64", all(target_arch = "arm", target_abi = "eabihf"))))]
mod imp {
    #[cfg(feature = "approx-math")]
    #[inline]
    pub(super) fn sqrt(x: f32) -> f32 {
        use micromath::F32Ext;
        F32Ext::sqrt(x)
    }

    #[cfg(not(feature = "approx-math"))]
    #[inline]
    pub(super) fn sqrt(x: f32) -> f32 {
        libm::sqrtf(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn square_roots_are_correctly_rounded() {
        for i in 0..20_000u32 {
            let x = f32::from_bits(0x0080_0000 + i * 100_003);
            assert_eq!(sqrt(x).to_bits(), libm::sqrtf(x).to_bits(), "sqrt({x})");
        }
        assert!(sqrt(-1.0).is_nan());
    }

    #[test]
    fn floor_and_round_of_negative_numbers() {
        assert_eq!([floor(-0.5), floor(-1.0), floor(1.9), floor(0.0)], [-1, -1, 1, 0]);
        assert_eq!([round(-0.6), round(-0.4), round(2.5), round(-2.5)], [-1, 0, 3, -2]);
        assert_eq!(floor(f32::NAN), 0);
    }
}
