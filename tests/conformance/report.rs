//! The table as text and as Markdown.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::errors::{Errors, Key};
use crate::rows::{Pair, Requirement, Row, Set, Stage};
use crate::table::{REQUIREMENTS, STAGES, TABLE};

/// What stands between the part that is the same everywhere and that of the real recordings.
const REAL: &str = "\n## Real recordings\n";

/// A stage by its name.
pub fn stage(name: &str) -> &'static Stage {
    STAGES.iter().find(|stage| stage.name == name).unwrap_or_else(|| panic!("{name} is not in the list of stages"))
}

/// The table's columns, each as wide as its widest entry may become.
const HEAD: [(&str, usize); 9] = [
    ("stage", 32),
    ("compared", 12),
    ("inputs", 10),
    ("samples", 9),
    ("largest error (bound)", 30),
    ("LSBs", 9),
    ("SNR in dB (bound)", 17),
    ("changed (bound)", 21),
    ("what changes", 30),
];

/// A row's cells: what was measured and, in brackets, the bound.
fn cells(row: &Row, errors: &Errors) -> [String; 9] {
    let stage = stage(row.stage);
    let scientific = |v: f64| if v == 0.0 { "0".to_owned() } else { format!("{v:.2e}") };
    let bound = |v: f64| if v == 0.0 { "0".to_owned() } else { format!("{v:.1e}") };
    let lsb = stage.lsb > 0.0 && row.pair != Pair::Float;
    let decibels = |v: f64, digits: usize| if v.is_finite() { format!("{v:.digits$}") } else { "exact".to_owned() };
    let unit = if stage.unit == "1" { String::new() } else { format!(" {}", stage.unit) };
    [
        row.stage.to_owned(),
        row.pair.name().to_owned(),
        row.set.name().to_owned(),
        errors.samples().to_string(),
        format!("{} ({}){unit}", scientific(errors.largest()), bound(row.largest)),
        if lsb { format!("{:.2}", errors.largest() / stage.lsb) } else { String::new() },
        row.snr.map_or(String::new(), |snr| format!("{} ({})", decibels(errors.snr(), 1), decibels(snr, 0))),
        if stage.decision.is_empty() {
            String::new()
        } else {
            format!("{} ({})", scientific(errors.share()), bound(row.share))
        },
        stage.decision.to_owned(),
    ]
}

fn line(cells: &[String; 9]) -> String {
    let mut out = String::from("|");
    for (cell, (_, width)) in cells.iter().zip(HEAD) {
        let _ = write!(out, " {cell:<width$} |");
    }
    out + "\n"
}

/// The rows on sets that `which` names.
pub fn table(measured: &BTreeMap<Key, Errors>, which: impl Fn(Set) -> bool) -> String {
    let mut out = line(&HEAD.map(|(name, _)| name.to_owned()));
    out += &format!("|{}\n", HEAD.map(|(_, width)| format!("{}|", "-".repeat(width + 2))).concat());
    for row in TABLE.iter().filter(|row| which(row.set)) {
        if let Some(errors) = measured.get(&Key { stage: row.stage, pair: row.pair, set: row.set }) {
            out += &line(&cells(row, errors));
        }
    }
    out
}

/// Requirements, the sets that they hold for, and what was measured there.
pub fn required(measured: &BTreeMap<Key, Errors>) -> impl Iterator<Item = (&'static Requirement, Set, &Errors)> {
    let sets = |r: &'static Requirement| r.sets.iter().map(move |set| (r, *set));
    REQUIREMENTS
        .iter()
        .flat_map(sets)
        .filter_map(|(r, set)| Some((r, set, measured.get(&Key { stage: r.stage, pair: r.pair, set })?)))
}

/// The requirements on sets that `which` names, and whether they are met.
fn requirements(measured: &BTreeMap<Key, Errors>, which: impl Fn(Set) -> bool) -> String {
    let mut out = String::from(
        "| what is required of fixed point beside float | inputs | changed (at most) | RMS (at most) | met |\n|---|---|---|---|---|\n",
    );
    for (r, set, errors) in required(measured).filter(|(_, set, _)| which(*set)) {
        let rms = if r.rms.is_finite() { format!("{:.2e} ({:.1e})", errors.rms(), r.rms) } else { String::new() };
        let met = if r.is_met(errors) { "yes" } else { "**no**" };
        let share = format!("{:.2e} ({:.1e})", errors.share(), r.share);
        let _ = writeln!(out, "| {} | {} | {share} | {rms} | {met} |", r.stage, set.name());
    }
    out
}

/// Where the table is committed.
fn committed() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/conformance.md")
}

/// The document; what it says of the real recordings stays as it is committed where they are missing.
fn document(measured: &BTreeMap<Key, Errors>, old: &str) -> String {
    let mut out = String::from(include_str!("preface.md"));
    out += &requirements(measured, |set| set != Set::Real);
    out += "\n";
    out += &table(measured, |set| set != Set::Real);
    if measured.keys().any(|key| key.set == Set::Real) {
        let words = "\nFrames of real sensors, which are not part of the repository: without them this part is not checked.\n\n";
        let real = |set| set == Set::Real;
        out + REAL + words + &requirements(measured, real) + "\n" + &table(measured, real)
    } else {
        out + old.find(REAL).map_or("", |at| &old[at..])
    }
}

/// Whether the document keeps what it says of the real recordings where they are missing.
pub fn keeps_real_rows(measured: &BTreeMap<Key, Errors>) -> bool {
    let whole = document(measured, "");
    let mut elsewhere = measured.clone();
    elsewhere.retain(|key, _| key.set != Set::Real);
    document(&elsewhere, &whole) == whole
}

/// Writes the document anew.
pub fn renew(measured: &BTreeMap<Key, Errors>) -> Result<(), String> {
    let path = committed();
    let old = std::fs::read_to_string(&path).unwrap_or_default();
    std::fs::write(&path, document(measured, &old)).map_err(|error| format!("docs/conformance.md: {error}"))
}

/// Compares the document with what is committed.
pub fn check(measured: &BTreeMap<Key, Errors>) -> Result<(), String> {
    let old = std::fs::read_to_string(committed()).map_err(|error| format!("docs/conformance.md: {error}"))?;
    let new = document(measured, &old);
    if old == new {
        return Ok(());
    }
    let differs = |(i, (a, b)): (usize, (&str, &str))| (a != b).then(|| format!("line {}:\n- {a}\n+ {b}", i + 1));
    let first = old.lines().zip(new.lines()).enumerate().find_map(differs);
    let first = first.unwrap_or_else(|| "one is the beginning of the other".to_owned());
    Err(format!("docs/conformance.md is not what is measured; `cargo xtask conformance --renew` writes it. {first}"))
}
