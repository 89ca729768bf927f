//! The real libOpenNI2 with a sensor that is none: `driver` is loaded as a driver beside OpenNI2's own for `.oni` files.
//!
//! libOpenNI2 reads its drivers' folder from `/etc/openni2/OpenNI.ini` alone, so a program that is to see the sensor runs
//! in a mount namespace of its own, where that file is another.
//!
//! ```ignore
//! let film = film(&recording);                                        // what the sensor sees
//! let Some(sensor) = VirtualSensor::new(&film, "pace: asked") else { return };
//! let outcome = sensor.pldi(["run", "openni2:"]).ok();                // or sensor.command(program) and more
//! ```

#![allow(dead_code, reason = "each test binary uses its own part")]

use std::ffi::OsStr;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use pldi_fixtures::Recording;
use tempfile::TempDir;

use crate::common::{self, Outcome};

/// The file that names the drivers' folder.
const INI: &str = "/etc/openni2/OpenNI.ini";

/// Puts the file of its first argument in place of the one above, then becomes the program of the others.
const MOUNTED: &str = r#"mount --bind "$1" /etc/openni2/OpenNI.ini && shift && exec "$@""#;

/// As above, and back from the administrator to the user that called.
const MOUNTED_BY_SUDO: &str = r#"mount --bind "$1" /etc/openni2/OpenNI.ini && shift &&
    exec setpriv --reuid="$SUDO_UID" --regid="$SUDO_GID" --init-groups -- "$@""#;

/// Ways into a mount namespace: as root, by a user namespace, as root by sudo.
const WAYS: [(&[&str], &str); 3] = [
    (&["unshare", "-m"], MOUNTED),
    (&["unshare", "-rm"], MOUNTED),
    (&["sudo", "-n", "--preserve-env", "unshare", "-m"], MOUNTED_BY_SUDO),
];

/// What the machine has and the driver as it was built.
struct Bench {
    /// The folder of OpenNI2's own drivers.
    drivers: PathBuf,
    way: (&'static [&'static str], &'static str),
    /// Where the driver and the program `oni` are.
    built: PathBuf,
}

/// What is needed, found or built once per test binary.
fn bench() -> Option<&'static Bench> {
    static BENCH: OnceLock<Result<Bench, String>> = OnceLock::new();
    match BENCH.get_or_init(prepare) {
        Ok(bench) => Some(bench),
        Err(missing) => {
            assert!(std::env::var_os("CI").is_none_or(|ci| ci != "true"), "{missing}");
            // Written directly: the test harness keeps what print macros say of tests that pass.
            let _ = writeln!(std::io::stderr(), "SKIPPED: {missing}");
            None
        }
    }
}

fn prepare() -> Result<Bench, String> {
    let libraries = std::fs::read_dir("/usr/lib").map_err(|error| error.to_string())?;
    let drivers = libraries
        .filter_map(|entry| Some(entry.ok()?.path().join("OpenNI2/Drivers")))
        .find(|drivers| drivers.join("libOniFile.so.0").exists())
        .filter(|_| Path::new(INI).exists())
        .ok_or("no libOpenNI2 here (Debian: libopenni2-0)")?;
    let way = WAYS
        .into_iter()
        .find(|way| {
            let tried = entering(*way, Path::new("/dev/null")).arg("true").stderr(Stdio::null()).status();
            tried.is_ok_and(|status| status.success())
        })
        .ok_or("no mount namespace may be made here (unshare -m)")?;
    let built = Path::new(env!("CARGO_TARGET_TMPDIR")).join("openni2-driver");
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/openni2/driver/Cargo.toml");
    let output = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
        .args(["build", "--quiet", "--offline", "--locked", "--manifest-path"])
        .arg(manifest)
        .arg("--target-dir")
        .arg(&built)
        .output()
        .expect("cargo starts");
    assert!(output.status.success(), "the driver: {}", String::from_utf8_lossy(&output.stderr));
    Ok(Bench { drivers, way, built: built.join("debug") })
}

/// A command in a namespace with another ini; the program and its arguments are to be added.
fn entering((prefix, script): (&[&str], &str), ini: &Path) -> Command {
    let mut command = Command::new(prefix[0]);
    command.args(&prefix[1..]).args(["sh", "-c", script, "sh"]).arg(ini).stdin(Stdio::null());
    command
}

/// What the sensor sees: the frames of a recording, as the file that the driver reads (its `film.rs` says how).
pub fn film(recording: &Recording) -> Vec<u8> {
    let of = recording.sensor.intrinsics;
    let fov = |size: u32, focal: f32| 2.0 * libm::atanf(size as f32 / (2.0 * focal));
    let mut film = b"PLDIFILM".to_vec();
    for word in [of.width as u32, of.height as u32, 30, recording.len() as u32] {
        film.extend(word.to_le_bytes());
    }
    film.extend(fov(of.width as u32, of.fx).to_le_bytes());
    film.extend(fov(of.height as u32, of.fy).to_le_bytes());
    for frame in recording.frames() {
        // OpenNI2's recorder spoils readings from the sensor's greatest on.
        assert!(frame.capture.depth.iter().all(|&mm| mm < 10_000), "too far for the sensor");
        film.extend(frame.capture.depth.iter().flat_map(|mm| mm.to_le_bytes()));
        film.extend(&frame.capture.colour);
    }
    film
}

/// A sensor on its cable, and the way to run programs that see it. Its controls are described in the driver's
/// `controls.rs`.
#[derive(Debug)]
pub struct VirtualSensor {
    /// `OpenNI.ini`, `drivers/`, `film`, and `control/` with `controls`, `events` and `unplugged`.
    folder: TempDir,
}

impl VirtualSensor {
    /// A sensor that sees a film; `None`, after a loud word, where there is no libOpenNI2.
    pub fn new(film: &[u8], controls: &str) -> Option<Self> {
        let bench = bench()?;
        let folder = common::folder();
        let path = |name: &str| folder.path().join(name);
        for name in ["drivers", "control"] {
            std::fs::create_dir(path(name)).expect("made");
        }
        std::fs::copy(bench.built.join("libpldi_virtual.so"), path("drivers/libPldiVirtual.so.0")).expect("copied");
        let own = bench.drivers.join("libOniFile.so.0");
        std::os::unix::fs::symlink(own, path("drivers/libOniFile.so.0")).expect("linked");
        let drivers = path("drivers");
        let ini =
            format!("[Log]\nVerbosity=3\nLogToConsole=0\nLogToFile=0\n\n[Drivers]\nRepository={}\n", drivers.display());
        std::fs::write(path("OpenNI.ini"), ini).expect("written");
        std::fs::write(path("film"), film).expect("written");
        std::fs::write(path("control/controls"), controls).expect("written");
        Some(Self { folder })
    }

    /// A file of the sensor's folder, which goes away with it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Takes the cable out. While it is out before a program starts, no device is listed.
    pub fn unplug(&self) {
        std::fs::write(self.path("control/unplugged"), "").expect("written");
    }

    /// Puts it in again.
    pub fn plug(&self) {
        std::fs::remove_file(self.path("control/unplugged")).expect("removed");
    }

    /// What happened to the sensor so far: `opened`, `not opened`, `started Depth`, `registration on kept` (or `lost`),
    /// `stopped Depth`, `closed`, `unplugged`, `plugged`.
    pub fn events(&self) -> Vec<String> {
        let text = std::fs::read_to_string(self.path("control/events")).unwrap_or_default();
        text.lines().map(Into::into).collect()
    }

    /// A program that sees the sensor. The process is the program itself (but for sudo), so that it can be interrupted.
    pub fn command(&self, program: impl AsRef<OsStr>) -> Command {
        let way = bench().expect("there is a sensor").way;
        let mut command = entering(way, &self.path("OpenNI.ini"));
        command.arg(program).env_remove("RUST_BACKTRACE");
        command.env("PLDI_VIRTUAL_SENSOR", self.path("film")).env("PLDI_VIRTUAL_CONTROL", self.path("control"));
        command
    }

    /// Runs the binary under test; a panic fails the test whatever the exit code.
    #[track_caller]
    pub fn pldi<I: IntoIterator<Item = S>, S: AsRef<OsStr>>(&self, arguments: I) -> Outcome {
        outcome(self.command(env!("CARGO_BIN_EXE_pldi")).args(arguments))
    }

    /// Runs the program `oni`, which is the driver's judge: it uses libOpenNI2 by itself.
    #[track_caller]
    pub fn oni<I: IntoIterator<Item = S>, S: AsRef<OsStr>>(&self, arguments: I) -> Outcome {
        outcome(self.command(bench().expect("there is a sensor").built.join("oni")).args(arguments))
    }

    /// Records the first frames losslessly with OpenNI2's own recorder. With `pace: asked` exactly these are in it.
    #[track_caller]
    pub fn record(&self, name: &str, width: usize, frames: usize) -> PathBuf {
        let file = self.path(name);
        self.oni([OsStr::new("record"), file.as_os_str(), width.to_string().as_ref(), frames.to_string().as_ref()])
            .ok();
        file
    }
}

#[track_caller]
fn outcome(command: &mut Command) -> Outcome {
    let output = command.output().expect("the program starts");
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!stderr.contains("panicked"), "{stderr}");
    Outcome { code: output.status.code(), stdout: output.stdout, stderr }
}
