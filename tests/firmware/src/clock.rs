//! Instructions of the stages.

use crate::board;
use core::arch::asm;
use semihosting::println;

/// Rounds of the loop that the clock is checked with.
const ROUNDS: u32 = 1_000_000;

/// Instructions of one stage.
#[derive(Debug, Clone, Copy)]
pub struct Stage {
    name: &'static str,
    sum: u64,
}

impl Stage {
    /// A stage that has not run yet.
    pub const fn new(name: &'static str) -> Self {
        Self { name, sum: 0 }
    }

    /// Runs and counts.
    pub fn run<T>(&mut self, what: impl FnOnce() -> T) -> T {
        let start = board::instructions();
        let result = what();
        self.sum += board::instructions() - start;
        result
    }

    /// Prints what all runs took together.
    pub fn print(&self) {
        println!("budget {}: {}", self.name, self.sum);
    }
}

/// Counts a loop of known length: prints what was counted, and what it has.
pub fn calibrate() {
    let start = board::instructions();
    let mut left = ROUNDS;
    // SAFETY: registers only.
    unsafe {
        #[cfg(target_arch = "arm")]
        asm!("2: subs {0}, {0}, #1", "bne 2b", inout(reg) left);
        #[cfg(target_arch = "riscv32")]
        asm!("2: addi {0}, {0}, -1", "bnez {0}, 2b", inout(reg) left);
    }
    let counted = board::instructions() - start;
    println!("budget calibration: {counted} of {}", 2 * ROUNDS + left);
}
