//! QEMU's `virt` machine with a core without FPU, rv32imac.

use core::arch::asm;
use core::ptr::write_volatile;

pub use riscv_rt::entry;

/// As it is called in reports.
pub const NAME: &str = "RISC-V rv32imac, virt";

/// What the stack is painted with.
pub(super) const PAINT: u32 = 0xcccc_cccc;

unsafe extern "C" {
    static mut __eheap: u32;
    static _stack_start: u32;
}

/// Paints the stack below the caller's.
pub fn start() {
    let here: usize;
    // SAFETY: reads the stack pointer.
    unsafe { asm!("mv {}, sp", out(reg) here) };
    let mut word = &raw mut __eheap;
    while word.addr() < here - 256 {
        // SAFETY: RAM between the statics and the stack in use.
        unsafe { write_volatile(word, PAINT) };
        word = word.wrapping_add(1);
    }
}

/// Instructions since the start.
pub fn instructions() -> u64 {
    riscv::register::minstret::read64()
}

/// Both ends of the stack, its end first.
pub(super) fn stack() -> (*const u32, *const u32) {
    (&raw const __eheap, &raw const _stack_start)
}
