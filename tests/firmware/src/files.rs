//! Files of the host, by the names on the image's command line.

use core::ffi::CStr;
use semihosting::io;

use crate::failure::Failure;

/// Longest name.
const LONGEST: usize = 400;

/// Opens the file of a name, which the host wants with a zero behind it.
///
/// # Errors
/// `Usage` for a name of 400 bytes and more, `Host` with what the host says.
pub fn open<T>(name: &str, open: impl FnOnce(&CStr) -> io::Result<T>) -> Result<T, Failure> {
    let mut bytes = [0; LONGEST];
    // The last zero stays.
    let place = bytes.get_mut(..name.len()).filter(|place| place.len() < LONGEST).ok_or(Failure::Usage)?;
    place.copy_from_slice(name.as_bytes());
    Ok(open(CStr::from_bytes_until_nul(&bytes).map_err(|_| Failure::Usage)?)?)
}
