//! Reading whole files with a bound on their size.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::Error;

/// The bytes of a file of at most `limit` bytes; an empty one is an error.
pub(crate) fn read(path: &Path, limit: u64) -> Result<Vec<u8>, Error> {
    let failed = |cause| Error::Read { path: path.to_owned(), cause };
    let file = File::open(path).map_err(failed)?;
    let bytes = file.metadata().map_err(failed)?.len();
    if bytes > limit {
        return Err(Error::TooLarge { path: path.to_owned(), bytes, limit });
    }
    let mut content = Vec::with_capacity(bytes as usize);
    // Pipes and devices report no size: the bound holds for them as well.
    file.take(limit + 1).read_to_end(&mut content).map_err(failed)?;
    match content.len() as u64 {
        0 => Err(Error::EmptyFile(path.to_owned())),
        bytes if bytes > limit => Err(Error::TooLarge { path: path.to_owned(), bytes, limit }),
        _ => Ok(content),
    }
}

/// The same for text in UTF-8, without a byte order mark.
pub(crate) fn read_text(path: &Path, limit: u64) -> Result<String, Error> {
    text(path, read(path, limit)?)
}

/// The same of a file's bytes.
pub(super) fn text(path: &Path, bytes: Vec<u8>) -> Result<String, Error> {
    let mut text = String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        Error::Content { path: path.to_owned(), reason: format!("not text: byte {at} is not UTF-8") }
    })?;
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    Ok(text)
}
