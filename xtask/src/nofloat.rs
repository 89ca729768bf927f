//! The pipeline in integers, linked for a core without FPU: no routine of software floating point may be in it.
//!
//! `tests/nofloat` calls all of it; the linker keeps what those calls need. The check looks for the names of the
//! compiler's float routines among the program's symbols, and then proves that it would see one: built with one float
//! multiplication more, the same check must fail.

use std::path::{Path, PathBuf};

use crate::elf;
use crate::nostd::{self, Toolchain};
use crate::process::{program, root, run as run_command, target_dir};
use crate::report::{Outcome, Report};

/// A core without FPU.
const TARGET: &str = "thumbv7m-none-eabi";

/// One step.
pub(crate) fn run(report: &mut Report) {
    report.step(format!("no float routine in the integer pipeline, {TARGET}"), || {
        let Some(toolchain) = nostd::toolchain(TARGET) else { return nostd::missing(TARGET) };
        let built = |features: &str| build(toolchain, features);
        built("")
            .and_then(|| match float_symbols(&image("clean")) {
                Ok(found) if found.is_empty() => Outcome::Passed,
                Ok(found) => Outcome::Failed(format!("the program has float routines: {}", found.join(", "))),
                Err(why) => Outcome::Failed(why),
            })
            .and_then(|| built("float"))
            .and_then(|| match float_symbols(&image("poisoned")) {
                Ok(found) if found.is_empty() => {
                    Outcome::Failed("a float multiplication was put in, and the check does not see it".into())
                }
                Ok(found) => {
                    println!("with a float multiplication put in: {}", found.join(", "));
                    Outcome::Passed
                }
                Err(why) => Outcome::Failed(why),
            })
    });
}

/// Where the program is built, with and without the float multiplication.
fn image(variant: &str) -> PathBuf {
    target_dir().join("nofloat").join(variant).join(TARGET).join("release/nofloat")
}

fn build(toolchain: Toolchain, features: &str) -> Outcome {
    let variant = if features.is_empty() { "clean" } else { "poisoned" };
    let line = format!("build --release --manifest-path tests/nofloat/Cargo.toml --target {TARGET}");
    let mut command = nostd::cargo_for(toolchain, &line, &target_dir().join("nofloat").join(variant));
    if !features.is_empty() {
        command.arg("--features").arg(features);
    }
    // The program starts nowhere: what must be kept is named.
    command.env("CARGO_TARGET_THUMBV7M_NONE_EABI_RUSTFLAGS", "-Clink-arg=--entry=entry");
    if let Some(linker) = rust_lld() {
        command.env("CARGO_TARGET_THUMBV7M_NONE_EABI_LINKER", linker);
    }
    run_command(&mut command)
}

/// The linker that comes with the compiler in use; Debian's compiler comes without.
fn rust_lld() -> Option<PathBuf> {
    let output = program("rustc").args(["--print", "target-libdir"]).output().ok()?;
    let libdir = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    let linker = Path::new(&libdir).parent()?.join("bin/rust-lld");
    linker.exists().then_some(linker)
}

fn float_symbols(image: &Path) -> Result<Vec<String>, String> {
    let path = image.strip_prefix(root()).unwrap_or(image).display();
    let bytes = std::fs::read(image).map_err(|error| format!("{path}: {error}"))?;
    let symbols = elf::symbols(&bytes).ok_or_else(|| format!("{path} is no 32-bit ELF file with symbols"))?;
    if !symbols.iter().any(|name| name == "entry") {
        return Err(format!("{path}: the entry point is missing"));
    }
    println!("{path}: {} symbols", symbols.len());
    Ok(symbols.into_iter().filter(|name| is_float_routine(name)).collect())
}

/// Whether a symbol is one of the compiler's or libm's float routines (the names of the ARM run-time ABI, section 4.1.2,
/// and of libgcc's soft-float routines).
fn is_float_routine(name: &str) -> bool {
    let aeabi = ["__aeabi_f", "__aeabi_d", "__aeabi_cf", "__aeabi_cd", "__aeabi_cr", "__aeabi_h2f"];
    let from_integer = ["__aeabi_i2", "__aeabi_ui2", "__aeabi_l2", "__aeabi_ul2"];
    let libgcc =
        ["sf2", "sf3", "df2", "df3", "sfdf2", "dfsf2", "sfsi", "sfdi", "dfsi", "dfdi", "sisf", "disf", "sidf", "didf"];
    aeabi.iter().chain(&from_integer).any(|prefix| name.starts_with(prefix))
        || (name.starts_with("__") && libgcc.iter().any(|suffix| name.ends_with(suffix)))
        || name.contains("compiler_builtins5float")
        || name.contains("libm4math")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn float_routines_are_told_from_others() {
        for name in ["__aeabi_fadd", "__mulsf3", "__aeabi_ui2d", "__floatunsisf", "__aeabi_cfcmple", "__fixunssfsi"] {
            assert!(is_float_routine(name), "{name}");
        }
        for name in ["__aeabi_uidiv", "__aeabi_memcpy", "__aeabi_ldivmod", "__udivmoddi4", "entry", "__aeabi_lmul"] {
            assert!(!is_float_routine(name), "{name}");
        }
    }
}
