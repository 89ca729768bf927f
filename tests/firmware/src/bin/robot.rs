//! A robot's co-processor: takes the rows of frames from a host over a line, and answers with detections, until the line
//! is closed. Memory is what the linker gave it.
//!
//! Arguments: the file (or FIFO) to read from, and the one to write to.
#![no_std]
#![no_main]

use core::ffi::CStr;

use firmware::failure::{Failure, end};
use firmware::{TEMPLATES, board, setup};
use pldi_core::Error;
use pldi_core::pipeline::QvgaFixedWorkspace;
use pldi_core::serial::{DEVICE_BUFFER, Decoder, Device};
use pldi_core::templates::Templates;
use semihosting::fs::File;
use semihosting::io::{Read, Write};
use semihosting::println;
use static_cell::ConstStaticCell;

static WORKSPACE: ConstStaticCell<QvgaFixedWorkspace> = ConstStaticCell::new(QvgaFixedWorkspace::new());
static DECODER: ConstStaticCell<Decoder<DEVICE_BUFFER>> = ConstStaticCell::new(Decoder::new());

#[firmware::board::entry]
fn main() -> ! {
    board::start();
    end(run())
}

fn run() -> Result<(), Failure> {
    let (mut input, mut output) = line()?;
    let templates = Templates::parse(TEMPLATES).map_err(Error::from)?;
    let pipeline = setup::FIXED.first().ok_or(Failure::Usage)?;
    let mut device = Device::new(pipeline, templates, WORKSPACE.take(), DECODER.take())?;
    device.telemetry().memory = memory();
    // As a line's interrupt would fill it.
    let mut bytes = [0; 512];
    loop {
        let count = input.read(&mut bytes)?;
        if count == 0 {
            break;
        }
        let (mut written, mut answered) = (Ok(()), false);
        let start = board::instructions();
        device.receive(bytes.get(..count).unwrap_or(&[]), &mut |piece| {
            answered = true;
            if written.is_ok() {
                written = output.write_all(piece);
            }
        });
        written?;
        if answered {
            device.telemetry().stack = board::stack_used() as u32;
            device.telemetry().time = (board::instructions() - start) as u32;
        }
    }
    println!("{}: {} packets rejected, stack {}", board::NAME, device.rejects().total(), board::stack_used());
    Ok(())
}

/// Opens both ends of the line.
fn line() -> Result<(File, File), Failure> {
    let arguments = semihosting::experimental::env::args::<512>()?;
    let mut arguments = (&arguments).into_iter().skip(1);
    let mut names = [[0; 256]; 2];
    for name in &mut names {
        let argument = arguments.next().and_then(Result::ok).ok_or(Failure::Usage)?;
        // The last zero stays.
        name.get_mut(..argument.len())
            .filter(|n| n.len() < 256)
            .ok_or(Failure::Usage)?
            .copy_from_slice(argument.as_bytes());
    }
    let [input, output] = names.each_ref().map(|name| CStr::from_bytes_until_nul(name));
    let (input, output) = (input.map_err(|_| Failure::Usage)?, output.map_err(|_| Failure::Usage)?);
    Ok((File::open(input)?, File::create(output)?))
}

/// Bytes of static memory.
#[cfg(target_arch = "arm")]
fn memory() -> u32 {
    unsafe extern "C" {
        static __sdata: u32;
        static __ebss: u32;
    }
    // Addresses alone: initialised data and zeros lie one behind the other.
    ((&raw const __ebss).addr() - (&raw const __sdata).addr()) as u32
}

#[cfg(not(target_arch = "arm"))]
fn memory() -> u32 {
    0
}
