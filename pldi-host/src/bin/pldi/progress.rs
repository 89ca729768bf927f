//! Progress on a terminal, and a clean end on an interrupt.

use std::sync::OnceLock;

use indicatif::{ProgressBar, ProgressStyle};
use pldi_host::input::Stop;

/// Raised by the first interrupt; sources that wait look at it.
pub fn stop() -> &'static Stop {
    static STOP: OnceLock<Stop> = OnceLock::new();
    STOP.get_or_init(Stop::default)
}

/// Lets the first interrupt (Ctrl-C, termination) end the work after the items under way; the second ends the process.
pub fn watch_interrupts() {
    let stop = stop();
    let handler = || {
        if stop.is_raised() {
            std::process::exit(130);
        }
        stop.raise();
    };
    if let Err(error) = ctrlc::set_handler(handler) {
        tracing::warn!("interrupts are not watched: {error}");
    }
}

/// Whether the work is to end.
pub fn interrupted() -> bool {
    stop().is_raised()
}

/// A progress bar on stderr, where that is a terminal; a counter where nobody knows how many there will be.
pub fn bar(count: Option<u64>) -> ProgressBar {
    let (bar, form) = match count {
        Some(count) => (ProgressBar::new(count), "{wide_bar} {pos}/{len} {per_sec} {eta}"),
        None => (ProgressBar::new_spinner(), "{spinner} {pos} {per_sec} {elapsed}"),
    };
    if let Ok(style) = ProgressStyle::with_template(form) {
        bar.set_style(style);
    }
    bar
}
