//! Instructions of each stage in both arithmetics, counted by valgrind: the same numbers on every run, whatever else the
//! machine does.

use std::path::Path;
use std::process::Stdio;

use crate::process::{cargo, program, run as run_command, succeeds, target_dir};
use crate::report::{Outcome, Report};

/// The stages that the example knows.
const STAGES: [&str; 7] =
    ["reconstruct", "floor", "ground", "diffusion", "views and descriptors", "matching", "whole frame"];

/// One step, which prints a table in Markdown.
pub(crate) fn run(report: &mut Report) {
    report.step("instructions of the stages", || {
        if !succeeds(program("valgrind").arg("--version")) {
            return Outcome::missing_tool("valgrind counts the instructions: install it".into());
        }
        run_command(&mut cargo("build --release --locked -p pldi-host --example one_stage")).and_then(|| table().into())
    });
}

fn table() -> Result<(), String> {
    let binary = target_dir().join("release/examples/one_stage");
    let frame = target_dir().join("one_stage.frame");
    for arguments in [&["prepare"][..], &["float", "none", "0"]] {
        let status = program(&binary).args(arguments).arg(&frame).status();
        if !status.as_ref().is_ok_and(std::process::ExitStatus::success) {
            return Err(format!("{}: {status:?}", binary.display()));
        }
    }
    println!("| stage | float, million | fixed, million | fixed / float |\n|---|---:|---:|---:|");
    for stage in STAGES {
        // The difference of two runs is what a run of the stage alone takes.
        let count = |arithmetic: &str| -> Result<f64, String> {
            let of = |times: &str| instructions(&binary, &[arithmetic, stage, times], &frame);
            Ok((of("3")? - of("1")?) as f64 / 2e6)
        };
        let (float, fixed) = (count("float")?, count("fixed")?);
        println!("| {stage} | {float:.2} | {fixed:.2} | {:.2} |", fixed / float);
    }
    Ok(())
}

/// Instructions of a whole run of the program.
fn instructions(binary: &Path, arguments: &[&str], frame: &Path) -> Result<i64, String> {
    let mut command = program("valgrind");
    command.arg("--tool=callgrind").arg("--callgrind-out-file=/dev/null").arg(binary).args(arguments).arg(frame);
    let output = command.stdout(Stdio::null()).output().map_err(|error| format!("valgrind: {error}"))?;
    let text = String::from_utf8_lossy(&output.stderr);
    let line = text.lines().find_map(|line| line.split_once("Collected :"));
    line.and_then(|(_, count)| count.trim().parse().ok()).ok_or_else(|| format!("valgrind printed no count: {text}"))
}
