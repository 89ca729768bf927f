//! Golden data: files that are generated, committed, and checked for drift.

use std::fs;
use std::path::{Path, PathBuf};

use crate::process::{cargo, root, run as run_command, target_dir};
use crate::report::{Outcome, Report};

/// A committed file and the command that makes it.
struct Artefact {
    /// Where it is committed, from the root.
    path: &'static str,
    /// Arguments of cargo; the output's path is added as the last.
    cargo: &'static str,
}

/// All golden data. To add one: a line here, `cargo xtask golden`, commit what it wrote.
const ARTEFACTS: &[Artefact] = &[
    Artefact {
        path: "pldi-host/assets/furniture.pldt",
        cargo: "run --release --quiet --locked -p pldi-host -- templates build --procedural --distance 2,3 -o",
    },
    // Made with the templates above.
    Artefact {
        path: "tests/golden/digests.txt",
        cargo: "run --release --quiet --locked -p pldi-host --example digests --",
    },
];

/// What is done with what was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mode {
    /// It takes the place of what is committed.
    Renew,
    /// It is compared with what is committed, which is left as it is.
    Check,
}

/// One step for each artefact.
pub(crate) fn run(report: &mut Report, mode: Mode) {
    ARTEFACTS.iter().for_each(|artefact| step(report, mode, artefact));
}

/// The check sums of what every stage leaves behind: a single bit that changes in any of them is noticed.
pub(crate) fn digests(report: &mut Report) {
    let digests = ARTEFACTS.iter().filter(|artefact| artefact.path.ends_with("digests.txt"));
    digests.for_each(|artefact| step(report, Mode::Check, artefact));
}

fn step(report: &mut Report, mode: Mode, artefact: &Artefact) {
    report.step(format!("golden data {}", artefact.path), || {
        let committed = root().join(artefact.path);
        let made = target_dir().join("golden").join(artefact.path);
        prepare(&made)
            .and_then(|| run_command(cargo(artefact.cargo).arg(&made)))
            .and_then(|| settle(mode, &committed, &made).into())
    });
}

/// Makes the folder, and removes what an earlier run left: it must not pass for this one's output.
fn prepare(made: &Path) -> Outcome {
    let folder = made.parent().map(PathBuf::from).unwrap_or_default();
    let result = fs::create_dir_all(folder).and_then(|()| if made.exists() { fs::remove_file(made) } else { Ok(()) });
    result.map_err(|error| format!("{}: {error}", made.display())).into()
}

fn settle(mode: Mode, committed: &Path, made: &Path) -> Result<(), String> {
    let new = fs::read(made).map_err(|error| format!("the command wrote no {}: {error}", made.display()))?;
    let old = fs::read(committed);
    let relative = committed.strip_prefix(root()).unwrap_or(committed).display();
    match mode {
        Mode::Renew if old.as_ref().is_ok_and(|old| *old == new) => println!("{relative}: as it was"),
        Mode::Renew => {
            let folder = committed.parent().map(PathBuf::from).unwrap_or_default();
            fs::create_dir_all(folder)
                .and_then(|()| fs::write(committed, &new))
                .map_err(|error| format!("{relative}: {error}"))?;
            println!("{relative}: renewed, {} bytes", new.len());
        }
        Mode::Check => {
            let old = old.map_err(|error| format!("{relative}: {error}; `cargo xtask golden` makes it"))?;
            if let Some(difference) = difference(&old, &new) {
                return Err(format!(
                    "{relative} is not what the code makes: {difference}; if that is meant, `cargo xtask golden` and commit it"
                ));
            }
            println!("{relative}: {} bytes, no drift", new.len());
        }
    }
    Ok(())
}

/// Where two files part, in words; `None` if they are the same.
pub(crate) fn difference(old: &[u8], new: &[u8]) -> Option<String> {
    let lengths = if old.len() == new.len() {
        String::new()
    } else {
        format!(" ({} bytes committed, {} made)", old.len(), new.len())
    };
    let first = old.iter().zip(new).position(|(a, b)| a != b);
    match first {
        Some(offset) => Some(format!("they part at byte {offset}{lengths}")),
        None if old.len() == new.len() => None,
        None => Some(format!("one is the beginning of the other{lengths}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drift_is_named() {
        assert_eq!(difference(b"abc", b"abc"), None);
        assert_eq!(difference(b"abc", b"abd").unwrap(), "they part at byte 2");
        let cut = difference(b"abc", b"ab").unwrap();
        assert_eq!(cut, "one is the beginning of the other (3 bytes committed, 2 made)");
    }

    #[test]
    fn checking_leaves_what_is_committed_and_renewing_replaces_it() {
        let folder = std::env::temp_dir().join(format!("xtask-golden-{}", std::process::id()));
        let (committed, made) = (folder.join("assets/a.bin"), folder.join("b.bin"));
        fs::create_dir_all(&folder).unwrap();
        fs::write(&made, b"new").unwrap();
        let missing = settle(Mode::Check, &committed, &made).unwrap_err();
        assert!(missing.contains("cargo xtask golden"), "{missing}");
        settle(Mode::Renew, &committed, &made).unwrap();
        settle(Mode::Check, &committed, &made).unwrap();
        fs::write(&made, b"newer").unwrap();
        assert!(settle(Mode::Check, &committed, &made).is_err());
        assert_eq!(fs::read(&committed).unwrap(), b"new");
        fs::remove_dir_all(&folder).unwrap();
    }
}
