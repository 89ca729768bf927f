//! A bad line, for the tests of the serial protocol and for the loop with a device in an emulator.

#![allow(dead_code, reason = "each user uses its own part")]

pub mod corrupt;
pub mod stream;
