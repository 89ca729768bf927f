//! A sensor as a source: it may be lost, and found again.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::clock::Clock;
use super::facts::{Failure, Frame, Listed};
use super::gaps::Gaps;
use super::library::Library;
use super::session::{Kind, Session};
use super::{find, is_file};
use crate::Error;
use crate::input::pair::{Pair, Pairer};
use crate::input::{Mode, OpenOptions, RawFrame, Source, Stop};

/// How long to wait for a frame before looking whether to give up.
const GLANCE: Duration = Duration::from_millis(100);
/// How often to look for a lost device.
const RETRY: Duration = Duration::from_millis(50);
/// Cameras that were asked to take their images at once, and give none for so long, are let go.
const SYNCHRONISED: Duration = Duration::from_secs(3);
/// A sensor that gives nothing for so long is mentioned.
const SILENT: Duration = Duration::from_secs(10);
/// Images of a stream that wait for one of the other.
const WAITING: usize = 8;
/// So many depth images without colour, one after the other, are mentioned: two seconds.
const WITHOUT_COLOUR: u64 = 60;

/// A sensor's frames.
pub(super) struct Live {
    library: Arc<Library>,
    device: Listed,
    mode: Option<Mode>,
    once: bool,
    /// `None` while the device is lost.
    session: Option<Session>,
    /// Why the device was lost, until its last frames are out.
    lost: Option<String>,
    pairer: Pairer<Frame, Frame>,
    clock: Clock,
    /// When the last image came.
    heard: Instant,
    gaps: Gaps,
    given: u64,
    warned_silent: bool,
    warned_colour: bool,
    warned_reopen: bool,
}

impl Live {
    /// Opens the device of that URI, or the first one.
    pub(super) fn open(library: Arc<Library>, uri: &str, options: &OpenOptions) -> Result<Self, Error> {
        let devices = library.devices().map_err(|failure| Error::Device(format!("no list of devices: {failure}")))?;
        let listed =
            devices.iter().find(|device| if uri.is_empty() { !is_file(&device.uri) } else { device.uri == uri });
        let device = match listed {
            Some(device) => device.clone(),
            None if uri.is_empty() => return Err(Error::Device(find::no_device())),
            // Some drivers know devices that they do not list, as those of a network.
            None => Listed { uri: uri.to_owned(), vendor: String::new(), name: String::new(), usb: (0, 0) },
        };
        let session = Session::sensor(&library, &device.uri, options.mode).map_err(|error| match (listed, error) {
            (None, Error::Device(reason)) => {
                let there: Vec<&str> = devices.iter().map(|device| device.uri.as_str()).collect();
                let there = if there.is_empty() { "none".to_owned() } else { there.join(", ") };
                Error::Device(format!("no device {uri} is listed (there is: {there}); {reason}"))
            }
            (_, error) => error,
        })?;
        let mut live = Self {
            library,
            device,
            mode: options.mode,
            once: options.once,
            session: None,
            lost: None,
            pairer: Pairer::depth_only(),
            clock: Clock::default(),
            heard: Instant::now(),
            gaps: Gaps::default(),
            given: 0,
            warned_silent: false,
            warned_colour: false,
            warned_reopen: false,
        };
        live.begin(session);
        Ok(live)
    }

    /// Frames are those of this session from now on.
    fn begin(&mut self, session: Session) {
        self.pairer = if session.has_colour() {
            Pairer::new(WAITING).spaced(session.period() / 2)
        } else {
            tracing::warn!("{} has no colour sensor: frames are depth alone", self.device.uri);
            Pairer::depth_only()
        };
        self.session = Some(session);
        self.gaps.restart();
        self.warned_silent = false;
        self.warned_reopen = false;
    }

    /// Takes an image if one comes soon.
    fn take(&mut self) {
        let Some(session) = &mut self.session else { return };
        match session.read(GLANCE) {
            Ok(Some((kind, frame))) => {
                let stamp = self.clock.stamp(frame.microseconds, self.heard.elapsed());
                self.heard = Instant::now();
                self.warned_silent = false;
                match kind {
                    Kind::Colour => self.pairer.push_colour(stamp, frame),
                    Kind::Depth => {
                        self.gaps.next(frame.index);
                        self.pairer.push_depth(stamp, frame);
                    }
                }
                self.count_left_out();
            }
            Ok(None) => self.look(),
            Err(failure) => self.lose(&failure.to_string()),
        }
    }

    fn count_left_out(&mut self) {
        self.gaps.lost += self.pairer.take_left_out().depth;
        if self.gaps.lost >= WITHOUT_COLOUR && !self.warned_colour {
            self.warned_colour = true;
            let uri = &self.device.uri;
            tracing::warn!(
                "{uri}: {} depth images have no colour image of their time and are left out",
                self.gaps.lost
            );
        }
    }

    /// No image came: whether the device is still there.
    fn look(&mut self) {
        let Some(session) = &mut self.session else { return };
        if session.heard().0 > 0 {
            return self.lose("it was unplugged or failed");
        }
        let silent = self.heard.elapsed();
        if silent > SYNCHRONISED && session.synced(true) {
            tracing::debug!("{}: nothing comes while the cameras are synchronised", self.device.uri);
            session.synced(false);
            self.heard = Instant::now();
        } else if silent > SILENT {
            match self.library.devices() {
                Ok(devices) if !devices.iter().any(|device| device.uri == self.device.uri) => {
                    self.lose("it is not listed");
                }
                _ if !self.warned_silent => {
                    self.warned_silent = true;
                    tracing::warn!("{} has given no image for {} s", self.device.uri, SILENT.as_secs());
                }
                _ => {}
            }
        }
    }

    fn lose(&mut self, why: &str) {
        // What was pending finds its partner now or never.
        self.pairer.end();
        self.count_left_out();
        self.lost = Some(why.to_owned());
    }

    /// Closes what is lost; says so, or ends with it.
    fn close(&mut self, why: &str) -> Result<(), Error> {
        self.session = None;
        let uri = &self.device.uri;
        if self.once {
            return Err(Error::Device(format!("the device {uri} was lost: {why}")));
        }
        tracing::warn!("the device {uri} was lost ({why}); waiting for it to come back");
        Ok(())
    }

    /// Opens the device if it is there again.
    fn reopen(&mut self) {
        let uri = match self.found() {
            Ok(Some(uri)) => uri,
            Ok(None) => return,
            Err(failure) => return tracing::debug!("no list of devices: {failure}"),
        };
        match Session::sensor(&self.library, &uri, self.mode) {
            Ok(session) => {
                tracing::warn!("the device {uri} is back");
                self.device.uri = uri;
                self.clock.reopened();
                self.begin(session);
            }
            // It may still be starting.
            Err(error) if self.warned_reopen => tracing::debug!("{error}"),
            Err(error) => {
                self.warned_reopen = true;
                tracing::warn!("{error}; trying on");
            }
        }
    }

    /// The URI under which the device is listed now: at another socket it has another.
    fn found(&self) -> Result<Option<String>, Failure> {
        let devices = self.library.devices()?;
        let same = |device: &&Listed| device.uri == self.device.uri;
        let alike = |device: &&Listed| {
            (&device.vendor, &device.name, device.usb) == (&self.device.vendor, &self.device.name, self.device.usb)
        };
        Ok(devices.iter().find(same).or_else(|| devices.iter().find(alike)).map(|device| device.uri.clone()))
    }

    fn frame(&mut self, pair: Pair<Frame, Frame>) -> Option<RawFrame> {
        let name = format!("{} frame {}", self.device.uri, self.given);
        self.given += 1;
        let dropped = self.gaps.take();
        Some(self.session.as_ref()?.frame(name, pair, dropped))
    }
}

impl Source for Live {
    fn next(&mut self, stop: &Stop) -> Result<Option<RawFrame>, Error> {
        loop {
            if stop.is_raised() {
                return Ok(None);
            }
            if let Some(pair) = self.pairer.pop() {
                return Ok(self.frame(pair));
            }
            if let Some(why) = self.lost.take() {
                self.close(&why)?;
            }
            if self.session.is_some() {
                self.take();
            } else {
                self.reopen();
                if self.session.is_none() {
                    std::thread::sleep(RETRY);
                }
            }
        }
    }

    fn is_live(&self) -> bool {
        true
    }
}
