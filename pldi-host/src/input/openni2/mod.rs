//! Sensors that OpenNI2 has drivers for (PrimeSense, Asus Xtion, Orbbec, Kinect v1), and its recordings (`.oni`).

mod clock;
mod facts;
mod film;
mod find;
mod gaps;
mod library;
mod live;
mod modes;
mod pixels;
mod session;
mod sys;

use std::ffi::CString;
use std::path::Path;

use serde::Serialize;

use self::library::Library;
use super::{OpenOptions, Source};
use crate::Error;

/// What the URIs of sensors begin with.
const SCHEME: &str = "openni2:";

/// Whether a URI is one of a sensor: `openni2:` for the first one, `openni2:URI` for that of OpenNI2's URI.
pub(super) fn is_sensor(uri: &str) -> bool {
    uri.starts_with(SCHEME)
}

/// Whether a name is that of a recording.
pub(super) fn is_file(name: &str) -> bool {
    Path::new(name).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("oni"))
}

/// Opens a sensor or a recording.
pub(super) fn open(uri: &str, options: &OpenOptions) -> Result<Box<dyn Source>, Error> {
    let name = uri.strip_prefix(SCHEME).unwrap_or(uri);
    let library = Library::get()?;
    if is_file(name) {
        return Ok(Box::new(film::Film::open(&library, name)?));
    }
    Ok(Box::new(live::Live::open(library, name, options)?))
}

/// A device that OpenNI2 lists.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Device {
    /// What opens it: `openni2:` and OpenNI2's own URI.
    pub uri: String,
    /// Its maker.
    pub vendor: String,
    /// Its name.
    pub name: String,
    /// Vendor and product number on the USB, four hexadecimal digits each; empty for devices without.
    pub usb: String,
    /// Its cameras.
    pub sensors: Vec<Sensor>,
    /// Why the sensors are not known, where the device cannot be opened.
    pub error: Option<String>,
}

/// A camera of a device.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Sensor {
    /// depth, colour or infrared.
    pub kind: String,
    /// Its modes, as `640x480@30`, by their pixel formats.
    pub modes: Vec<Modes>,
}

/// A camera's modes of one pixel format.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Modes {
    /// The format.
    pub format: String,
    /// Sizes and rates.
    pub sizes: Vec<String>,
}

/// The devices that are there, each opened for a moment to ask for its modes.
///
/// # Errors
/// Where OpenNI2 is not there or does not start; says what to do.
pub fn devices() -> Result<Vec<Device>, Error> {
    let library = Library::get()?;
    let listed = library.devices().map_err(|failure| Error::Device(format!("no list of devices: {failure}")))?;
    let devices = listed.into_iter().map(|listed| {
        let opened = CString::new(listed.uri.as_str()).map_err(|error| error.to_string());
        let opened = opened.and_then(|uri| library.open(&uri).map_err(|failure| failure.to_string()));
        let (sensors, error) = match opened {
            Ok(device) => (sys::SENSORS.iter().filter_map(|&sensor| describe(&device, sensor)).collect(), None),
            Err(failure) => (Vec::new(), Some(find::cannot_open(&listed.uri, &failure))),
        };
        let usb = match listed.usb {
            (0, 0) => String::new(),
            (vendor, product) => format!("{vendor:04x}:{product:04x}"),
        };
        let uri = format!("{SCHEME}{}", listed.uri);
        Device { uri, vendor: listed.vendor, name: listed.name, usb, sensors, error }
    });
    Ok(devices.collect())
}

/// What to say where [`devices`] gives none: the drivers that there are, and what is plugged in.
pub fn why_none() -> String {
    find::no_device()
}

fn describe(device: &library::Device, (number, kind): (i32, &str)) -> Option<Sensor> {
    let mut modes: Vec<Modes> = Vec::new();
    for video in device.modes(number)? {
        let format = modes::format_name(video.format);
        let size = modes::mode(&video).map(|mode| mode.to_string());
        match modes.iter_mut().find(|modes| modes.format == format) {
            Some(modes) => modes.sizes.extend(size),
            None => modes.push(Modes { format, sizes: size.into_iter().collect() }),
        }
    }
    Some(Sensor { kind: kind.to_owned(), modes })
}
