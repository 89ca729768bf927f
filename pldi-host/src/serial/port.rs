//! Where the bytes come from: a serial port, a FIFO, a file, stdin.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;
use std::time::Duration;

use crate::Error;

/// How long a read of a serial port waits at most; then it fails with [`io::ErrorKind::TimedOut`].
pub const TIMEOUT: Duration = Duration::from_millis(200);

/// Opens what a device's answers come from: `-` is stdin; a serial port is set raw, 8 bits, no parity, at `baud`; anything
/// else is read as it is. A FIFO is waited for until somebody writes to it.
///
/// # Errors
/// `Read` where the system refuses.
pub fn open(path: &Path, baud: u32) -> Result<Box<dyn Read + Send>, Error> {
    if path.as_os_str() == "-" {
        return Ok(Box::new(io::stdin()));
    }
    let read = |cause| Error::Read { path: path.to_owned(), cause };
    if is_port(path) {
        return Ok(Box::new(port(path, baud).map_err(read)?));
    }
    Ok(Box::new(File::open(path).map_err(read)?))
}

/// Opens a serial port for both directions.
///
/// # Errors
/// `Read` where the system refuses, or where it is no serial port.
#[allow(clippy::type_complexity)]
pub fn open_both(path: &Path, baud: u32) -> Result<(Box<dyn Read + Send>, Box<dyn Write + Send>), Error> {
    let read = |cause| Error::Read { path: path.to_owned(), cause };
    let reader = port(path, baud).map_err(read)?;
    let writer = reader.try_clone().map_err(|error| read(error.into()))?;
    Ok((Box::new(reader), Box::new(writer)))
}

fn port(path: &Path, baud: u32) -> io::Result<Box<dyn serialport::SerialPort>> {
    Ok(serialport::new(path.to_string_lossy(), baud).timeout(TIMEOUT).open()?)
}

#[cfg(unix)]
fn is_port(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    let device = std::fs::metadata(path).is_ok_and(|data| data.file_type().is_char_device());
    device && path != Path::new("/dev/null")
}

#[cfg(not(unix))]
fn is_port(path: &Path) -> bool {
    let name = path.to_string_lossy().to_ascii_uppercase();
    name.trim_start_matches(r"\\.\").starts_with("COM") && !path.is_file()
}
