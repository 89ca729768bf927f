//! What OpenNI2 tells, in types of Rust.

use std::ffi::{c_char, c_int};
use std::fmt;

use super::sys::{self, DeviceInfo};

/// What OpenNI2 says about a call that failed, and the call's status.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Failure {
    pub(super) status: c_int,
    pub(super) says: String,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let status = match self.status {
            2 => "not implemented",
            3 => "not supported",
            4 => "bad parameter",
            5 => "out of flow",
            6 => "no device",
            sys::TIME_OUT => "time-out",
            _ => "error",
        };
        let says = if self.says.is_empty() { String::new() } else { format!(", {}", self.says) };
        write!(f, "OpenNI2 says: {status}{says}")
    }
}

/// What was heard of a device: how often it came, went, failed, and came to the end of its file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Heard {
    pub(super) connected: u64,
    pub(super) disconnected: u64,
    pub(super) failed: u64,
    pub(super) ended: u64,
}

/// The text up to its 0, or all.
pub(super) fn text(chars: &[c_char]) -> String {
    let bytes: Vec<u8> = chars.iter().take_while(|&&c| c != 0).map(|&c| c.to_ne_bytes()[0]).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

/// A device as it is listed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Listed {
    pub(super) uri: String,
    pub(super) vendor: String,
    pub(super) name: String,
    pub(super) usb: (u16, u16),
}

impl From<&DeviceInfo> for Listed {
    fn from(info: &DeviceInfo) -> Self {
        let [uri, vendor, name] = [&info.uri, &info.vendor, &info.name].map(|chars| text(chars));
        Self { uri, vendor, name, usb: (info.usb_vendor, info.usb_product) }
    }
}

/// A frame's bytes and what belongs to them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Frame {
    pub(super) bytes: Vec<u8>,
    pub(super) microseconds: u64,
    pub(super) index: c_int,
    pub(super) size: (c_int, c_int),
    pub(super) stride: c_int,
    pub(super) format: c_int,
}
