//! A device or file whose streams run.

use std::ffi::{CString, c_int};
use std::sync::Arc;
use std::time::{Duration, Instant};

use pldi_core::Intrinsics;

use super::facts::{Failure, Frame, Heard};
use super::library::{Device, Library, Plain, Stream};
use super::sys::{self, VideoMode};
use super::{find, modes, pixels};
use crate::Error;
use crate::error::IntrinsicsOrigin;
use crate::input::intrinsics::checked;
use crate::input::{Mode, RawFrame, Stamp};

/// Depth and, where there is one, colour of a device.
pub(super) struct Session {
    library: Arc<Library>,
    device: Arc<Device>,
    /// Depth, then colour.
    streams: Vec<Stream>,
    uri: String,
    /// What had been heard of the device before it was opened.
    before: Heard,
    mirrored: [bool; 2],
    camera: Option<Intrinsics>,
    /// Frames per second.
    rate: u16,
    synced: bool,
    /// When a file was opened.
    playing: Option<Instant>,
}

/// OpenNI2's player of files has a thread that goes through the streams without a lock: it needs so long to notice that
/// they were stopped, and so long from opening a file until it can be closed. Without these, one of a hundred programs
/// crashes (2.2.0.33).
const PLAYER_STOPS: Duration = Duration::from_millis(50);
const PLAYER_STARTS: Duration = Duration::from_millis(150);

impl Drop for Session {
    fn drop(&mut self) {
        for stream in &self.streams {
            stream.stop();
        }
        if let Some(opened) = self.playing {
            std::thread::sleep(PLAYER_STOPS.max(PLAYER_STARTS.saturating_sub(opened.elapsed())));
        }
    }
}

/// Which stream an image is from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Depth,
    Colour,
}

impl Session {
    /// Opens a sensor in a mode and starts it.
    pub(super) fn sensor(library: &Arc<Library>, uri: &str, wanted: Option<Mode>) -> Result<Self, Error> {
        let mut session = Self::open(library, uri, |failure| find::cannot_open(uri, failure))?;
        let no_depth = || Error::Device(format!("the device {uri} has no depth sensor"));
        let depth = session.device.modes(sys::SENSOR_DEPTH).ok_or_else(no_depth)?;
        let colour = session.device.modes(sys::SENSOR_COLOUR);
        let (depth, colour) = modes::choose(wanted, &depth, colour.as_deref()).map_err(|reason| {
            let reason = format!("the device {uri}: {reason}");
            if wanted.is_some() { Error::Usage(reason) } else { Error::Device(reason) }
        })?;
        let failed = |failure: Failure| Error::Device(format!("the device {uri} does not start: {failure}"));
        for (sensor, mode) in [(sys::SENSOR_DEPTH, Some(depth)), (sys::SENSOR_COLOUR, colour)] {
            let Some(mode) = mode else { continue };
            let stream = session.device.stream(sensor).map_err(failed)?;
            stream.set(sys::STREAM_VIDEO_MODE, mode).map_err(failed)?;
            // Whether it took is read back later.
            let _ = stream.set::<c_int>(sys::STREAM_MIRRORING, 0);
            session.streams.push(stream);
        }
        session.start().map_err(failed)?;
        session.rate = modes::mode(&depth).map_or(0, |mode| mode.rate);
        let registered = colour.is_some() && session.register();
        session.camera = session.field_of_view(registered);
        session.synced = colour.is_some() && session.device.sync().is_ok();
        tracing::debug!("{uri}: {depth:?}, {colour:?}, registered {registered}, synchronised {}", session.synced);
        Ok(session)
    }

    /// Opens a file and starts it; a frame comes when it is asked for.
    pub(super) fn file(library: &Arc<Library>, path: &str) -> Result<Self, Error> {
        let damaged = |failure: &dyn std::fmt::Display| Error::Content {
            path: path.into(),
            reason: format!("OpenNI2 cannot play it ({failure})"),
        };
        let mut session = Self::open(library, path, |failure| {
            format!("{path}: OpenNI2 cannot play it ({failure}): it is no .oni recording, or it was cut or damaged")
        })?;
        session.playing = Some(Instant::now());
        let device = &session.device;
        device.set(sys::DEVICE_PLAYBACK_SPEED, sys::PLAYBACK_MANUAL).map_err(|f| damaged(&f))?;
        device.set::<c_int>(sys::DEVICE_PLAYBACK_REPEAT, 0).map_err(|f| damaged(&f))?;
        if device.modes(sys::SENSOR_DEPTH).is_none() {
            return Err(damaged(&"there is no depth in it"));
        }
        for sensor in [sys::SENSOR_DEPTH, sys::SENSOR_COLOUR] {
            if device.modes(sensor).is_some() {
                session.streams.push(device.stream(sensor).map_err(|f| damaged(&f))?);
            }
        }
        session.start().map_err(|f| damaged(&f))?;
        if session.device.get::<c_int>(sys::DEVICE_REGISTRATION) == Ok(0) {
            tracing::warn!("{path} was recorded without registration: depth does not lie on colour");
        }
        // Files do not say whether depth was registered; but frames must be.
        session.camera = session.field_of_view(session.has_colour());
        Ok(session)
    }

    fn open(library: &Arc<Library>, uri: &str, failed: impl FnOnce(&str) -> String) -> Result<Self, Error> {
        let before = library.heard(uri);
        let name = CString::new(uri).map_err(|_| Error::Usage(format!("{uri:?} is no name of a device")))?;
        if uri.len() >= sys::MAX_TEXT {
            let most = sys::MAX_TEXT - 1;
            return Err(Error::Usage(format!("{uri}: OpenNI2 takes names of {most} bytes at most, move the file")));
        }
        let device = library.open(&name).map_err(|failure| Error::Device(failed(&failure.to_string())))?;
        let (streams, camera, mirrored, rate, synced, playing) = Default::default();
        let (library, device, uri) = (Arc::clone(library), Arc::new(device), uri.to_owned());
        Ok(Self { library, device, streams, uri, before, mirrored, camera, rate, synced, playing })
    }

    fn start(&mut self) -> Result<(), Failure> {
        for stream in &self.streams {
            stream.start()?;
        }
        for (stream, mirrored) in self.streams.iter().zip(&mut self.mirrored) {
            // A stream without such a property is as the sensor sees.
            *mirrored = stream.get::<c_int>(sys::STREAM_MIRRORING).is_ok_and(|on| on != 0);
        }
        Ok(())
    }

    /// Has depth registered to colour, which sensors forget unless their streams run; says where that fails.
    fn register(&self) -> bool {
        let uri = &self.uri;
        if !self.device.registers() {
            tracing::warn!("{uri} does not register depth to colour: the two images do not lie on each other");
            return false;
        }
        let set = self.device.set(sys::DEVICE_REGISTRATION, sys::DEPTH_TO_COLOUR);
        let says = match (set, self.device.get::<c_int>(sys::DEVICE_REGISTRATION)) {
            (_, Ok(sys::DEPTH_TO_COLOUR)) => return true,
            (Err(failure), _) | (Ok(()), Err(failure)) => failure.to_string(),
            (Ok(()), Ok(_)) => "it is still off when it is read back".to_owned(),
        };
        tracing::warn!("{uri}: depth was not registered to colour ({says}): the two images do not lie on each other");
        false
    }

    /// The camera, from its angles of view: the colour camera's where depth is registered to it.
    fn field_of_view(&self, registered: bool) -> Option<Intrinsics> {
        let depth = self.streams.first()?;
        let size = modes::mode(&depth.get::<VideoMode>(sys::STREAM_VIDEO_MODE).ok()?)?;
        let angles = |stream: &Stream| {
            let angle = |property| stream.get::<f32>(property).ok().filter(|a| *a > 0.0 && *a < std::f32::consts::PI);
            Some((angle(sys::STREAM_HORIZONTAL_FOV)?, angle(sys::STREAM_VERTICAL_FOV)?))
        };
        let colour = self.streams.get(1).filter(|_| registered);
        let (across, down) = colour.and_then(angles).or_else(|| angles(depth))?;
        camera((size.width, size.height), [across, down])
    }

    /// Whether there is a colour stream.
    pub(super) fn has_colour(&self) -> bool {
        self.streams.len() > 1
    }

    /// Nanoseconds between two frames; 0 where that is not known.
    pub(super) fn period(&self) -> i64 {
        if self.rate == 0 { 0 } else { 1_000_000_000 / i64::from(self.rate) }
    }

    /// Whether both cameras take their images at once. If nothing comes then, it can be ended.
    pub(super) fn synced(&mut self, go_on: bool) -> bool {
        if self.synced && !go_on {
            self.device.unsync();
            self.synced = false;
            return true;
        }
        self.synced
    }

    /// Reads a property of the depth or the colour stream.
    pub(super) fn property<T: Plain>(&self, kind: Kind, property: c_int) -> Option<T> {
        self.streams.get(kind as usize)?.get(property).ok()
    }

    /// What was heard of the device since it was opened, as (disconnections and failures, ends of the file).
    pub(super) fn heard(&self) -> (u64, u64) {
        let (now, before) = (self.library.heard(&self.uri), self.before);
        let lost = now.disconnected + now.failed - before.disconnected - before.failed;
        (lost, now.ended - before.ended)
    }

    /// Waits for an image.
    pub(super) fn read(&self, at_most: Duration) -> Result<Option<(Kind, Frame)>, Failure> {
        let streams: Vec<&Stream> = self.streams.iter().collect();
        let Some(ready) = self.library.wait(&streams, at_most)? else { return Ok(None) };
        let kind = if ready == 0 { Kind::Depth } else { Kind::Colour };
        Ok(self.streams.get(ready).map(Stream::read).transpose()?.flatten().map(|frame| (kind, frame)))
    }

    /// A frame from a pair of images.
    pub(super) fn frame(&self, name: String, pair: (Stamp, Frame, Option<(Stamp, Frame)>), dropped: u64) -> RawFrame {
        let (stamp, depth, colour) = pair;
        let mirrored = self.mirrored;
        let origin = || IntrinsicsOrigin::Source("the device's field of view".to_owned());
        let camera = self.camera.map(|camera| (camera, origin()));
        let (colour_stamp, colour) = colour.unzip();
        let path = name.clone().into();
        let images = Box::new(move || {
            pixels::images(&depth, colour.as_ref(), mirrored).map_err(|reason| Error::Content { path, reason })
        });
        RawFrame { stamp, colour_stamp, name, frame_id: None, camera, dropped, images }
    }
}

/// A pinhole camera of these angles of view, in radians; `None` where they cannot be.
fn camera(size: (u16, u16), angles: [f32; 2]) -> Option<Intrinsics> {
    let focal = |pixels: u16, angle: f32| f64::from(pixels) / 2.0 / libm::tan(f64::from(angle) / 2.0);
    let centre = |pixels: u16| (f64::from(pixels) - 1.0) / 2.0;
    let k = [focal(size.0, angles[0]), focal(size.1, angles[1]), centre(size.0), centre(size.1)];
    checked(&IntrinsicsOrigin::Default, size, k).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_camera_of_a_primesense_sensor() {
        // Its depth camera's angles of view, as its driver tells them.
        let camera = camera((640, 480), [1.022_599_9, 0.796_616]).unwrap();
        assert!((camera.fx - 570.34).abs() < 0.05 && (camera.fy - 570.34).abs() < 0.3, "{camera:?}");
        assert_eq!((camera.cx, camera.cy), (319.5, 239.5));
        assert!(super::camera((640, 480), [f32::NAN, 1.0]).is_none());
        assert!(super::camera((640, 480), [1e-30, 1.0]).is_none());
    }
}
