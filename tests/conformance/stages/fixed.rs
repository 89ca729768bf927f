//! Fixed-point stages that work on single numbers and points, beside their truth and the float ones.

use crate::common::Random;
use crate::errors::Tally;
use crate::inputs::analytic::CAMERA;
use crate::inputs::{H, W};
use crate::oracle::image;
use crate::rows::Pair::{Fixed, Twins};
use pldi_core::{fixed, rays};

/// All of them; each is a job of its own.
pub const JOBS: &[fn(&mut Tally)] = &[exponential, logarithm, sines, reciprocal, products, unit, parameters, points];

/// 2 to the power of `n`.
fn two_to(n: i32) -> f64 {
    libm::ldexp(1.0, n)
}

/// e^-x, with both ends of the range.
fn exponential(tally: &mut Tally) {
    let errors = tally.at("fixed: exponential", Fixed);
    let mut random = Random(50);
    let ends = [0, 1, (1 << 29) - 1, 1 << 29, u32::MAX];
    let drawn = (0..200_000).map(|_| (random.bits() as u32 >> 3) >> (random.bits() % 20));
    for x in ends.into_iter().chain(drawn) {
        errors.add(f64::from(fixed::exp_neg(x)) * two_to(-32), libm::exp(-f64::from(x) * two_to(-24)));
    }
}

/// The logarithm of integers of all sizes.
fn logarithm(tally: &mut Tally) {
    let errors = tally.at("fixed: logarithm", Fixed);
    let mut random = Random(51);
    let ends = [0, 1, 2, 3, u64::MAX, u64::MAX - 1, 1 << 63];
    let drawn = (0..200_000).map(|_| random.bits() >> (random.bits() % 64));
    for x in ends.into_iter().chain(drawn) {
        let found = fixed::log2(x).map(|l| f64::from(l) * two_to(-16));
        errors.add_option(found, (x > 0).then(|| libm::log2(x as f64)));
    }
}

/// Sine and cosine within a quarter turn, and beyond it, where they are clamped.
fn sines(tally: &mut Tally) {
    let errors = tally.at("fixed: sine, cosine", Fixed);
    let mut random = Random(52);
    let quarter = core::f64::consts::FRAC_PI_2;
    let ends = [0, 1, -1, i32::MAX, i32::MIN, 421_657_428, -421_657_428];
    let drawn = (0..200_000).map(|_| random.between(-421_657_429.0, 421_657_429.0) as i32 >> (random.bits() % 24));
    for angle in ends.into_iter().chain(drawn) {
        let (sin, cos) = fixed::sin_cos(angle);
        let radians = (f64::from(angle) * two_to(-28)).clamp(-quarter, quarter);
        errors.add(f64::from(sin) * two_to(-30), libm::sin(radians));
        errors.add(f64::from(cos) * two_to(-30), libm::cos(radians));
    }
}

/// 1/x, times x: what it should be is 1.
fn reciprocal(tally: &mut Tally) {
    let errors = tally.at("fixed: reciprocal", Fixed);
    let mut random = Random(53);
    let ends = [1, 2, 3, u32::MAX, u32::MAX - 1, 1 << 31, (1 << 31) - 1];
    let drawn = (0..200_000).map(|_| (random.bits() as u32 >> (random.bits() % 32)).max(1));
    for x in ends.into_iter().chain(drawn) {
        let (mantissa, shift) = fixed::reciprocal(x);
        errors.add(f64::from(mantissa) * f64::from(x) * two_to(-(shift as i32)), 1.0);
    }
}

/// Products with a fraction.
fn products(tally: &mut Tally) {
    let errors = tally.at("fixed: products", Fixed);
    let mut random = Random(54);
    for _ in 0..200_000 {
        let (a, b) = (random.bits() as i32, random.between(-1.0, 1.0) * two_to(30));
        let b = b as i32;
        errors.add(f64::from(fixed::mul_q30(a, b)), f64::from(a) * f64::from(b) * two_to(-30));
    }
}

/// Unit vectors, of vectors of all lengths.
fn unit(tally: &mut Tally) {
    let errors = tally.at("fixed: unit vectors", Fixed);
    let mut random = Random(55);
    errors.decide(fixed::unit([0; 3]).is_none());
    let ends = [[1, 0, 0], [0, -1, 0], [i64::MAX, i64::MAX, i64::MAX], [i64::MIN + 1, 1, -1], [1, 1, i64::MAX]];
    let drawn = (0..100_000).map(|_| {
        let shift = random.bits() % 62;
        core::array::from_fn(|_| (random.bits() as i64 >> shift) | 1)
    });
    for v in ends.into_iter().chain(drawn) {
        let float = v.map(|c| c as f64);
        let length = float.iter().map(|c| c * c).sum::<f64>().sqrt();
        match fixed::unit(v) {
            Some(found) => (0..3).for_each(|i| errors.add(f64::from(found[i]) * two_to(-30), float[i] / length)),
            None => errors.decide(false),
        }
    }
}

/// Parameters of all magnitudes, in units of 1/65536, within bounds or refused.
fn parameters(tally: &mut Tally) {
    let errors = tally.at("fixed: parameters", Fixed);
    let mut random = Random(56);
    for _ in 0..100_000 {
        let value = random.between(-1100.0, 1100.0) as f32;
        let found = fixed::quantise(value, -1000.0, 1000.0, two_to(16)).map(|v| v as f64 * two_to(-16));
        errors.add_option(found, (value.abs() <= 1000.0).then(|| f64::from(value)));
    }
}

/// The tables of rays, and points at all depths.
fn points(tally: &mut Tally) {
    let mut random = Random(57);
    let float = pldi_core::Rays::<W, H>::new(&CAMERA).expect("a camera");
    let camera = rays::fixed::Intrinsics::new(&CAMERA).expect("a camera");
    let rays = rays::fixed::Rays::<W, H>::new(&camera).expect("a camera");
    for i in 0..W * H {
        let (u, v) = (i % W, i / W);
        let slopes = [rays.x()[u], rays.y()[v]].map(|s| f64::from(s) * two_to(-26));
        let truth = image::point(&CAMERA, u, v, 1.0);
        for k in 0..2 {
            tally.at("rays: slopes", Fixed).add(slopes[k], truth[k]);
            tally.at("rays: slopes", Twins).add(slopes[k], f64::from([float.x()[u], float.y()[v]][k]));
        }
        let z = if i % 5 == 0 { u16::MAX } else { random.bits() as u16 };
        let metres = f64::from(z) / f64::from(fixed::METRE_OF_DEPTH);
        let found = rays.point(u, v, z).map(|c| f64::from(c) / f64::from(fixed::METRE));
        let (truth, float) = (image::point(&CAMERA, u, v, metres), float.point(u, v, metres as f32));
        for k in 0..3 {
            tally.at("rays: points", Fixed).add(found[k], truth[k]);
            tally.at("rays: points", Twins).add(found[k], f64::from(float[k]));
            tally.at("rays: points", crate::rows::Pair::Float).add(f64::from(float[k]), truth[k]);
        }
    }
}
