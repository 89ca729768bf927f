//! What stands for the rerun viewer where it is not built in: there is no such option, and nothing is shown.

use pldi_host::Error;
use pldi_host::input::Stop;
use pldi_host::runner::Processed;

/// No option.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct Rerun {}

impl Rerun {
    /// Nowhere.
    pub fn open(&self, _: &str, _: &Stop) -> Result<Stream, Error> {
        Ok(Stream)
    }

    /// Nothing.
    pub fn scene(&self, _: &mut Processed<'_>) -> Result<Shown, Error> {
        Ok(())
    }
}

/// Nothing.
pub type Shown = ();

/// Nowhere.
#[derive(Debug, Clone, Copy)]
pub struct Stream;

impl Stream {
    /// Does nothing.
    pub fn show(&mut self, (): Shown, _: &Stop) -> Result<(), Error> {
        Ok(())
    }

    /// Does nothing.
    pub fn end(self, _: bool) -> Result<(), Error> {
        Ok(())
    }
}
