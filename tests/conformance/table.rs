//! The table of tolerances. A bound holds, and is at most twice what is measured.

use crate::rows::Pair::{self, *};
use crate::rows::Set::{self, *};
use crate::rows::{Requirement, Row, Stage};

/// All sets of inputs.
pub const SETS: [Set; 7] = [Numbers, Analytic, Recordings, Views, Extremes, Set::Random, Real];

/// Modules of the core that give no numbers which could be off.
pub const EXACT_MODULES: &[&str] = &["templates", "serial"];

const fn stage(name: &'static str, unit: &'static str, lsb: f64, snr: bool, decision: &'static str) -> Stage {
    Stage { name, unit, lsb, snr, decision }
}

/// 2^-n.
const fn q(n: u32) -> f64 {
    1.0 / (1u64 << n) as f64
}

/// What is measured, in the order of the pipeline: unit of the error (C is that of a Canberra distance, 0 to 58), one unit of
/// the fixed-point format in it, whether the ratio of signal to noise means anything, what counts as a changed decision.
pub const STAGES: &[Stage] = &[
    stage("math: exp", "ulp", 0.0, false, ""),
    stage("math: sin, cos, asin, atan2", "rad", 0.0, true, ""),
    stage("fixed: exponential", "1", q(32), true, ""),
    stage("fixed: logarithm", "1", q(16), true, "a logarithm or none"),
    stage("fixed: sine, cosine", "1", q(30), true, ""),
    stage("fixed: reciprocal", "1", q(32), true, ""),
    stage("fixed: products", "1", 1.0, true, ""),
    stage("fixed: unit vectors", "1", q(30), true, "a direction or none"),
    stage("fixed: parameters", "1", q(16), true, "in range or refused"),
    stage("frame: back-projection", "m", 0.0, true, ""),
    stage("frame: projection", "px", 0.0, true, ""),
    stage("rays: slopes", "1", q(26), true, ""),
    stage("rays: points", "m", 1.0 / 128_000.0, true, ""),
    stage("reconstruct: joint", "m", 1.0 / 8000.0, true, "a depth or none"),
    stage("reconstruct: bilateral", "m", 1.0 / 8000.0, true, "a depth or none"),
    stage("reconstruct: equation 1", "m", 0.0, true, "a depth or none"),
    stage("floor: pose and axes", "1", q(30), true, ""),
    stage("floor: coordinates", "m", 1.0 / 128_000.0, true, ""),
    stage("floor: search", "m, 1", 0.0, true, "a floor or none"),
    stage("ground: cells of pixels", "-", 0.0, false, "another cell"),
    stage("ground: density", "px", q(10), true, "occupied or not"),
    stage("ground: clusters", "m", 1.0 / 128_000.0, true, "another reason, no partner"),
    stage("diffusion: N", "1", 1.0 / 65_535.0, true, "N or none; off by more than 1/128"),
    stage("view: planes to pixels", "px", 0.0, true, ""),
    stage("view: pixels to plane", "m", 0.0, true, ""),
    stage("view: fitted square", "px", 0.0, true, ""),
    stage("view: sampling", "1", 1.0 / 65_535.0, true, "a view or none"),
    stage("view: smooth pattern", "1", 1.0 / 65_535.0, true, ""),
    stage("wavelet: coefficients", "1", 1.0 / (128.0 * 65_535.0), true, ""),
    stage("descriptor: paper", "C", 0.0, false, ""),
    stage("descriptor: halves", "C", 0.0, false, ""),
    stage("descriptor: paper, numbers", "1", 0.0, true, ""),
    stage("descriptor: halves, numbers", "1", 0.0, true, ""),
    stage("matching: Canberra distance", "C", q(16), true, ""),
    stage("matching: nearest class", "C", q(16), true, "another class"),
    stage("pipeline: floor", "m, 1", 0.0, true, "a floor or none"),
    stage("pipeline: N", "1", 1.0 / 65_535.0, true, "N or none; off by more than 1/128"),
    stage("pipeline: N of candidates", "1", 1.0 / 65_535.0, true, "N or none; off by more than 1/128"),
    stage("pipeline: clusters", "m", 1.0 / 128_000.0, true, "another reason, no partner"),
    stage("pipeline: descriptor", "C", 0.0, false, "a descriptor or none"),
    stage("pipeline: nearest class", "C", q(16), true, "another class"),
    stage("pipeline: frame to descriptor", "C", 0.0, false, ""),
];

/// Frames as sensors give them.
const FRAMES: &[Set] = &[Analytic, Recordings, Real];

const fn require(stage: &'static str, sets: &'static [Set], share: f64, rms: f64, open: &'static [Set]) -> Requirement {
    Requirement { stage, pair: Twins, sets, share, rms, open }
}

/// What integers must keep of what floats give, on inputs as sensors see them.
pub const REQUIREMENTS: &[Requirement] = &[
    // Filtered depth within 1 mm on 99.9 % of the pixels.
    require("reconstruct: joint", FRAMES, 1e-3, f64::INFINITY, &[]),
    // N within 1/128 on 99 % of the pixels, and nearer in the mean: of the same depth, and of each one's own.
    require("diffusion: N", &[Analytic, Recordings, Views, Real], 0.01, 0.003, &[Views]),
    require("pipeline: N", FRAMES, 0.01, 0.003, FRAMES),
    // 99.5 % of the clusters are candidates in both or rejected for the same reason.
    require("pipeline: clusters", FRAMES, 0.005, f64::INFINITY, &[]),
    // The same class on 99 % of at least 2,000 queries.
    require("pipeline: nearest class", &[Views], 0.01, f64::INFINITY, &[]),
];

/// No ratio of signal to noise.
const NONE: Option<f64> = None;
/// No error at all.
#[allow(dead_code, reason = "rows without any error come and go with the stages")]
const EXACT: Option<f64> = Some(f64::INFINITY);

const fn db(snr: i32) -> Option<f64> {
    Some(snr as f64)
}

const fn row(stage: &'static str, pair: Pair, set: Set, largest: f64, share: f64, snr: Option<f64>) -> Row {
    Row { stage, pair, set, largest, share, snr }
}

/// Stage, what is compared, inputs, largest error, share of changed decisions, signal to noise.
#[rustfmt::skip]
pub const TABLE: &[Row] = &[
    row("math: exp", Float, Numbers, 9.9e-1, 0.0, NONE),
    row("math: sin, cos, asin, atan2", Float, Numbers, 2.6e-7, 0.0, db(151)),
    row("fixed: exponential", Fixed, Numbers, 1.8e-9, 0.0, db(185)),
    row("fixed: logarithm", Fixed, Numbers, 1.8e-5, 0.0, db(131)),
    row("fixed: sine, cosine", Fixed, Numbers, 4.3e-9, 0.0, db(186)),
    row("fixed: reciprocal", Fixed, Numbers, 1.6e-9, 0.0, db(183)),
    row("fixed: products", Fixed, Numbers, 5.8e-1, 0.0, db(186)),
    row("fixed: unit vectors", Fixed, Numbers, 3.0e-9, 0.0, db(179)),
    row("fixed: parameters", Fixed, Numbers, 8.8e-6, 0.0, db(169)),
    row("frame: back-projection", Float, Numbers, 5.1e-7, 0.0, db(156)),
    row("frame: projection", Float, Numbers, 4.0e-5, 0.0, db(149)),
    row("rays: slopes", Fixed, Numbers, 4.0e-8, 0.0, db(142)),
    row("rays: slopes", Twins, Numbers, 5.2e-8, 0.0, db(141)),
    row("rays: points", Float, Numbers, 7.0e-7, 0.0, db(146)),
    row("rays: points", Fixed, Numbers, 4.8e-6, 0.0, db(124)),
    row("rays: points", Twins, Numbers, 5.0e-6, 0.0, db(124)),
    row("reconstruct: joint", Float, Analytic, 1.6e-6, 0.0, db(137)),
    row("reconstruct: joint", Float, Recordings, 3.4e-6, 0.0, db(139)),
    row("reconstruct: joint", Float, Extremes, 5.0e-6, 0.0, db(147)),
    row("reconstruct: joint", Float, Random, 6.2e-6, 0.0, db(138)),
    row("reconstruct: joint", Float, Real, 4.1e-6, 0.0, db(139)),
    row("reconstruct: joint", Twins, Analytic, 3.4e-4, 0.0, db(91)),
    row("reconstruct: joint", Twins, Recordings, 4.3e-2, 1.2e-4, db(91)),
    row("reconstruct: joint", Twins, Extremes, 7.2e-4, 0.0, db(110)),
    row("reconstruct: joint", Twins, Random, 1.6e0, 1.2e-1, db(35)),
    row("reconstruct: joint", Twins, Real, 7.4e-1, 2.5e-4, db(65)),
    row("reconstruct: bilateral", Float, Analytic, 2.2e-6, 0.0, db(137)),
    row("reconstruct: bilateral", Float, Recordings, 2.7e-6, 0.0, db(139)),
    row("reconstruct: bilateral", Float, Extremes, 8.7e-6, 0.0, db(142)),
    row("reconstruct: bilateral", Float, Random, 4.0e-6, 0.0, db(139)),
    row("reconstruct: bilateral", Float, Real, 3.9e-6, 0.0, db(138)),
    row("reconstruct: bilateral", Twins, Analytic, 3.5e-4, 0.0, db(92)),
    row("reconstruct: bilateral", Twins, Recordings, 3.4e-4, 0.0, db(95)),
    row("reconstruct: bilateral", Twins, Extremes, 4.5e-3, 3.5e-5, db(105)),
    row("reconstruct: bilateral", Twins, Random, 1.7e0, 4.7e-1, db(30)),
    row("reconstruct: bilateral", Twins, Real, 1.1e0, 1.1e-2, db(46)),
    row("reconstruct: equation 1", Float, Analytic, 8.1e-6, 0.0, db(124)),
    row("reconstruct: equation 1", Float, Recordings, 1.4e-5, 0.0, db(128)),
    row("reconstruct: equation 1", Float, Extremes, 3.6e-5, 0.0, db(120)),
    row("reconstruct: equation 1", Float, Random, 1.1e-5, 0.0, db(132)),
    row("reconstruct: equation 1", Float, Real, 9.4e-6, 0.0, db(130)),
    row("floor: pose and axes", Float, Numbers, 7.4e-7, 0.0, db(141)),
    row("floor: coordinates", Float, Numbers, 2.9e-6, 0.0, db(140)),
    row("floor: search", Float, Analytic, 4.6e-3, 0.0, db(53)),
    row("floor: search", Float, Recordings, 2.6e-3, 0.0, db(63)),
    row("floor: search", Twins, Analytic, 4.1e-5, 0.0, db(93)),
    row("floor: search", Twins, Recordings, 1.1e-4, 0.0, db(90)),
    row("floor: search", Twins, Real, 8.2e-3, 0.0, db(61)),
    row("ground: cells of pixels", Float, Analytic, 0.0, 1.4e-5, NONE),
    row("ground: cells of pixels", Float, Recordings, 0.0, 7.8e-6, NONE),
    row("ground: cells of pixels", Float, Extremes, 0.0, 6.3e-7, NONE),
    row("ground: cells of pixels", Float, Random, 0.0, 5.0e-6, NONE),
    row("ground: cells of pixels", Float, Real, 0.0, 6.2e-6, NONE),
    row("ground: density", Float, Analytic, 3.2e0, 0.0, db(44)),
    row("ground: density", Float, Recordings, 3.7e0, 0.0, db(42)),
    row("ground: density", Float, Extremes, 2.8e-1, 0.0, db(46)),
    row("ground: density", Float, Random, 5.6e-1, 0.0, db(44)),
    row("ground: density", Float, Real, 2.8e0, 0.0, db(43)),
    row("ground: density", Twins, Analytic, 8.8e-1, 3.4e-6, db(55)),
    row("ground: density", Twins, Recordings, 4.1e0, 6.7e-6, db(55)),
    row("ground: density", Twins, Extremes, 5.1e-1, 4.5e-6, db(52)),
    row("ground: density", Twins, Random, 8.3e-1, 7.7e-5, db(45)),
    row("ground: density", Twins, Real, 1.2e1, 1.3e-5, db(51)),
    row("ground: clusters", Float, Analytic, 3.7e-3, 0.0, db(73)),
    row("ground: clusters", Float, Recordings, 9.6e-2, 0.0, db(56)),
    row("ground: clusters", Float, Extremes, 9.5e-1, 6.1e-2, db(26)),
    row("ground: clusters", Float, Random, 2.4e-2, 0.0, db(57)),
    row("ground: clusters", Float, Real, 2.3e-2, 0.0, db(59)),
    row("ground: clusters", Twins, Analytic, 5.7e-4, 0.0, db(89)),
    row("ground: clusters", Twins, Recordings, 9.4e-2, 0.0, db(54)),
    row("ground: clusters", Twins, Extremes, 1.6e-4, 0.0, db(99)),
    row("ground: clusters", Twins, Random, 9.2e-2, 2.5e-2, db(49)),
    row("ground: clusters", Twins, Real, 2.3e-2, 0.0, db(66)),
    row("diffusion: N", Float, Analytic, 2.3e-1, 7.0e-6, db(71)),
    row("diffusion: N", Float, Recordings, 3.2e-1, 1.2e-4, db(65)),
    row("diffusion: N", Float, Views, 3.3e-2, 1.3e-3, db(81)),
    row("diffusion: N", Float, Extremes, 6.3e-5, 9.8e-6, db(105)),
    row("diffusion: N", Float, Random, 6.9e-1, 2.7e-3, db(44)),
    row("diffusion: N", Float, Real, 9.7e-3, 4.5e-4, db(80)),
    row("diffusion: N", Twins, Analytic, 4.6e-1, 8.5e-4, db(60)),
    row("diffusion: N", Twins, Recordings, 1.1e0, 1.7e-3, db(47)),
    row("diffusion: N", Twins, Views, 1.2e0, 9.0e-4, db(45)),
    row("diffusion: N", Twins, Extremes, 1.2e0, 5.9e-4, db(40)),
    row("diffusion: N", Twins, Random, 1.2e0, 1.1e-3, db(40)),
    row("diffusion: N", Twins, Real, 1.2e0, 1.1e-3, db(50)),
    row("view: planes to pixels", Float, Numbers, 1.9e-4, 0.0, db(138)),
    row("view: pixels to plane", Float, Numbers, 8.1e-7, 0.0, db(131)),
    row("view: fitted square", Float, Analytic, 3.0e-4, 0.0, db(127)),
    row("view: fitted square", Float, Recordings, 7.7e-4, 0.0, db(127)),
    row("view: fitted square", Float, Views, 1.2e-2, 0.0, db(110)),
    row("view: fitted square", Float, Random, 6.8e-5, 0.0, db(138)),
    row("view: fitted square", Float, Real, 2.2e-4, 0.0, db(131)),
    row("view: sampling", Float, Analytic, 8.6e-5, 0.0, db(102)),
    row("view: sampling", Float, Recordings, 1.6e-4, 0.0, db(100)),
    row("view: sampling", Float, Views, 6.1e-3, 0.0, db(83)),
    row("view: sampling", Float, Random, 8.8e-5, 0.0, db(99)),
    row("view: sampling", Float, Real, 1.1e-4, 0.0, db(100)),
    row("view: sampling", Twins, Analytic, 4.3e-4, 0.0, db(90)),
    row("view: sampling", Twins, Recordings, 5.3e-4, 0.0, db(85)),
    row("view: sampling", Twins, Views, 2.2e-3, 0.0, db(86)),
    row("view: sampling", Twins, Random, 5.8e-4, 0.0, db(81)),
    row("view: sampling", Twins, Real, 5.1e-4, 0.0, db(85)),
    row("view: smooth pattern", Float, Analytic, 4.3e-4, 0.0, db(73)),
    row("wavelet: coefficients", Float, Analytic, 1.5e-5, 0.0, db(129)),
    row("wavelet: coefficients", Float, Recordings, 1.8e-5, 0.0, db(130)),
    row("wavelet: coefficients", Float, Views, 2.0e-5, 0.0, db(130)),
    row("wavelet: coefficients", Float, Extremes, 2.2e-5, 0.0, db(133)),
    row("wavelet: coefficients", Float, Random, 1.2e-5, 0.0, db(130)),
    row("wavelet: coefficients", Float, Real, 1.6e-5, 0.0, db(130)),
    row("wavelet: coefficients", Twins, Analytic, 1.6e-5, 0.0, db(130)),
    row("wavelet: coefficients", Twins, Recordings, 2.6e-5, 0.0, db(130)),
    row("wavelet: coefficients", Twins, Views, 1.9e-5, 0.0, db(130)),
    row("wavelet: coefficients", Twins, Extremes, 2.2e-5, 0.0, db(133)),
    row("wavelet: coefficients", Twins, Random, 1.2e-5, 0.0, db(129)),
    row("wavelet: coefficients", Twins, Real, 1.4e-5, 0.0, db(130)),
    row("descriptor: paper", Float, Analytic, 5.5e-5, 0.0, NONE),
    row("descriptor: paper", Float, Recordings, 6.9e-4, 0.0, NONE),
    row("descriptor: paper", Float, Views, 1.5e-3, 0.0, NONE),
    row("descriptor: paper", Float, Random, 3.8e-5, 0.0, NONE),
    row("descriptor: paper", Float, Real, 1.9e-5, 0.0, NONE),
    row("descriptor: paper", Twins, Analytic, 5.9e-3, 0.0, NONE),
    row("descriptor: paper", Twins, Recordings, 7.8e-3, 0.0, NONE),
    row("descriptor: paper", Twins, Views, 2.1e-2, 0.0, NONE),
    row("descriptor: paper", Twins, Random, 1.6e-2, 0.0, NONE),
    row("descriptor: paper", Twins, Real, 6.6e-3, 0.0, NONE),
    row("descriptor: halves", Float, Analytic, 1.2e-5, 0.0, NONE),
    row("descriptor: halves", Float, Recordings, 2.3e-5, 0.0, NONE),
    row("descriptor: halves", Float, Views, 4.3e-5, 0.0, NONE),
    row("descriptor: halves", Float, Random, 2.3e-5, 0.0, NONE),
    row("descriptor: halves", Float, Real, 1.5e-5, 0.0, NONE),
    row("descriptor: halves", Twins, Analytic, 6.3e-3, 0.0, NONE),
    row("descriptor: halves", Twins, Recordings, 6.8e-3, 0.0, NONE),
    row("descriptor: halves", Twins, Views, 7.1e-3, 0.0, NONE),
    row("descriptor: halves", Twins, Random, 5.9e-3, 0.0, NONE),
    row("descriptor: halves", Twins, Real, 6.3e-3, 0.0, NONE),
    row("descriptor: paper, numbers", Float, Extremes, 4.5e0, 0.0, db(27)),
    row("descriptor: paper, numbers", Twins, Extremes, 4.5e0, 0.0, db(26)),
    row("descriptor: halves, numbers", Float, Extremes, 5.0e-6, 0.0, db(109)),
    row("descriptor: halves, numbers", Twins, Extremes, 1.1e-3, 0.0, db(59)),
    row("matching: Canberra distance", Float, Numbers, 6.6e-6, 0.0, db(148)),
    row("matching: Canberra distance", Fixed, Numbers, 2.2e-3, 0.0, db(98)),
    row("matching: Canberra distance", Twins, Numbers, 3.4e-3, 0.0, db(89)),
    row("matching: nearest class", Float, Views, 1.4e-6, 0.0, db(145)),
    row("matching: nearest class", Twins, Analytic, 2.8e-3, 0.0, db(74)),
    row("matching: nearest class", Twins, Recordings, 3.5e-3, 0.0, db(72)),
    row("matching: nearest class", Twins, Views, 4.5e-3, 5.4e-4, db(74)),
    row("matching: nearest class", Twins, Random, 2.6e-3, 0.0, db(82)),
    row("matching: nearest class", Twins, Real, 2.4e-3, 0.0, db(75)),
    row("pipeline: floor", Twins, Analytic, 4.3e-5, 0.0, db(96)),
    row("pipeline: floor", Twins, Recordings, 1.1e-4, 0.0, db(90)),
    row("pipeline: floor", Twins, Extremes, 0.0, 0.0, EXACT),
    row("pipeline: floor", Twins, Random, 4.3e-6, 0.0, db(115)),
    row("pipeline: floor", Twins, Real, 1.7e-3, 0.0, db(68)),
    row("pipeline: N", Twins, Analytic, 8.4e-1, 5.0e-3, db(47)),
    row("pipeline: N", Twins, Recordings, 1.2e0, 2.4e-2, db(34)),
    row("pipeline: N", Twins, Extremes, 1.2e0, 8.2e-2, db(40)),
    row("pipeline: N", Twins, Random, 1.2e0, 7.9e-2, db(23)),
    row("pipeline: N", Twins, Real, 1.2e0, 1.3e-2, db(41)),
    row("pipeline: N of candidates", Twins, Analytic, 6.8e-2, 5.0e-3, db(56)),
    row("pipeline: N of candidates", Twins, Recordings, 1.1e0, 2.0e-2, db(38)),
    row("pipeline: N of candidates", Twins, Extremes, 0.0, 0.0, EXACT),
    row("pipeline: N of candidates", Twins, Random, 8.1e-1, 2.2e-2, db(32)),
    row("pipeline: N of candidates", Twins, Real, 3.8e-1, 9.9e-3, db(46)),
    row("pipeline: clusters", Float, Analytic, 3.7e-3, 0.0, db(73)),
    row("pipeline: clusters", Float, Recordings, 1.1e-2, 0.0, db(66)),
    row("pipeline: clusters", Float, Extremes, 9.5e-1, 6.1e-2, db(26)),
    row("pipeline: clusters", Float, Random, 2.4e-2, 0.0, db(57)),
    row("pipeline: clusters", Float, Real, 2.2e-2, 0.0, db(59)),
    row("pipeline: clusters", Twins, Analytic, 7.7e-4, 0.0, db(84)),
    row("pipeline: clusters", Twins, Recordings, 8.3e-2, 0.0, db(58)),
    row("pipeline: clusters", Twins, Extremes, 1.3e-4, 0.0, db(102)),
    row("pipeline: clusters", Twins, Random, 7.0e-1, 1.4e-1, db(29)),
    row("pipeline: clusters", Twins, Real, 2.3e-1, 4.4e-3, db(43)),
    row("pipeline: descriptor", Twins, Analytic, 2.0e-1, 0.0, NONE),
    row("pipeline: descriptor", Twins, Recordings, 7.3e-1, 0.0, NONE),
    row("pipeline: descriptor", Twins, Views, 7.2e-1, 0.0, NONE),
    row("pipeline: descriptor", Twins, Random, 1.6e1, 0.0, NONE),
    row("pipeline: descriptor", Twins, Real, 1.4e-1, 0.0, NONE),
    row("pipeline: nearest class", Twins, Analytic, 7.0e-2, 0.0, db(47)),
    row("pipeline: nearest class", Twins, Recordings, 1.6e-1, 0.0, db(44)),
    row("pipeline: nearest class", Twins, Views, 4.2e-1, 1.1e-3, db(48)),
    row("pipeline: nearest class", Twins, Random, 3.9e-1, 1.2e-1, db(40)),
    row("pipeline: nearest class", Twins, Real, 2.7e-2, 0.0, db(58)),
    row("pipeline: frame to descriptor", Float, Analytic, 4.8e-4, 0.0, NONE),
    row("pipeline: frame to descriptor", Float, Recordings, 9.4e-3, 0.0, NONE),
    row("pipeline: frame to descriptor", Float, Views, 5.8e-1, 0.0, NONE),
    row("pipeline: frame to descriptor", Float, Random, 1.9e-2, 0.0, NONE),
    row("pipeline: frame to descriptor", Float, Real, 1.9e-4, 0.0, NONE),
];
