//! What the Cortex-M boards have in common: the timer of Arm's CMSDK, and the painted stack of cortex-m-rt.

use core::ptr::{read_volatile, write_volatile};

pub use cortex_m_rt::entry;

use super::this::{PER_TICK, TIMER};

/// What cortex-m-rt paints the stack with before `main`.
pub(super) const PAINT: u32 = cortex_m_rt::STACK_PAINT_VALUE;

/// Starts the clock.
pub fn start() {
    // SAFETY: the timer's registers (CTRL, VALUE, RELOAD) on this board; nothing else uses it.
    unsafe {
        write_volatile((TIMER + 8) as *mut u32, u32::MAX);
        write_volatile((TIMER + 4) as *mut u32, u32::MAX);
        write_volatile(TIMER as *mut u32, 1);
    }
}

/// Instructions since [`start`], to a tick (40 or 50 instructions).
pub fn instructions() -> u64 {
    // SAFETY: as above; reading VALUE changes nothing.
    let value = unsafe { read_volatile((TIMER + 4) as *const u32) };
    u64::from(u32::MAX - value) * u64::from(PER_TICK)
}

/// Both ends of the stack, its end first.
pub(super) fn stack() -> (*const u32, *const u32) {
    unsafe extern "C" {
        static _stack_start: u32;
        static _stack_end: u32;
    }
    (&raw const _stack_end, &raw const _stack_start)
}
