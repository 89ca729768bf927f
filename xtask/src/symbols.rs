//! Programs that are linked for their symbols alone: `tests/symbols` calls everything that a firmware does, and the linker
//! keeps what those calls need.

use std::path::{Path, PathBuf};

use crate::nostd::{self, Toolchain};
use crate::process::{program, root, run as run_command, target_dir};
use crate::report::Outcome;
use crate::{elf, firmware};

/// A program of `tests/symbols`, built for a target, with a feature that puts something in which a check must find.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Program {
    /// `fixed` or `float`.
    pub(crate) name: &'static str,
    pub(crate) target: &'static str,
    /// Empty for the program as it is.
    pub(crate) feature: &'static str,
}

impl Program {
    /// Builds it and passes those of its symbols that `wanted` picks on.
    pub(crate) fn find(&self, wanted: impl Fn(&str) -> bool, judge: impl FnOnce(Vec<String>) -> Outcome) -> Outcome {
        let Some(toolchain) = nostd::toolchain(self.target) else { return nostd::missing(self.target) };
        let image = folder().join(self.target).join("release").join(self.name);
        self.build(toolchain).and_then(|| match of(&image, wanted) {
            Ok(found) => judge(found),
            Err(why) => Outcome::Failed(why),
        })
    }

    fn build(&self, toolchain: Toolchain) -> Outcome {
        let Self { name, target, feature } = self;
        let line =
            format!("rustc --release --locked --manifest-path tests/symbols/Cargo.toml --target {target} --bin {name}");
        let mut command = nostd::cargo_for(toolchain, &line, &folder());
        if !feature.is_empty() {
            command.arg("--features").arg(feature);
        }
        let variable = format!("CARGO_TARGET_{}", target.to_uppercase().replace('-', "_"));
        if let Some(cpu) = firmware::cpu(target) {
            command.env(format!("{variable}_RUSTFLAGS"), format!("-Ctarget-cpu={cpu}"));
        }
        if let Some(linker) = rust_lld() {
            command.env(format!("{variable}_LINKER"), linker);
        }
        // The program starts nowhere: what must be kept is named.
        command.args(["--", "-Clink-arg=--entry=entry"]);
        run_command(&mut command)
    }
}

/// Where all of them are built: one after the other, with a feature in the place of the same without. The firmware images
/// are built there with the same flags, so that `core` is built once for both.
fn folder() -> PathBuf {
    target_dir().join("firmware")
}

/// The linker that comes with the compiler in use; Debian's compiler comes without.
pub(crate) fn rust_lld() -> Option<PathBuf> {
    let output = program("rustc").args(["--print", "target-libdir"]).output().ok()?;
    let libdir = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    let linker = Path::new(&libdir).parent()?.join("bin/rust-lld");
    linker.exists().then_some(linker)
}

/// Those of a program's symbols that `wanted` picks. The program must have an entry point of that name: in one without,
/// the linker keeps nothing, and there is nothing to find.
pub(crate) fn of(image: &Path, wanted: impl Fn(&str) -> bool) -> Result<Vec<String>, String> {
    let path = image.strip_prefix(root()).unwrap_or(image).display();
    let bytes = std::fs::read(image).map_err(|error| format!("{path}: {error}"))?;
    let symbols = elf::symbols(&bytes).ok_or_else(|| format!("{path} is no 32-bit ELF file with symbols"))?;
    if !symbols.iter().any(|name| name == "entry") {
        return Err(format!("{path}: the entry point is missing"));
    }
    println!("{path}: {} symbols", symbols.len());
    Ok(symbols.into_iter().filter(|name| wanted(name)).collect())
}
