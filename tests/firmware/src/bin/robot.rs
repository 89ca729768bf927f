//! A robot's co-processor: takes the rows of frames from a host over a line, and answers with detections, until the line
//! is closed. Memory is what the linker gave it.
//!
//! Arguments: the file (or FIFO) to read from, and the one to write to.
#![no_std]
#![no_main]

use firmware::failure::{Failure, end};
use firmware::{TEMPLATES, board, files, setup};
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
    device.telemetry().memory = board::static_memory() as u32;
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
    let mut argument = || arguments.next().and_then(Result::ok).ok_or(Failure::Usage);
    let (input, output) = (argument()?, argument()?);
    Ok((files::open(input, |name| File::open(name))?, files::open(output, |name| File::create(name))?))
}
