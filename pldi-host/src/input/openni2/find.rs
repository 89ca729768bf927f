//! Where OpenNI2, its drivers and the sensors are looked for, and what to do when something of it is not there.

use std::ffi::OsString;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// The library's file names, as packages and the makers' kits have them.
const FILES: &[&str] = if cfg!(windows) {
    &["OpenNI2.dll"]
} else if cfg!(target_os = "macos") {
    &["libOpenNI2.dylib"]
} else {
    &["libOpenNI2.so.0", "libOpenNI2.so"]
};

/// Set by the makers' kits: the folder of the library.
const FOLDERS: [&str; 2] = ["OPENNI2_REDIST", "OPENNI2_REDIST64"];

/// Under which names to load the library, in this order.
pub(super) fn names() -> Vec<OsString> {
    let folders = FOLDERS.iter().filter_map(std::env::var_os).filter(|folder| !folder.is_empty()).map(PathBuf::from);
    let inside = folders.flat_map(|folder| FILES.iter().map(move |file| folder.join(file).into_os_string()));
    inside.chain(FILES.iter().map(OsString::from)).collect()
}

/// What to say when none of the names could be loaded.
pub(super) fn no_library(tried: &[(OsString, String)]) -> String {
    let mut text = format!(
        "OpenNI2, through which sensors and .oni files are read, cannot be loaded: install it (Debian and Ubuntu: the \
         package libopenni2-0), or set OPENNI2_REDIST to the folder of {}; tried",
        FILES.last().unwrap_or(&"")
    );
    for (i, (name, says)) in tried.iter().enumerate() {
        // Writing to a String cannot fail.
        let _ = write!(text, "{} {} ({says})", if i > 0 { "," } else { "" }, name.display());
    }
    text
}

/// What to say when the library does not start, which is almost always for want of drivers.
pub(super) fn no_driver(failure: &str) -> String {
    format!("OpenNI2 does not start ({failure}); {}", Places::default().drivers())
}

/// What to say when there is no device.
pub(super) fn no_device() -> String {
    let places = Places::default();
    format!("OpenNI2 finds no device; {}; {}", places.drivers(), places.sensors())
}

/// What to say when a device that is there cannot be opened.
pub(super) fn cannot_open(uri: &str, failure: &str) -> String {
    let places = Places::default();
    format!(
        "the device {uri} cannot be opened ({failure}): another program may have it, or this user may not; {}",
        places.sensors()
    )
}

/// Where the system keeps what is looked at.
struct Places {
    /// The loaded library.
    library: Option<PathBuf>,
    /// Debian's place of the configuration; elsewhere it lies beside the library.
    configuration: PathBuf,
    /// A folder for each USB device.
    usb: PathBuf,
    /// The USB devices' files, by bus and number.
    nodes: PathBuf,
}

impl Default for Places {
    fn default() -> Self {
        Self {
            library: loaded(),
            configuration: "/etc/openni2/OpenNI.ini".into(),
            usb: "/sys/bus/usb/devices".into(),
            nodes: "/dev/bus/usb".into(),
        }
    }
}

/// The library's file, as the system shows the process's memory.
fn loaded() -> Option<PathBuf> {
    let maps = fs::read_to_string("/proc/self/maps").ok()?;
    let path = |line: &str| line.find('/').map(|at| PathBuf::from(&line[at..]));
    maps.lines().filter_map(path).find(|path| {
        path.file_name().is_some_and(|name| FILES.iter().any(|file| name.to_string_lossy().starts_with(file)))
    })
}

impl Places {
    /// The drivers' folder, and what lies in it.
    fn drivers(&self) -> String {
        let beside = self.library.as_deref().and_then(Path::parent).map(Path::to_path_buf).unwrap_or_default();
        let inis = [self.configuration.clone(), beside.join("OpenNI.ini")];
        let chosen = inis.iter().find_map(|ini| Some((repository(&fs::read_to_string(ini).ok()?)?, ini)));
        let folder = beside.join(chosen.as_ref().map_or(Path::new("OpenNI2/Drivers"), |(folder, _)| folder));
        let whose = chosen.map(|(_, ini)| format!(" (Repository in {})", ini.display())).unwrap_or_default();
        let found = match fs::read_dir(&folder) {
            Err(error) => format!("cannot be read: {error}"),
            Ok(entries) => {
                let names = entries.filter_map(|entry| Some(entry.ok()?.file_name().to_string_lossy().into_owned()));
                let mut names: Vec<String> = names.filter(|name| is_library(name)).collect();
                names.sort();
                if names.is_empty() { "has none".to_owned() } else { format!("has {}", names.join(", ")) }
            }
        };
        format!("its folder of drivers {}{whose} {found}", folder.display())
    }

    /// The sensors that are plugged in, and whether this user may open them.
    fn sensors(&self) -> String {
        let devices = fs::read_dir(&self.usb).into_iter().flatten().flatten();
        let said: Vec<String> = devices.filter_map(|device| self.sensor(&device.path())).collect();
        if said.is_empty() { "no sensor that it knows is plugged in by USB".to_owned() } else { said.join("; ") }
    }

    /// What is to be said of a USB device, if it is a sensor.
    fn sensor(&self, device: &Path) -> Option<String> {
        let read = |file: &str| fs::read_to_string(device.join(file)).ok().map(|text| text.trim().to_owned());
        let (vendor, product) = (read("idVendor")?, read("idProduct")?);
        let (name, driver) = match (vendor.as_str(), product.as_str()) {
            ("1d27", _) => ("a PrimeSense sensor", "PS1080 or PSLink"),
            ("045e", "02ae" | "02bf" | "02c2") => ("a Kinect", "FreenectDriver"),
            ("2bc5", _) => ("an Orbbec sensor", "orbbec"),
            _ => return None,
        };
        let (bus, number) = (read("busnum")?.parse::<u32>().ok()?, read("devnum")?.parse::<u32>().ok()?);
        let node = self.nodes.join(format!("{bus:03}/{number:03}"));
        let opened = fs::OpenOptions::new().read(true).write(true).open(&node);
        Some(match opened {
            Err(error) => format!(
                "{name} ({vendor}:{product}) is plugged in, but this user may not open it ({}: {error}): install udev \
                 rules for it (60-libopenni2-0.rules of libopenni2-0 has those of PrimeSense and Kinect) and plug it in \
                 again, or join the group of that file",
                node.display()
            ),
            Ok(_) => format!(
                "{name} ({vendor}:{product}) is plugged in and may be opened, but no driver takes it: it needs the \
                 driver {driver}, and that no other program has it"
            ),
        })
    }
}

/// Whether a file looks like a driver.
fn is_library(name: &str) -> bool {
    name.contains(".so") || name.ends_with(".dylib") || name.ends_with(".dll")
}

/// The drivers' folder as the configuration names it.
fn repository(ini: &str) -> Option<PathBuf> {
    let mut here = false;
    for line in ini.lines().map(str::trim) {
        if let Some(section) = line.strip_prefix('[') {
            here = section.trim_end_matches(']').eq_ignore_ascii_case("drivers");
        } else if let Some((key, value)) = line.split_once('=').filter(|_| here)
            && key.trim().eq_ignore_ascii_case("repository")
        {
            return Some(value.trim().trim_matches('"').into());
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A system made of files below a folder.
    fn places(folder: &Path) -> Places {
        Places {
            library: Some(folder.join("lib/libOpenNI2.so.0")),
            configuration: folder.join("OpenNI.ini"),
            usb: folder.join("usb"),
            nodes: folder.join("nodes"),
        }
    }

    fn write(path: PathBuf, text: &str) {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }

    #[test]
    fn the_drivers_folder_is_named_with_what_is_in_it() {
        let folder = tempfile::tempdir().unwrap();
        let places = places(folder.path());
        assert!(places.drivers().contains("lib/OpenNI2/Drivers cannot be read"), "{}", places.drivers());
        write(folder.path().join("lib/OpenNI2/Drivers/libOniFile.so.0"), "");
        write(folder.path().join("lib/OpenNI2/Drivers/readme"), "");
        assert!(places.drivers().ends_with("lib/OpenNI2/Drivers has libOniFile.so.0"), "{}", places.drivers());
        let other = folder.path().join("other");
        fs::create_dir(&other).unwrap();
        let ini = format!("[Log]\nRepository=no\n[Drivers]\n;Repository=no\nRepository = {}\n", other.display());
        write(folder.path().join("OpenNI.ini"), &ini);
        let text = places.drivers();
        assert!(text.contains("other (Repository in") && text.ends_with("OpenNI.ini) has none"), "{text}");
    }

    #[test]
    fn a_sensor_that_may_not_be_opened_is_told_from_one_without_a_driver() {
        let folder = tempfile::tempdir().unwrap();
        let places = places(folder.path());
        assert!(places.sensors().contains("no sensor"), "{}", places.sensors());
        let device = |name: &str, ids: [&str; 4]| {
            for (file, id) in ["idVendor", "idProduct", "busnum", "devnum"].iter().zip(ids) {
                write(folder.path().join("usb").join(name).join(file), &format!("{id}\n"));
            }
        };
        device("1-1", ["8087", "0024", "1", "2"]);
        device("1-2", ["1d27", "0601", "1", "4"]);
        let text = places.sensors();
        assert!(text.contains("(1d27:0601)") && text.contains("udev") && text.contains("nodes/001/004"), "{text}");
        write(folder.path().join("nodes/001/004"), "");
        let text = places.sensors();
        assert!(text.contains("PrimeSense") && text.contains("no driver takes it"), "{text}");
        device("2-1", ["045e", "02ae", "2", "11"]);
        device("2-2", ["2bc5", "0401", "2", "12"]);
        let text = places.sensors();
        assert!(text.contains("Kinect") && text.contains("002/011") && text.contains("Orbbec"), "{text}");
    }

    #[test]
    fn every_name_that_was_tried_is_told() {
        let names = names();
        assert!(names.len() >= FILES.len());
        let tried: Vec<(OsString, String)> = names.into_iter().map(|name| (name, "not there".to_owned())).collect();
        let text = no_library(&tried);
        assert!(text.contains("libopenni2-0") && text.contains("OPENNI2_REDIST"), "{text}");
        assert!(tried.iter().all(|(name, _)| text.contains(&format!("{} (not there)", name.display()))), "{text}");
    }
}
