//! Everything that must hold before a change lands.

use crate::process::{cargo, run as run_command};
use crate::report::Report;
use crate::{capi, conformance, firmware, golden, nofloat, nopanic, nostd, robot, size};

/// `pldi-core`'s features. A test below keeps this list as the manifest has it.
const CORE_FEATURES: [&str; 3] = ["defmt", "nalgebra", "approx-math"];

/// Runs all steps, the quick ones first.
pub(crate) fn run(report: &mut Report) {
    step(report, "format", "fmt --all -- --check");
    step(report, "format, firmware images", "fmt --manifest-path tests/firmware/Cargo.toml -- --check");
    step(report, "format, fuzz targets", "fmt --manifest-path tests/fuzz/Cargo.toml -- --check");
    let driver = "--manifest-path tests/openni2/driver/Cargo.toml";
    step(report, "format, OpenNI2 driver", &format!("fmt {driver} -- --check"));
    step(report, "clippy", "clippy --workspace --all-targets --locked -- -D warnings");
    // Not among all targets: it is no part of `cargo test`.
    step(report, "clippy, conformance suite", "clippy -p pldi-host --test conformance --locked -- -D warnings");
    let line = format!("clippy {driver} --target-dir target/openni2 --all-targets --locked -- -D warnings");
    step(report, "clippy, OpenNI2 driver", &line);
    for feature in CORE_FEATURES {
        let line = format!("clippy -p pldi-core --all-targets --locked --features {feature} -- -D warnings");
        step(report, &format!("clippy, pldi-core with {feature}"), &line);
    }
    for feature in ["panic-handler", "std"] {
        let line = format!("clippy -p pldi-capi --lib --locked --features {feature} -- -D warnings");
        step(report, &format!("clippy, C library with {feature}"), &line);
    }
    for (name, line) in [
        ("documentation", "doc --no-deps --workspace --locked"),
        ("documentation, pldi-core with all features", "doc --no-deps -p pldi-core --all-features --locked"),
    ] {
        report.step(name, || run_command(cargo(line).env("RUSTDOCFLAGS", "-D warnings")));
    }
    step(report, "tests", "test --workspace --locked --no-fail-fast");
    // Tests with defmt cannot link on a host, and approx-math gives up the accuracy that they check.
    step(
        report,
        "tests, pldi-core with nalgebra",
        "test -p pldi-core --lib --locked --no-fail-fast --features nalgebra floor::",
    );
    nostd::run(report);
    nofloat::run(report);
    nopanic::run(report);
    capi::run(report, golden::Mode::Check);
    firmware::run(report, firmware::Options::default());
    robot::run(report, robot::Extent::Short);
    size::run(report, golden::Mode::Check);
    // The template set takes minutes: a test makes a part of it.
    golden::digests(report);
    conformance::suite(report, conformance::Document::Check);
    conformance::run(report);
}

fn step(report: &mut Report, name: &str, line: &str) {
    report.step(name, || run_command(&mut cargo(line)));
}

#[cfg(test)]
mod tests {
    use super::CORE_FEATURES;

    #[test]
    fn every_feature_of_the_core_is_checked() {
        let manifest = std::fs::read_to_string(crate::process::root().join("pldi-core/Cargo.toml")).unwrap();
        let features: Vec<&str> = manifest
            .lines()
            .skip_while(|line| line.trim() != "[features]")
            .skip(1)
            .take_while(|line| !line.starts_with('['))
            .filter(|line| !line.starts_with('#'))
            .filter_map(|line| Some(line.split_once('=')?.0.trim()))
            .filter(|name| *name != "default")
            .collect();
        assert_eq!(features, CORE_FEATURES);
    }
}
