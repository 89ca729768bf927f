//! OpenNI2's C types and numbers (`OniCTypes.h`, `OniCEnums.h`, `OniCProperties.h` of 2.2), as far as they are used.

use std::ffi::{c_char, c_int, c_void};

/// What `oniInitialize` is told: 2.2.
pub(super) const API_VERSION: c_int = 2002;

pub(super) const OK: c_int = 0;
pub(super) const TIME_OUT: c_int = 102;

pub(super) const SENSOR_COLOUR: c_int = 2;
pub(super) const SENSOR_DEPTH: c_int = 3;

pub(super) const DEPTH_1_MM: c_int = 100;
pub(super) const DEPTH_100_UM: c_int = 101;
pub(super) const RGB888: c_int = 200;
pub(super) const YUV422: c_int = 201;
pub(super) const GRAY8: c_int = 202;
pub(super) const YUYV: c_int = 205;

/// What the formats are called, those that are not read included.
pub(super) const FORMATS: [(c_int, &str); 10] = [
    (DEPTH_1_MM, "depth in mm"),
    (DEPTH_100_UM, "depth in 0.1 mm"),
    (102, "shifts 9.2"),
    (103, "shifts 9.3"),
    (RGB888, "RGB"),
    (YUV422, "YUV 4:2:2"),
    (GRAY8, "grey"),
    (203, "16-bit grey"),
    (204, "JPEG"),
    (YUYV, "YUYV"),
];

/// The sensors, with what they are called.
pub(super) const SENSORS: [(c_int, &str); 3] = [(SENSOR_DEPTH, "depth"), (SENSOR_COLOUR, "colour"), (1, "infrared")];

pub(super) const STATE_ERROR: c_int = 1;
pub(super) const STATE_EOF: c_int = 3;

pub(super) const DEVICE_REGISTRATION: c_int = 5;
pub(super) const DEVICE_PLAYBACK_SPEED: c_int = 100;
pub(super) const DEVICE_PLAYBACK_REPEAT: c_int = 101;
pub(super) const DEPTH_TO_COLOUR: c_int = 1;
/// A frame of a file comes when a reader waits for one. (0 would be: as fast as they can be read, whoever takes them.)
pub(super) const PLAYBACK_MANUAL: f32 = -1.0;

pub(super) const STREAM_HORIZONTAL_FOV: c_int = 1;
pub(super) const STREAM_VERTICAL_FOV: c_int = 2;
pub(super) const STREAM_VIDEO_MODE: c_int = 3;
pub(super) const STREAM_MIRRORING: c_int = 7;
pub(super) const STREAM_NUMBER_OF_FRAMES: c_int = 8;

/// Length of the texts in [`DeviceInfo`], the 0 at their end included.
pub(super) const MAX_TEXT: usize = 256;

pub(super) type DeviceHandle = *mut c_void;
pub(super) type StreamHandle = *mut c_void;
pub(super) type CallbackHandle = *mut c_void;

/// `OniVideoMode`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct VideoMode {
    pub(super) format: c_int,
    pub(super) width: c_int,
    pub(super) height: c_int,
    pub(super) rate: c_int,
}

/// `OniSensorInfo`.
#[repr(C)]
#[derive(Debug)]
pub(super) struct SensorInfo {
    pub(super) sensor: c_int,
    pub(super) count: c_int,
    pub(super) modes: *const VideoMode,
}

/// `OniDeviceInfo`.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub(super) struct DeviceInfo {
    pub(super) uri: [c_char; MAX_TEXT],
    pub(super) vendor: [c_char; MAX_TEXT],
    pub(super) name: [c_char; MAX_TEXT],
    pub(super) usb_vendor: u16,
    pub(super) usb_product: u16,
}

/// `OniFrame`.
#[repr(C)]
#[derive(Debug)]
pub(super) struct Frame {
    pub(super) bytes: c_int,
    pub(super) data: *const c_void,
    pub(super) sensor: c_int,
    pub(super) microseconds: u64,
    pub(super) index: c_int,
    pub(super) width: c_int,
    pub(super) height: c_int,
    pub(super) mode: VideoMode,
    pub(super) cropped: c_int,
    pub(super) crop_x: c_int,
    pub(super) crop_y: c_int,
    pub(super) stride: c_int,
}

/// Told of a device.
pub(super) type InfoCallback = extern "system" fn(*const DeviceInfo, *mut c_void);
/// Told of a device's state.
pub(super) type StateCallback = extern "system" fn(*const DeviceInfo, c_int, *mut c_void);

/// `OniDeviceCallbacks`.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub(super) struct DeviceCallbacks {
    pub(super) connected: Option<InfoCallback>,
    pub(super) disconnected: Option<InfoCallback>,
    pub(super) state_changed: Option<StateCallback>,
}
