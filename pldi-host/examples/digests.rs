//! Writes the golden digests to the file named on the command line: `cargo xtask golden` calls it.

#[path = "../../tests/golden/digests.rs"]
mod digests;

fn main() -> std::io::Result<()> {
    let path = std::env::args_os().nth(1).unwrap_or_else(|| "digests.txt".into());
    std::fs::write(path, digests::text())
}
