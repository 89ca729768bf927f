//! The library as others use it: archive, header, and what CMake and pkg-config want to know.

use std::fs;
use std::path::Path;

use super::{CRATE, HEADER, firmware_archive, host_archive};
use crate::process::root;
use crate::report::Report;

/// The templates of the files that are written, and where they go.
const WRITTEN: [(&str, &str); 3] = [
    ("cmake/pldi-config.cmake.in", "lib/cmake/pldi/pldi-config.cmake"),
    ("cmake/pldi-config-version.cmake.in", "lib/cmake/pldi/pldi-config-version.cmake"),
    ("pldi.pc.in", "lib/pkgconfig/pldi.pc"),
];

/// One step: installs the library for a target, or for this machine.
pub(crate) fn install(report: &mut Report, prefix: &str, target: Option<&str>) {
    report.step(format!("C library for {} to {prefix}", target.unwrap_or("this machine")), || {
        let archive = match target.map_or_else(host_archive, firmware_archive) {
            Ok(archive) => archive,
            Err(outcome) => return outcome,
        };
        copy(&archive, &root().join(prefix), target.is_none()).map_err(|error| format!("{prefix}: {error}")).into()
    });
}

fn copy(archive: &Path, prefix: &Path, hosted: bool) -> std::io::Result<()> {
    for folder in ["include", "lib/cmake/pldi", "lib/pkgconfig"] {
        fs::create_dir_all(prefix.join(folder))?;
    }
    fs::copy(archive, prefix.join("lib/libpldi.a"))?;
    fs::copy(root().join(HEADER), prefix.join("include/pldi.h"))?;
    for (from, to) in WRITTEN {
        let text = fs::read_to_string(root().join(CRATE).join(from))?;
        fs::write(prefix.join(to), filled(&text, hosted))?;
    }
    Ok(())
}

/// A template with its numbers put in. std wants threads and the dynamic loader, firmware wants nothing.
fn filled(template: &str, hosted: bool) -> String {
    let [cmake, pkg_config] = if hosted { ["pthread;dl;m", "-lpthread -ldl -lm"] } else { [""; 2] };
    [
        ("@VERSION@", env!("CARGO_PKG_VERSION")),
        ("@MAJOR@", env!("CARGO_PKG_VERSION_MAJOR")),
        ("@MINOR@", env!("CARGO_PKG_VERSION_MINOR")),
        ("@CMAKE_LIBS@", cmake),
        ("@PC_LIBS@", pkg_config),
    ]
    .iter()
    .fold(template.to_owned(), |text, (name, value)| text.replace(name, value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_left_open_in_the_templates() {
        for (from, _) in WRITTEN {
            let text = fs::read_to_string(root().join(CRATE).join(from)).unwrap();
            for hosted in [true, false] {
                assert!(!filled(&text, hosted).contains('@'), "{from}");
            }
        }
    }
}
