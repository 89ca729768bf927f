//! The image that logs through defmt: its events, decoded, beside those that are committed.

use std::fs::{self, File};
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use super::{Board, build, data, qemu};
use crate::process::{cargo, root, shown, target_dir};
use crate::report::{Outcome, Report};

/// The committed events, from the root: without their times, which are counts of instructions.
const COMMITTED: &str = "tests/firmware/out/log.out";

/// How long the image may run.
const LIMIT: Duration = Duration::from_secs(60);

/// One step. `overwrite` commits what the image logs.
pub(crate) fn run(report: &mut Report, overwrite: bool) {
    report.step("firmware: log through defmt", || step(overwrite).unwrap_or_else(|outcome| outcome));
}

fn step(overwrite: bool) -> Result<Outcome, Outcome> {
    let board = Board::of("an500").ok_or_else(|| Outcome::Failed("an500 is no board".to_owned()))?;
    let image = build(board, "log", "log")?;
    let frames = data::folder()?.join("frames.bin");
    let stream = qemu::bytes(&mut qemu::command(board, &image, &[&frames.to_string_lossy()])?, LIMIT);
    let text = decode(&image, &stream.map_err(Outcome::Failed)?).map_err(Outcome::Failed)?;
    print!("{text}");
    Ok(compare(&without_times(&text), overwrite).into())
}

/// The events in a stream, one a line.
fn decode(image: &Path, stream: &[u8]) -> Result<String, String> {
    let failed = |error: std::io::Error| format!("defmt's stream: {error}");
    let path = image.with_extension("defmt");
    fs::write(&path, stream).map_err(failed)?;
    let mut command = cargo("run --quiet --locked --manifest-path tests/firmware/decode/Cargo.toml");
    command.arg("--target-dir").arg(target_dir().join("firmware/decode")).arg("--").arg(image);
    println!("$ {} < {}", shown(&command), path.display());
    command.stdin(File::open(&path).map_err(failed)?).stderr(Stdio::inherit());
    let output = command.output().map_err(failed)?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() {
        Ok(text)
    } else {
        Err(format!("`{}`: {}; it said\n{text}", shown(&command), output.status))
    }
}

/// Drops the first word of each line.
fn without_times(text: &str) -> String {
    text.lines().map(|line| format!("{}\n", line.split_once(' ').map_or(line, |(_, event)| event))).collect()
}

fn compare(new: &str, overwrite: bool) -> Result<(), String> {
    let path = root().join(COMMITTED);
    if overwrite {
        return fs::write(path, new).map_err(|error| format!("{COMMITTED}: {error}"));
    }
    let old = fs::read_to_string(path).map_err(|error| format!("{COMMITTED}: {error}"))?;
    difference(&old, new).map_or(Ok(()), |what| Err(format!("{COMMITTED}: {what}")))
}

/// The first line that differs, if one does.
fn difference(old: &str, new: &str) -> Option<String> {
    let (old, new): (Vec<_>, Vec<_>) = (old.lines().collect(), new.lines().collect());
    let first = (0..old.len().max(new.len())).find(|i| old.get(*i) != new.get(*i))?;
    let line = |lines: &[&str]| lines.get(first).map_or("nothing".to_owned(), |line| format!("'{line}'"));
    Some(format!("line {}: {} is now {}", first + 1, line(&old), line(&new)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_left_out() {
        assert_eq!(without_times("12 info a b\n7 warn c\n"), "info a b\nwarn c\n");
    }

    #[test]
    fn the_first_difference_is_told() {
        assert_eq!(difference("a\nb\n", "a\nb\n"), None);
        assert_eq!(difference("a\nb\n", "a\nc\n").unwrap(), "line 2: 'b' is now 'c'");
        assert_eq!(difference("a\n", "a\nc\n").unwrap(), "line 2: nothing is now 'c'");
        assert_eq!(difference("a\nb\n", "a\n").unwrap(), "line 2: 'b' is now nothing");
    }
}
