//! The system's OpenNI2, loaded when it is first asked for. Nothing of it is needed to build or to run without sensors.
#![allow(unsafe_code, reason = "a C library is called; this file alone does it, the rest sees safe handles")]

use std::collections::BTreeMap;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::mem::{ManuallyDrop, size_of};
use std::ptr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;

use super::facts::{Failure, Frame, Heard, Listed, text};
use super::find;
use super::sys::{
    self, CallbackHandle, DeviceCallbacks, DeviceHandle, DeviceInfo, SensorInfo, StreamHandle, VideoMode,
};
use crate::Error;

/// The functions that are called, under their names without the prefix.
macro_rules! table {
    ($($name:ident = $symbol:literal ($($argument:ty),*) $(-> $result:ty)?;)*) => {
        struct Table {
            $($name: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
        }

        impl Table {
            /// The error names the function that is not there.
            fn load(library: &libloading::Library) -> Result<Self, libloading::Error> {
                // SAFETY: the types are those of OniCAPI.h.
                unsafe { Ok(Self { $($name: *library.get($symbol)?,)* }) }
            }
        }
    };
}

table! {
    initialize = "oniInitialize" (c_int) -> c_int;
    shutdown = "oniShutdown" ();
    extended_error = "oniGetExtendedError" () -> *const c_char;
    device_list = "oniGetDeviceList" (*mut *mut DeviceInfo, *mut c_int) -> c_int;
    release_device_list = "oniReleaseDeviceList" (*mut DeviceInfo) -> c_int;
    register = "oniRegisterDeviceCallbacks" (*mut DeviceCallbacks, *mut c_void, *mut CallbackHandle) -> c_int;
    unregister = "oniUnregisterDeviceCallbacks" (CallbackHandle);
    wait = "oniWaitForAnyStream" (*mut StreamHandle, c_int, *mut c_int, c_int) -> c_int;
    device_open = "oniDeviceOpen" (*const c_char, *mut DeviceHandle) -> c_int;
    device_close = "oniDeviceClose" (DeviceHandle) -> c_int;
    sensor_info = "oniDeviceGetSensorInfo" (DeviceHandle, c_int) -> *const SensorInfo;
    device_get = "oniDeviceGetProperty" (DeviceHandle, c_int, *mut c_void, *mut c_int) -> c_int;
    device_set = "oniDeviceSetProperty" (DeviceHandle, c_int, *const c_void, c_int) -> c_int;
    registers = "oniDeviceIsImageRegistrationModeSupported" (DeviceHandle, c_int) -> c_int;
    sync = "oniDeviceEnableDepthColorSync" (DeviceHandle) -> c_int;
    unsync = "oniDeviceDisableDepthColorSync" (DeviceHandle);
    stream_create = "oniDeviceCreateStream" (DeviceHandle, c_int, *mut StreamHandle) -> c_int;
    stream_destroy = "oniStreamDestroy" (StreamHandle);
    stream_start = "oniStreamStart" (StreamHandle) -> c_int;
    stream_stop = "oniStreamStop" (StreamHandle);
    stream_read = "oniStreamReadFrame" (StreamHandle, *mut *mut sys::Frame) -> c_int;
    stream_get = "oniStreamGetProperty" (StreamHandle, c_int, *mut c_void, *mut c_int) -> c_int;
    stream_set = "oniStreamSetProperty" (StreamHandle, c_int, *const c_void, c_int) -> c_int;
    frame_release = "oniFrameRelease" (*mut sys::Frame);
}

/// A type that properties have: any bytes of its size are a value of it.
///
/// # Safety
/// Only for types without padding and without bytes that are no value.
pub(super) unsafe trait Plain: Copy + Default {}
// SAFETY: numbers, and a structure of four of the same size.
unsafe impl Plain for c_int {}
// SAFETY: as above.
unsafe impl Plain for f32 {}
// SAFETY: as above.
unsafe impl Plain for VideoMode {}

/// By the devices' URIs. OpenNI2's threads write to it.
static HEARD: Mutex<BTreeMap<String, Heard>> = Mutex::new(BTreeMap::new());
/// OpenNI2 is one in a process.
static SHARED: Mutex<Weak<Library>> = Mutex::new(Weak::new());
/// Held while it is started or shut down.
static TURNING: Mutex<()> = Mutex::new(());

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Notes what is heard of a device.
fn hear(info: *const DeviceInfo, note: impl FnOnce(&mut Heard)) {
    if info.is_null() {
        return;
    }
    // SAFETY: OpenNI2 hands a valid structure over for the time of the call.
    let uri = text(unsafe { &(*info).uri });
    note(lock(&HEARD).entry(uri).or_default());
}

extern "system" fn connected(info: *const DeviceInfo, _: *mut c_void) {
    hear(info, |heard| heard.connected += 1);
}

extern "system" fn disconnected(info: *const DeviceInfo, _: *mut c_void) {
    hear(info, |heard| heard.disconnected += 1);
}

extern "system" fn state_changed(info: *const DeviceInfo, state: c_int, _: *mut c_void) {
    hear(info, |heard| match state {
        sys::STATE_ERROR => heard.failed += 1,
        sys::STATE_EOF => heard.ended += 1,
        _ => {}
    });
}

/// An error with its causes.
fn whole(error: &dyn std::error::Error) -> String {
    let causes = std::iter::successors(Some(error), |error| error.source());
    causes.map(ToString::to_string).collect::<Vec<_>>().join(": ")
}

/// OpenNI2, started. It is shut down with the last of its users.
pub(super) struct Library {
    table: Table,
    callbacks: CallbackHandle,
    /// Never unloaded: drivers leave threads and destructors of their own behind.
    _library: ManuallyDrop<libloading::Library>,
}

// SAFETY: OpenNI2 guards its lists with locks of its own and may be called from any thread; the handle of the callbacks
// is used once, at the end.
unsafe impl Send for Library {}
// SAFETY: as above.
unsafe impl Sync for Library {}

impl Library {
    /// The library, started if it was not yet.
    ///
    /// # Errors
    /// Where it is not there, too old, or finds no driver; says what to do.
    pub(super) fn get() -> Result<Arc<Self>, Error> {
        let mut shared = lock(&SHARED);
        if let Some(library) = shared.upgrade() {
            return Ok(library);
        }
        let mut tried = Vec::new();
        for name in find::names() {
            // SAFETY: OpenNI2 runs nothing but its own initialisation.
            let loaded = unsafe { libloading::Library::new(&name) };
            let loaded = loaded.and_then(|library| Ok((Table::load(&library)?, library)));
            match loaded {
                Ok((table, library)) => {
                    let library = Arc::new(Self::start(table, library)?);
                    *shared = Arc::downgrade(&library);
                    return Ok(library);
                }
                Err(error) => tried.push((name, whole(&error))),
            }
        }
        Err(Error::Device(find::no_library(&tried)))
    }

    fn start(table: Table, library: libloading::Library) -> Result<Self, Error> {
        let turning = lock(&TURNING);
        // SAFETY: called with the version of the headers that the types are from.
        let status = unsafe { (table.initialize)(sys::API_VERSION) };
        drop(turning);
        let mut started = Self { table, callbacks: ptr::null_mut(), _library: ManuallyDrop::new(library) };
        if let Err(failure) = started.check(status) {
            return Err(Error::Device(find::no_driver(&failure.to_string())));
        }
        let mut callbacks = DeviceCallbacks {
            connected: Some(connected),
            disconnected: Some(disconnected),
            state_changed: Some(state_changed),
        };
        // SAFETY: OpenNI2 copies the structure; the functions live as long as the process.
        let status = unsafe { (started.table.register)(&mut callbacks, ptr::null_mut(), &mut started.callbacks) };
        match started.check(status) {
            Ok(()) => Ok(started),
            Err(failure) => Err(Error::Device(format!("OpenNI2 does not tell of devices that come and go: {failure}"))),
        }
    }

    fn check(&self, status: c_int) -> Result<(), Failure> {
        if status == sys::OK {
            return Ok(());
        }
        // SAFETY: a text that ends with 0 and lives until the thread's next call.
        let says = unsafe {
            let text = (self.table.extended_error)();
            if text.is_null() { String::new() } else { CStr::from_ptr(text).to_string_lossy().into_owned() }
        };
        let says = says.split_whitespace().collect::<Vec<_>>().join(" ");
        Err(Failure { status, says })
    }

    /// The devices that are there; files that were played count among them.
    pub(super) fn devices(&self) -> Result<Vec<Listed>, Failure> {
        let (mut list, mut count) = (ptr::null_mut(), 0);
        // SAFETY: OpenNI2 writes a list of that many devices, which is read before it is given back.
        unsafe {
            self.check((self.table.device_list)(&mut list, &mut count))?;
            let count = if list.is_null() { 0 } else { usize::try_from(count).unwrap_or(0) };
            let devices = (0..count).map(|i| Listed::from(&*list.add(i))).collect();
            (self.table.release_device_list)(list);
            Ok(devices)
        }
    }

    /// What was heard of a device since the process began.
    pub(super) fn heard(&self, uri: &str) -> Heard {
        lock(&HEARD).get(uri).copied().unwrap_or_default()
    }

    /// Opens a device, or a file.
    pub(super) fn open(self: &Arc<Self>, uri: &CString) -> Result<Device, Failure> {
        let mut handle = ptr::null_mut();
        // SAFETY: the text ends with 0.
        let status = unsafe { (self.table.device_open)(uri.as_ptr(), &mut handle) };
        match self.check(status) {
            Ok(()) => Ok(Device { library: Arc::clone(self), handle }),
            Err(failure) => Err(failure),
        }
    }

    /// Waits until one of the streams has a frame: its number, or `None` where the time is over.
    pub(super) fn wait(&self, streams: &[&Stream], at_most: Duration) -> Result<Option<usize>, Failure> {
        let mut handles: Vec<StreamHandle> = streams.iter().map(|stream| stream.handle).collect();
        let (count, milliseconds) = (handles.len() as c_int, at_most.as_millis() as c_int);
        let mut ready = -1;
        // SAFETY: the handles are those of streams that live.
        let status = unsafe { (self.table.wait)(handles.as_mut_ptr(), count, &mut ready, milliseconds) };
        if status == sys::TIME_OUT {
            return Ok(None);
        }
        self.check(status)?;
        Ok(usize::try_from(ready).ok().filter(|&ready| ready < streams.len()))
    }
}

impl Drop for Library {
    fn drop(&mut self) {
        let _turning = lock(&TURNING);
        // SAFETY: nothing of the library is in use any more: streams and devices hold it.
        unsafe {
            if !self.callbacks.is_null() {
                (self.table.unregister)(self.callbacks);
            }
            (self.table.shutdown)();
        }
    }
}

/// An opened device; closed with the last of its users.
pub(super) struct Device {
    library: Arc<Library>,
    handle: DeviceHandle,
}

// SAFETY: a handle is bound to no thread; it is used from one at a time.
unsafe impl Send for Device {}
// SAFETY: OpenNI2's functions of a device take its locks.
unsafe impl Sync for Device {}

impl Device {
    /// The modes of a sensor; `None` where there is no such sensor.
    pub(super) fn modes(&self, sensor: c_int) -> Option<Vec<VideoMode>> {
        // SAFETY: OpenNI2 gives null or a structure that lives as long as the device.
        let info = unsafe { (self.library.table.sensor_info)(self.handle, sensor).as_ref() }?;
        let count = if info.modes.is_null() { 0 } else { usize::try_from(info.count).unwrap_or(0) };
        // SAFETY: the structure says how many there are.
        Some((0..count).map(|i| unsafe { *info.modes.add(i) }).collect())
    }

    /// Reads a property.
    pub(super) fn get<T: Plain>(&self, property: c_int) -> Result<T, Failure> {
        // SAFETY: OpenNI2 writes no more than the size it is given.
        get(&self.library, |data, size| unsafe { (self.library.table.device_get)(self.handle, property, data, size) })
    }

    /// Changes a property.
    pub(super) fn set<T: Plain>(&self, property: c_int, value: T) -> Result<(), Failure> {
        let data = ptr::from_ref(&value).cast();
        // SAFETY: the pointer and the size are those of the value.
        self.library
            .check(unsafe { (self.library.table.device_set)(self.handle, property, data, size_of::<T>() as c_int) })
    }

    /// Whether the device can register depth to colour.
    pub(super) fn registers(&self) -> bool {
        // SAFETY: the handle is the device's.
        unsafe { (self.library.table.registers)(self.handle, sys::DEPTH_TO_COLOUR) != 0 }
    }

    /// Has both cameras take their images at the same time.
    pub(super) fn sync(&self) -> Result<(), Failure> {
        // SAFETY: the handle is the device's.
        self.library.check(unsafe { (self.library.table.sync)(self.handle) })
    }

    /// Ends that.
    pub(super) fn unsync(&self) {
        // SAFETY: the handle is the device's.
        unsafe { (self.library.table.unsync)(self.handle) };
    }

    /// Makes a stream.
    pub(super) fn stream(self: &Arc<Self>, sensor: c_int) -> Result<Stream, Failure> {
        let mut handle = ptr::null_mut();
        // SAFETY: the handle is the device's.
        let status = unsafe { (self.library.table.stream_create)(self.handle, sensor, &mut handle) };
        self.library.check(status)?;
        Ok(Stream { device: Arc::clone(self), handle })
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: its streams are gone: they hold it.
        unsafe { (self.library.table.device_close)(self.handle) };
    }
}

/// A stream of a device.
pub(super) struct Stream {
    device: Arc<Device>,
    handle: StreamHandle,
}

// SAFETY: a handle is bound to no thread; it is used from one at a time.
unsafe impl Send for Stream {}

impl Stream {
    /// Starts it.
    pub(super) fn start(&self) -> Result<(), Failure> {
        // SAFETY: the handle is the stream's.
        self.device.library.check(unsafe { (self.table().stream_start)(self.handle) })
    }

    /// Stops it; nothing comes any more.
    pub(super) fn stop(&self) {
        // SAFETY: the handle is the stream's.
        unsafe { (self.table().stream_stop)(self.handle) };
    }

    /// Takes the frame that is there; waits where there is none.
    pub(super) fn read(&self) -> Result<Option<Frame>, Failure> {
        let mut frame = ptr::null_mut();
        // SAFETY: OpenNI2 gives null or a frame that is ours until we give it back, with that many bytes of data.
        unsafe {
            self.device.library.check((self.table().stream_read)(self.handle, &mut frame))?;
            let Some(shown) = frame.as_ref() else { return Ok(None) };
            let count = if shown.data.is_null() { 0 } else { usize::try_from(shown.bytes).unwrap_or(0) };
            let mut bytes = vec![0; count];
            ptr::copy_nonoverlapping(shown.data.cast(), bytes.as_mut_ptr(), count);
            let (microseconds, index, stride) = (shown.microseconds, shown.index, shown.stride);
            let (size, format) = ((shown.width, shown.height), shown.mode.format);
            (self.table().frame_release)(frame);
            Ok(Some(Frame { bytes, microseconds, index, size, stride, format }))
        }
    }

    /// Reads a property.
    pub(super) fn get<T: Plain>(&self, property: c_int) -> Result<T, Failure> {
        // SAFETY: OpenNI2 writes no more than the size it is given.
        get(&self.device.library, |data, size| unsafe { (self.table().stream_get)(self.handle, property, data, size) })
    }

    /// Changes a property.
    pub(super) fn set<T: Plain>(&self, property: c_int, value: T) -> Result<(), Failure> {
        let data = ptr::from_ref(&value).cast();
        // SAFETY: the pointer and the size are those of the value.
        self.device
            .library
            .check(unsafe { (self.table().stream_set)(self.handle, property, data, size_of::<T>() as c_int) })
    }

    fn table(&self) -> &Table {
        &self.device.library.table
    }
}

impl Drop for Stream {
    fn drop(&mut self) {
        // SAFETY: the device is still open: this holds it. Destroying stops the stream first.
        unsafe { (self.table().stream_destroy)(self.handle) };
    }
}

/// Reads a property into a value of its type. A property of another size is none of it.
fn get<T: Plain>(library: &Library, read: impl FnOnce(*mut c_void, *mut c_int) -> c_int) -> Result<T, Failure> {
    let mut value = T::default();
    let mut size = size_of::<T>() as c_int;
    library.check(read(ptr::from_mut(&mut value).cast(), &mut size))?;
    if size == size_of::<T>() as c_int { Ok(value) } else { Err(Failure { status: 4, says: String::new() }) }
}
