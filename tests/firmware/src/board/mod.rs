//! What differs between the boards.

#[cfg(target_arch = "arm")]
mod cortex_m;
#[cfg(target_arch = "arm")]
pub use self::cortex_m::{entry, instructions, stack_used, start};

#[cfg_attr(feature = "an385", path = "an385.rs")]
#[cfg_attr(feature = "an386", path = "an386.rs")]
#[cfg_attr(feature = "an500", path = "an500.rs")]
#[cfg_attr(feature = "an505", path = "an505.rs")]
#[cfg_attr(feature = "virt", path = "virt.rs")]
mod this;
pub use this::*;
