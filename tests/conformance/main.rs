//! The conformance suite: float against the truth in float64, fixed point against float, stage by stage and all together.
//!
//!     cargo test --release -p pldi-host --test conformance -- [--renew] [--suggest] [--only INPUTS] [--threads N]
//!
//! `--renew` writes docs/conformance.md instead of comparing it, `--suggest` prints the lines of a table that fits what was
//! measured, `--only` measures one kind of inputs. To add a row: call `tally.at(stage, pair)` where the stage is measured, name
//! the stage in the table's list, and take over the line that `--suggest` prints.

#[path = "../../pldi-core/tests/common/mod.rs"]
mod common;
mod errors;
mod inputs;
mod jobs;
mod oracle;
mod report;
mod rows;
mod self_test;
mod stages;
mod table;

use std::collections::BTreeMap;
use std::process::ExitCode;
use std::time::Instant;

use errors::{Errors, Key};
use rows::{Row, Set};
use table::{EXACT_MODULES, REQUIREMENTS, SETS, STAGES, TABLE};

/// What the command line asks for.
struct Options {
    renew: bool,
    suggest: bool,
    only: Option<Set>,
    threads: usize,
}

fn options() -> Result<Options, String> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut out = Options { renew: false, suggest: false, only: None, threads };
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or_else(|| format!("{argument} needs a value"));
        match argument.as_str() {
            "--renew" => out.renew = true,
            "--suggest" => out.suggest = true,
            "--only" => {
                let name = value()?;
                out.only = Some(*SETS.iter().find(|set| set.name() == name).ok_or(format!("no inputs named {name}"))?);
            }
            "--threads" => out.threads = value()?.parse().map_err(|error| format!("--threads: {error}"))?,
            other => return Err(format!("{other} is no option")),
        }
    }
    Ok(out)
}

fn main() -> ExitCode {
    let options = match options() {
        Ok(options) => options,
        Err(why) => {
            eprintln!("{why}");
            return ExitCode::from(2);
        }
    };
    let start = Instant::now();
    stages::object::check_the_filter();
    let measured = jobs::run(options.only, options.threads);
    if options.suggest {
        suggest(&measured);
        return ExitCode::SUCCESS;
    }
    print!("{}", report::table(&measured, |_| true));
    let without_real = inputs::real::folders().is_empty();
    if without_real {
        println!("\nSKIPPED: NO REAL RECORDINGS in ../shared/data/recordings: their rows are not measured");
    }
    let mut complaints = coverage();
    complaints.extend(bounds(&measured, |set| {
        options.only.is_none_or(|only| only == set) && !(without_real && set == Set::Real)
    }));
    println!();
    complaints.extend(requirements(&measured));
    let (tried, unnoticed) = self_test::run(&measured);
    println!("\nself-test: {tried} bounds loosened to three times what they are, and exceeded");
    complaints.extend(unnoticed.into_iter().map(|what| format!("self-test: {what} went unnoticed")));
    if !report::keeps_real_rows(&measured) {
        complaints.push("self-test: the document loses the rows of missing recordings".to_owned());
    }
    if options.only.is_none() {
        let document = if options.renew { report::renew(&measured) } else { report::check(&measured) };
        complaints.extend(document.err());
    }
    println!("{} rows in {:.1} s", measured.len(), start.elapsed().as_secs_f64());
    for complaint in &complaints {
        println!("FAILED: {complaint}");
    }
    if complaints.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Bounds that do not hold or are too loose; rows that were not measured, and what was measured without a row.
fn bounds(measured: &BTreeMap<Key, Errors>, expected: impl Fn(Set) -> bool) -> Vec<String> {
    let mut out = Vec::new();
    for row in TABLE.iter().filter(|row| expected(row.set)) {
        match measured.get(&Key { stage: row.stage, pair: row.pair, set: row.set }) {
            None => out.push(format!("{} ({:?}, {:?}) was not measured", row.stage, row.pair, row.set)),
            Some(errors) => {
                let complaints = row.complaints(errors);
                if !complaints.is_empty() {
                    out.extend(complaints);
                    let fitting = Row::fitting(report::stage(row.stage), row.pair, row.set, errors);
                    out.push(format!("this would fit:\n{}", fitting.source()));
                }
            }
        }
    }
    for key in measured.keys() {
        if !TABLE.iter().any(|row| (row.stage, row.pair, row.set) == (key.stage, key.pair, key.set)) {
            out.push(format!("{key:?} has no row; `--suggest` prints one"));
        }
    }
    out
}

/// What must hold whatever the table says.
fn requirements(measured: &BTreeMap<Key, Errors>) -> Vec<String> {
    let mut out = Vec::new();
    for (requirement, set, errors) in report::required(measured) {
        if requirement.open.contains(&set) {
            println!("NOT MET YET: {} ({})", requirement.stage, set.name());
        }
        out.extend(requirement.complaint(set, errors));
    }
    out
}

/// Every module of the core has its stages, and every stage is a module's.
fn coverage() -> Vec<String> {
    let text = include_str!("../../pldi-core/src/lib.rs");
    let modules: Vec<_> = text.lines().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';')).collect();
    assert!(modules.len() > 10, "{modules:?}");
    let module_of = |stage: &'static str| stage.split(':').next().unwrap_or_default();
    let mut out = Vec::new();
    for module in &modules {
        let rows = TABLE.iter().filter(|row| module_of(row.stage) == *module).count();
        if (rows == 0) != EXACT_MODULES.contains(module) {
            out.push(format!("the core's module {module} has {rows} rows"));
        }
    }
    for stage in STAGES {
        if !modules.contains(&module_of(stage.name)) {
            out.push(format!("{} is no module's", stage.name));
        }
        if !TABLE.iter().any(|row| row.stage == stage.name) {
            out.push(format!("{} has no row", stage.name));
        }
    }
    let required = REQUIREMENTS.iter().filter(|r| !TABLE.iter().any(|row| (row.stage, row.pair) == (r.stage, r.pair)));
    out.extend(required.map(|r| format!("{} ({:?}) is required, but has no row", r.stage, r.pair)));
    out
}

/// Prints the rows that fit what was measured, in the order of the stages.
fn suggest(measured: &BTreeMap<Key, Errors>) {
    for stage in STAGES {
        for (key, errors) in measured.iter().filter(|(key, _)| key.stage == stage.name) {
            println!("{}", Row::fitting(stage, key.pair, key.set, errors).source());
        }
    }
    for key in measured.keys().filter(|key| STAGES.iter().all(|stage| stage.name != key.stage)) {
        println!("// {} is not in the list of stages", key.stage);
    }
}
