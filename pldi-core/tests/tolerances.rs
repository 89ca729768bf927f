//! The tolerance table: how far each stage may be from its truth, computed in float64 by code that shares nothing with
//! the core (`tolerances/`).
//!
//! A stage that is farther off than its bound fails, and so does a bound that is more than four times looser than
//! what is measured: the numbers below are what the stages really do. Everything is deterministic, on every machine.
//!
//!     cargo test -p pldi-core --test tolerances -- --nocapture

mod common;
mod tolerances {
    pub mod geometry;
    pub mod image;
    pub mod measure;
    pub mod numbers;
    pub mod scenes;
    pub mod stages;
    pub mod views;
}

use tolerances::measure::{Errors, Row};
use tolerances::{stages, views};

/// A line: stage, unit (C is that of a Canberra distance, 0 to 58), largest error, share of decisions that come out otherwise, signal to noise in dB.
const fn row(
    stage: &'static str,
    unit: &'static str,
    largest: f64,
    share: f64,
    snr: Option<f64>,
    measure: fn() -> Errors,
) -> Row {
    Row { stage, unit, largest, share, snr, measure }
}

/// The table, in the order of the pipeline.
const TABLE: &[Row] = &[
    row("math: exp", "ulp", 1.0, 0.0, None, stages::exp),
    row("math: sin, cos, asin, atan2", "rad", 4e-7, 0.0, Some(147.0), stages::angles),
    row("frame: back-projection", "m", 1e-6, 0.0, None, stages::back_projection),
    row("frame: projection", "px", 7e-5, 0.0, None, stages::projection),
    row("rays: points", "m", 1e-6, 0.0, None, stages::rays),
    row("reconstruct: joint", "m", 2.5e-6, 0.0, Some(135.0), stages::joint),
    row("reconstruct: bilateral", "m", 2.5e-6, 0.0, Some(135.0), stages::depth_alone),
    row("reconstruct: equation 1", "m", 1e-5, 0.0, Some(123.0), stages::exact),
    row("floor: pose and axes", "1", 1e-6, 0.0, None, stages::axes),
    row("floor: coordinates", "m", 4e-6, 0.0, None, stages::coordinates),
    row("floor: search in noisy rooms", "m, 1", 6e-3, 0.0, None, stages::search),
    row("ground: cells of pixels", "-", 0.0, 4e-5, None, stages::cells),
    row("ground: density", "px", 0.1, 0.0, Some(40.0), stages::spread),
    row("diffusion: N", "1", 1e-3, 0.0, Some(100.0), stages::diffusion),
    row("view: planes to pixels", "px", 3e-4, 0.0, None, stages::to_pixels),
    row("view: pixels to plane", "m", 1.5e-6, 0.0, None, stages::to_plane),
    row("view: fitted square", "px", 2e-4, 0.0, None, views::square),
    row("view: sampling", "1", 1.5e-4, 0.0, Some(97.0), views::sampling),
    row("view: smooth pattern", "1", 6e-4, 0.0, Some(70.0), views::pattern),
    row("wavelet: coefficients", "1", 3e-5, 0.0, Some(126.0), views::wavelets),
    row("descriptor: paper", "C", 5e-4, 0.0, None, views::paper),
    row("descriptor: halves", "C", 1e-4, 0.0, None, views::halves),
    row("matching: Canberra distance", "C", 1e-5, 0.0, Some(143.0), views::canberra),
    row("pipeline: frame to descriptor", "C", 2e-3, 0.0, None, views::frame_to_descriptor),
];

/// Modules of the core that give no numbers which could be off.
const EXACT: &[&str] = &["fixed", "templates"];

#[test]
fn every_stage_is_as_near_to_the_truth_as_the_table_says() {
    common::with_stack(|| {
        println!("{:<36} {:<5} largest error         SNR in dB    decided otherwise; (measured)", "stage", "unit");
        let mut complaints = Vec::new();
        for row in TABLE {
            let errors = (row.measure)();
            println!("{}", row.line(&errors));
            complaints.extend(row.complaints(&errors));
        }
        assert!(complaints.is_empty(), "{}", complaints.join("\n"));
    });
}

#[test]
fn every_module_of_the_core_has_its_rows() {
    let modules =
        include_str!("../src/lib.rs").lines().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'));
    let modules: Vec<_> = modules.collect();
    assert!(modules.len() > 10, "{modules:?}");
    for module in &modules {
        let rows = TABLE.iter().filter(|row| row.stage.split(':').next() == Some(module)).count();
        assert_eq!(rows == 0, EXACT.contains(module), "{module} has {rows} rows in the tolerance table");
    }
    for row in TABLE {
        assert!(modules.iter().any(|m| row.stage.split(':').next() == Some(m)), "{} is no module's", row.stage);
    }
}
