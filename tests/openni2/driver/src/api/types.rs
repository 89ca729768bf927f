//! The structures that go over the border, as `OniDriverTypes.h` and `OniCTypes.h` lay them out.

#![allow(unsafe_code, reason = "pointers of the library's go from thread to thread")]

use std::ffi::{c_char, c_int, c_void};

use super::StreamHandle;

/// `OniDeviceInfo`.
#[repr(C)]
pub struct DeviceInfo {
    pub uri: [c_char; 256],
    pub vendor: [c_char; 256],
    pub name: [c_char; 256],
    pub vendor_id: u16,
    pub product_id: u16,
}

impl DeviceInfo {
    /// A device of these names, with the numbers of a PrimeSense sensor.
    pub fn new(uri: &str, vendor: &str, name: &str) -> Self {
        let [uri, vendor, name] = [uri, vendor, name].map(|text| {
            let mut field = [0; 256];
            for (to, from) in field.iter_mut().zip(text.bytes()) {
                *to = from as c_char;
            }
            field
        });
        Self { uri, vendor, name, vendor_id: 0x1d27, product_id: 0x0601 }
    }
}

/// `OniVideoMode`: pixel format, columns, rows, rate.
pub type VideoMode = [c_int; 4];

/// `OniSensorInfo`.
#[repr(C)]
pub struct SensorInfo {
    pub sensor: c_int,
    pub count: c_int,
    pub modes: *const VideoMode,
}

/// `OniFrame`.
#[repr(C)]
pub struct OniFrame {
    pub size: c_int,
    pub data: *mut u8,
    pub sensor: c_int,
    pub timestamp: u64,
    pub index: c_int,
    pub width: c_int,
    pub height: c_int,
    pub mode: VideoMode,
    pub cropped: c_int,
    pub crop_origin: [c_int; 2],
    pub stride: c_int,
}

/// `OniStreamServices`.
#[repr(C)]
pub struct Services {
    pub library: *mut c_void,
    pub default_size: extern "C" fn(*mut c_void) -> c_int,
    pub acquire: extern "C" fn(*mut c_void) -> *mut OniFrame,
    pub add_reference: extern "C" fn(*mut c_void, *mut OniFrame),
    pub release: extern "C" fn(*mut c_void, *mut OniFrame),
}

pub type OnDevice = extern "C" fn(*const DeviceInfo, *mut c_void);
pub type OnState = extern "C" fn(*const DeviceInfo, c_int, *mut c_void);
pub type OnFrame = extern "C" fn(*mut StreamHandle, *mut OniFrame, *mut c_void);
pub type OnProperty = extern "C" fn(*mut c_void, c_int, *const c_void, c_int, *mut c_void);

/// A pointer of the library's that its other threads may use too.
pub struct Foreign<T>(pub *mut T);

impl<T> Clone for Foreign<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Foreign<T> {}

// SAFETY: they are cookies and service tables of the library, which calls of any thread are meant to hand back.
unsafe impl<T> Send for Foreign<T> {}
// SAFETY: as above.
unsafe impl<T> Sync for Foreign<T> {}

impl<T> Foreign<T> {
    /// The pointer; by a method, so that a closure takes the whole and not the bare pointer inside.
    pub const fn get(self) -> *mut T {
        self.0
    }
}
