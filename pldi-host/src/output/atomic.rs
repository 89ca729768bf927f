//! A file appears under its name only when it is complete: written beside it under a temporary name, then renamed.
//!
//! This guards readers and interrupted runs against half a file; it is no promise about power cuts.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::Error;

/// Writes a file with what `content` puts out. On an error the old file, if there was one, is as before.
///
/// # Errors
/// `Write` with the file's name, also for errors that `content` returns.
pub fn write_with(path: &Path, content: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>) -> Result<(), Error> {
    write_inner(path, content).map_err(|cause| Error::Write { path: path.to_owned(), cause })
}

/// Writes a file of these bytes.
///
/// # Errors
/// `Write` with the file's name.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    write_with(path, |out| out.write_all(bytes))
}

/// Writes a JSON file, indented, with a line feed at its end.
///
/// # Errors
/// `Write` with the file's name.
pub fn write_json(path: &Path, value: &serde_json::Value) -> Result<(), Error> {
    write_with(path, |out| {
        serde_json::to_writer_pretty(&mut *out, value)?;
        out.write_all(b"\n")
    })
}

fn write_inner(path: &Path, content: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>) -> io::Result<()> {
    let mut pending = Pending::open(path)?;
    let mut out = BufWriter::new(pending.file());
    content(&mut out)?;
    out.flush()?;
    drop(out);
    pending.rename()
}

/// A file that is being written, for those who write it bit by bit. It appears under its name when it is
/// [kept](Self::keep); otherwise the old file, if there was one, stays.
#[derive(Debug)]
pub struct Pending {
    path: PathBuf,
    target: Target,
}

#[derive(Debug)]
enum Target {
    /// Pipes and devices (/dev/stdout) cannot be replaced by a rename.
    Stream(File),
    Temporary(NamedTempFile),
}

impl Pending {
    /// Begins a file.
    ///
    /// # Errors
    /// `Write` with the file's name.
    pub fn create(path: &Path) -> Result<Self, Error> {
        Self::open(path).map_err(|cause| Error::Write { path: path.to_owned(), cause })
    }

    /// Lets the file appear under its name.
    ///
    /// # Errors
    /// `Write` with the file's name.
    pub fn keep(self) -> Result<(), Error> {
        let path = self.path.clone();
        self.rename().map_err(|cause| Error::Write { path, cause })
    }

    fn open(path: &Path) -> io::Result<Self> {
        let target = match std::fs::metadata(path) {
            Ok(target) if target.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
            Ok(target) if !target.is_file() => Target::Stream(File::options().write(true).open(path)?),
            _ => Target::Temporary(temporary(path)?),
        };
        Ok(Self { path: path.to_owned(), target })
    }

    fn file(&mut self) -> &mut File {
        match &mut self.target {
            Target::Stream(file) => file,
            Target::Temporary(file) => file.as_file_mut(),
        }
    }

    fn rename(self) -> io::Result<()> {
        match self.target {
            Target::Stream(_) => Ok(()),
            Target::Temporary(file) => Ok(file.persist(self.path).map(drop)?),
        }
    }
}

impl Write for Pending {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file().flush()
    }
}

/// A temporary file beside `path`.
fn temporary(path: &Path) -> io::Result<NamedTempFile> {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(io::Error::new(io::ErrorKind::NotFound, format!("there is no folder {}", folder.display())));
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".pldi-").suffix(".tmp");
    // Temporary files are private by default; this one becomes an ordinary file, for which the umask decides.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_is_there_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.bin");
        write_bytes(&path, b"first").unwrap();
        let error = write_with(&path, |out| {
            out.write_all(&[7; 100_000])?;
            Err(io::Error::other("disk gone"))
        });
        let text = error.unwrap_err().to_string();
        assert!(text.contains("out.bin") && text.contains("disk gone"), "{text}");
        assert_eq!(std::fs::read(&path).unwrap(), b"first");
        write_bytes(&path, b"second").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"second");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "a temporary file was left");
    }

    #[test]
    fn bit_by_bit_it_appears_when_it_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.bin");
        let mut pending = Pending::create(&path).unwrap();
        pending.write_all(b"given up").unwrap();
        drop(pending);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        let mut pending = Pending::create(&path).unwrap();
        pending.write_all(b"kept").unwrap();
        assert!(!path.exists());
        pending.keep().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"kept");
        assert!(Pending::create(folder.path()).unwrap_err().to_string().contains("directory"));
    }

    #[test]
    fn what_cannot_be_written_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let text = write_bytes(&folder.path().join("no/such/file"), b"").unwrap_err().to_string();
        assert!(text.contains("no/such/file") && text.contains("there is no folder"), "{text}");
        assert!(write_bytes(folder.path(), b"").is_err());
    }

    #[cfg(unix)]
    #[test]
    fn modes_and_devices_are_as_usual() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (ours, usual) = (folder.path().join("ours"), folder.path().join("usual"));
        write_bytes(&ours, b"x").unwrap();
        std::fs::write(&usual, b"x").unwrap();
        let mode = |path| std::fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&usual));
        write_bytes(Path::new("/dev/null"), b"x").unwrap();
    }
}
