//! What differs between the boards.

use core::ptr::read_volatile;

#[cfg(target_arch = "arm")]
mod cortex_m;
#[cfg(target_arch = "arm")]
use self::cortex_m::{PAINT, stack};
#[cfg(target_arch = "arm")]
pub use self::cortex_m::{entry, instructions, start};

#[cfg_attr(feature = "an385", path = "an385.rs")]
#[cfg_attr(feature = "an386", path = "an386.rs")]
#[cfg_attr(feature = "an500", path = "an500.rs")]
#[cfg_attr(feature = "an505", path = "an505.rs")]
#[cfg_attr(feature = "virt", path = "virt.rs")]
mod this;
pub use this::NAME;
#[cfg(target_arch = "riscv32")]
use this::{PAINT, stack};
#[cfg(target_arch = "riscv32")]
pub use this::{entry, instructions, start};

unsafe extern "C" {
    static __sdata: u32;
    static __ebss: u32;
}

/// Bytes of static memory: initialised data and zeros, which lie one behind the other.
pub fn static_memory() -> usize {
    (&raw const __ebss).addr() - (&raw const __sdata).addr()
}

/// Bytes of stack that were ever used.
pub fn stack_used() -> usize {
    let (mut word, top) = stack();
    // SAFETY: between the two ends lies the stack, all of it RAM.
    while word < top && unsafe { read_volatile(word) } == PAINT {
        word = word.wrapping_add(1);
    }
    top.addr() - word.addr()
}
