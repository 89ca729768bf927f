//! The driver: the cable of the one device it knows, which may be pulled and put in again.

use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::controls::{Controls, Folder};
use crate::device::Device;
use crate::film::Film;

/// What the device is called, in the form of a USB sensor's name.
pub const URI: &str = "virtual/0601@1/5";

/// How often the folder is looked at.
const PERIOD: Duration = Duration::from_millis(20);
/// How long the library is waited for before the driver leaves it alone.
const PATIENCE: Duration = Duration::from_secs(2);

/// Tells the library that the device came (true) or went.
pub type Announce = Box<dyn Fn(bool) + Send>;

/// The cable's state.
#[derive(Debug, Default)]
pub struct Cable {
    /// Whether it is in, as announced.
    plugged: bool,
    /// How often it was pulled: a device opened before is dead for ever.
    pulls: u64,
    /// When it was pulled by `unplug-after`.
    pulled: Option<Instant>,
    /// Whether that has happened already.
    spent: bool,
    /// Frame of the film that comes next: the world goes on while nobody looks.
    pub next: u64,
    /// The driver is about to go.
    closing: bool,
    /// The watch is over.
    ended: bool,
}

/// What the driver and its devices share.
#[derive(Debug)]
pub struct Hub {
    /// What the sensor sees.
    pub film: Option<Film>,
    /// Where the test speaks.
    pub folder: Folder,
    /// What it asks.
    pub controls: Controls,
    cable: Mutex<Cable>,
    changed: Condvar,
}

impl Hub {
    /// The cable's state.
    pub fn cable(&self) -> MutexGuard<'_, Cable> {
        lock(&self.cable)
    }

    /// Whether a device opened after so many pulls still lives.
    pub fn alive(&self, pulls: u64) -> bool {
        let cable = self.cable();
        cable.plugged && cable.pulls == pulls
    }

    /// Pulls the cable if it is time for it.
    pub fn pull(&self) -> bool {
        let mut cable = self.cable();
        let due = !cable.spent && cable.plugged && self.controls.unplug_after.is_some_and(|n| cable.next >= n);
        if due {
            cable.spent = true;
            cable.pulled = Some(Instant::now());
            cable.pulls += 1;
            self.changed.notify_all();
        }
        due
    }
}

/// A lock whose holder panicked is as good as any: the process ends with the panic.
pub fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The driver of one library.
#[derive(Debug)]
pub struct Driver {
    hub: Arc<Hub>,
    watch: Option<JoinHandle<()>>,
}

impl Driver {
    /// A driver for the film and the folder that the environment names.
    pub fn new() -> Result<Self, String> {
        let path = |name: &str| std::env::var_os(name).map(PathBuf::from);
        let film = path("PLDI_VIRTUAL_SENSOR").map(|path| Film::open(&path)).transpose().map_err(|e| e.to_string())?;
        let folder = Folder(path("PLDI_VIRTUAL_CONTROL"));
        let controls = folder.controls()?;
        let hub = Hub { film, folder, controls, cable: Mutex::default(), changed: Condvar::new() };
        Ok(Self { hub: Arc::new(hub), watch: None })
    }

    /// Announces the device if it is there, and watches over the cable from now on.
    pub fn watch(&mut self, announce: Announce) {
        if self.hub.film.is_none() {
            return;
        }
        if !self.hub.folder.unplugged() {
            self.hub.cable().plugged = true;
            announce(true);
        }
        let hub = Arc::clone(&self.hub);
        self.watch = Some(thread::spawn(move || watch(&hub, &announce)));
    }

    /// Opens the device.
    pub fn open(&self, uri: &str) -> Option<Arc<Device>> {
        let pulls = {
            let cable = self.hub.cable();
            (cable.plugged && uri == URI && !self.hub.controls.denied).then_some(cable.pulls)
        };
        self.hub.folder.event(if pulls.is_some() { "opened" } else { "not opened" });
        Some(Device::new(Arc::clone(&self.hub), pulls?))
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        let Some(watch) = self.watch.take() else { return };
        let mut cable = self.hub.cable();
        cable.closing = true;
        self.hub.changed.notify_all();
        // The watch may be inside the library, waiting for a lock that our caller holds: it is not waited for in vain.
        let waited = self.hub.changed.wait_timeout_while(cable, PATIENCE, |cable| !cable.ended);
        if waited.is_ok_and(|(cable, _)| cable.ended) {
            let _ = watch.join();
        }
    }
}

/// Says what happens to the cable until the driver goes.
fn watch(hub: &Hub, announce: &Announce) {
    let mut cable = hub.cable();
    while !cable.closing {
        cable = hub.changed.wait_timeout(cable, PERIOD).unwrap_or_else(PoisonError::into_inner).0;
        if let (Some(pulled), Some(after)) = (cable.pulled, hub.controls.replug_after)
            && pulled.elapsed() >= after
            && !cable.plugged
        {
            cable.pulled = None;
        }
        let plugged = cable.pulled.is_none() && !hub.folder.unplugged();
        if plugged != cable.plugged && !cable.closing {
            cable.plugged = plugged;
            cable.pulls += u64::from(!plugged);
            drop(cable);
            hub.folder.event(if plugged { "plugged" } else { "unplugged" });
            // Without the lock: the library may call back.
            announce(plugged);
            cable = hub.cable();
        }
    }
    cable.ended = true;
    hub.changed.notify_all();
}
