//! Every function of the header linked for a core without FPU: the header declares nothing that the archive lacks, and nothing of
//! it needs a routine of software floating point.

use std::path::Path;

use super::{HEADER, firmware_archive, folder, need};
use crate::process::{program, root, run as run_command};
use crate::report::Outcome;
use crate::{elf, nofloat};

/// A core without FPU.
pub(super) const TARGET: &str = "thumbv7m-none-eabi";

pub(super) fn check() -> Outcome {
    let tool = need("arm-none-eabi-gcc", "gcc-arm-none-eabi");
    if tool != Outcome::Passed {
        return tool;
    }
    let functions = match std::fs::read_to_string(root().join(HEADER)) {
        Ok(header) => functions(&header),
        Err(error) => return Outcome::Failed(format!("{HEADER}: {error}")),
    };
    let archive = match firmware_archive(TARGET) {
        Ok(archive) => archive,
        Err(outcome) => return outcome,
    };
    let (image, poisoned) = (folder().join("all.elf"), folder().join("all-and-float.elf"));
    let link = |more: Option<&str>, image: &Path| {
        let mut command = program("arm-none-eabi-gcc");
        command.args(["-mcpu=cortex-m3", "-mthumb", "-nostdlib", "-Wl,--gc-sections", "-Wl,--entry=pldi_version"]);
        command.args(functions.iter().map(String::as_str).chain(more).map(|name| format!("-Wl,--undefined={name}")));
        run_command(command.arg(&archive).arg("-o").arg(image))
    };
    link(None, &image)
        .and_then(|| match symbols(&image) {
            Ok(symbols) if !functions.iter().all(|name| symbols.contains(name)) => {
                Outcome::Failed("a function of the header is not in the image".into())
            }
            Ok(symbols) => match symbols.iter().find(|name| nofloat::is_float_routine(name)) {
                Some(name) => Outcome::Failed(format!("the image has float routines: {name}")),
                None => {
                    println!("{} functions, {} symbols", functions.len(), symbols.len());
                    Outcome::Passed
                }
            },
            Err(why) => Outcome::Failed(why),
        })
        .and_then(|| link(Some("__aeabi_fmul"), &poisoned))
        .and_then(|| match symbols(&poisoned) {
            Ok(symbols) if symbols.iter().any(|name| nofloat::is_float_routine(name)) => Outcome::Passed,
            Ok(_) => Outcome::Failed("a float multiplication was put in, and the check does not see it".into()),
            Err(why) => Outcome::Failed(why),
        })
}

fn symbols(image: &Path) -> Result<Vec<String>, String> {
    let bytes = std::fs::read(image).map_err(|error| format!("{}: {error}", image.display()))?;
    elf::symbols(&bytes).ok_or_else(|| format!("{} is no 32-bit ELF file with symbols", image.display()))
}

/// The functions that a header declares.
fn functions(header: &str) -> Vec<String> {
    let declarations = header.lines().filter(|line| !line.starts_with([' ', '#', '/', '*', '}']));
    let name = |line: &str| {
        let before = line.split_once('(')?.0;
        let name = before.rsplit([' ', '*']).next()?;
        name.starts_with("pldi_").then(|| name.to_owned())
    };
    declarations.filter_map(name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn declarations_are_found() {
        let header = "/** pldi_x(). */\n#define PLDI_A(b) (b)\n * pldi_y()\nconst char *pldi_a(uint32_t b);\n\
                      pldi_status pldi_b(void *memory,\n                   size_t size);\ntypedef struct pldi_c pldi_c;\n";
        assert_eq!(functions(header), ["pldi_a", "pldi_b"]);
        let header = std::fs::read_to_string(root().join(HEADER)).unwrap();
        assert!(functions(&header).len() > 20);
    }
}
