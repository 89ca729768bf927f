//! What can go wrong on the host, in sentences: what, where, and what to do about it.
//!
//! The messages are complete by themselves (causes included), so that one line on stderr is enough.

use std::io;
use std::path::PathBuf;

/// Where a camera's intrinsics came from; an error says it, and whose mistake it is depends on it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum IntrinsicsOrigin {
    /// Given by the user (`--intrinsics`).
    Option,
    /// Read from a `camera_info.yaml`.
    File(PathBuf),
    /// Known to the source itself; says how.
    Source(String),
    /// None of these was there: the nominal structured-light camera.
    Default,
}

impl std::fmt::Display for IntrinsicsOrigin {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Option => f.write_str("--intrinsics"),
            Self::File(path) => write!(f, "{}", path.display()),
            Self::Source(how) => f.write_str(how),
            Self::Default => f.write_str("the default intrinsics"),
        }
    }
}

/// Why the host refused or failed. [`Error::is_usage`] tells a mistake in the call from a fault of the data.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An option or argument that makes no sense, with what would.
    #[error("{0}")]
    Usage(String),
    /// A file or folder could not be read.
    #[error("cannot read {}: {cause}", path.display())]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        cause: io::Error,
    },
    /// A file could not be written.
    #[error("cannot write {}: {cause}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        cause: io::Error,
    },
    /// A file of zero bytes.
    #[error("{} is empty (0 bytes): the recording or a copy was interrupted, fetch it again", .0.display())]
    EmptyFile(PathBuf),
    /// A file larger than anything sensible of its kind.
    #[error("{} has {bytes} bytes, at most {limit} are read for such a file: is it the right one?", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
        /// The largest size accepted.
        limit: u64,
    },
    /// A line of a text file is not understood.
    #[error("{}, line {line}: {reason}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// What is wrong there.
        reason: String,
    },
    /// A file's content is not usable.
    #[error("{}: {reason}", path.display())]
    Content {
        /// The file or folder.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The file of a frame failed; says where the frame is listed.
    #[error("{cause} (listed in {}, line {line})", list.display())]
    Listed {
        /// The list that names the file.
        list: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// What is wrong with the file.
        cause: Box<Self>,
    },
    /// Colour and depth of one frame have different sizes.
    #[error(
        "{} is {}x{}, but {} is {}x{}: colour and depth must be registered and of one size",
        colour.display(), colour_size.0, colour_size.1, depth.display(), depth_size.0, depth_size.1
    )]
    PairSizes {
        /// The colour image.
        colour: PathBuf,
        /// Its width and height.
        colour_size: (u32, u32),
        /// The depth image.
        depth: PathBuf,
        /// Its width and height.
        depth_size: (u32, u32),
    },
    /// The intrinsics belong to images of another size.
    #[error(
        "{} is {}x{}, but the intrinsics ({origin}) are for {}x{}: give the ones calibrated at the image's size",
        image.display(), size.0, size.1, intrinsics.0, intrinsics.1
    )]
    IntrinsicsSize {
        /// The depth image.
        image: PathBuf,
        /// Its width and height.
        size: (u32, u32),
        /// Width and height that the intrinsics are for.
        intrinsics: (u16, u16),
        /// Where the intrinsics came from.
        origin: IntrinsicsOrigin,
    },
    /// A number of the intrinsics is absurd.
    #[error("{origin}: {name} = {value} {reason}")]
    Intrinsics {
        /// Where the intrinsics came from.
        origin: IntrinsicsOrigin,
        /// Which number.
        name: &'static str,
        /// What it is.
        value: f64,
        /// Why that cannot be.
        reason: String,
    },
    /// An image size that cannot be reduced to QVGA by taking whole blocks.
    #[error(
        "{} is {}x{}: frames are processed at 320x240, so width and height must be the same whole multiple of it \
         (320x240, 640x480, 960x720, 1280x960, ... up to {}x{}); crop or resize the recording",
        image.display(), size.0, size.1, 320 * crate::input::MAX_FACTOR, 240 * crate::input::MAX_FACTOR
    )]
    UnsupportedSize {
        /// The image.
        image: PathBuf,
        /// Its width and height.
        size: (u32, u32),
    },
    /// The core refused parameters, intrinsics or a frame.
    #[error("{0}")]
    Core(pldi_core::Error),
    /// A template file was refused.
    #[error("{}: {cause}", path.display())]
    Templates {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        cause: pldi_core::TemplateError,
    },
    /// The system gave no thread to read frames with.
    #[error("cannot start a thread: {0}; end other programs, or raise the limit of threads (ulimit -u)")]
    Thread(io::Error),
    /// A sensor, or the library through which it is reached; says what to do.
    #[error("{0}")]
    Device(String),
    /// The user or a signal ended the work.
    #[error("interrupted")]
    Interrupted,
    /// There is no frame of that number.
    #[error("frame {index} was asked for, but the recording has {len} (the first is 0)")]
    FrameIndex {
        /// The number asked for.
        index: usize,
        /// Number of frames.
        len: usize,
    },
}

impl Error {
    /// An error of the core.
    pub fn core(cause: pldi_core::Error) -> Self {
        Self::Core(cause)
    }

    /// Whether the call was wrong (exit code 2) rather than the data (exit code 1).
    pub fn is_usage(&self) -> bool {
        match self {
            Self::Usage(_) | Self::FrameIndex { .. } => true,
            Self::IntrinsicsSize { origin, .. } | Self::Intrinsics { origin, .. } => {
                *origin == IntrinsicsOrigin::Option
            }
            Self::Listed { cause, .. } => cause.is_usage(),
            _ => false,
        }
    }

    /// The process exit code that goes with the error: 2 for usage, 1 for data.
    pub fn exit_code(&self) -> u8 {
        if self.is_usage() { 2 } else { 1 }
    }
}

/// The beginning of what a file says, for a message: a line may be as long as the file.
pub(crate) fn excerpt(text: &str) -> String {
    text.chars().take(40).collect()
}

/// What another library says, as part of a sentence: its first line, at most 200 characters of it, control characters
/// written out. What follows is an excerpt of the file.
pub(crate) fn told(cause: &impl std::fmt::Display) -> String {
    let text = cause.to_string();
    let line = text.lines().next().unwrap_or_default().trim_end();
    let plain = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
    line.chars().take(200).map(plain).collect()
}

#[cfg(test)]
mod tests {
    use super::told;

    #[test]
    fn what_a_library_says_becomes_part_of_a_sentence() {
        assert_eq!(told(&"Line 3: no\u{1b}[31m number \n\tString: 'x'"), "Line 3: no\\u{1b}[31m number");
        assert_eq!(told(&"\u{e4}".repeat(999)).chars().count(), 200);
        assert_eq!(told(&""), "");
    }
}
