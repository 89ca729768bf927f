//! Writes the C header to the file named on the command line: `cargo xtask capi` compares it with the committed one.

use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let out = std::env::args_os().nth(1).ok_or("usage: header FILE")?;
    let config = cbindgen::Config::from_file(here.join("cbindgen.toml"))?;
    let builder = cbindgen::Builder::new().with_config(config);
    let bindings = builder.with_src(here.join("src/lib.rs")).generate()?;
    let mut text = Vec::new();
    bindings.write(&mut text);
    std::fs::write(out, text)?;
    Ok(())
}
