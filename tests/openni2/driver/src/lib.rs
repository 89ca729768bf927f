//! A depth camera without the camera: a driver for OpenNI2 that plays a film as a sensor would.
//!
//! libOpenNI2 loads it as `libPldiVirtual.so.0` from its drivers' folder. Two environment variables say what it does:
//!
//! * `PLDI_VIRTUAL_SENSOR`: the [film]. Without it no device is listed.
//! * `PLDI_VIRTUAL_CONTROL`: a folder with the file `controls` ([`Controls`](controls::Controls)); while there is a file
//!   `unplugged` in it the device is gone; what happens is appended to its file `events`, one line each.
//!
//! It behaves like a PrimeSense sensor where that is a trap: it starts in the smaller mode, mirrored and unregistered; a
//! registration that is asked for before the streams run is lost without an error; a device that was unplugged stays dead
//! when it comes back, and its time stamps begin anew.

mod api;
mod controls;
mod device;
mod driver;
mod film;
mod properties;
