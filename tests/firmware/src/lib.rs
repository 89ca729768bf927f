//! What the images share: boards, frames over semihosting, the pipelines' parameters, counting.
#![no_std]

pub mod board;
pub mod clock;
pub mod failure;
pub mod files;
pub mod frames;
pub mod setup;

/// The template file of the image's arithmetic, in flash.
pub static TEMPLATES: &[u8] = include_bytes!(env!("PLDI_TEMPLATES"));
