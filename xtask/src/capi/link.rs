//! Every function of the header linked for microcontrollers: the header declares nothing that the archive lacks, and nothing
//! of it can panic or needs a routine of software floating point.

use std::path::Path;

use super::{HEADER, firmware_archive, folder, need};
use crate::process::{program, root, run as run_command};
use crate::report::Outcome;
use crate::{elf, nofloat, nopanic};

/// A target, and what a C compiler calls it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Machine {
    pub(super) target: &'static str,
    options: &'static [&'static str],
}

/// With FPU, and without: there software floating point would show.
pub(super) const MACHINES: [Machine; 2] = [
    Machine {
        target: "thumbv7em-none-eabihf",
        options: &["-mcpu=cortex-m7", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv5-d16"],
    },
    Machine { target: "thumbv7m-none-eabi", options: &["-mcpu=cortex-m3", "-mthumb"] },
];

pub(super) fn check(machine: Machine) -> Outcome {
    let tool = need("arm-none-eabi-gcc", "gcc-arm-none-eabi");
    if tool != Outcome::Passed {
        return tool;
    }
    let functions = match std::fs::read_to_string(root().join(HEADER)) {
        Ok(header) => functions(&header),
        Err(error) => return Outcome::Failed(format!("{HEADER}: {error}")),
    };
    let archive = match firmware_archive(machine.target) {
        Ok(archive) => archive,
        Err(outcome) => return outcome,
    };
    let image = |name: &str| folder().join(format!("{name}-{}.elf", machine.target));
    let (clean, poisoned) = (image("all"), image("all-and-float"));
    let link = |more: Option<&str>, image: &Path| {
        let mut command = program("arm-none-eabi-gcc");
        command.args(machine.options).args(["-nostdlib", "-Wl,--gc-sections", "-Wl,--entry=pldi_version"]);
        command.args(functions.iter().map(String::as_str).chain(more).map(|name| format!("-Wl,--undefined={name}")));
        run_command(command.arg(&archive).arg("-o").arg(image))
    };
    let unwanted = |name: &&String| nofloat::is_float_routine(name) || nopanic::is_panic(name);
    link(None, &clean)
        .and_then(|| match symbols(&clean) {
            Ok(symbols) if !functions.iter().all(|name| symbols.contains(name)) => {
                Outcome::Failed("a function of the header is not in the image".into())
            }
            Ok(symbols) => match symbols.iter().filter(unwanted).map(String::as_str).collect::<Vec<_>>()[..] {
                [] => {
                    println!("{} functions, {} symbols", functions.len(), symbols.len());
                    Outcome::Passed
                }
                ref found => Outcome::Failed(format!("float routines or panics in the image: {}", found.join(", "))),
            },
            Err(why) => Outcome::Failed(why),
        })
        // Proves that the check would see one.
        .and_then(|| link(Some("__aeabi_dmul"), &poisoned))
        .and_then(|| match symbols(&poisoned) {
            Ok(symbols) if symbols.iter().any(|name| unwanted(&name)) => Outcome::Passed,
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
