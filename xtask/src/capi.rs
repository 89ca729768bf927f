//! The C library: its header, its use from C and C++, on a host and in firmware, and its installation.

mod install;
mod link;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::golden::{self, Mode};
use crate::nostd;
use crate::process::{cargo, program, root, run as run_command, succeeds, target_dir};
use crate::report::{Outcome, Report};

pub(crate) use install::install;

/// The crate, from the root.
const CRATE: &str = "pldi-core/capi";
const HEADER: &str = "pldi-core/capi/include/pldi.h";

/// What the example must print, on every machine.
const EXPECTED: &str = "pldi-core/capi/examples/qemu/main.out";

/// What C and C++ must be free of.
const WARNINGS: [&str; 5] = ["-Wall", "-Wextra", "-pedantic", "-Werror", "-Ipldi-core/capi/include"];

/// What Rust's std asks a C program to link.
const HOST_LIBS: [&str; 3] = ["-lpthread", "-ldl", "-lm"];

/// The example's board.
const BOARD: &str = "thumbv7em-none-eabihf";

/// All steps.
pub(crate) fn run(report: &mut Report, mode: Mode) {
    report.step("C library: header", || header(mode));
    report.step("C library: header in C99 and C++", in_c_and_cpp);
    report.step("C library: example's frame", || example_data(mode));
    report.step("C library: border, valgrind, sanitizers", on_host);
    report.step(format!("C library: example in QEMU, {BOARD}"), in_qemu);
    for machine in link::MACHINES {
        let name = format!("C library: every function linked, without float routines and panics, {}", machine.target);
        report.step(name, || link::check(machine));
    }
}

/// Where the steps leave what they make.
fn folder() -> PathBuf {
    target_dir().join("capi")
}

/// Makes the header and compares it with the committed one.
fn header(mode: Mode) -> Outcome {
    let (made, committed) = (folder().join("pldi.h"), root().join(HEADER));
    if let Err(error) = fs::create_dir_all(folder()) {
        return Outcome::Failed(format!("{}: {error}", folder().display()));
    }
    let mut command = cargo("run --quiet --locked -p pldi-capi --example header --");
    run_command(command.arg(&made)).and_then(|| renew_or_compare(mode, &made, &committed, HEADER))
}

fn renew_or_compare(mode: Mode, made: &Path, committed: &Path, name: &str) -> Outcome {
    match mode {
        Mode::Renew => fs::copy(made, committed).map(|_| ()).map_err(|error| format!("{name}: {error}")).into(),
        Mode::Check => match (fs::read(committed), fs::read(made)) {
            (Ok(old), Ok(new)) => golden::difference(&old, &new).map_or(Outcome::Passed, |difference| {
                Outcome::Failed(format!("{name} is out of date: {difference}; `cargo xtask capi --renew`"))
            }),
            (Err(error), _) | (_, Err(error)) => Outcome::Failed(format!("{name}: {error}")),
        },
    }
}

/// Whether a tool is there; what to install where it is not.
fn need(tool: &str, package: &str) -> Outcome {
    if succeeds(program(tool).arg("--version")) {
        Outcome::Passed
    } else {
        Outcome::missing_tool(format!("{tool} is missing: install Debian's {package}"))
    }
}

/// A compiler's call with a language and the warnings that are errors.
fn compiler(tool: &str, standard: &str) -> Command {
    let mut command = program(tool);
    command.arg(format!("-std={standard}")).args(WARNINGS);
    command
}

fn in_c_and_cpp() -> Outcome {
    let check = |tool: &str, standard: &str, language: &str| {
        run_command(compiler(tool, standard).args(["-fsyntax-only", "-x", language, HEADER]))
    };
    need("gcc", "gcc")
        .and_then(|| need("g++", "g++"))
        .and_then(|| check("gcc", "c99", "c"))
        .and_then(|| check("gcc", "c17", "c"))
        .and_then(|| check("g++", "c++11", "c++"))
        .and_then(|| check("g++", "c++20", "c++"))
}

/// Where the frame and the templates are.
fn data() -> PathBuf {
    folder().join("data")
}

/// Makes the frame, the templates and what the Rust pipeline finds: that must be what the example is to print.
fn example_data(mode: Mode) -> Outcome {
    let mut command = cargo("run --quiet --locked -p pldi-capi --example frame --");
    run_command(command.arg(data()))
        .and_then(|| renew_or_compare(mode, &data().join("expected.out"), &root().join(EXPECTED), EXPECTED))
}

/// Builds the archive for hosts; where it is then.
fn host_archive() -> Result<PathBuf, Outcome> {
    let line = "rustc -p pldi-capi --lib --locked --profile archive --crate-type staticlib --features std";
    match run_command(&mut cargo(line)) {
        Outcome::Passed => Ok(target_dir().join("archive/libpldi.a")),
        other => Err(other),
    }
}

/// Builds the archive for firmware; where it is then.
fn firmware_archive(target: &str) -> Result<PathBuf, Outcome> {
    let toolchain = nostd::toolchain(target).ok_or_else(|| nostd::missing(target))?;
    let line = format!(
        "rustc -p pldi-capi --lib --locked --profile archive --crate-type staticlib --features panic-handler --target {target}"
    );
    let folder = folder().join("firmware");
    match run_command(&mut nostd::cargo_for(toolchain, &line, &folder)) {
        Outcome::Passed => Ok(folder.join(target).join("archive/libpldi.a")),
        other => Err(other),
    }
}

/// The test in C, as it is, under valgrind and with sanitizers; the example, and the header in C++.
fn on_host() -> Outcome {
    let tools = need("gcc", "gcc").and_then(|| need("g++", "g++")).and_then(|| need("valgrind", "valgrind"));
    if tools != Outcome::Passed {
        return tools;
    }
    let archive = match host_archive() {
        Ok(archive) => archive,
        Err(outcome) => return outcome,
    };
    let test = |name: &str| format!("{CRATE}/tests/{name}");
    let (plain, checked) = (folder().join("border"), folder().join("border-sanitized"));
    let (cpp, example) = (folder().join("header-cpp"), folder().join("example"));
    let build = |command: &mut Command, sources: &[String], to: &Path| {
        run_command(command.args(["-O1", "-g"]).args(sources).arg(&archive).args(HOST_LIBS).arg("-o").arg(to))
    };
    let sanitizers = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
    build(&mut compiler("gcc", "c99"), &[test("border.c")], &plain)
        .and_then(|| run_command(program(&plain).arg(data())))
        .and_then(|| {
            let mut valgrind = program("valgrind");
            run_command(valgrind.args(["-q", "--error-exitcode=9", "--leak-check=full"]).arg(&plain).arg(data()))
        })
        .and_then(|| build(compiler("gcc", "c99").args(sanitizers), &[test("border.c")], &checked))
        .and_then(|| run_command(program(&checked).arg(data())))
        .and_then(|| build(&mut compiler("g++", "c++11"), &[test("header.cpp")], &cpp))
        .and_then(|| run_command(&mut program(&cpp)))
        .and_then(|| {
            build(compiler("gcc", "gnu99").arg(assembler_path()), &example_sources(&["main", "data"]), &example)
        })
        .and_then(|| prints_what_it_should(&mut program(&example)))
}

/// The assembler looks for the included files here.
fn assembler_path() -> String {
    format!("-Wa,-I{}", data().display())
}

fn example_sources(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| format!("{CRATE}/examples/qemu/{name}.c")).collect()
}

/// Builds the example with a C compiler for microcontrollers and runs it.
fn in_qemu() -> Outcome {
    let tools = need("arm-none-eabi-gcc", "gcc-arm-none-eabi and libnewlib-arm-none-eabi")
        .and_then(|| need("qemu-system-arm", "qemu-system-arm"));
    if tools != Outcome::Passed {
        return tools;
    }
    let archive = match firmware_archive(BOARD) {
        Ok(archive) => archive,
        Err(outcome) => return outcome,
    };
    let image = folder().join("example.elf");
    let mut build = compiler("arm-none-eabi-gcc", "gnu99");
    build.args(["-O2", "-mcpu=cortex-m7", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv5-d16", "-ffunction-sections"]);
    build.args(["-fdata-sections", "--specs=nano.specs", "-nostartfiles", "-Wl,--gc-sections"]);
    build.args([&assembler_path(), "-T", "pldi-core/capi/examples/qemu/mps2-an500.ld"]);
    build.args(example_sources(&["main", "data", "startup"])).arg(&archive).arg("-o").arg(&image);
    run_command(&mut build).and_then(|| run_command(program("arm-none-eabi-size").arg(&image))).and_then(|| {
        // A machine that hangs is a failure, not a wait.
        let mut qemu = program("timeout");
        qemu.args(["300", "qemu-system-arm", "-machine", "mps2-an500", "-cpu", "cortex-m7", "-nographic"]);
        qemu.args(["-semihosting-config", "enable=on,target=native", "-kernel"]).arg(&image);
        prints_what_it_should(&mut qemu)
    })
}

/// Whether a program succeeds and prints what is committed.
fn prints_what_it_should(command: &mut Command) -> Outcome {
    let name = command.get_program().to_string_lossy().into_owned();
    // QEMU's semihosting prints to its standard error.
    let output = match command.stdout(Stdio::piped()).stderr(Stdio::piped()).output() {
        Ok(output) => output,
        Err(error) => return Outcome::Failed(format!("{name}: {error}")),
    };
    let printed = [output.stdout, output.stderr].concat();
    print!("{}", String::from_utf8_lossy(&printed));
    if !output.status.success() {
        return Outcome::Failed(format!("{name}: {}", output.status));
    }
    match fs::read(root().join(EXPECTED)) {
        Ok(expected) => golden::difference(&expected, &printed).map_or(Outcome::Passed, |difference| {
            Outcome::Failed(format!("{name} does not print {EXPECTED}: {difference}"))
        }),
        Err(error) => Outcome::Failed(format!("{EXPECTED}: {error}")),
    }
}
