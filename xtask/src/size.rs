//! The memory plan: printed, and compared with what the documentation says.

use std::fs;
use std::process::Stdio;

use crate::golden::{self, Mode};
use crate::process::{cargo, root};
use crate::report::{Outcome, Report};

/// Where the plan is committed, from the root.
const PAGE: &str = "docs/memory.md";

/// One step.
pub(crate) fn run(report: &mut Report, mode: Mode) {
    report.step("memory plan", || {
        let mut command = cargo("run --quiet --locked -p pldi-core --example memory_plan");
        let output = match command.stderr(Stdio::inherit()).output() {
            Ok(output) if output.status.success() => output.stdout,
            Ok(output) => return Outcome::Failed(format!("the plan could not be printed: {}", output.status)),
            Err(error) => return Outcome::Failed(format!("cargo: {error}")),
        };
        print!("{}", String::from_utf8_lossy(&output));
        let page = root().join(PAGE);
        match mode {
            Mode::Renew => fs::write(&page, &output).map_err(|error| format!("{PAGE}: {error}")).into(),
            Mode::Check => match fs::read(&page) {
                Ok(old) => golden::difference(&old, &output).map_or(Outcome::Passed, |difference| {
                    Outcome::Failed(format!("{PAGE} is out of date: {difference}; `cargo xtask size --renew`"))
                }),
                Err(error) => Outcome::Failed(format!("{PAGE}: {error}; `cargo xtask size --renew` makes it")),
            },
        }
    });
}
