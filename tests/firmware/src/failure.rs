//! What can go wrong in an image, and how it ends.

use pldi_core::Error;
use semihosting::process::ExitCode;
use semihosting::{io, println};

/// What can go wrong.
#[derive(Debug)]
#[allow(dead_code, reason = "what is in them is printed")]
pub enum Failure {
    /// The host's files.
    Host(io::Error),
    /// A file of the host ended too early.
    Cut,
    /// The pipeline and its templates.
    Core(Error),
    /// The frames were made for another camera.
    Camera([f32; 4]),
    /// The command line.
    Usage,
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::Host(error)
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Core(error)
    }
}

/// Ends the image with its exit code; a failure is printed.
pub fn end(result: Result<(), Failure>) -> ! {
    match result {
        Ok(()) => ExitCode::SUCCESS.exit_process(),
        Err(failure) => {
            println!("failed: {failure:?}");
            ExitCode::FAILURE.exit_process()
        }
    }
}
