//! Images run in QEMU.

use std::io::Read as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use super::board::Board;
use crate::process::{program, shown, succeeds};
use crate::report::Outcome;

/// The command that runs an image with arguments: the first one that it reads is its own name, here `firmware`. Semihosting
/// is on, the image's output is the command's, and one instruction takes one nanosecond of the board's time.
///
/// # Errors
/// The outcome of a step for which QEMU is missing.
pub(crate) fn command(board: Board, image: &Path, arguments: &[&str]) -> Result<Command, Outcome> {
    let mut words = board.qemu.split_whitespace();
    let name = words.next().unwrap_or_default();
    if !succeeds(program(name).arg("--version")) {
        let package = if name.ends_with("arm") { "qemu-system-arm" } else { "qemu-system-misc or qemu-system-riscv" };
        return Err(Outcome::missing_tool(format!("{name} is not there; it is in Debian's package {package}")));
    }
    let mut semihosting = String::from("enable=on,target=native,arg=firmware");
    for argument in arguments {
        // A comma separates QEMU's options; two of them stand for one.
        semihosting += &format!(",arg={}", argument.replace(',', ",,"));
    }
    let mut command = program(name);
    command.args(words).args(["-nographic", "-monitor", "none", "-serial", "none", "-icount", "shift=0"]);
    command.arg("-semihosting-config").arg(semihosting).arg("-kernel").arg(image);
    Ok(command)
}

/// Runs an image and returns what it prints; ends it when `limit` is over.
///
/// # Errors
/// The outcome of a step whose image failed, was too slow, or for which QEMU is missing.
pub(crate) fn qemu(board: Board, image: &Path, arguments: &[&str], limit: Duration) -> Result<String, Outcome> {
    output(&mut command(board, image, arguments)?, limit).map_err(Outcome::Failed)
}

fn output(command: &mut Command, limit: Duration) -> Result<String, String> {
    bytes(command, limit).map(|bytes| String::from_utf8_lossy(&bytes).into_owned())
}

/// Runs a command and returns what it prints; ends it when `limit` is over.
///
/// # Errors
/// How it ended, if not well, and what it said last.
pub(crate) fn bytes(command: &mut Command, limit: Duration) -> Result<Vec<u8>, String> {
    let shown = shown(command);
    println!("$ {shown}");
    let failed = |error: std::io::Error| format!("`{shown}`: {error}");
    let mut child = command.stdout(Stdio::piped()).spawn().map_err(failed)?;
    // A pipe that nobody reads fills up and stops who writes.
    let reader = child.stdout.take().map(|mut stdout| {
        thread::spawn(move || {
            let mut bytes = Vec::new();
            let _ = stdout.read_to_end(&mut bytes);
            bytes
        })
    });
    let start = Instant::now();
    let ended = loop {
        match child.try_wait().map_err(failed)? {
            Some(status) if status.success() => break Ok(()),
            Some(status) => break Err(status.to_string()),
            None if start.elapsed() > limit => {
                let _ = child.kill();
                let _ = child.wait();
                break Err(format!("ended after {} s", limit.as_secs()));
            }
            None => thread::sleep(Duration::from_millis(20)),
        }
    };
    let bytes = reader.and_then(|reader| reader.join().ok()).unwrap_or_default();
    ended.map_err(|why| {
        let text = String::from_utf8_lossy(&bytes);
        let lines: Vec<&str> = text.lines().collect();
        let last = lines[lines.len().saturating_sub(5)..].join("\n  ");
        format!("`{shown}`: {why}; it said last:\n  {last}")
    })?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_hangs_is_ended_and_what_fails_is_told() {
        let slow = output(program("sleep").arg("60"), Duration::from_millis(50)).unwrap_err();
        assert!(slow.contains("ended after"), "{slow}");
        let failed = output(program("sh").args(["-c", "echo said; exit 3"]), Duration::from_secs(9)).unwrap_err();
        assert!(failed.contains("said") && failed.contains('3'), "{failed}");
        assert_eq!(output(program("echo").arg("a"), Duration::from_secs(9)).unwrap(), "a\n");
    }
}
