//! One place where inputs are opened, whatever their format.

use std::path::{Path, PathBuf};

use super::{DepthScale, Frame, IntrinsicsSpec, Preparation, RawFrame, Source, Stop, bag, folder, mcap, openni2};
use crate::Error;

/// How to understand an input. Each format takes what concerns it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct OpenOptions {
    /// Unit of 16-bit depth images.
    pub depth_scale: DepthScale,
    /// Intrinsics to use in place of the source's.
    pub intrinsics: Option<IntrinsicsSpec>,
    /// Calibration file to use in place of the source's.
    pub camera_info: Option<PathBuf>,
    /// The colour image that belongs to a single depth image.
    pub colour_image: Option<PathBuf>,
    /// Topic of the colour images in a bag.
    pub colour_topic: Option<String>,
    /// Topic of the depth images in a bag.
    pub depth_topic: Option<String>,
    /// Topic of the calibration in a bag.
    pub info_topic: Option<String>,
    /// What a sensor is to deliver.
    pub mode: Option<Mode>,
    /// End where a sensor is lost, instead of waiting for it.
    pub once: bool,
}

/// What a sensor delivers: both images of one size.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mode {
    /// Width in pixels.
    pub width: u16,
    /// Height in pixels.
    pub height: u16,
    /// Frames per second.
    pub rate: u16,
}

impl Mode {
    /// What microcontrollers process, and every structured-light sensor delivers.
    pub const QVGA: Self = Self { width: 320, height: 240, rate: 30 };
    /// The full resolution of structured-light sensors.
    pub const VGA: Self = Self { width: 640, height: 480, rate: 30 };
}

impl std::fmt::Display for Mode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}@{}", self.width, self.height, self.rate)
    }
}

impl std::str::FromStr for Mode {
    type Err = Error;

    /// `qvga`, `vga` (both at 30 Hz), or `WxH@RATE`.
    fn from_str(text: &str) -> Result<Self, Error> {
        let numbers = || {
            let (size, rate) = text.split_once('@')?;
            let (width, height) = size.split_once(['x', 'X'])?;
            let number = |s: &str| s.trim().parse::<u16>().ok().filter(|n| *n > 0);
            Some(Self { width: number(width)?, height: number(height)?, rate: number(rate)? })
        };
        match text {
            "qvga" => Ok(Self::QVGA),
            "vga" => Ok(Self::VGA),
            _ => numbers().ok_or_else(|| {
                Error::Usage(format!("mode {text:?}: give qvga, vga, or width, height and rate as 640x480@30"))
            }),
        }
    }
}

/// What options an input can do something with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Images in files.
    Files,
    /// Topics.
    Bag,
    /// A sensor.
    Device,
}

/// Opens an input of one kind.
type Open = fn(&str, &OpenOptions) -> Result<Box<dyn Source>, Error>;

/// A kind of input.
struct Format {
    /// What it is, for messages.
    name: &'static str,
    /// Whether this text names an input of this kind. The first format that claims it opens it.
    claims: fn(&str) -> bool,
    kind: Kind,
    open: Open,
}

/// All formats.
const FORMATS: &[Format] = &[
    Format {
        name: "a recording's folder",
        claims: |uri| Path::new(uri).is_dir(),
        kind: Kind::Files,
        open: folder::open,
    },
    Format { name: "a ROS 2 recording (.mcap)", claims: mcap::claims, kind: Kind::Bag, open: mcap::open },
    Format { name: "a ROS 1 bag (.bag)", claims: bag::claims, kind: Kind::Bag, open: bag::open },
    Format { name: "a depth image (.png)", claims: is_image, kind: Kind::Files, open: folder::open_image },
    Format { name: "OpenNI2's recording (.oni)", claims: openni2::is_file, kind: Kind::Files, open: openni2::open },
    Format { name: "a sensor (openni2:)", claims: openni2::is_sensor, kind: Kind::Device, open: openni2::open },
];

/// Whether a file's name ends so, in capitals or not.
pub(super) fn ends_with(uri: &str, extension: &str) -> bool {
    Path::new(uri).extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

/// Whether the name is that of an image that could hold depth, if by mistake.
pub fn is_image(uri: &str) -> bool {
    ["png", "jpg", "jpeg"].iter().any(|e| ends_with(uri, e)) && !Path::new(uri).is_dir()
}

/// Opens whatever `uri` names: a device, a file, a folder.
///
/// # Errors
/// `Usage` where the options make no sense, `Read` where there is nothing of that name, `Content` where no format knows it, and
/// what the format says.
pub fn open(uri: &str, options: &OpenOptions) -> Result<Input, Error> {
    let Some(format) = FORMATS.iter().find(|format| (format.claims)(uri)) else {
        let path = Path::new(uri);
        std::fs::metadata(path).map_err(|cause| Error::Read { path: path.to_owned(), cause })?;
        let known: Vec<&str> = FORMATS.iter().map(|format| format.name).collect();
        let reason = format!("no known kind of input; there are {}", known.join(", "));
        return Err(Error::Content { path: path.to_owned(), reason });
    };
    check(uri, format.kind, options)?;
    tracing::debug!("{uri} is {}", format.name);
    let preparation = Preparation::new(options)?;
    Ok(Input { source: (format.open)(uri, options)?, preparation, next: 0 })
}

/// Options that an input can do nothing with are mistakes.
fn check(uri: &str, kind: Kind, options: &OpenOptions) -> Result<(), Error> {
    let OpenOptions { colour_image, colour_topic, depth_topic, info_topic, mode, once, .. } = options;
    let topics = depth_topic.is_some() || info_topic.is_some();
    let mistake = match kind {
        _ if colour_image.is_some() && !is_image(uri) => "--color FILE goes with a single depth image",
        Kind::Files | Kind::Device if colour_topic.is_some() => "--color goes with a bag, or with a single depth image",
        Kind::Files | Kind::Device if topics => "--depth and --info name topics of a bag",
        Kind::Files | Kind::Bag if mode.is_some() => "--mode goes with a device",
        Kind::Files | Kind::Bag if *once => "--once goes with a device",
        _ => return Ok(()),
    };
    Err(Error::Usage(format!("{mistake}; {uri} is none")))
}

/// An open source, and how its frames become the pipeline's.
pub struct Input {
    source: Box<dyn Source>,
    preparation: Preparation,
    /// Number of the next frame.
    next: usize,
}

impl std::fmt::Debug for Input {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Input")
            .field("preparation", &self.preparation)
            .field("next", &self.next)
            .finish_non_exhaustive()
    }
}

impl Input {
    /// Frames of a source that is none of the formats here.
    ///
    /// # Errors
    /// Where the calibration file in the options is not understood.
    pub fn new(source: Box<dyn Source>, options: &OpenOptions) -> Result<Self, Error> {
        Ok(Self { source, preparation: Preparation::new(options)?, next: 0 })
    }

    /// Number of frames, where it is known without reading them.
    pub fn frames_left(&self) -> Option<usize> {
        self.source.frames()
    }

    /// Whether frames that nobody takes in time are lost.
    pub fn is_live(&self) -> bool {
        self.source.is_live()
    }

    /// The source, and what prepares its frames: to do either on threads of its own.
    pub fn into_parts(self) -> (Box<dyn Source>, Preparation) {
        (self.source, self.preparation)
    }

    /// The next frame with its number, its images not decoded yet.
    ///
    /// # Errors
    /// As [`Source::next`].
    pub fn raw(&mut self, stop: &Stop) -> Result<Option<(usize, RawFrame)>, Error> {
        let Some(raw) = self.source.next(stop)? else { return Ok(None) };
        self.next += 1;
        Ok(Some((self.next - 1, raw)))
    }

    /// Prepares a frame.
    ///
    /// # Errors
    /// As [`Preparation::frame`].
    pub fn prepare(&self, index: usize, raw: RawFrame) -> Result<Frame, Error> {
        self.preparation.frame(index, raw)
    }

    /// Ends after `count` frames.
    pub fn first(self, count: usize) -> Self {
        let Self { source, preparation, next } = self;
        Self { source: Box::new(First { source, left: count }), preparation, next }
    }

    /// All frames from here on. An error of one frame is followed by the next frame, one of the source by the end.
    pub fn frames(&mut self) -> impl Iterator<Item = Result<Frame, Error>> {
        let (stop, mut ended) = (Stop::default(), false);
        std::iter::from_fn(move || {
            if ended {
                return None;
            }
            match self.raw(&stop) {
                Ok(Some((index, raw))) => Some(self.prepare(index, raw)),
                Ok(None) => {
                    ended = true;
                    None
                }
                Err(error) => {
                    ended = true;
                    Some(Err(error))
                }
            }
        })
    }

    /// The frame of number `index`, which must not have been read yet; those before it are passed over.
    ///
    /// # Errors
    /// `FrameIndex` where there are fewer frames; what is wrong with the source or the frame.
    pub fn frame(&mut self, index: usize, stop: &Stop) -> Result<Frame, Error> {
        loop {
            match self.raw(stop)? {
                Some((at, raw)) if at == index => return self.prepare(at, raw),
                Some(_) => {}
                None if stop.is_raised() => return Err(Error::Interrupted),
                None => return Err(Error::FrameIndex { index, len: self.next }),
            }
        }
    }
}

/// The first frames of a source.
struct First {
    source: Box<dyn Source>,
    left: usize,
}

impl Source for First {
    fn next(&mut self, stop: &Stop) -> Result<Option<RawFrame>, Error> {
        if self.left == 0 {
            return Ok(None);
        }
        self.left -= 1;
        self.source.next(stop)
    }

    fn frames(&self) -> Option<usize> {
        self.source.frames().map(|count| count.min(self.left))
    }

    fn is_live(&self) -> bool {
        self.source.is_live()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_by_name_and_by_numbers() {
        assert_eq!("qvga".parse::<Mode>().unwrap(), Mode::QVGA);
        assert_eq!("640x480@30".parse::<Mode>().unwrap(), Mode::VGA);
        assert_eq!(Mode::VGA.to_string(), "640x480@30");
        for text in ["", "640x480", "0x480@30", "640x480@", "axb@c", "640x480@70000"] {
            let error = text.parse::<Mode>().unwrap_err();
            assert!(error.is_usage() && error.to_string().contains("qvga"), "{error}");
        }
    }

    #[test]
    fn what_is_not_there_or_not_known_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("nowhere");
        let error = open(missing.to_str().unwrap(), &OpenOptions::default()).unwrap_err();
        assert!(!error.is_usage() && error.to_string().contains("nowhere"), "{error}");
        let file = folder.path().join("notes.txt");
        std::fs::write(&file, "x").unwrap();
        let error = open(file.to_str().unwrap(), &OpenOptions::default()).unwrap_err();
        assert!(!error.is_usage() && error.to_string().contains("a recording's folder"), "{error}");
    }
}
