//! The driver stays in memory when the library closes it: its thread may still be inside one of the library's callbacks.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-cdylib-link-arg=-Wl,-z,nodelete");
}
