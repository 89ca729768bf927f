//! The functions of `OniDriverAPI.h` that libOpenNI2 looks up by name; it wants all of them.
//!
//! This is where C is spoken, so this is where `unsafe` is. What holds throughout: the library hands in only device and
//! stream handles that it got here and has not given back, callbacks with the cookies that belong to them, and pointers
//! to as many bytes as it says.

#![allow(unsafe_code, reason = "a C interface: pointers in, pointers out")]

mod types;

use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr;
use std::sync::{Arc, Mutex};

use self::types::{DeviceInfo, Foreign, OnDevice, OnFrame, OnProperty, OnState, SensorInfo, Services, VideoMode};
use crate::controls::Registration;
use crate::device::{Device, Frame, Sink};
use crate::driver::{Driver, URI, lock};
use crate::film::Kind;
use crate::properties::{self, Failure};

const OK: c_int = 0;
const ERROR: c_int = 1;
const UNSUPPORTED: c_int = 3;

/// What the library holds of an opened device.
struct DeviceHandle {
    device: Arc<Device>,
    sensors: [SensorInfo; 2],
    // What `sensors` points to.
    _modes: [Vec<VideoMode>; 2],
}

/// What the library holds of a stream.
struct StreamHandle {
    device: Arc<Device>,
    kind: Kind,
    services: Mutex<Option<Foreign<Services>>>,
    on_frame: Mutex<Option<(OnFrame, Foreign<c_void>)>>,
}

static DRIVER: Mutex<Option<Driver>> = Mutex::new(None);

const fn sensor(kind: Kind) -> c_int {
    match kind {
        Kind::Depth => 3,
        Kind::Color => 2,
    }
}

fn status(result: Result<(), Failure>) -> c_int {
    result.map_or_else(|failure| failure as c_int, |()| OK)
}

/// Copies a property out.
///
/// # Safety
/// `data` has room for `*size` bytes.
unsafe fn answer(value: Result<Vec<u8>, Failure>, data: *mut c_void, size: *mut c_int) -> c_int {
    status(value.and_then(|value| {
        // SAFETY: the caller says so.
        let room = unsafe { size.as_ref() }.and_then(|&size| usize::try_from(size).ok());
        let string = value.last() == Some(&0) && value.len() > 4 && value.is_ascii();
        match room {
            // A number's size is exact, as PrimeSense's driver has it; a text's is what there is room for.
            Some(room) if room == value.len() || (string && room > value.len()) => {
                // SAFETY: there is room for `value.len()` bytes, and the library's memory is not ours.
                unsafe {
                    ptr::copy_nonoverlapping(value.as_ptr(), data.cast(), value.len());
                    *size = value.len() as c_int;
                }
                Ok(())
            }
            _ => Err(Failure::Parameter),
        }
    }))
}

/// The bytes of a property that is set.
///
/// # Safety
/// `data` points to `size` bytes that nobody changes meanwhile.
unsafe fn bytes<'a>(data: *const c_void, size: c_int) -> &'a [u8] {
    match usize::try_from(size) {
        // SAFETY: the caller says so.
        Ok(size) if !data.is_null() => unsafe { std::slice::from_raw_parts(data.cast(), size) },
        _ => &[],
    }
}

/// Makes the driver. A film or control that is not understood ends the process: no test shall pass without it.
#[unsafe(no_mangle)]
extern "C" fn oniDriverCreate(_services: *mut c_void) {
    *lock(&DRIVER) = Some(Driver::new().expect("PLDI_VIRTUAL_SENSOR, PLDI_VIRTUAL_CONTROL"));
}

#[unsafe(no_mangle)]
extern "C" fn oniDriverDestroy() {
    let driver = lock(&DRIVER).take();
    drop(driver);
}

#[unsafe(no_mangle)]
extern "C" fn oniDriverInitialize(came: OnDevice, went: OnDevice, _state: OnState, cookie: *mut c_void) -> c_int {
    let cookie = Foreign(cookie);
    let announce = move |plugged: bool| {
        let info = DeviceInfo::new(URI, "pldi", "virtual sensor");
        let tell = if plugged { came } else { went };
        tell(&raw const info, cookie.get());
    };
    lock(&DRIVER).as_mut().map_or(ERROR, |driver| {
        driver.watch(Box::new(announce));
        OK
    })
}

/// The one device is listed; there are no others.
#[unsafe(no_mangle)]
extern "C" fn oniDriverTryDevice(_uri: *const c_char) -> c_int {
    ERROR
}

#[unsafe(no_mangle)]
unsafe extern "C" fn oniDriverDeviceOpen(uri: *const c_char, _mode: *const c_char) -> *mut DeviceHandle {
    // SAFETY: a string that ends.
    let uri = unsafe { CStr::from_ptr(uri) }.to_string_lossy();
    let device = lock(&DRIVER).as_ref().and_then(|driver| driver.open(&uri));
    device.map_or(ptr::null_mut(), |device| {
        let video_mode = |kind| move |mode| properties::video_mode(kind, mode);
        let modes = Kind::ALL.map(|kind| device.modes().into_iter().map(video_mode(kind)).collect::<Vec<_>>());
        let sensors = [0, 1].map(|i| SensorInfo {
            sensor: sensor(Kind::ALL[i]),
            count: modes[i].len() as c_int,
            modes: modes[i].as_ptr(),
        });
        Box::into_raw(Box::new(DeviceHandle { device, sensors, _modes: modes }))
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn oniDriverDeviceClose(handle: *mut DeviceHandle) {
    // SAFETY: made by `oniDriverDeviceOpen`, given back once.
    unsafe { Box::from_raw(handle) }.device.close();
}

#[unsafe(no_mangle)]
unsafe extern "C" fn oniDriverDeviceGetSensorInfoList(
    handle: *mut DeviceHandle,
    list: *mut *const SensorInfo,
    count: *mut c_int,
) -> c_int {
    // SAFETY: a live handle, and places to write to. The list lives as long as the handle.
    unsafe {
        *list = (&raw const (*handle).sensors).cast();
        *count = (*handle).sensors.len() as c_int;
    }
    OK
}

#[unsafe(no_mangle)]
unsafe extern "C" fn oniDriverDeviceCreateStream(handle: *mut DeviceHandle, source: c_int) -> *mut StreamHandle {
    // SAFETY: a live handle.
    let device = Arc::clone(unsafe { &(*handle).device });
    match Kind::ALL.into_iter().find(|&kind| sensor(kind) == source) {
        Some(kind) if device.create(kind) => Box::into_raw(Box::new(StreamHandle {
            device,
            kind,
            services: Mutex::default(),
            on_frame: Mutex::default(),
        })),
        _ => ptr::null_mut(),
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn oniDriverDeviceDestroyStream(_device: *mut DeviceHandle, stream: *mut StreamHandle) {
    // SAFETY: made by `oniDriverDeviceCreateStream`, given back once.
    let stream = unsafe { Box::from_raw(stream) };
    stream.device.destroy(stream.kind);
}

#[unsafe(no_mangle)]
unsafe extern "C" fn oniDriverDeviceSetProperty(
    handle: *mut DeviceHandle,
    property: c_int,
    data: *const c_void,
    size: c_int,
) -> c_int {
    // SAFETY: a live handle and so many bytes.
    let (device, value) = unsafe { (&(*handle).device, bytes(data, size)) };
    status(properties::set_device(device, property, value))
}

#[unsafe(no_mangle)]
unsafe extern "C" fn oniDriverDeviceGetProperty(
    handle: *mut DeviceHandle,
    property: c_int,
    data: *mut c_void,
    size: *mut c_int,
) -> c_int {
    // SAFETY: a live handle and room for so many bytes.
    unsafe { answer(properties::device(&(*handle).device, property), data, size) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn oniDriverDeviceIsPropertySupported(handle: *mut DeviceHandle, property: c_int) -> c_int {
    // SAFETY: a live handle.
    properties::device(unsafe { &(*handle).device }, property).is_ok().into()
}

#[unsafe(no_mangle)]
extern "C" fn oniDriverDeviceSetPropertyChangedCallback(_: *mut DeviceHandle, _: OnProperty, _: *mut c_void) {}

#[unsafe(no_mangle)]
extern "C" fn oniDriverDeviceNotifyAllProperties(_: *mut DeviceHandle) {}

#[unsafe(no_mangle)]
extern "C" fn oniDriverDeviceInvoke(_: *mut DeviceHandle, _command: c_int, _: *mut c_void, _: c_int) -> c_int {
    UNSUPPORTED
}

#[unsafe(no_mangle)]
extern "C" fn oniDriverDeviceIsCommandSupported(_: *mut DeviceHandle, _command: c_int) -> c_int {
    0
}

/// Called by a reader who waits for an image and has none.
#[unsafe(no_mangle)]
unsafe extern "C" fn oniDriverDeviceTryManualTrigger(handle: *mut DeviceHandle) -> c_int {
    // SAFETY: a live handle.
    unsafe { &(*handle).device }.ask();
    OK
}

#[unsafe(no_mangle)]
unsafe extern "C" fn oniDriverDeviceIsImageRegistrationModeSupported(handle: *mut DeviceHandle, mode: c_int) -> c_int {
    // SAFETY: a live handle.
    let registration = unsafe { &(*handle).device }.hub.controls.registration;
    (mode == 0 || (mode == 1 && registration != Registration::Unsupported)).into()
}

#[unsafe(no_mangle)]
unsafe extern "C" fn oniDriverStreamSetServices(stream: *mut StreamHandle, services: *mut Services) {
    // SAFETY: a live handle.
    *lock(unsafe { &(*stream).services }) = Some(Foreign(services));
}

#[unsafe(no_mangle)]
unsafe extern "C" fn oniDriverStreamSetProperty(
    stream: *mut StreamHandle,
    property: c_int,
    data: *const c_void,
    size: c_int,
) -> c_int {
    // SAFETY: a live handle and so many bytes.
    let (stream, value) = unsafe { (&*stream, bytes(data, size)) };
    status(properties::set_stream(&stream.device, stream.kind, property, value))
}

#[unsafe(no_mangle)]
unsafe extern "C" fn oniDriverStreamGetProperty(
    stream: *mut StreamHandle,
    property: c_int,
    data: *mut c_void,
    size: *mut c_int,
) -> c_int {
    // SAFETY: a live handle and room for so many bytes.
    unsafe { answer(properties::stream(&(*stream).device, (*stream).kind, property), data, size) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn oniDriverStreamIsPropertySupported(stream: *mut StreamHandle, property: c_int) -> c_int {
    // SAFETY: a live handle.
    let stream = unsafe { &*stream };
    properties::stream(&stream.device, stream.kind, property).is_ok().into()
}

#[unsafe(no_mangle)]
extern "C" fn oniDriverStreamSetPropertyChangedCallback(_: *mut StreamHandle, _: OnProperty, _: *mut c_void) {}

#[unsafe(no_mangle)]
extern "C" fn oniDriverStreamNotifyAllProperties(_: *mut StreamHandle) {}

#[unsafe(no_mangle)]
extern "C" fn oniDriverStreamInvoke(_: *mut StreamHandle, _command: c_int, _: *mut c_void, _: c_int) -> c_int {
    UNSUPPORTED
}

#[unsafe(no_mangle)]
extern "C" fn oniDriverStreamIsCommandSupported(_: *mut StreamHandle, _command: c_int) -> c_int {
    0
}

#[unsafe(no_mangle)]
unsafe extern "C" fn oniDriverStreamStart(handle: *mut StreamHandle) -> c_int {
    // SAFETY: a live handle.
    let stream = unsafe { &*handle };
    let (Some(services), Some((on_frame, cookie))) = (*lock(&stream.services), *lock(&stream.on_frame)) else {
        return ERROR;
    };
    let handle = Foreign(handle);
    let sink: Sink = Arc::new(move |frame| {
        // SAFETY: images come only between start and stop of the stream, while all three are alive.
        unsafe { deliver(frame, handle.get(), services.get(), (on_frame, cookie.get())) }
    });
    stream.device.with(stream.kind, |stream| stream.sink = Some(sink));
    if stream.device.start(stream.kind) { OK } else { ERROR }
}

/// Hands an image to the library.
///
/// # Safety
/// The stream, its services and the cookie are alive.
unsafe fn deliver(
    frame: &Frame,
    stream: *mut StreamHandle,
    services: *mut Services,
    (on_frame, cookie): (OnFrame, *mut c_void),
) {
    // SAFETY: alive, as the caller says; a frame that is acquired is ours until it is released.
    unsafe {
        let library = (*services).library;
        let to = ((*services).acquire)(library);
        let Some(target) = to.as_mut().filter(|target| target.size as usize >= frame.bytes.len()) else {
            if !to.is_null() {
                ((*services).release)(library, to);
            }
            return;
        };
        ptr::copy_nonoverlapping(frame.bytes.as_ptr(), target.data, frame.bytes.len());
        target.size = frame.bytes.len() as c_int;
        target.sensor = sensor(frame.kind);
        target.timestamp = frame.stamp;
        target.index = frame.index as c_int;
        target.width = frame.mode.width as c_int;
        target.height = frame.mode.height as c_int;
        target.mode = properties::video_mode(frame.kind, frame.mode);
        target.cropped = 0;
        target.crop_origin = [0; 2];
        target.stride = (frame.mode.width * frame.kind.pixel()) as c_int;
        on_frame(stream, to, cookie);
        ((*services).release)(library, to);
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn oniDriverStreamStop(stream: *mut StreamHandle) {
    // SAFETY: a live handle.
    let stream = unsafe { &*stream };
    stream.device.stop(stream.kind);
}

#[unsafe(no_mangle)]
unsafe extern "C" fn oniDriverStreamGetRequiredFrameSize(stream: *mut StreamHandle) -> c_int {
    // SAFETY: a live handle.
    let stream = unsafe { &*stream };
    let size = stream.device.with(stream.kind, |state| state.mode.width * state.mode.height * stream.kind.pixel());
    size.unwrap_or(0) as c_int
}

#[unsafe(no_mangle)]
unsafe extern "C" fn oniDriverStreamSetNewFrameCallback(
    stream: *mut StreamHandle,
    on_frame: OnFrame,
    cookie: *mut c_void,
) {
    // SAFETY: a live handle.
    *lock(unsafe { &(*stream).on_frame }) = Some((on_frame, Foreign(cookie)));
}

#[unsafe(no_mangle)]
extern "C" fn oniDriverStreamConvertDepthToColorCoordinates(
    _depth: *mut StreamHandle,
    _color: *mut StreamHandle,
    _x: c_int,
    _y: c_int,
    _z: u16,
    _color_x: *mut c_int,
    _color_y: *mut c_int,
) -> c_int {
    UNSUPPORTED
}

/// The two cameras are a little apart in time, and no more can be had.
#[unsafe(no_mangle)]
extern "C" fn oniDriverEnableFrameSync(_streams: *mut *mut StreamHandle, _count: c_int) -> *mut c_void {
    ptr::null_mut()
}

#[unsafe(no_mangle)]
extern "C" fn oniDriverDisableFrameSync(_group: *mut c_void) {}
