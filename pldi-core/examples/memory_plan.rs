//! Prints the memory plan of the pipeline in integers as Markdown: `cargo xtask size` compares it with `docs/memory.md`.

use pldi_core::pipeline::plan::{BUFFERS, MEMORY_LIMIT, Place, TABLES};
use pldi_core::pipeline::{QvgaFixedWorkspace, QvgaWorkspace};

fn main() {
    let total = size_of::<QvgaFixedWorkspace>();
    println!("# Memory of the pipeline in integers\n");
    println!("Made by `cargo xtask size --renew`; what it is made of is checked at compile time (`pipeline::plan`).\n");
    println!("| part of `QvgaFixedWorkspace` | bytes | KiB |\n|---|---:|---:|");
    let kib = |bytes: usize| format!("{:.1}", bytes as f64 / 1024.0);
    for place in [Place::Depth, Place::Shared, Place::Lines, Place::Report] {
        println!("| {} | {} | {} |", place.name(), place.bytes(), kib(place.bytes()));
    }
    println!("| **all** (at most {MEMORY_LIMIT}) | **{total}** | **{}** |", kib(total));
    println!(
        "\nBeside it: {TABLES} bytes of tables (`QvgaFixedPipeline`), and the templates in flash, 120 bytes each."
    );
    println!("In floats the workspace takes {} bytes.\n", size_of::<QvgaWorkspace>());
    println!("Buffers that share a place are not in use at the same time:\n");
    println!("| place | from byte | bytes | holds | while |\n|---|---:|---:|---|---|");
    for buffer in BUFFERS {
        let (place, stage) = (buffer.place.name(), buffer.stage.name());
        println!("| {place} | {} | {} | {} | {stage} |", buffer.offset, buffer.bytes, buffer.name);
    }
}
