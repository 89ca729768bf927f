use super::*;
use proptest::prelude::*;

const W: usize = 40;
const H: usize = 30;
type Depth = [u16; W * H];

/// Runs the filter on a small frame.
fn filtered(depth: &Depth, colour: Option<&[u8]>, params: &FilterParams) -> Image<f32, W, H> {
    let frame = Frame::<W, H>::new(depth, colour).unwrap();
    let mut out = [[0.0; W]; H];
    let mut scratch = FilterScratch::new();
    reconstruct(&frame, DepthRange::KINECT, params, &GuideTable::new(params), &mut scratch, &mut out);
    out
}

/// A depth image from a function of column and row.
fn depth_of(f: impl Fn(usize, usize) -> u16) -> Depth {
    core::array::from_fn(|i| f(i % W, i / W))
}

#[test]
fn sigma_halves_and_the_variances_add_up() {
    let p = FilterParams::DEFAULT;
    let s: [f32; 3] = core::array::from_fn(|i| p.sigma_of_iteration(i as u8));
    assert!((s[0] / s[1] - 2.0).abs() < 1e-6 && (s[1] / s[2] - 2.0).abs() < 1e-6);
    // 4^N - 1 makes the iterations' variances sum to sigma_s^2.
    let variance: f32 = s.iter().map(|s| s * s).sum();
    assert!((variance / 144.0 - 1.0).abs() < 1e-6);
}

#[test]
fn a_constant_stays_constant_and_holes_are_filled() {
    let depth = depth_of(|x, y| if (15..20).contains(&x) && (10..16).contains(&y) { 0 } else { 2000 });
    for kind in [FilterKind::Joint, FilterKind::Bilateral] {
        let out = filtered(&depth, Some(&[90; 3 * W * H]), &FilterParams { kind, ..FilterParams::DEFAULT });
        assert!(out.as_flattened().iter().all(|z| (z - 2.0).abs() < 2e-6), "{kind:?}");
    }
}

#[test]
fn a_step_in_depth_keeps_its_edge() {
    let depth = depth_of(|x, _| if x < 20 { 1000 } else { 2000 });
    let out = filtered(&depth, None, &FilterParams::DEFAULT);
    // The domain distance across the step is 301, so nothing leaks: e^(-0.135 * 301).
    assert!(out.iter().all(|row| (row[19] - 1.0).abs() < 1e-5 && (row[20] - 2.0).abs() < 1e-5));
}

#[test]
fn a_hole_takes_the_depth_of_the_pixels_of_its_own_colour() {
    // Left half red and near, right half green and far; the hole straddles both.
    let mut colour = [0u8; 3 * W * H];
    for (i, p) in colour.as_chunks_mut::<3>().0.iter_mut().enumerate() {
        *p = if i % W < 20 { [200, 20, 20] } else { [20, 200, 20] };
    }
    let depth = depth_of(|x, _| {
        if x < 14 {
            1000
        } else if x < 26 {
            0
        } else {
            2000
        }
    });
    let out = filtered(&depth, Some(&colour), &FilterParams::DEFAULT);
    assert!((out[15][19] - 1.0).abs() < 1e-3 && (out[15][20] - 2.0).abs() < 1e-3);
    // Without colour there is no telling: the hole blends.
    let blended = filtered(&depth, None, &FilterParams::DEFAULT);
    assert!((blended[15][19] - 1.0).abs() > 0.05);
}

#[test]
fn no_reading_anywhere_stays_no_reading() {
    let out = filtered(&[0; W * H], None, &FilterParams::DEFAULT);
    assert!(out.as_flattened().iter().all(|&z| z == 0.0));
}

#[test]
fn noise_shrinks_and_both_forms_agree_on_a_noisy_plane() {
    let mut state = 1u32;
    let depth = depth_of(|_, _| 0).map(|_: u16| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        2000 + (state >> 24) as u16 / 16 // 0..=15 mm
    });
    let fast = filtered(&depth, None, &FilterParams::DEFAULT);
    let mut slow = [[0.0; W]; H];
    let frame = Frame::<W, H>::new(&depth, None).unwrap();
    exact::exact(&frame, DepthRange::KINECT, &FilterParams::DEFAULT, &mut slow);
    let error = |image: &Image<f32, W, H>| {
        image.as_flattened().iter().map(|z| (z - 2.0075) * (z - 2.0075)).sum::<f32>() / (W * H) as f32
    };
    // Raw variance: (4.6 mm)^2. The recursive filter averages fewer readings, since noise itself counts as distance.
    assert!(error(&fast) < 1.8e-3 * 1.8e-3, "{}", error(&fast));
    assert!(error(&slow) < 0.25e-6, "{}", error(&slow));
}

#[test]
fn without_a_filter_the_depth_is_the_measured_one() {
    let depth = depth_of(|x, y| (x * y) as u16);
    let out = filtered(&depth, None, &FilterParams { kind: FilterKind::None, ..FilterParams::DEFAULT });
    assert!(out.as_flattened().iter().zip(depth).all(|(z, d)| (z - f32::from(d) * 1e-3).abs() < 1e-7));
}

#[test]
fn parameters_out_of_range_are_named() {
    let p = FilterParams { sigma_depth: f32::NAN, ..FilterParams::DEFAULT };
    assert_eq!(p.validate(), Err(Error::OutOfRange("sigma_depth")));
    assert_eq!(FilterParams { iterations: 0, ..p }.validate(), Err(Error::OutOfRange("sigma_depth")));
    assert_eq!(
        FilterParams { iterations: 9, ..FilterParams::DEFAULT }.validate(),
        Err(Error::OutOfRange("iterations"))
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// A weighted mean stays within the readings' range whatever the frame.
    #[test]
    fn results_lie_between_the_smallest_and_largest_reading(
        depth in proptest::collection::vec(any::<u16>(), W * H),
        colour in proptest::collection::vec(any::<u8>(), 3 * W * H),
        kind in prop_oneof![Just(FilterKind::Joint), Just(FilterKind::Bilateral), Just(FilterKind::None)],
    ) {
        let depth: &Depth = depth.as_slice().try_into().unwrap();
        let out = filtered(depth, Some(&colour), &FilterParams { kind, ..FilterParams::DEFAULT });
        let readings = depth.iter().map(|&d| DepthRange::KINECT.apply(d)).filter(|&d| d > 0);
        let (low, high) = readings.fold((u16::MAX, 0), |(l, h), d| (l.min(d), h.max(d)));
        let (low, high) = (f32::from(low) * 1e-3 - 1e-4, f32::from(high) * 1e-3 + 1e-4);
        prop_assert!(out.as_flattened().iter().all(|&z| z == 0.0 || (low..=high).contains(&z)));
    }
}
