//! Where the image lies in the board's memory, and which template file goes into it.

use std::path::Path;
use std::{env, fs};

/// Boards: flash, RAM, and the RAM that there is.
const BOARDS: [(&str, u32, u32); 5] = [
    ("an385", 0x0000_0000, 0x2000_0000),
    ("an386", 0x0000_0000, 0x2000_0000),
    ("an500", 0x0000_0000, 0x2000_0000),
    ("an505", 0x1000_0000, 0x3800_0000),
    ("virt", 0x8000_0000, 0x8040_0000),
];

fn main() {
    let has = |name: &str| env::var_os(format!("CARGO_FEATURE_{}", name.to_uppercase())).is_some();
    let chosen: Vec<_> = BOARDS.into_iter().filter(|(name, ..)| has(name)).collect();
    let [(board, flash, ram)] = chosen[..] else {
        panic!("choose one board by its feature: an385, an386, an500, an505 or virt");
    };
    // The pipeline in integers lives in half a megabyte, stack and all; the one in floats takes what the board has.
    let ram_size = if has("float") { "4M" } else { "512K" };
    let mut memory = format!(
        "MEMORY\n{{\n  FLASH : ORIGIN = {flash:#x}, LENGTH = 4M\n  RAM : ORIGIN = {ram:#x}, LENGTH = {ram_size}\n}}\n"
    );
    if board == "virt" {
        for (region, place) in
            [("TEXT", "FLASH"), ("RODATA", "FLASH"), ("DATA", "RAM"), ("BSS", "RAM"), ("HEAP", "RAM"), ("STACK", "RAM")]
        {
            memory += &format!("REGION_ALIAS(\"REGION_{region}\", {place});\n");
        }
    }
    let out = env::var("OUT_DIR").unwrap();
    fs::write(Path::new(&out).join("memory.x"), memory).unwrap();
    println!("cargo::rustc-link-search={out}");
    if board == "virt" {
        println!("cargo::rustc-link-arg-bins=-Tmemory.x");
    }
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
    println!("cargo::rustc-link-arg-bin=log=-Tdefmt.x");

    let file = if has("float") { "float.pldt" } else { "fixed.pldt" };
    let data = env::var("PLDI_FIRMWARE_DATA").unwrap_or_default();
    let templates = Path::new(&data).join(file);
    assert!(
        templates.is_absolute() && templates.exists(),
        "PLDI_FIRMWARE_DATA must name the folder with {file} by its absolute path; `cargo xtask firmware` makes and names it"
    );
    println!("cargo::rustc-env=PLDI_TEMPLATES={}", templates.display());
    println!("cargo::rerun-if-env-changed=PLDI_FIRMWARE_DATA");
    println!("cargo::rerun-if-changed={}", templates.display());
    println!("cargo::rerun-if-changed=build.rs");
}
