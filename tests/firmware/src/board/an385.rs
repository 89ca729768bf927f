//! Arm MPS2 with AN385: Cortex-M3, 25 MHz.

/// As it is called in reports.
pub const NAME: &str = "Cortex-M3, mps2-an385";

/// The timer of 32 bits that counts down at the board's clock.
pub(super) const TIMER: usize = 0x4000_0000;

/// Instructions per tick, where QEMU lets one take a nanosecond.
pub(super) const PER_TICK: u32 = 40;
