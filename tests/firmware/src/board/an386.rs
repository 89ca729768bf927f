//! Arm MPS2 with AN386: Cortex-M4F, 25 MHz.

/// As it is called in reports.
pub const NAME: &str = "Cortex-M4F, mps2-an386";

/// The timer of 32 bits that counts down at the board's clock.
pub(super) const TIMER: usize = 0x4000_0000;

/// Instructions per tick, where QEMU lets one take a nanosecond.
pub(super) const PER_TICK: u32 = 40;
