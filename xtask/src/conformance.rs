//! Conformance: first the suite in `tests/conformance`, then the stages of `pldi` against the reference, number by number,
//! on real recordings.
//!
//! The recordings and the reference (float64, Python) lie beside the checkout and are not part of the repository.
//! The command writes what each stage gave; `tests/judge/compare.py` computes the same with the reference.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::process::{cargo, program, root, run as run_command, succeeds, target_dir};
use crate::report::{Outcome, Report};

/// What the judge imports.
const MODULES: &str = "import numpy, scipy, numba, pywt, cv2";

/// What the suite does with `docs/conformance.md`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Document {
    /// It is written anew.
    Renew,
    /// It is compared with what is measured.
    Check,
}

/// The suite: stages against their truth in float64 and fixed point against float. One step.
pub(crate) fn suite(report: &mut Report, document: Document) {
    report.step("conformance suite", || {
        let mut command = cargo("test --release --locked --quiet -p pldi-host --test conformance --");
        if document == Document::Renew {
            command.arg("--renew");
        }
        run_command(&mut command)
    });
}

/// The reference's judgement. One step.
pub(crate) fn run(report: &mut Report) {
    report.step("conformance with the reference", || {
        let shared = root().join("../shared");
        let (recordings, reference) = (shared.join("data/recordings"), shared.join("reference"));
        if !recordings.is_dir() || !reference.is_dir() {
            return Outcome::Skipped("no recordings or no reference in ../shared".into());
        }
        let Some(python) = python() else {
            return Outcome::missing_tool(
                "no Python with the judge's modules: make target/judge-venv with tests/judge/requirements.txt, \
                 or set PLDI_PYTHON"
                    .into(),
            );
        };
        match cases(&recordings) {
            Ok(cases) => judge(&python, &reference, &cases),
            Err(why) => Outcome::Failed(why),
        }
    });
}

/// One frame of one recording.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Case {
    recording: PathBuf,
    frame: usize,
}

impl Case {
    /// Where the command writes this frame's stages.
    fn output(&self) -> PathBuf {
        let name = self.recording.file_name().unwrap_or_default().to_string_lossy();
        target_dir().join("conformance").join(format!("{name}-{}", self.frame))
    }
}

/// The first and the last frame of each recording.
fn cases(recordings: &Path) -> Result<Vec<Case>, String> {
    let entries = fs::read_dir(recordings).map_err(|error| format!("{}: {error}", recordings.display()))?;
    let mut folders: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(|path| path.is_dir()).collect();
    folders.sort();
    let mut cases = Vec::new();
    for recording in folders {
        let frames = frames(&recording)?;
        let last = frames.checked_sub(1).ok_or_else(|| format!("{}: no frame", recording.display()))?;
        cases.push(Case { recording: recording.clone(), frame: 0 });
        if last > 0 {
            cases.push(Case { recording, frame: last });
        }
    }
    if cases.is_empty() { Err(format!("{}: no recording", recordings.display())) } else { Ok(cases) }
}

/// Number of frames in a recording: lines of `associations.txt`, or of `depth.txt` where there is no colour.
fn frames(recording: &Path) -> Result<usize, String> {
    let lists = ["associations.txt", "depth.txt"].map(|name| recording.join(name));
    let list = lists.iter().find(|list| list.exists()).ok_or_else(|| format!("{}: no frames", recording.display()))?;
    let text = fs::read_to_string(list).map_err(|error| format!("{}: {error}", list.display()))?;
    Ok(count_lines(&text))
}

fn count_lines(list: &str) -> usize {
    list.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#')).count()
}

/// A Python that has the judge's modules.
fn python() -> Option<OsString> {
    let candidates = match std::env::var_os("PLDI_PYTHON") {
        Some(python) => vec![python],
        None => vec![root().join("target/judge-venv/bin/python").into_os_string(), "python3".into()],
    };
    candidates.into_iter().find(|python| succeeds(program(python).args(["-c", MODULES])))
}

fn judge(python: &OsString, reference: &Path, cases: &[Case]) -> Outcome {
    run_command(&mut cargo("build --release --locked -p pldi-host --bin pldi")).and_then(|| {
        // All frames, whatever came of one, so that one run shows all that is wrong.
        let failures: Vec<String> = cases.iter().filter_map(|case| stages(case).err()).collect();
        if !failures.is_empty() {
            return Outcome::Failed(failures.join("; "));
        }
        match run_command(&mut judge_command(python, reference, cases)) {
            // The command line names every case: too long for the summary.
            Outcome::Failed(_) => Outcome::Failed("see the judge's rows above, those marked FAILED".into()),
            other => other,
        }
    })
}

fn stages(case: &Case) -> Result<(), String> {
    let output = case.output();
    // What an earlier run left must not pass for this one's output.
    if output.exists() {
        fs::remove_dir_all(&output).map_err(|error| format!("{}: {error}", output.display()))?;
    }
    fs::create_dir_all(&output).map_err(|error| format!("{}: {error}", output.display()))?;
    let mut command = program(target_dir().join("release/pldi"));
    command.arg("stages").arg(&case.recording).arg("--frame").arg(case.frame.to_string()).arg("--out").arg(output);
    match run_command(&mut command) {
        Outcome::Failed(why) => Err(why),
        Outcome::Passed | Outcome::Skipped(_) => Ok(()),
    }
}

fn judge_command(python: &OsString, reference: &Path, cases: &[Case]) -> Command {
    let mut command = program(python);
    command.arg("tests/judge/compare.py").arg("--reference").arg(reference);
    command.arg("--json").arg(target_dir().join("conformance/report.json")).arg("--require-views");
    for case in cases {
        command.arg("--case").arg(&case.recording).arg(case.frame.to_string()).arg(case.output());
    }
    // Compiled once, not in every run.
    command.env("NUMBA_CACHE_DIR", target_dir().join("judge-cache"));
    command
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_empty_lines_are_no_frames() {
        assert_eq!(count_lines("# timestamp filename\n0.0 depth/0.png\n\n0.1 depth/1.png\n"), 2);
        assert_eq!(count_lines(""), 0);
    }

    #[test]
    fn first_and_last_frame_of_each_recording() {
        let folder = std::env::temp_dir().join(format!("xtask-cases-{}", std::process::id()));
        for (name, list, text) in [("b", "associations.txt", "1\n2\n3\n"), ("a", "depth.txt", "# x\n1\n")] {
            fs::create_dir_all(folder.join(name)).unwrap();
            fs::write(folder.join(name).join(list), text).unwrap();
        }
        let found: Vec<_> = cases(&folder)
            .unwrap()
            .into_iter()
            .map(|case| (case.recording.file_name().unwrap().to_string_lossy().into_owned(), case.frame))
            .collect();
        assert_eq!(found, [("a".into(), 0), ("b".into(), 0), ("b".into(), 2)]);
        fs::create_dir_all(folder.join("c")).unwrap();
        assert!(cases(&folder).unwrap_err().contains("no frames"));
        fs::remove_dir_all(&folder).unwrap();
    }
}
