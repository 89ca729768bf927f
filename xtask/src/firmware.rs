//! `tests/firmware`: images for microcontrollers, built for a board and run in QEMU.
#![allow(dead_code, reason = "the tasks that use these come one by one")]

mod board;
mod build;
mod data;
mod qemu;

#[allow(unused_imports, reason = "as above")]
pub(crate) use self::{
    board::{BOARDS, Board},
    build::build,
    data::folder,
    qemu::{command, qemu},
};
