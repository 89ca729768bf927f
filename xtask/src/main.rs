//! Repository tasks: `cargo xtask help` lists them.
//!
//! Standard library only, so that it builds in a second. Every task is a list of steps; all of them run, and what
//! failed is told again at the end, so that one run shows everything that is wrong.

mod capi;
mod ci;
mod conformance;
mod elf;
mod endurance;
mod firmware;
mod fuzz;
mod golden;
mod instructions;
mod nofloat;
mod nopanic;
mod nostd;
mod process;
mod report;
mod robot;
mod size;
mod symbols;

use std::process::ExitCode;

use report::Report;

const HELP: &str = "\
Repository tasks.

Usage: cargo xtask TASK

Tasks:
  ci                everything below, after formatting, lints, documentation and tests: what CI runs
  nostd             pldi-core for microcontrollers, with and without its features
  nofloat           that the pipeline in integers needs no float routine
  nopanic           that no path to a panic is left in either pipeline
  instructions      counts the instructions of each stage in both arithmetics (valgrind); not part of ci
  capi              the C library: header, C and C++, tests under valgrind and sanitizers, the example in QEMU
  capi --renew      the same, and writes the header and the example's output anew
  capi --install PREFIX [--target TARGET]   builds the archive and installs it with header, CMake and pkg-config files
  robot             a device in QEMU answers frames that come over a bad line: 20 frames, 1,000 corrupted packets
  robot --all       200 frames, 10,000 corrupted packets
  firmware          builds the images of tests/firmware, runs them in QEMU, and compares what they print with the host's
                    digests and tests/firmware/out, and what they take with docs/firmware.md and README.md
  firmware [--board NAME] [--all] [--overwrite] [--renew]   one board; all frames; writes tests/firmware/out; writes the tables
  size              prints the memory plan of the pipeline in integers, compares it with docs/memory.md
  size --renew      writes docs/memory.md anew
  golden            makes the committed golden data anew
  golden --check    makes it elsewhere and compares it byte for byte with what is committed; of the template set,
                    ci makes one object of each class
  conformance       compares the stages' bits with the golden ones, all stages with their truth, fixed point with
                    float, and the stages of `pldi` with the reference on real recordings
  endurance [MINUTES]   records 10 minutes at 30 Hz and recognises them: memory and time; not part of ci
  conformance --renew   the same without the reference, and writes docs/conformance.md
  fuzz [--seconds N] [TARGET...]   looks for inputs that a reader of foreign bytes does not stand (cargo-fuzz), 60 s for
                    each target of tests/fuzz; not part of ci
  fuzz --corpus     the targets on their corpus alone, without cargo-fuzz; one of the tests
  help              this text

Environment:
  CI                when set, a step that lacks a tool fails instead of being skipped
  PLDI_PYTHON       the Python of the conformance judge; default target/judge-venv/bin/python, then python3

Exit code: 0 when nothing failed, 1 when a step failed, 2 for a wrong command line.";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let mut report = Report::default();
    match arguments[..] {
        ["ci"] => ci::run(&mut report),
        ["nostd"] => nostd::run(&mut report),
        ["nofloat"] => nofloat::run(&mut report),
        ["nopanic"] => nopanic::run(&mut report),
        ["capi"] => capi::run(&mut report, golden::Mode::Check),
        ["capi", "--renew"] => capi::run(&mut report, golden::Mode::Renew),
        ["capi", "--install", prefix] => capi::install(&mut report, prefix, None),
        ["capi", "--install", prefix, "--target", target] => capi::install(&mut report, prefix, Some(target)),
        ["instructions"] => instructions::run(&mut report),
        ["endurance"] => endurance::run(&mut report, 10),
        ["endurance", minutes] => match minutes.parse() {
            Ok(minutes @ 1..=600) => endurance::run(&mut report, minutes),
            _ => return usage(),
        },
        ["robot"] => robot::run(&mut report, robot::Extent::Short),
        ["robot", "--all"] => robot::run(&mut report, robot::Extent::All),
        ["firmware", ref words @ ..] => match firmware::Options::parse(words) {
            Some(options) => firmware::run(&mut report, options),
            None => return usage(),
        },
        ["fuzz", ref words @ ..] => match fuzz::Options::parse(words) {
            Some(options) => fuzz::run(&mut report, &options),
            None => return usage(),
        },
        ["size"] => size::run(&mut report, golden::Mode::Check),
        ["size", "--renew"] => size::run(&mut report, golden::Mode::Renew),
        ["golden"] => golden::run(&mut report, golden::Mode::Renew),
        ["golden", "--check"] => golden::run(&mut report, golden::Mode::Check),
        ["conformance"] => {
            golden::digests(&mut report);
            conformance::suite(&mut report, conformance::Document::Check);
            conformance::run(&mut report);
        }
        ["conformance", "--renew"] => conformance::suite(&mut report, conformance::Document::Renew),
        ["help" | "--help" | "-h"] => {
            println!("{HELP}");
            return ExitCode::SUCCESS;
        }
        _ => return usage(),
    }
    report.finish()
}

/// A wrong command line.
fn usage() -> ExitCode {
    eprintln!("{HELP}");
    ExitCode::from(2)
}
