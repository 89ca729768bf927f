//! What the library and its users ask a device and its streams about, as bytes.

use crate::controls::Registration;
use crate::device::{Device, Mode};
use crate::film::Kind;

/// What goes wrong, by OpenNI2's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i32)]
pub enum Failure {
    /// Something else.
    Error = 1,
    /// There is no such property.
    Unsupported = 3,
    /// Wrong size or value.
    Parameter = 4,
    /// Not while the stream runs.
    Flow = 5,
}

const DRIVER_VERSION: i32 = 1;
const SERIAL: i32 = 3;
const REGISTRATION: i32 = 5;

const CROPPING: i32 = 0;
const HORIZONTAL_FOV: i32 = 1;
const VERTICAL_FOV: i32 = 2;
const VIDEO_MODE: i32 = 3;
const MAX_VALUE: i32 = 4;
const MIN_VALUE: i32 = 5;
const STRIDE: i32 = 6;
const MIRRORING: i32 = 7;
const AUTO_WHITE_BALANCE: i32 = 100;
const AUTO_EXPOSURE: i32 = 101;

/// Greatest depth in mm, as of the PrimeSense sensors.
const MAX_DEPTH: i32 = 10_000;

/// Bytes of some numbers of 4 bytes each.
fn words<const N: usize>(words: [i32; N]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_ne_bytes()).collect()
}

fn word(bytes: &[u8], at: usize) -> Option<i32> {
    bytes.get(4 * at..4 * at + 4)?.try_into().ok().map(i32::from_ne_bytes)
}

/// A property that is one number and nothing else.
fn number(bytes: &[u8]) -> Result<i32, Failure> {
    word(bytes, 0).filter(|_| bytes.len() == 4).ok_or(Failure::Parameter)
}

/// Number of the pixel format: mm, RGB.
pub const fn format(kind: Kind) -> i32 {
    match kind {
        Kind::Depth => 100,
        Kind::Color => 200,
    }
}

/// A video mode as OpenNI2 has it: format, columns, rows, rate.
pub const fn video_mode(kind: Kind, mode: Mode) -> [i32; 4] {
    [format(kind), mode.width as i32, mode.height as i32, mode.rate as i32]
}

/// What the device says.
pub fn device(device: &Device, property: i32) -> Result<Vec<u8>, Failure> {
    match property {
        DRIVER_VERSION => Ok(words([1, 0, 0, 0])),
        SERIAL => Ok(b"PLDI0001\0".to_vec()),
        REGISTRATION if device.hub.controls.registration != Registration::Unsupported => {
            Ok(words([device.registered().into()]))
        }
        _ => Err(Failure::Unsupported),
    }
}

/// What the device is told.
pub fn set_device(device: &Device, property: i32, value: &[u8]) -> Result<(), Failure> {
    match property {
        REGISTRATION if device.hub.controls.registration != Registration::Unsupported => match number(value)? {
            on @ (0 | 1) => {
                device.register(on == 1);
                Ok(())
            }
            _ => Err(Failure::Parameter),
        },
        _ => Err(Failure::Unsupported),
    }
}

/// What a stream says.
pub fn stream(device: &Device, kind: Kind, property: i32) -> Result<Vec<u8>, Failure> {
    let stream = device.with(kind, |stream| stream.clone()).ok_or(Failure::Error)?;
    let fov = device.hub.film.as_ref().ok_or(Failure::Error)?.fov;
    Ok(match property {
        CROPPING => words([0; 5]),
        HORIZONTAL_FOV => fov[0].to_ne_bytes().to_vec(),
        VERTICAL_FOV => fov[1].to_ne_bytes().to_vec(),
        VIDEO_MODE => words(video_mode(kind, stream.mode)),
        MAX_VALUE if kind == Kind::Depth => words([MAX_DEPTH]),
        MIN_VALUE if kind == Kind::Depth => words([0]),
        STRIDE => words([(stream.mode.width * kind.pixel()) as i32]),
        MIRRORING => words([stream.mirrored.into()]),
        AUTO_WHITE_BALANCE | AUTO_EXPOSURE if kind == Kind::Color => words([1]),
        _ => return Err(Failure::Unsupported),
    })
}

/// What a stream is told.
pub fn set_stream(device: &Device, kind: Kind, property: i32, value: &[u8]) -> Result<(), Failure> {
    match property {
        MIRRORING => {
            let mirrored = number(value)? != 0;
            device.with(kind, |stream| stream.mirrored = mirrored).ok_or(Failure::Error)
        }
        VIDEO_MODE => {
            let wanted = |mode: &Mode| value == words(video_mode(kind, *mode));
            let mode = device.modes().into_iter().find(wanted).ok_or(Failure::Parameter)?;
            let set = device.with(kind, |stream| {
                if !stream.started {
                    stream.mode = mode;
                }
                !stream.started
            });
            if set.ok_or(Failure::Error)? { Ok(()) } else { Err(Failure::Flow) }
        }
        AUTO_WHITE_BALANCE | AUTO_EXPOSURE if kind == Kind::Color => number(value).map(|_| ()),
        _ => Err(Failure::Unsupported),
    }
}
