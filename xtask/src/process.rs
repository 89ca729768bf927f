//! Where the workspace lies, and running commands in it.

use std::env;
use std::ffi::OsStr;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::report::Outcome;

/// The workspace's root.
pub(crate) fn root() -> PathBuf {
    let manifest = env::var_os("CARGO_MANIFEST_DIR").unwrap_or_else(|| env!("CARGO_MANIFEST_DIR").into());
    Path::new(&manifest).parent().map_or_else(|| PathBuf::from("."), Path::to_path_buf)
}

/// Where cargo builds: `CARGO_TARGET_DIR`, else `target` in the root.
pub(crate) fn target_dir() -> PathBuf {
    root().join(env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into()))
}

/// A program to be run in the root, without standard input.
pub(crate) fn program(name: impl AsRef<OsStr>) -> Command {
    let mut command = Command::new(name);
    command.current_dir(root()).stdin(Stdio::null());
    command
}

/// Cargo (the one that runs this task) with the arguments of `line`, separated by spaces.
pub(crate) fn cargo(line: &str) -> Command {
    let mut command = program(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(line.split_whitespace());
    command
}

/// Prints the command, runs it with its output going where ours goes, and tells how it ended.
pub(crate) fn run(command: &mut Command) -> Outcome {
    println!("$ {}", shown(command));
    match command.status() {
        Ok(status) if status.success() => Outcome::Passed,
        Ok(status) => Outcome::Failed(format!("`{}`: {status}", shown(command))),
        Err(error) => Outcome::Failed(format!("`{}`: {error}", shown(command))),
    }
}

/// Whether the command runs and succeeds; its output is dropped.
pub(crate) fn succeeds(command: &mut Command) -> bool {
    command.stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok_and(|status| status.success())
}

/// The command as one would type it in the root, with the variables it sets.
pub(crate) fn shown(command: &Command) -> String {
    let mut text = String::new();
    for (name, value) in command.get_envs() {
        if let Some(value) = value {
            let _ = write!(text, "{}={} ", name.to_string_lossy(), quoted(value));
        }
    }
    let path = Path::new(command.get_program());
    // Cargo's own path says nothing that the word does not.
    let is_own_cargo = env::var_os("CARGO").is_some_and(|cargo| path == Path::new(&cargo));
    text += &if is_own_cargo { "cargo".into() } else { quoted(path.as_os_str()) };
    for argument in command.get_args() {
        text.push(' ');
        text += &quoted(argument);
    }
    text
}

fn quoted(word: &OsStr) -> String {
    let word = Path::new(word);
    let word = word.strip_prefix(root()).unwrap_or(word).to_string_lossy();
    if word.contains(char::is_whitespace) { format!("'{word}'") } else { word.into_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_is_shown_as_one_would_type_it() {
        let mut command = program("tool");
        command.env("FLAGS", "-D warnings").arg(root().join("target/x")).arg("--fast");
        assert_eq!(shown(&command), "FLAGS='-D warnings' tool target/x --fast");
    }

    #[test]
    fn how_a_command_ended_is_told() {
        assert_eq!(run(&mut program("true")), Outcome::Passed);
        assert!(matches!(run(&mut program("false")), Outcome::Failed(why) if why.starts_with("`false`: exit")));
        assert!(matches!(run(&mut program("no-such-program")), Outcome::Failed(_)));
        assert!(succeeds(&mut program("true")) && !succeeds(&mut program("false")));
    }
}
