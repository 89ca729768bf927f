//! An opened device: two streams and the thread that feeds them.

use std::fmt;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::controls::Registration;
use crate::driver::{Hub, lock};
use crate::film::{Film, Kind, View};

/// Columns between the two cameras' images, at full width.
pub const PARALLAX: usize = 10;
/// Time stamp of the first frame in microseconds: no sensor begins at 0.
const FIRST_STAMP: u64 = 1_000_000;
/// How often a sleeping thread looks whether the cable was pulled.
const GLANCE: Duration = Duration::from_millis(50);

/// Size of the images and their rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mode {
    /// Every so many pixels of the film.
    pub step: usize,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Frames per second.
    pub rate: u32,
}

/// One image on its way to the library.
#[derive(Debug)]
pub struct Frame {
    /// Its pixels.
    pub bytes: Vec<u8>,
    /// Which camera took it.
    pub kind: Kind,
    /// Its size.
    pub mode: Mode,
    /// When, in microseconds.
    pub stamp: u64,
    /// Its number, from 1.
    pub index: u64,
}

/// Takes images to the library.
pub type Sink = Arc<dyn Fn(&Frame) + Send + Sync>;

/// One stream's state.
#[derive(Clone)]
pub struct Stream {
    /// Size of its images.
    pub mode: Mode,
    /// Left and right swapped.
    pub mirrored: bool,
    /// Whether it runs.
    pub started: bool,
    /// Where its images go.
    pub sink: Option<Sink>,
}

#[derive(Default)]
struct State {
    streams: [Option<Stream>; 2],
    registered: bool,
    /// A reader waits.
    asked: bool,
    closing: bool,
}

impl State {
    fn started(&self) -> impl Iterator<Item = bool> {
        self.streams.iter().flatten().map(|stream| stream.started)
    }
}

/// An opened device.
pub struct Device {
    /// The driver's.
    pub hub: Arc<Hub>,
    pulls: u64,
    state: Mutex<State>,
    changed: Condvar,
    /// Held while the library has an image in its hands: who has it, knows that none is on its way.
    delivery: Mutex<()>,
    thread: Mutex<Option<JoinHandle<()>>>,
}

impl fmt::Debug for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Device").field("pulls", &self.pulls).finish_non_exhaustive()
    }
}

impl Device {
    /// A device opened after the cable was pulled so many times.
    pub fn new(hub: Arc<Hub>, pulls: u64) -> Arc<Self> {
        let device = Arc::new(Self {
            hub,
            pulls,
            state: Mutex::default(),
            changed: Condvar::new(),
            delivery: Mutex::default(),
            thread: Mutex::default(),
        });
        let worker = Arc::clone(&device);
        *lock(&device.thread) = Some(thread::spawn(move || {
            if let Some(film) = &worker.hub.film {
                worker.play(film);
            }
        }));
        device
    }

    /// Ends the thread.
    pub fn close(&self) {
        self.state().closing = true;
        self.changed.notify_all();
        if let Some(thread) = lock(&self.thread).take() {
            let _ = thread.join();
        }
        self.hub.folder.event("closed");
    }

    /// The modes, the smaller first, which is the one that streams start in.
    pub fn modes(&self) -> Vec<Mode> {
        let Some(film) = &self.hub.film else { return Vec::new() };
        let mode = |step| Mode { step, width: film.width / step, height: film.height / step, rate: film.rate };
        let halves = film.width >= 640 && film.width.is_multiple_of(2) && film.height.is_multiple_of(2);
        if halves { vec![mode(2), mode(1)] } else { vec![mode(1)] }
    }

    /// Makes a stream.
    pub fn create(&self, kind: Kind) -> bool {
        let Some(&mode) = self.modes().first() else { return false };
        let mut state = self.state();
        let free = state.streams[kind as usize].is_none();
        if free {
            state.streams[kind as usize] = Some(Stream { mode, mirrored: true, started: false, sink: None });
        }
        free
    }

    /// Ends a stream.
    pub fn destroy(&self, kind: Kind) {
        self.stop(kind);
        self.state().streams[kind as usize] = None;
    }

    /// Starts a stream.
    pub fn start(&self, kind: Kind) -> bool {
        if !self.hub.alive(self.pulls) {
            return false;
        }
        let started = self.with(kind, |stream| stream.started = true).is_some();
        self.changed.notify_all();
        self.hub.folder.event(&format!("started {kind:?}"));
        started
    }

    /// Stops a stream; when it returns no image is on its way any more.
    pub fn stop(&self, kind: Kind) {
        let mut state = self.state();
        let Some(stream) = &mut state.streams[kind as usize] else { return };
        let was = std::mem::take(&mut stream.started);
        if !state.started().any(|started| started) {
            state.registered = false;
        }
        drop(state);
        drop(lock(&self.delivery));
        if was {
            self.hub.folder.event(&format!("stopped {kind:?}"));
        }
    }

    /// Reads or changes a stream's state.
    pub fn with<T>(&self, kind: Kind, what: impl FnOnce(&mut Stream) -> T) -> Option<T> {
        self.state().streams[kind as usize].as_mut().map(what)
    }

    /// Whether depth is registered to colour.
    pub fn registered(&self) -> bool {
        self.state().registered
    }

    /// Asks for registration. It is lost where the sensor would lose it.
    pub fn register(&self, wanted: bool) {
        let mut state = self.state();
        let running = state.started().count() > 0 && state.started().all(|started| started);
        let kept = running && self.hub.controls.registration == Registration::Works;
        if kept {
            state.registered = wanted;
        }
        drop(state);
        let word = if wanted { "on" } else { "off" };
        self.hub.folder.event(&format!("registration {word} {}", if kept { "kept" } else { "lost" }));
    }

    /// A reader waits and has no image.
    pub fn ask(&self) {
        self.state().asked = true;
        self.changed.notify_all();
    }

    fn state(&self) -> MutexGuard<'_, State> {
        lock(&self.state)
    }

    /// Waits a little; false when the device is to be closed.
    fn wait<'a>(&self, state: MutexGuard<'a, State>, at_most: Duration) -> MutexGuard<'a, State> {
        let time = at_most.min(GLANCE);
        self.changed.wait_timeout(state, time).unwrap_or_else(PoisonError::into_inner).0
    }

    /// Feeds the streams until the device is closed.
    fn play(&self, film: &Film) {
        let controls = &self.hub.controls;
        let first = self.hub.cable().next;
        let period_us = |frame: u64| (frame - first) * 1_000_000 / u64::from(film.rate);
        // Frames are due so long after this moment; there is none while no stream runs.
        let mut began: Option<(Instant, u64)> = None;
        let mut next = Kind::Depth;
        loop {
            let mut state = self.state();
            if state.closing {
                return;
            }
            let frame = self.hub.cable().next;
            let all = state.started().count() > 0 && state.started().all(|started| started);
            let any = state.started().any(|started| started);
            if !any {
                began = None;
            }
            let over = !controls.loops && frame >= film.frames;
            if !(all || any && began.is_some()) || over || !self.hub.alive(self.pulls) {
                drop(self.wait(state, GLANCE));
                continue;
            }
            let later = if next == Kind::Color { controls.color_after_us } else { 0 };
            let stamp = period_us(frame) + later;
            let &mut (start, start_stamp) = began.get_or_insert_with(|| (Instant::now() + controls.start_after, stamp));
            if controls.asked {
                if !std::mem::take(&mut state.asked) {
                    drop(self.wait(state, GLANCE));
                    continue;
                }
            } else {
                let due = start + Duration::from_micros(stamp - start_stamp).div_f64(controls.speed);
                let left = due.saturating_duration_since(Instant::now());
                if !left.is_zero() {
                    drop(self.wait(state, left));
                    continue;
                }
            }
            drop(state);
            if next == Kind::Depth && self.hub.pull() {
                continue;
            }
            let sent = !controls.dropped[next as usize].contains(&frame)
                && self.send(film, next, frame, (FIRST_STAMP + stamp, frame - first + 1));
            // A reader that waits gets something, or it would wait for ever.
            if controls.asked && !sent {
                self.state().asked = true;
            }
            if next == Kind::Color {
                self.hub.cable().next += 1;
            }
            next = if next == Kind::Depth { Kind::Color } else { Kind::Depth };
        }
    }

    /// Sends one image; false if nobody wants it.
    fn send(&self, film: &Film, kind: Kind, frame: u64, (stamp, index): (u64, u64)) -> bool {
        let delivery = lock(&self.delivery);
        let state = self.state();
        let registered = state.registered;
        let stream = state.streams[kind as usize].clone().filter(|stream| stream.started);
        drop(state);
        let Some(Stream { mode, mirrored, sink: Some(sink), .. }) = stream else { return false };
        let shift = if kind == Kind::Depth && !registered { PARALLAX } else { 0 };
        let Ok(bytes) = film.image(frame, kind, View { step: mode.step, mirrored, shift }) else { return false };
        sink(&Frame { bytes, kind, mode, stamp, index });
        drop(delivery);
        true
    }
}
