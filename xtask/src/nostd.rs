//! `pldi-core` built for microcontrollers: nothing of std, and nothing that such a target lacks.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::process::{cargo, program, run as run_command, target_dir};
use crate::report::{Outcome, Report};

/// What the targets are built with: a name and cargo's options. (Nothing is linked, so defmt needs no linker script.) With the
/// default features, the images of `tests/firmware` and `tests/symbols` are built.
const BUILDS: [(&str, &str, &str); 3] = [
    ("thumbv6m-none-eabi", "all features", "--all-features"),
    ("thumbv7em-none-eabihf", "all features", "--all-features"),
    ("riscv32imac-unknown-none-elf", "all features", "--all-features"),
];

/// Debian's compiler and cargo, which can build `core` from the source in its package rust-web-src.
const DEBIAN_RUSTC: &str = "/usr/bin/rustc";
const DEBIAN_CARGO: &str = "/usr/bin/cargo";

/// How a target can be built here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Toolchain {
    /// The compiler in use has the target's `core`.
    Installed,
    /// Debian's compiler, which builds `core` itself.
    Debian,
}

/// One step for each build: cores with and without FPU, without 64-bit or compare-and-swap instructions, and another
/// architecture.
pub(crate) fn run(report: &mut Report) {
    for (target, name, options) in BUILDS {
        report.step(format!("no_std build for {target}, {name}"), || match toolchain(target) {
            Some(toolchain) => run_command(&mut build(toolchain, target, options)),
            None => missing(target),
        });
    }
}

/// How a target can be built; `None` where it cannot.
pub(crate) fn toolchain(target: &str) -> Option<Toolchain> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    if path_printed_by(program(rustc).args(["--print", "target-libdir", "--target", target])) {
        return Some(Toolchain::Installed);
    }
    let debian = Path::new(DEBIAN_CARGO).exists() && {
        let mut sysroot = program(DEBIAN_RUSTC);
        sysroot.env_remove("LD_LIBRARY_PATH").args(["--print", "sysroot"]);
        printed_by(&mut sysroot).is_some_and(|path| Path::new(&path).join("lib/rustlib/src/rust/library/core").exists())
    };
    debian.then_some(Toolchain::Debian)
}

/// The outcome of a step that needs a target which cannot be built here.
pub(crate) fn missing(target: &str) -> Outcome {
    Outcome::missing_tool(format!(
        "install the target with 'rustup target add {target}', or Debian's rustc-web, cargo-web and rust-web-src"
    ))
}

fn build(toolchain: Toolchain, target: &str, options: &str) -> Command {
    let line = format!("build -p pldi-core --lib --release --locked --target {target} {options}");
    match toolchain {
        Toolchain::Installed => cargo(&line),
        // Another compiler's output would only push ours out of the cache.
        Toolchain::Debian => cargo_for(toolchain, &line, &target_dir().join("nostd")),
    }
}

/// The cargo that can build for microcontrollers, with the arguments of `line`, building in `folder`.
pub(crate) fn cargo_for(toolchain: Toolchain, line: &str, folder: &Path) -> Command {
    let mut command = match toolchain {
        Toolchain::Installed => cargo(line),
        Toolchain::Debian => {
            let mut command = program(DEBIAN_CARGO);
            command.args(line.split_whitespace()).arg("-Zbuild-std=core");
            // `cargo run` puts the libraries of its own compiler here.
            command.env("RUSTC", DEBIAN_RUSTC).env("RUSTC_BOOTSTRAP", "1").env_remove("LD_LIBRARY_PATH");
            command
        }
    };
    command.arg("--target-dir").arg(folder);
    command
}

/// The compiler's name and version, as `rustc 1.90.0`.
pub(crate) fn version(toolchain: Toolchain) -> Option<String> {
    let rustc = match toolchain {
        Toolchain::Installed => std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()),
        Toolchain::Debian => DEBIAN_RUSTC.into(),
    };
    let text = printed_by(program(rustc).env_remove("LD_LIBRARY_PATH").arg("--version"))?;
    Some(text.split_whitespace().take(2).collect::<Vec<_>>().join(" "))
}

/// What the command prints, without the white space around it; `None` if it fails.
fn printed_by(command: &mut Command) -> Option<String> {
    let output = command.stderr(Stdio::null()).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Whether the command prints a path that exists.
fn path_printed_by(command: &mut Command) -> bool {
    printed_by(command).is_some_and(|path| !path.is_empty() && Path::new(&path).exists())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_compiler_says_which_targets_it_has() {
        assert_eq!(toolchain("x86_64-unknown-linux-gnu"), Some(Toolchain::Installed));
    }

    #[test]
    fn a_path_that_is_not_there_is_told() {
        assert!(path_printed_by(program("echo").arg("/")));
        assert!(!path_printed_by(program("echo").arg("/no/such/path")));
        assert!(!path_printed_by(&mut program("false")));
    }
}
