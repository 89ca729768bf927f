//! Files written: whole or not at all.

pub mod atomic;
pub mod mcap;
pub mod png;
