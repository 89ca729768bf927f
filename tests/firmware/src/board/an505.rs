//! Arm MPS2+ with AN505: Cortex-M33 in its secure state, 20 MHz.

/// As it is called in reports.
pub const NAME: &str = "Cortex-M33, mps2-an505";

/// The timer of 32 bits that counts down at the board's clock.
pub(super) const TIMER: usize = 0x5000_0000;

/// Instructions per tick, where QEMU lets one take a nanosecond.
pub(super) const PER_TICK: u32 = 50;
