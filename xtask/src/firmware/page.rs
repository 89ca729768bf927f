//! The tables of docs/firmware.md and of the front page: written anew, or compared with what was measured.

use std::fmt::Write as _;
use std::fs;

use super::Arithmetic;
use super::board::{BOARDS, Board};
use super::budget::Measured;
use super::tolerance;
use crate::nostd;
use crate::process::root;
use crate::report::Outcome;

const PAGE: &str = "docs/firmware.md";
const FRONT: &str = "README.md";

/// Around what is written here; the rest of the files is written by hand.
const BEGIN: &str = "<!-- firmware: from here on written by `cargo xtask firmware --renew` -->";
const END: &str = "<!-- firmware: up to here -->";

/// What a compiler is named after in the page.
const COMPILER: &str = "Compiled by ";

/// Writes or checks both tables.
pub(crate) fn step(measured: &[Measured], renew: bool) -> Outcome {
    let images: usize = BOARDS.iter().map(|board| 1 + usize::from(board.fpu)).sum();
    if measured.len() < images {
        return Outcome::Skipped("not all images have run".into());
    }
    let compiler = BOARDS.first().and_then(|board| nostd::version(nostd::toolchain(board.target)?)).unwrap_or_default();
    let results = [(PAGE, page(measured, &compiler)), (FRONT, front(measured))];
    let same_compiler = fs::read_to_string(root().join(PAGE)).is_ok_and(|old| old.contains(&named(&compiler)));
    let failures: Vec<String> =
        results.into_iter().filter_map(|(path, new)| settle(path, &new, renew, same_compiler).err()).collect();
    if failures.is_empty() { Outcome::Passed } else { Outcome::Failed(failures.join("; ")) }
}

fn settle(path: &str, new: &str, renew: bool, same_compiler: bool) -> Result<(), String> {
    let failed = |why: String| format!("{path}: {why}");
    let text = fs::read_to_string(root().join(path)).map_err(|error| failed(error.to_string()))?;
    let parts = text.split_once(BEGIN).and_then(|(before, rest)| Some((before, rest.split_once(END)?)));
    let (before, (old, after)) = parts.ok_or_else(|| failed(format!("no place for the table: {BEGIN} ... {END}")))?;
    if renew {
        let text = format!("{before}{BEGIN}\n{new}{END}{after}");
        return fs::write(root().join(path), text).map_err(|error| failed(error.to_string()));
    }
    match &tolerance::differences(old, new, same_compiler)[..] {
        [] => Ok(()),
        found => Err(failed(format!("{}; `cargo xtask firmware --renew` if that is meant", found.join("; ")))),
    }
}

fn named(compiler: &str) -> String {
    format!("{COMPILER}{compiler}.")
}

/// A table for each board.
fn page(measured: &[Measured], compiler: &str) -> String {
    let mut text = format!(
        "\n{} Memory is in KiB (1024 bytes), instructions in millions: those of the frame with three candidates / the average of the \
         {} frames that are run by default.\n",
        named(compiler),
        super::SUBSET.len()
    );
    for board in BOARDS {
        let of = |arithmetic| measured.iter().find(|one| one.board == board && one.arithmetic == arithmetic);
        let images: Vec<&Measured> = [Arithmetic::Fixed, Arithmetic::Float].into_iter().filter_map(of).collect();
        table(&mut text, board, &images);
    }
    text
}

fn table(text: &mut String, board: Board, images: &[&Measured]) {
    let machine = board.qemu.split_whitespace().nth(2).unwrap_or_default();
    let heads = images.iter().map(|image| image.arithmetic.in_words()).collect::<Vec<_>>().join(" | ");
    let _ = writeln!(text, "\n### {} (QEMU's `{machine}`)\n\n| | {heads} |", board.title);
    let _ = writeln!(text, "|---|{}", "---:|".repeat(images.len()));
    let mut row = |name: &str, cell: &dyn Fn(&Measured) -> String| {
        let cells: Vec<String> = images.iter().map(|image| cell(image)).collect();
        let _ = writeln!(text, "| {name} | {} |", cells.join(" | "));
    };
    row("static RAM: `.data`, KiB", &|image| kib(image.data));
    row("static RAM: `.bss`, KiB", &|image| kib(image.bss));
    row("stack, most in use, KiB", &|image| kib(image.stack));
    row("**RAM**, KiB", &|image| kib(image.ram() + image.stack));
    row("flash: code, KiB", &|image| kib(image.code));
    row("flash: constants, KiB", &|image| kib(image.constants));
    row("**flash without templates**, KiB", &|image| kib(image.flash()));
    row("flash: template set, KiB", &|image| kib(image.templates));
    let stages: Vec<&str> =
        images.first().map(|image| image.stages.iter().map(|(stage, ..)| stage.as_str()).collect()).unwrap_or_default();
    for stage in stages {
        let name = if stage == "whole frame" { "**whole frame**" } else { stage };
        row(name, &|image| match image.stages.iter().find(|(name, ..)| name == stage) {
            Some((_, three, average)) => format!("{} / {}", millions(*three), millions(*average)),
            None => String::new(),
        });
    }
}

/// A line for each board.
fn front(measured: &[Measured]) -> String {
    let mut text = String::from(
        "\n| | RAM, KiB: static + stack | flash, KiB: code and constants + template set | instructions, millions | the same in floats |\n\
         |---|---:|---:|---:|---:|\n",
    );
    for image in measured.iter().filter(|image| image.arithmetic == Arithmetic::Fixed) {
        let float = measured.iter().find(|one| one.board == image.board && one.arithmetic == Arithmetic::Float);
        let _ = writeln!(
            text,
            "| {} | {} + {} | {} + {} | {} | {} |",
            image.board.title,
            kib(image.ram()),
            kib(image.stack),
            kib(image.flash()),
            kib(image.templates),
            millions(image.instructions()),
            float.map_or_else(|| "no FPU".to_owned(), |float| millions(float.instructions())),
        );
    }
    text + "\n"
}

fn kib(bytes: u64) -> String {
    let tenths = (bytes * 10).div_ceil(1024);
    format!("{}.{}", tenths / 10, tenths % 10)
}

fn millions(instructions: u64) -> String {
    let hundredths = (instructions + 5_000) / 10_000;
    format!("{}.{:02}", hundredths / 100, hundredths % 100)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded() {
        assert_eq!([kib(0), kib(1), kib(1024), kib(6868)], ["0.0", "0.1", "1.0", "6.8"]);
        assert_eq!([millions(4_999), millions(104_934_999)], ["0.00", "104.93"]);
    }

    #[test]
    fn both_files_have_a_place_for_their_tables() {
        for path in [PAGE, FRONT] {
            let text = fs::read_to_string(root().join(path)).unwrap();
            let (_, rest) = text.split_once(BEGIN).expect(path);
            assert!(rest.contains(END), "{path}");
        }
    }
}
