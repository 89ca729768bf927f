//! As much of `OniCAPI.h` as recording and playing need, from `libOpenNI2.so.0` at run time. `unsafe` is here alone.

#![allow(unsafe_code, reason = "a C library, loaded at run time")]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The version of the interface: major times 1000 plus minor.
const API_VERSION: c_int = 2002;
const OK: c_int = 0;
const TIME_OUT: c_int = 102;

/// Property: registration of depth to colour.
pub const REGISTRATION: c_int = 5;
/// Property of a file: how fast it plays; -1 is as fast as it is read.
pub const SPEED: c_int = 100;
/// Property of a file: whether it begins again.
pub const REPEAT: c_int = 101;
/// Property of a stream: fields of view.
pub const FOV: [c_int; 2] = [1, 2];
/// Property of a stream: format, columns, rows, rate.
pub const VIDEO_MODE: c_int = 3;
/// Property of a stream: left and right swapped.
pub const MIRRORING: c_int = 7;
/// Sensor: colour.
pub const COLOR: c_int = 2;
/// Sensor: depth.
pub const DEPTH: c_int = 3;

#[repr(C)]
struct DeviceInfo {
    names: [[c_char; 256]; 3],
    ids: [u16; 2],
}

#[repr(C)]
struct Frame {
    size: c_int,
    data: *const u8,
    sensor: c_int,
    timestamp: u64,
    index: c_int,
}

#[repr(C)]
struct Callbacks {
    came: Option<extern "C" fn(*const DeviceInfo, *mut c_void)>,
    went: Option<extern "C" fn(*const DeviceInfo, *mut c_void)>,
    state: Option<extern "C" fn(*const DeviceInfo, c_int, *mut c_void)>,
}

unsafe extern "C" {
    fn dlopen(name: *const c_char, flags: c_int) -> *mut c_void;
    fn dlsym(library: *mut c_void, name: *const c_char) -> *mut c_void;
}

/// Calls a function of the library by name; the types are those of `OniCAPI.h`.
macro_rules! call {
    ($library:expr, $name:literal, ($($argument:expr => $type:ty),*) -> $result:ty) => {{
        let symbol = $library.symbol($name);
        // SAFETY: the function of that name has this type; pointers are to live objects of the types it wants.
        unsafe {
            let function: unsafe extern "C" fn($($type),*) -> $result = std::mem::transmute(symbol);
            function($($argument),*)
        }
    }};
}

/// What an image is, beside its pixels.
#[derive(Debug)]
pub struct Image {
    /// Pixels.
    pub bytes: Vec<u8>,
    /// Microseconds.
    pub stamp: u64,
    /// Its number.
    pub index: i32,
}

/// Devices that came and went.
static CAME: AtomicUsize = AtomicUsize::new(0);
static WENT: AtomicUsize = AtomicUsize::new(0);

extern "C" fn on_came(_: *const DeviceInfo, _: *mut c_void) {
    CAME.fetch_add(1, Ordering::SeqCst);
}

extern "C" fn on_went(_: *const DeviceInfo, _: *mut c_void) {
    WENT.fetch_add(1, Ordering::SeqCst);
}

/// The initialised library.
#[derive(Debug)]
pub struct Library(*mut c_void);

/// An opened device.
#[derive(Debug)]
pub struct Device<'a>(&'a Library, *mut c_void);

/// A stream of it.
#[derive(Debug)]
pub struct Stream<'a>(&'a Library, *mut c_void);

/// A recorder of streams.
#[derive(Debug)]
pub struct Recorder<'a>(&'a Library, *mut c_void);

fn c(text: &str) -> CString {
    CString::new(text).expect("no zero in a name")
}

impl Library {
    /// Loads and initialises.
    pub fn new() -> Result<Self, String> {
        // SAFETY: a name that ends in zero; the library's initialisers are trusted as any linked library's.
        let handle = unsafe { dlopen(c("libOpenNI2.so.0").as_ptr(), 2) };
        if handle.is_null() {
            return Err("libOpenNI2.so.0 is not there".into());
        }
        let library = Self(handle);
        let code = call!(library, "oniInitialize", (API_VERSION => c_int) -> c_int);
        library.check(code, "initialise")?;
        let mut callbacks = Callbacks { came: Some(on_came), went: Some(on_went), state: None };
        let mut registered = ptr::null_mut::<c_void>();
        let code = call!(library, "oniRegisterDeviceCallbacks",
            (&raw mut callbacks => *mut Callbacks, ptr::null_mut() => *mut c_void, &raw mut registered => *mut *mut c_void)
            -> c_int);
        library.check(code, "listen")?;
        Ok(library)
    }

    fn symbol(&self, name: &str) -> *mut c_void {
        // SAFETY: a live library and a name that ends in zero.
        let symbol = unsafe { dlsym(self.0, c(name).as_ptr()) };
        assert!(!symbol.is_null(), "{name} is not in the library");
        symbol
    }

    fn check(&self, code: c_int, what: &str) -> Result<(), String> {
        if code == OK {
            return Ok(());
        }
        let text = call!(self, "oniGetExtendedError", () -> *const c_char);
        // SAFETY: a string of the library's.
        let text = unsafe { CStr::from_ptr(text) }.to_string_lossy();
        Err(format!("{what}: status {code}: {}", text.trim()))
    }

    /// How many devices came and went since the start.
    pub fn came_and_went() -> (usize, usize) {
        (CAME.load(Ordering::SeqCst), WENT.load(Ordering::SeqCst))
    }

    /// The devices' names.
    pub fn devices(&self) -> Result<Vec<String>, String> {
        let (mut list, mut count) = (ptr::null_mut::<DeviceInfo>(), 0);
        let code = call!(self, "oniGetDeviceList", (&raw mut list => *mut *mut DeviceInfo, &raw mut count => *mut c_int) -> c_int);
        self.check(code, "list")?;
        let name = |i: usize| {
            // SAFETY: the list has `count` entries, and their names end.
            let uri = unsafe { CStr::from_ptr((&raw const (*list.add(i)).names[0]).cast()) };
            uri.to_string_lossy().into_owned()
        };
        let names = (0..count as usize).map(name).collect();
        call!(self, "oniReleaseDeviceList", (list => *mut DeviceInfo) -> c_int);
        Ok(names)
    }

    /// Opens a device or a file.
    pub fn open(&self, uri: &str) -> Result<Device<'_>, String> {
        let mut device = ptr::null_mut::<c_void>();
        let uri = c(uri);
        let code =
            call!(self, "oniDeviceOpen", (uri.as_ptr() => *const c_char, &raw mut device => *mut *mut c_void) -> c_int);
        self.check(code, "open")?;
        Ok(Device(self, device))
    }

    /// Waits for an image of one of the streams: which, or `None` when the time is over.
    pub fn wait(&self, streams: &[&Stream<'_>], ms: c_int) -> Result<Option<usize>, String> {
        let mut handles: Vec<*mut c_void> = streams.iter().map(|stream| stream.1).collect();
        let mut which = 0;
        let code = call!(self, "oniWaitForAnyStream",
            (handles.as_mut_ptr() => *mut *mut c_void, handles.len() as c_int => c_int, &raw mut which => *mut c_int,
             ms => c_int) -> c_int);
        if code == TIME_OUT {
            return Ok(None);
        }
        self.check(code, "wait")?;
        Ok(Some(which as usize))
    }

    /// A recorder to a file.
    pub fn recorder(&self, path: &str) -> Result<Recorder<'_>, String> {
        let mut recorder = ptr::null_mut::<c_void>();
        let path = c(path);
        let code = call!(self, "oniCreateRecorder",
            (path.as_ptr() => *const c_char, &raw mut recorder => *mut *mut c_void) -> c_int);
        self.check(code, "record")?;
        Ok(Recorder(self, recorder))
    }
}

impl Drop for Library {
    fn drop(&mut self) {
        call!(self, "oniShutdown", () -> ());
    }
}

impl Device<'_> {
    /// Sets a property.
    pub fn set<T: Copy>(&self, property: c_int, value: T) -> Result<(), String> {
        let (data, size) = ((&raw const value).cast::<c_void>(), size_of::<T>() as c_int);
        let code = call!(self.0, "oniDeviceSetProperty",
            (self.1 => *mut c_void, property => c_int, data => *const c_void, size => c_int) -> c_int);
        self.0.check(code, "set")
    }

    /// A property that is one number.
    pub fn get(&self, property: c_int) -> Result<c_int, String> {
        let (mut value, mut size) = (0, 4);
        let code = call!(self.0, "oniDeviceGetProperty",
            (self.1 => *mut c_void, property => c_int, &raw mut value => *mut c_int, &raw mut size => *mut c_int) -> c_int);
        self.0.check(code, "get").map(|()| value)
    }

    /// Makes a stream.
    pub fn stream(&self, sensor: c_int) -> Result<Stream<'_>, String> {
        let mut stream = ptr::null_mut::<c_void>();
        let code = call!(self.0, "oniDeviceCreateStream",
            (self.1 => *mut c_void, sensor => c_int, &raw mut stream => *mut *mut c_void) -> c_int);
        self.0.check(code, "stream")?;
        Ok(Stream(self.0, stream))
    }
}

impl Drop for Device<'_> {
    fn drop(&mut self) {
        call!(self.0, "oniDeviceClose", (self.1 => *mut c_void) -> c_int);
    }
}

impl Stream<'_> {
    /// Sets a property.
    pub fn set<T: Copy>(&self, property: c_int, value: T) -> Result<(), String> {
        let (data, size) = ((&raw const value).cast::<c_void>(), size_of::<T>() as c_int);
        let code = call!(self.0, "oniStreamSetProperty",
            (self.1 => *mut c_void, property => c_int, data => *const c_void, size => c_int) -> c_int);
        self.0.check(code, "set")
    }

    /// A property of some words of 4 bytes each.
    pub fn get<const N: usize>(&self, property: c_int) -> Result<[u32; N], String> {
        let (mut value, mut size) = ([0; N], 4 * N as c_int);
        let data = (&raw mut value).cast::<c_void>();
        let code = call!(self.0, "oniStreamGetProperty",
            (self.1 => *mut c_void, property => c_int, data => *mut c_void, &raw mut size => *mut c_int) -> c_int);
        self.0.check(code, "get").map(|()| value)
    }

    /// Starts it.
    pub fn start(&self) -> Result<(), String> {
        let code = call!(self.0, "oniStreamStart", (self.1 => *mut c_void) -> c_int);
        self.0.check(code, "start")
    }

    /// Stops it.
    pub fn stop(&self) {
        call!(self.0, "oniStreamStop", (self.1 => *mut c_void) -> ());
    }

    /// The image that is there.
    pub fn read(&self) -> Result<Image, String> {
        let mut frame = ptr::null_mut::<Frame>();
        let code = call!(self.0, "oniStreamReadFrame",
            (self.1 => *mut c_void, &raw mut frame => *mut *mut Frame) -> c_int);
        self.0.check(code, "read")?;
        // SAFETY: a frame of the library's until it is released; null if there is none.
        let image = unsafe { frame.as_ref() }.map(|frame| Image {
            // SAFETY: so many bytes, as the frame says.
            bytes: unsafe { std::slice::from_raw_parts(frame.data, frame.size as usize) }.to_vec(),
            stamp: frame.timestamp,
            index: frame.index,
        });
        if image.is_some() {
            call!(self.0, "oniFrameRelease", (frame => *mut Frame) -> ());
        }
        image.ok_or_else(|| "no image".into())
    }
}

impl Drop for Stream<'_> {
    fn drop(&mut self) {
        call!(self.0, "oniStreamDestroy", (self.1 => *mut c_void) -> ());
    }
}

impl Recorder<'_> {
    /// Attaches a stream, without lossy compression.
    pub fn attach(&self, stream: &Stream<'_>) -> Result<(), String> {
        let code = call!(self.0, "oniRecorderAttachStream",
            (self.1 => *mut c_void, stream.1 => *mut c_void, 0 => c_int) -> c_int);
        self.0.check(code, "attach")
    }

    /// Starts recording.
    pub fn start(&self) -> Result<(), String> {
        let code = call!(self.0, "oniRecorderStart", (self.1 => *mut c_void) -> c_int);
        self.0.check(code, "start recording")
    }
}

impl Drop for Recorder<'_> {
    fn drop(&mut self) {
        call!(self.0, "oniRecorderStop", (self.1 => *mut c_void) -> ());
        call!(self.0, "oniRecorderDestroy", (&raw mut self.1 => *mut *mut c_void) -> c_int);
    }
}
