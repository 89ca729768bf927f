//! The fuzz targets of `tests/fuzz`, one after another, each starting from its corpus.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::process::{cargo, program, root, run as run_command, shown, succeeds, target_dir};
use crate::report::{Outcome, Report};

const FOLDER: &str = "tests/fuzz";

/// What each run is held to: megabytes in all and at once, seconds for an input.
const LIMITS: [&str; 3] = ["-rss_limit_mb=2048", "-malloc_limit_mb=512", "-timeout=20"];

/// What to run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Options {
    /// The corpus alone, without a fuzzer.
    Corpus,
    /// Each target for some seconds; no target named: all.
    Search { seconds: u32, targets: Vec<String> },
}

impl Options {
    /// From the words behind `fuzz`; `None` where they make no sense.
    pub(crate) fn parse(words: &[&str]) -> Option<Self> {
        if words == ["--corpus"] {
            return Some(Self::Corpus);
        }
        let (mut seconds, mut targets) = (60, Vec::new());
        let mut words = words.iter();
        while let Some(word) = words.next() {
            match *word {
                "--seconds" => seconds = words.next()?.parse().ok().filter(|n| *n > 0)?,
                option if option.starts_with('-') => return None,
                target => targets.push(target.to_owned()),
            }
        }
        Some(Self::Search { seconds, targets })
    }
}

/// One step for the corpus, or for each target.
pub(crate) fn run(report: &mut Report, options: &Options) {
    let (seconds, named) = match options {
        Options::Corpus => {
            report.step("fuzz targets on their corpus", || {
                run_command(&mut cargo("test --locked -p pldi-host --test fuzz"))
            });
            return;
        }
        Options::Search { seconds, targets } => (*seconds, targets),
    };
    let mut binaries = PathBuf::new();
    report.step("fuzz targets, build", || match build() {
        Ok(folder) => {
            binaries = folder;
            Outcome::Passed
        }
        Err(outcome) => outcome,
    });
    if binaries.as_os_str().is_empty() {
        return;
    }
    let mut found = Vec::new();
    let all = targets();
    for target in if named.is_empty() { &all } else { named } {
        report.step(format!("fuzz target {target}, {seconds} s"), || {
            let binary = binaries.join(target);
            if !binary.exists() {
                return Outcome::Failed(format!("there is no such target; there are {}", all.join(", ")));
            }
            match search(target, &binary, seconds) {
                Ok(run) => {
                    println!("{run}");
                    found.push(format!("{target:<16} {run}"));
                    Outcome::from(run.verdict(target))
                }
                Err(why) => Outcome::Failed(why),
            }
        });
    }
    println!("\n{}", found.join("\n"));
}

/// The names of all targets.
fn targets() -> Vec<String> {
    let files = fs::read_dir(root().join(FOLDER).join("fuzz_targets")).into_iter().flatten().flatten();
    let mut names: Vec<String> = files.filter_map(|file| Some(file.path().file_stem()?.to_str()?.to_owned())).collect();
    names.sort();
    names
}

/// Builds all targets with the address sanitizer; where they are then.
fn build() -> Result<PathBuf, Outcome> {
    if !succeeds(&mut cargo("fuzz --version")) {
        let why = "install it with 'cargo install cargo-fuzz --locked'; libFuzzer needs a C++ compiler";
        return Err(Outcome::missing_tool(why.into()));
    }
    let folder = target_dir().join("fuzz");
    let mut command = cargo("fuzz build --fuzz-dir");
    // The sanitizers' flags are unstable; a stable compiler has them all the same.
    command.arg(FOLDER).arg("--target-dir").arg(&folder).env("RUSTC_BOOTSTRAP", "1");
    match run_command(&mut command) {
        Outcome::Passed => {}
        failed => return Err(failed),
    }
    let host = program(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into())).arg("-vV").output();
    let host = host.ok().and_then(|output| {
        let text = String::from_utf8(output.stdout).ok()?;
        text.lines().find_map(|line| line.strip_prefix("host: ").map(str::to_owned))
    });
    let host = host.ok_or_else(|| Outcome::Failed("rustc does not say what it runs on".into()))?;
    Ok(folder.join(host).join("release"))
}

/// What came of a run.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct Run {
    executions: u64,
    /// Edges and features that the inputs reach.
    coverage: u64,
    features: u64,
    /// Inputs that reach something new; they stay in the target folder, where the next run starts from them.
    new_inputs: u64,
    peak_mb: u64,
    /// The file of the input that it ended with.
    crash: Option<String>,
    ended_well: bool,
}

impl Run {
    /// From what libFuzzer prints.
    fn read(log: &str, ended_well: bool) -> Self {
        let mut run = Self { ended_well, ..Self::default() };
        for line in log.lines() {
            let number = |name: &str| {
                let mut words = line.split_whitespace().skip_while(|word| *word != name).skip(1);
                words.next().and_then(|word| word.parse().ok())
            };
            if line.starts_with('#') {
                run.coverage = number("cov:").unwrap_or(run.coverage);
                run.features = number("ft:").unwrap_or(run.features);
            }
            run.executions = number("stat::number_of_executed_units:").unwrap_or(run.executions);
            run.new_inputs = number("stat::new_units_added:").unwrap_or(run.new_inputs);
            run.peak_mb = number("stat::peak_rss_mb:").unwrap_or(run.peak_mb);
            if let Some((_, file)) = line.split_once("Test unit written to ") {
                run.crash = Some(file.trim().to_owned());
            }
        }
        run
    }

    fn verdict(&self, target: &str) -> Result<(), String> {
        match &self.crash {
            Some(file) => Err(format!(
                "see {file}; when it is mended, the input goes to {FOLDER}/corpus/{target} with a test beside the reader"
            )),
            None if !self.ended_well => Err("the fuzzer did not end well: see its log".into()),
            None => Ok(()),
        }
    }
}

impl std::fmt::Display for Run {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { executions, coverage, features, new_inputs, peak_mb, .. } = self;
        let crashes = u8::from(self.crash.is_some());
        write!(
            f,
            "{executions} executions, coverage {coverage} edges and {features} features, {new_inputs} new inputs, \
             {peak_mb} MB, {crashes} crashes"
        )
    }
}

/// Runs a target. What it finds goes to the target folder: the committed corpus stays as it is.
fn search(target: &str, binary: &Path, seconds: u32) -> Result<Run, String> {
    let folder = target_dir().join("fuzz");
    let [found, crashes] = ["found", "crashes"].map(|name| folder.join(name).join(target));
    for folder in [&found, &crashes] {
        fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    }
    let log = folder.join(format!("{target}.log"));
    let written = File::create(&log).map_err(|error| format!("{}: {error}", log.display()))?;
    let mut command: Command = program(binary);
    command.arg(&found).arg(root().join(FOLDER).join("corpus").join(target));
    let dictionary = root().join(FOLDER).join("dictionaries").join(target);
    if dictionary.exists() {
        command.arg(format!("-dict={}", dictionary.display()));
    }
    command.arg(format!("-artifact_prefix={}/", crashes.display())).arg(format!("-max_total_time={seconds}"));
    command.args(["-print_final_stats=1", "-max_len=65536"]).args(LIMITS);
    // As cargo-fuzz sets it.
    command.env("ASAN_OPTIONS", "detect_odr_violation=0");
    println!("$ {} 2> {}", shown(&command), log.display());
    let status = command.stdout(Stdio::null()).stderr(written).status().map_err(|error| error.to_string())?;
    let text = fs::read(&log).map_err(|error| format!("{}: {error}", log.display()))?;
    let text = String::from_utf8_lossy(&text);
    let run = Run::read(&text, status.success());
    if !status.success() {
        let from = text.lines().position(|line| line.contains("panicked at") || line.contains("ERROR:")).unwrap_or(0);
        text.lines().skip(from).take(12).for_each(|line| println!("{line}"));
    }
    Ok(run)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOG: &str = "\
INFO: seed corpus: files: 5 min: 11b max: 131b total: 421b rss: 41Mb
#6\tINITED cov: 401 ft: 733 corp: 5/421b exec/s: 0 rss: 44Mb
#1048576\tpulse  cov: 512 ft: 1733 corp: 98/4Kb lim: 4096 exec/s: 9000 rss: 400Mb
#2097152\tDONE   cov: 514 ft: 1740 corp: 99/4Kb lim: 4096 exec/s: 9000 rss: 401Mb
Done 2097152 runs in 61 second(s)
stat::number_of_executed_units: 2097152
stat::average_exec_per_sec:     34379
stat::new_units_added:          188
stat::slowest_unit_time_sec:    0
stat::peak_rss_mb:              401
";

    #[test]
    fn what_libfuzzer_prints_is_understood() {
        let run = Run::read(LOG, true);
        let (executions, coverage, features, new_inputs, peak_mb) = (2_097_152, 514, 1740, 188, 401);
        let expected = Run { executions, coverage, features, new_inputs, peak_mb, crash: None, ended_well: true };
        assert_eq!((&run, run.verdict("off")), (&expected, Ok(())));
        let crashed = format!("{LOG}artifact_prefix='x/'; Test unit written to x/crash-da39\n");
        let run = Run::read(&crashed, false);
        assert!(run.verdict("off").unwrap_err().contains("x/crash-da39"), "{run}");
        assert!(Run::read("", false).verdict("off").is_err());
    }

    #[test]
    fn words_are_understood() {
        let search = |seconds, targets: &[&str]| {
            Some(Options::Search { seconds, targets: targets.iter().map(|&t| t.to_owned()).collect() })
        };
        assert_eq!(Options::parse(&[]), search(60, &[]));
        assert_eq!(Options::parse(&["ply", "--seconds", "5", "off"]), search(5, &["ply", "off"]));
        assert_eq!(Options::parse(&["--corpus"]), Some(Options::Corpus));
        for wrong in [&["--seconds"][..], &["--seconds", "0"], &["--seconds", "x"], &["--fast"], &["--corpus", "ply"]] {
            assert_eq!(Options::parse(wrong), None, "{wrong:?}");
        }
        assert!(targets().contains(&"serial_device".to_owned()));
    }
}
