//! Golden data of the stages: `cargo xtask golden` and `cargo xtask firmware` call it.
//!
//!     digests FILE                   writes the golden digests
//!     digests --frames DIRECTORY     writes the golden frames and both template files for the firmware images

#[path = "../../tests/golden/digests.rs"]
mod digests;

use std::io::{BufWriter, Write as _};
use std::path::Path;
use std::{env, fs, io};

use pldi_host::templates::fixed_file;

fn main() -> io::Result<()> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        ["--frames", folder] => frames(Path::new(folder)),
        [path] if !path.starts_with('-') => fs::write(path, digests::text()),
        _ => Err(io::Error::other("usage: digests FILE | digests --frames DIRECTORY")),
    }
}

/// `frames.bin`: for each frame 48 bytes of name, filled up with zeros; fx, fy, cx, cy as f32; the variant as u32; depth as
/// u16; colour as rgb8; all little-endian. `float.pldt`, `fixed.pldt`: the embedded templates in both encodings.
fn frames(folder: &Path) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    let templates = include_bytes!("../assets/furniture.pldt");
    fs::write(folder.join("float.pldt"), templates)?;
    fs::write(folder.join("fixed.pldt"), fixed_file(templates).map_err(io::Error::other)?)?;
    let mut file = BufWriter::new(fs::File::create(folder.join("frames.bin"))?);
    for digests::Golden { name, variant, depth, colour, camera } in digests::frames() {
        let mut field = [0; 48];
        field[..name.len()].copy_from_slice(name.as_bytes());
        file.write_all(&field)?;
        for number in [camera.fx, camera.fy, camera.cx, camera.cy] {
            file.write_all(&number.to_le_bytes())?;
        }
        file.write_all(&(variant as u32).to_le_bytes())?;
        for d in depth {
            file.write_all(&d.to_le_bytes())?;
        }
        file.write_all(&colour)?;
    }
    file.into_inner()?.sync_all()
}
