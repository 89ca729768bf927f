//! An image's output beside the host's digests and beside what is committed.

use std::fs;
use std::path::PathBuf;

use super::Arithmetic;
use super::output::{Frame, Run};
use crate::process::root;

/// The host's digests, from the root.
const GOLDEN: &str = "tests/golden/digests.txt";

/// Where an arithmetic's output is committed, from the root: that of all frames, the same for every board.
fn committed(arithmetic: Arithmetic) -> String {
    format!("tests/firmware/out/{}.out", arithmetic.name())
}

/// What differs from the host: every digest of every frame, and which frames there are (`wanted`, or all).
pub(crate) fn with_host(run: &Run, arithmetic: Arithmetic, wanted: Option<&[usize]>) -> Vec<String> {
    match fs::read_to_string(root().join(GOLDEN)) {
        Ok(golden) => host(&golden, run, arithmetic, wanted),
        Err(error) => vec![format!("{GOLDEN}: {error}")],
    }
}

fn host(golden: &str, run: &Run, arithmetic: Arithmetic, wanted: Option<&[usize]>) -> Vec<String> {
    let stages: Vec<&str> = golden
        .lines()
        .take_while(|line| line.starts_with('#'))
        .last()
        .map(|line| line.trim_start_matches('#').split_whitespace().collect())
        .unwrap_or_default();
    let mark = format!(" {} ", arithmetic.name());
    let lines: Vec<(&str, Vec<&str>)> = golden
        .lines()
        .filter(|line| !line.starts_with('#'))
        .filter_map(|line| line.split_once(mark.as_str()))
        .map(|(name, digests)| (name, digests.split_whitespace().collect()))
        .collect();
    let all: Vec<usize> = (0..lines.len()).collect();
    let wanted = wanted.unwrap_or(&all);
    let mut failures = Vec::new();
    if run.frames.len() != wanted.len() {
        failures.push(format!("{} frames were run, not {}", run.frames.len(), wanted.len()));
    }
    for (index, frame) in wanted.iter().zip(&run.frames) {
        let Some((name, digests)) = lines.get(*index) else {
            failures.push(format!("{GOLDEN} has no frame {index}"));
            continue;
        };
        let expected: Vec<(&str, &str)> = stages.iter().copied().zip(digests.iter().copied()).collect();
        if frame.name != format!("{name} {}", arithmetic.name()) {
            failures.push(format!("frame {index} is '{}', not '{name}'", frame.name));
            continue;
        }
        if frame.digests().len() != expected.len() {
            failures.push(format!("{name}: {} digests, not {}", frame.digests().len(), expected.len()));
        }
        failures.extend(
            expected.iter().zip(frame.digests()).filter(|(host, image)| **host != *image).map(
                |((stage, host), (_, image))| format!("{name}: digest of {stage} is {image}, the host's is {host}"),
            ),
        );
    }
    failures
}

/// What differs from the committed output, frame by frame; `overwrite` commits the run's in its place.
pub(crate) fn with_committed(run: &Run, arithmetic: Arithmetic, overwrite: bool) -> Vec<String> {
    let name = committed(arithmetic);
    let path: PathBuf = root().join(&name);
    if overwrite {
        let written = fs::create_dir_all(path.parent().unwrap_or(&path)).and_then(|()| fs::write(&path, text(run)));
        return written.err().map(|error| format!("{name}: {error}")).into_iter().collect();
    }
    match fs::read_to_string(&path) {
        Ok(old) => frames(&old, run).into_iter().map(|what| format!("{name}: {what}")).collect(),
        Err(error) => vec![format!("{name}: {error}; `cargo xtask firmware --all --overwrite` makes it")],
    }
}

/// A frame as it is committed: its name and its lines.
fn block(frame: &Frame) -> String {
    format!("{}\n{}\n", frame.name, frame.lines.join("\n"))
}

fn text(run: &Run) -> String {
    run.frames.iter().map(block).collect::<Vec<_>>().join("\n")
}

fn frames(old: &str, run: &Run) -> Vec<String> {
    let old: Vec<&str> = old.split("\n\n").map(str::trim_end).collect();
    let first = |text: &str| text.lines().next().unwrap_or_default().to_owned();
    let difference = |frame: &Frame| {
        let new = block(frame);
        let Some(old) = old.iter().find(|old| first(old) == frame.name) else {
            return Some(format!("'{}' is not in it", frame.name));
        };
        let parted = old.lines().zip(new.lines()).find(|(old, new)| old != new);
        match parted {
            Some((old, new)) => Some(format!("{}: '{old}' is now '{new}'", frame.name)),
            None if old.lines().count() != new.lines().count() => {
                Some(format!("{}: lines were added or lost", frame.name))
            }
            None => None,
        }
    };
    run.frames.iter().filter_map(difference).collect()
}

#[cfg(test)]
mod tests {
    use super::super::output::EXAMPLE;
    use super::*;

    const HOST: &str = "# CRC\n# depth floor\nthree candidates float 0 1\nthree candidates fixed 4ce1fbc3 b89ec569\nroom 4 fixed 2a36b81e 2\n";

    #[test]
    fn a_digest_that_differs_is_named_with_its_frame() {
        let mut run = Run::parse(EXAMPLE).unwrap();
        run.frames.truncate(1);
        assert!(host(HOST, &run, Arithmetic::Fixed, Some(&[0])).is_empty());
        let short = host(HOST, &run, Arithmetic::Fixed, None);
        assert_eq!(short, ["1 frames were run, not 2"]);
        run.frames[0].lines[2] = "digest floor 1".to_owned();
        let [failure] = &host(HOST, &run, Arithmetic::Fixed, Some(&[0]))[..] else { panic!("one") };
        assert!(failure.contains("three candidates") && failure.contains("floor"), "{failure}");
        assert_eq!(host(HOST, &run, Arithmetic::Fixed, Some(&[1])).len(), 1);
    }

    #[test]
    fn committed_output_is_compared_frame_by_frame() {
        let run = Run::parse(EXAMPLE).unwrap();
        let old = text(&run);
        assert!(frames(&old, &run).is_empty());
        let mut part = run.clone();
        part.frames.pop();
        assert!(frames(&old, &part).is_empty());
        part.frames[0].lines[0].push('x');
        assert!(frames(&old, &part)[0].contains("is now"));
        part.frames[0].lines[0].pop();
        part.frames[0].lines.pop();
        assert!(frames(&old, &part)[0].contains("lost"));
        part.frames[0].name.push('x');
        assert!(frames(&old, &part)[0].contains("not in it"));
    }
}
