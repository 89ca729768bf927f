//! What the end-to-end tests share: the binary, a small recording made once, real recordings where they are present.

#![allow(dead_code, reason = "each test binary uses its own part")]

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use pldi_fixtures::{Recording, write_tum};
use serde_json::Value;
use tempfile::TempDir;

/// What a finished command left.
#[derive(Debug)]
pub struct Outcome {
    pub code: Option<i32>,
    pub stdout: Vec<u8>,
    pub stderr: String,
}

impl Outcome {
    /// The JSON lines on stdout; an incomplete line fails the test.
    pub fn lines(&self) -> Vec<Value> {
        lines(&self.stdout)
    }

    /// Fails the test unless the command succeeded.
    #[track_caller]
    pub fn ok(self) -> Self {
        assert_eq!(self.code, Some(0), "{}", self.stderr);
        self
    }

    /// The one JSON value on stdout.
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.stdout).expect("JSON on stdout")
    }
}

/// Complete JSON lines.
pub fn lines(bytes: &[u8]) -> Vec<Value> {
    assert!(bytes.is_empty() || bytes.ends_with(b"\n"), "the last line is not complete");
    let text = std::str::from_utf8(bytes).expect("UTF-8");
    text.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}"))).collect()
}

/// The binary, with nothing on its stdin.
pub fn command() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pldi"));
    command.stdin(Stdio::null()).env_remove("RUST_BACKTRACE");
    command
}

/// Runs the binary; a panic fails the test whatever the exit code.
#[track_caller]
pub fn pldi<I: IntoIterator<Item = S>, S: AsRef<std::ffi::OsStr>>(arguments: I) -> Outcome {
    let output = command().args(arguments).output().expect("the binary starts");
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!stderr.contains("panicked"), "{stderr}");
    Outcome { code: output.status.code(), stdout: output.stdout, stderr }
}

/// Arguments from texts and paths.
#[macro_export]
macro_rules! arguments {
    ($($argument:expr),* $(,)?) => { [$(std::ffi::OsString::from(&$argument)),*] };
}

/// An empty folder that goes away.
pub fn folder() -> TempDir {
    tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).expect("a temporary folder")
}

/// Three generated frames of 640x480.
pub fn frames() -> Recording {
    let mut recording = Recording::demo();
    recording.path = recording.path.into_iter().skip(2).step_by(3).take(3).collect();
    recording
}

/// These frames as a recording, rendered once per test binary.
pub fn recording() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        // Each binary has a folder of its own; what a former run left there is replaced.
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(concat!(env!("CARGO_CRATE_NAME"), "-recording"));
        write_tum(&frames(), "generated", &folder).expect("the recording is written");
        folder
    })
}

/// A copy of the recording, to be damaged.
pub fn copy() -> TempDir {
    let copy = folder();
    for name in ["associations.txt", "camera_info.yaml"] {
        std::fs::copy(recording().join(name), copy.path().join(name)).expect("copied");
    }
    for part in ["rgb", "depth"] {
        std::fs::create_dir(copy.path().join(part)).expect("made");
        for i in 0..3 {
            let file = format!("{part}/{i:04}.png");
            std::fs::copy(recording().join(&file), copy.path().join(&file)).expect("copied");
        }
    }
    copy
}

/// A recording that lists the three frames again and again.
pub fn listed(frames: usize) -> TempDir {
    let long = folder();
    let file = |part: &str, i: usize| recording().join(part).join(format!("{:04}.png", i % 3));
    let line = |i: usize| format!("{i} {} {i} {}\n", file("rgb", i).display(), file("depth", i).display());
    std::fs::write(long.path().join("associations.txt"), (0..frames).map(line).collect::<String>()).expect("written");
    std::fs::copy(recording().join("camera_info.yaml"), long.path().join("camera_info.yaml")).expect("copied");
    long
}

/// The folder of real recordings; says loudly on stderr where it is missing.
pub fn real_recordings() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/recordings");
    if folder.join("truth.json").is_file() {
        return Some(folder);
    }
    // Written directly: the test harness keeps what print macros say of tests that pass.
    let _ = writeln!(std::io::stderr(), "SKIPPED: no real recordings in {}", folder.display());
    None
}

/// Names of the files in a folder, in order.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}
