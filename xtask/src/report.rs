//! Steps, what came of them, and the summary at the end.

use std::process::ExitCode;
use std::time::{Duration, Instant};

/// What came of a step; the text says why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Outcome {
    Passed,
    Failed(String),
    Skipped(String),
}

impl Outcome {
    /// For a step that lacks a tool: skipped, loudly, on a developer's machine; failed in CI, which must install it.
    pub(crate) fn missing_tool(why: String) -> Self {
        Self::missing_tool_if(why, in_ci())
    }

    fn missing_tool_if(why: String, in_ci: bool) -> Self {
        if in_ci { Self::Failed(why) } else { Self::Skipped(why) }
    }

    /// The next step's outcome if this one passed, else this one.
    pub(crate) fn and_then(self, next: impl FnOnce() -> Self) -> Self {
        if self == Self::Passed { next() } else { self }
    }
}

impl From<Result<(), String>> for Outcome {
    fn from(result: Result<(), String>) -> Self {
        result.map_or_else(Self::Failed, |()| Self::Passed)
    }
}

/// Whether this is CI: the variable `CI` is set, and not to nothing or `false`.
pub(crate) fn in_ci() -> bool {
    std::env::var_os("CI").is_some_and(|value| !value.is_empty() && value != "false")
}

/// The steps that have run.
#[derive(Debug, Default)]
pub(crate) struct Report {
    steps: Vec<(String, Outcome, Duration)>,
}

impl Report {
    /// Runs a step and keeps what came of it; a failure never stops the run.
    pub(crate) fn step(&mut self, name: impl Into<String>, run: impl FnOnce() -> Outcome) {
        let name = name.into();
        println!("\n=== {name}");
        let start = Instant::now();
        let outcome = run();
        let took = start.elapsed();
        match &outcome {
            Outcome::Passed => println!("passed: {name} in {:.1} s", took.as_secs_f64()),
            Outcome::Failed(why) => println!("FAILED: {name} in {:.1} s: {why}", took.as_secs_f64()),
            Outcome::Skipped(why) => println!("SKIPPED: {name} ({why})"),
        }
        self.steps.push((name, outcome, took));
    }

    /// Prints the table of steps, what failed and the counts; the process ends with the returned code.
    pub(crate) fn finish(&self) -> ExitCode {
        println!("\n{}", self.summary());
        if self.counts().1 == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
    }

    /// Passed, failed, skipped.
    fn counts(&self) -> (usize, usize, usize) {
        self.steps.iter().fold((0, 0, 0), |(passed, failed, skipped), (_, outcome, _)| match outcome {
            Outcome::Passed => (passed + 1, failed, skipped),
            Outcome::Failed(_) => (passed, failed + 1, skipped),
            Outcome::Skipped(_) => (passed, failed, skipped + 1),
        })
    }

    fn summary(&self) -> String {
        let mut text = String::from("=== steps\n");
        for (name, outcome, took) in &self.steps {
            let verdict = match outcome {
                Outcome::Passed => "passed",
                Outcome::Failed(_) => "FAILED",
                Outcome::Skipped(_) => "SKIPPED",
            };
            text += &format!("{verdict:>8} {:>7.1} s  {name}\n", took.as_secs_f64());
        }
        // What needs a reader's eye comes last, where it is seen.
        for (name, outcome, _) in &self.steps {
            match outcome {
                Outcome::Skipped(why) => text += &format!("SKIPPED: {name} ({why})\n"),
                Outcome::Failed(why) => text += &format!("FAILED: {name}: {why}\n"),
                Outcome::Passed => {}
            }
        }
        let (passed, failed, skipped) = self.counts();
        text + &format!("{passed} passed, {failed} failed, {skipped} skipped")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_runs_and_the_last_line_counts_them() {
        let mut report = Report::default();
        report.step("a", || Outcome::Failed("no luck".into()));
        report.step("b", || Outcome::Passed);
        report.step("c", || Outcome::Skipped("no tool".into()));
        let summary = report.summary();
        assert!(summary.contains("FAILED: a: no luck\n"), "{summary}");
        assert!(summary.contains("SKIPPED: c (no tool)\n"), "{summary}");
        assert_eq!(summary.lines().last(), Some("1 passed, 1 failed, 1 skipped"));
    }

    #[test]
    fn a_missing_tool_fails_in_ci_only() {
        assert_eq!(Outcome::missing_tool_if("x".into(), false), Outcome::Skipped("x".into()));
        assert_eq!(Outcome::missing_tool_if("x".into(), true), Outcome::Failed("x".into()));
    }
}
