use super::*;
use crate::descriptor;
use crate::wavelet;
use proptest::prelude::*;

fn blank() -> Box<Plane> {
    vec![[0; SIZE]; SIZE].into_boxed_slice().try_into().unwrap()
}

fn plane_of(values: impl IntoIterator<Item = i32>) -> Box<Plane> {
    let mut plane = blank();
    plane.as_flattened_mut().iter_mut().zip(values).for_each(|(to, from)| *to = from);
    plane
}

/// The 58 numbers of coefficients in double precision.
fn exact(c: &Plane, kind: DescriptorKind) -> Vec<f64> {
    let magnitude = |y: usize, x: usize| f64::from(c[y][x]).abs();
    let total: f64 = c.as_flattened().iter().map(|c| f64::from(*c).abs()).sum();
    let scale = if total > 0.0 { 1.0 / total } else { 0.0 };
    let mut out = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(y, x)| magnitude(y, x) * scale).to_vec();
    for level in 1..7 {
        let size = 1 << level;
        for (top, left) in [(size, 0), (0, size), (size, size)] {
            let values: Vec<f64> =
                (0..size * size).map(|i| magnitude(top + i / size, left + i % size) * scale).collect();
            let mean_of = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
            let mean = mean_of(&values);
            let moment = |f: &dyn Fn(f64) -> f64| mean_of(&values.iter().map(|v| f(v - mean)).collect::<Vec<_>>());
            let deviation = moment(&|d| d * d).sqrt();
            let (upper, lower) = values.split_at(size * size / 2);
            match kind {
                DescriptorKind::Halves => out.extend([mean_of(upper), mean_of(lower), deviation]),
                DescriptorKind::Paper => {
                    let skewness = if deviation > 1e-6 * mean {
                        moment(&|d| d * d * d) / (deviation * deviation * deviation)
                    } else {
                        0.0
                    };
                    out.extend([mean, deviation, skewness]);
                }
            }
        }
    }
    out
}

/// A step of the codes is 0.068 %; skewness is allowed an absolute error besides.
#[track_caller]
fn assert_close(found: &Descriptor, truth: &[f64], kind: DescriptorKind) {
    assert_eq!(truth.len(), LENGTH);
    for (i, (code, truth)) in found.iter().zip(truth).enumerate() {
        let skewness = kind == DescriptorKind::Paper && i >= 4 && (i - 4) % 3 == 2;
        let floor = if skewness { 0.002 } else { 1.6e-8 };
        let error = (f64::from(decode(*code)) - truth).abs();
        assert!(error <= 1.02e-3 * truth.abs() + floor, "{i}: {} {truth}", decode(*code));
    }
}

#[test]
fn a_blank_view_has_58_zeros() {
    for kind in [DescriptorKind::Paper, DescriptorKind::Halves] {
        assert_eq!(describe(&mut blank(), kind), [0; LENGTH]);
    }
}

#[test]
fn a_constant_view_is_all_approximation() {
    let mut view = plane_of([40_000 << 7; SIZE * SIZE]);
    let d = describe(&mut view, DescriptorKind::Paper);
    assert_eq!((d[0], &d[1..]), (CODE_OF_ONE as u16, &[0; LENGTH - 1][..]));
}

#[test]
fn known_coefficients_have_known_statistics() {
    // The horizontal 2x2 band holds 1, -2, 3, 4 (rows first), everything else is 0.
    let mut c = blank();
    (c[2][0], c[2][1], c[3][0], c[3][1]) = (1, -2, 3, 4);
    let sd = 1.25f32.sqrt() / 10.0;
    let paper = from_coefficients(&c, DescriptorKind::Paper);
    assert_eq!(paper[4..7], [encode(0.25), encode(sd), 0]);
    let halves = from_coefficients(&c, DescriptorKind::Halves);
    assert_eq!(halves[4..7], [encode(0.15), encode(0.35), encode(sd)]);
    assert!(paper[7..].iter().chain(&paper[..4]).all(|v| *v == 0));
}

#[test]
fn one_outlier_skews_to_the_right_and_one_gap_to_the_left() {
    // n - 1 equal numbers and one that differs: skewness (n - 2) / sqrt(n - 1). In the largest band it is almost 64.
    for (level, outlier, others) in [(2, 5, 0), (2, 0, 77), (6, i32::MIN, 0), (6, 0, i32::MAX), (6, 1, 0)] {
        let mut c = blank();
        let size = 1 << level;
        for row in c[size..2 * size].iter_mut() {
            row[..size].fill(others);
        }
        c[size + 1][2] = outlier;
        let d = from_coefficients(&c, DescriptorKind::Paper);
        let n = (size * size) as f64;
        let skewness = (n - 2.0) / (n - 1.0).sqrt() * if outlier == 0 { -1.0 } else { 1.0 };
        let found = f64::from(decode(d[4 + 9 * (level - 1) + 2]));
        assert!((found / skewness - 1.0).abs() < 1e-3, "{found} {skewness}");
        assert_close(&d, &exact(&c, DescriptorKind::Paper), DescriptorKind::Paper);
    }
}

#[test]
fn extremes_do_not_overflow() {
    for kind in [DescriptorKind::Paper, DescriptorKind::Halves] {
        for (even, odd) in [(i32::MIN, i32::MIN), (i32::MIN, 0), (i32::MAX, -1), (1, 0), (1, 1), (i32::MIN, i32::MAX)] {
            for run in [1, 7, 64 * 128] {
                let c = plane_of((0..SIZE * SIZE).map(|i| if i / run % 2 == 0 { even } else { odd }));
                let d = from_coefficients(&c, kind);
                assert_close(&d, &exact(&c, kind), kind);
            }
        }
    }
}

#[test]
fn codes_of_numbers() {
    assert_eq!([0.0, -0.0, 1e-9, -1e-9, f32::MIN_POSITIVE / 2.0].map(encode), [0; 5]);
    assert_eq!([1.0, -1.0, 2.0, 0.5].map(encode), [26_624, SIGN | 26_624, 27_648, 25_600]);
    assert_eq!([64.0, f32::MAX, f32::INFINITY, f32::NEG_INFINITY].map(encode), [32_767, 32_767, 32_767, u16::MAX]);
    assert_eq!([0, SIGN, 26_624, SIGN | 26_624].map(decode), [0.0, 0.0, 1.0, -1.0]);
    for code in (0..=u16::MAX).filter(|code| *code != SIGN) {
        assert_eq!(encode(decode(code)), code);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn codes_keep_the_precision(mantissa in 1.0f32..2.0, exponent in -25i32..6, negative: bool) {
        let value = mantissa * libm::exp2f(exponent as f32) * if negative { -1.0 } else { 1.0 };
        prop_assert!((decode(encode(value)) / value - 1.0).abs() < 3.6e-4);
    }

    #[test]
    fn any_coefficients_have_the_right_numbers(
        values in proptest::collection::vec(any::<i32>(), SIZE * SIZE), shift in 0u32..31, sparse in 0u32..4,
    ) {
        let c = plane_of(values.iter().map(|v| if v.count_ones() % 4 < sparse { 0 } else { v >> shift }));
        for kind in [DescriptorKind::Paper, DescriptorKind::Halves] {
            assert_close(&from_coefficients(&c, kind), &exact(&c, kind), kind);
        }
    }

    /// From the view on, beside the float stages: a smooth object with an outline and texture.
    #[test]
    fn views_have_the_float_stages_numbers(seed: u32, texture in 0u16..2000, radius in 10.0f32..60.0) {
        let value = |x: usize, y: usize| {
            let (dx, dy) = (x as f32 - 64.0, y as f32 - 60.0);
            let noise = (x as u32 * 7919 + y as u32 * 104_729).wrapping_mul(seed | 1) >> 16;
            let n = 30_000.0 + 200.0 * dx + (noise as f32 / 65_536.0) * f32::from(texture);
            if dx * dx + 2.0 * dy * dy < radius * radius { n as u16 } else { 0 }
        };
        let rows: Vec<[u16; SIZE]> = (0..SIZE).map(|y| core::array::from_fn(|x| value(x, y))).collect();
        let view: Box<descriptor::View> = rows.into_boxed_slice().try_into().unwrap();
        let mut scratch: Box<wavelet::Plane> = vec![[0.0; SIZE]; SIZE].into_boxed_slice().try_into().unwrap();
        for kind in [DescriptorKind::Paper, DescriptorKind::Halves] {
            let float = descriptor::describe(&view, kind, &mut scratch);
            let fixed = describe(&mut plane_of(view.as_flattened().iter().map(|n| i32::from(*n) << 7)), kind);
            for (i, (a, b)) in float.iter().zip(fixed.map(decode)).enumerate() {
                let skewness = kind == DescriptorKind::Paper && i >= 4 && (i - 4) % 3 == 2;
                let floor = if skewness { 5e-3 } else { 3e-7 };
                prop_assert!((a - b).abs() <= 1.5e-3 * a.abs() + floor, "{kind:?} {i}: {a} {b}");
            }
        }
    }
}
