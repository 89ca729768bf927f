//! The C library: `pldi.h` says what each function does.
//!
//! Everything that crosses the border is checked here, and nothing else happens here: pointers become references or an
//! error ([`border`]), integers become parameters ([`params`]), and `pldi-core` does the work. No heap, no mutable statics, and no
//! panic: so nothing can unwind into C.
//!
//! Features, none of them on by default, because a Rust program that links this crate has a panic handler already:
//! `panic-handler` for firmware without Rust, `std` for programs on a host.
#![no_std]
#![deny(unsafe_op_in_unsafe_fn)]

#[cfg(any(test, feature = "std"))]
extern crate std;

mod border;
// In the order of the header.
mod status;
mod pipeline;
mod params;
mod checked;
mod templates;
mod frame;
mod results;

pub use frame::*;
pub use params::*;
pub use pipeline::*;
pub use results::*;
pub use status::*;
pub use templates::*;

/// Columns of a frame.
pub const PLDI_WIDTH: usize = 320;

/// Rows of a frame.
pub const PLDI_HEIGHT: usize = 240;

/// Version of the header: the first number. Versions with equal first numbers (while it is 0: equal first two) fit together.
pub const PLDI_VERSION_MAJOR: u32 = 0;

/// Version of the header: the second number.
pub const PLDI_VERSION_MINOR: u32 = 1;

/// Version of the header: the third number.
pub const PLDI_VERSION_PATCH: u32 = 0;

/// The library's version, major * 65536 + minor * 256 + patch. Compare it with the header's, PLDI_VERSION.
#[unsafe(no_mangle)]
pub extern "C" fn pldi_version() -> u32 {
    VERSION
}

/// The version as one number.
const VERSION: u32 = PLDI_VERSION_MAJOR << 16 | PLDI_VERSION_MINOR << 8 | PLDI_VERSION_PATCH;

/// A decimal number, at compile time.
const fn number(text: &str) -> u32 {
    let (bytes, mut value, mut i) = (text.as_bytes(), 0, 0);
    while i < bytes.len() {
        value = value * 10 + (bytes[i] - b'0') as u32;
        i += 1;
    }
    value
}

const _: () = assert!(
    PLDI_VERSION_MAJOR == number(env!("CARGO_PKG_VERSION_MAJOR"))
        && PLDI_VERSION_MINOR == number(env!("CARGO_PKG_VERSION_MINOR"))
        && PLDI_VERSION_PATCH == number(env!("CARGO_PKG_VERSION_PATCH")),
    "the header's version is the package's"
);

/// Nothing gets here; a linker wants it all the same. Interrupts go on, a watchdog that nobody feeds resets the machine.
#[cfg(all(feature = "panic-handler", not(feature = "std"), not(test)))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
