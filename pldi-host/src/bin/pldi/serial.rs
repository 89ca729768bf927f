//! `pldi run --from-serial`: a device's results, one JSON line each.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver as Queue, RecvTimeoutError, SyncSender};
use std::time::Duration;

use pldi_core::serial::{Reject, StatusCode};
use pldi_core::templates::Templates;
use pldi_host::Error;
use pldi_host::serial::{Answer, Names, Receiver, SerialReport, Traffic, port};

use crate::{print, progress};

/// Options of `pldi run --from-serial`.
#[derive(Debug, clap::Args)]
pub struct FromSerial {
    /// Print what a device answers, in place of a recording's results: a serial port, a FIFO, a file with what was
    /// received, or - for stdin. Frames without a result, and what was corrupted on the way, are told on stderr
    #[arg(
        long = "from-serial", value_name = "PATH",
        conflicts_with_all = ["input", "color", "depth", "info", "mode", "once", "frames", "depth_scale", "intrinsics", "camera_info", "overlay", "mcap", "keep_going", "threads", "arithmetic", "filter", "floor", "framing", "descriptor"]
    )]
    path: Option<PathBuf>,
    /// Rate of the serial port
    #[arg(long, value_name = "RATE", default_value_t = 115_200, requires = "path")]
    baud: u32,
}

/// What the reading thread tells.
enum Event {
    /// An answer.
    Answer(Answer),
    /// Nothing more comes: the counts, and why it ended where that was no end of the stream.
    End(Traffic, io::Result<()>),
    /// The counts so far.
    So(Traffic),
}

impl FromSerial {
    /// Where to listen, if that is asked for.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// Prints what comes until it ends, or an interrupt. `templates` name classes and objects where the device has the same.
    pub fn listen(&self, path: &Path, templates: Templates<'_>) -> anyhow::Result<()> {
        // A read may wait for ever; whoever waits for the thread can look whether to go on.
        let (to, from) = mpsc::sync_channel(64);
        let (place, baud) = (path.to_owned(), self.baud);
        std::thread::spawn(move || {
            let _ = match port::open(&place, baud) {
                Ok(reader) => read(Receiver::new(reader), &to),
                Err(Error::Read { cause, .. }) => to.send(Event::End(Traffic::default(), Err(cause))).ok(),
                Err(error) => to.send(Event::End(Traffic::default(), Err(io::Error::other(error)))).ok(),
            };
        });
        let mut printer =
            Printer { names: Names::new(Some(templates)), traffic: Traffic::default(), warned: None, failed: 0 };
        let result = printer.print(&from, path);
        printer.summary();
        result?;
        let Traffic { bytes, answers, .. } = printer.traffic;
        anyhow::ensure!(
            bytes == 0 || answers > 0,
            "{}: no answer of a device in {bytes} bytes: is it this protocol, and the right --baud?",
            path.display()
        );
        Ok(())
    }
}

/// Reads to the end; `None` where nobody listens any more.
fn read(mut receiver: Receiver<Box<dyn io::Read + Send>>, to: &SyncSender<Event>) -> Option<()> {
    loop {
        match receiver.next() {
            Ok(Some(received)) => {
                to.send(Event::So(receiver.traffic())).ok()?;
                to.send(Event::Answer(received.answer)).ok()?;
            }
            Ok(None) => return to.send(Event::End(receiver.traffic(), Ok(()))).ok(),
            Err(error) if matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock) => {
                to.send(Event::So(receiver.traffic())).ok()?;
            }
            Err(error) => return to.send(Event::End(receiver.traffic(), Err(error))).ok(),
        }
    }
}

/// Where the answers go.
struct Printer<'a> {
    names: Names<'a>,
    traffic: Traffic,
    /// Hash of the templates that a warning was about.
    warned: Option<u32>,
    /// Frames without a result.
    failed: u64,
}

impl Printer<'_> {
    fn print(&mut self, from: &Queue<Event>, path: &Path) -> anyhow::Result<()> {
        loop {
            if progress::interrupted() {
                return Err(Error::Interrupted.into());
            }
            match from.recv_timeout(Duration::from_millis(50)) {
                Ok(Event::Answer(answer)) => self.answer(answer)?,
                Ok(Event::So(traffic)) => self.traffic = traffic,
                Ok(Event::End(traffic, result)) => {
                    self.traffic = traffic;
                    return Ok(result.map_err(|cause| Error::Read { path: path.to_owned(), cause })?);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => anyhow::bail!("{}: the reader stopped", path.display()),
            }
        }
    }

    fn answer(&mut self, answer: Answer) -> anyhow::Result<()> {
        match answer {
            Answer::Detections(found) => {
                let hash = found.result.templates_hash.get();
                if !self.names.known(hash) && self.warned.replace(hash) != Some(hash) {
                    eprintln!(
                        "pldi: the device has other templates ({hash:08x}): give them with --templates to see names"
                    );
                }
                print::line(serde_json::to_string(&SerialReport::new(&found, &self.names))?)?;
            }
            Answer::Class(class) => self.names.learn(&class),
            Answer::Status(status) => {
                self.failed += 1;
                let name = StatusCode::from_number(status.code).map_or("unknown status", StatusCode::name);
                let (frame, missing) = (status.frame.get(), status.missing.get());
                let rows = if missing == 0 { String::new() } else { format!(", {missing} rows missing") };
                eprintln!("pldi: frame {frame}: {name}{rows}");
            }
            Answer::Info(info) => tracing::info!("{info:?}"),
            Answer::Pong(pong) => tracing::info!("{pong:?}"),
        }
        Ok(())
    }

    /// Says what went wrong on the way, if something did.
    fn summary(&self) {
        let Traffic { bytes, answers, repeated, rejects } = self.traffic;
        tracing::info!("{bytes} bytes, {answers} answers, {repeated} repeated");
        if self.failed > 0 {
            eprintln!("pldi: {} frames without a result", self.failed);
        }
        if rejects.total() > 0 {
            let reasons = Reject::ALL.iter().zip(rejects.counts()).filter(|(_, count)| *count > 0);
            let reasons: Vec<String> = reasons.map(|(reason, count)| format!("{count} {reason}")).collect();
            eprintln!("pldi: {} packets rejected: {}", rejects.total(), reasons.join(", "));
        }
    }
}
