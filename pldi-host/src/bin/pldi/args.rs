//! Options that several commands share.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use pldi_core::descriptor::DescriptorKind;
use pldi_core::floor::FloorMode;
use pldi_core::reconstruct::{FilterKind, FilterParams};
use pldi_core::view::{Framing, ViewParams};
use pldi_core::{Floor, Params};
use pldi_host::input::{DepthScale, Input, IntrinsicsSpec, Mode, OpenOptions, is_image, open, parse_intrinsics};
use pldi_host::{ArithmeticKind, Error};

/// Where the frames come from.
#[derive(Debug, Args)]
pub struct Source {
    /// A recording's folder (associations.txt, or rgb.txt and depth.txt, or depth.txt alone, or the folders rgb/ and
    /// depth/), a bag (.mcap, .bag), an OpenNI2 recording (.oni), a sensor (openni2: for the first, openni2:URI), or a
    /// single depth image
    #[arg(value_name = "SOURCE")]
    input: String,
    /// Topic of the colour images in a bag, or the colour image that belongs to a single depth image
    #[arg(long, visible_alias = "colour", value_name = "TOPIC|FILE")]
    color: Option<String>,
    /// Topic of the depth images in a bag
    #[arg(long, value_name = "TOPIC")]
    depth: Option<String>,
    /// Topic of the calibration in a bag
    #[arg(long, value_name = "TOPIC")]
    info: Option<String>,
    /// What a sensor is to deliver: qvga, vga, or WxH@RATE [default: qvga where the sensor can]
    #[arg(long, value_name = "MODE")]
    mode: Option<Mode>,
    /// End where a sensor is lost, instead of waiting for it
    #[arg(long)]
    once: bool,
    /// Unit of the depth images: mm, tum (1/5000 m), sun3d, or units per metre
    #[arg(long, value_name = "SCALE", default_value = "mm")]
    depth_scale: DepthScale,
    /// Intrinsics in pixels, in place of the recording's: fx,fy,cx,cy, with @WxH where they are for another size
    #[arg(long, value_name = "FX,FY,CX,CY[@WxH]", value_parser = intrinsics, allow_hyphen_values = true)]
    intrinsics: Option<IntrinsicsSpec>,
    /// Calibration file (camera_info.yaml) in place of the recording's
    #[arg(long, value_name = "FILE")]
    camera_info: Option<PathBuf>,
}

fn intrinsics(text: &str) -> Result<IntrinsicsSpec, Error> {
    parse_intrinsics(text)
}

impl Source {
    /// As it was given.
    pub fn name(&self) -> &str {
        &self.input
    }

    /// Opens it.
    pub fn open(&self) -> Result<Input, Error> {
        let image = is_image(&self.input);
        let options = OpenOptions {
            depth_scale: self.depth_scale,
            intrinsics: self.intrinsics,
            camera_info: self.camera_info.clone(),
            colour_image: self.color.as_ref().filter(|_| image).map(PathBuf::from),
            colour_topic: self.color.clone().filter(|_| !image),
            depth_topic: self.depth.clone(),
            info_topic: self.info.clone(),
            mode: self.mode,
            once: self.once,
        };
        open(&self.input, &options)
    }
}

/// How many frames.
#[derive(Debug, Args)]
pub struct Limit {
    /// End after so many frames
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frames: Option<u64>,
}

impl Limit {
    /// The input, or its first frames.
    pub fn apply(&self, input: Input) -> Input {
        match self.frames {
            Some(count) => input.first(usize::try_from(count).unwrap_or(usize::MAX)),
            None => input,
        }
    }
}

/// Which square of the frontal plane is the view.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum FramingArg {
    /// A square of 2 m standing on the floor: size counts
    Metric,
    /// Fitted to the object: size does not count
    Fit,
}

/// Which statistics describe a view.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum DescriptorArg {
    /// Mean, standard deviation and skewness of each sub-band
    Paper,
    /// Means of the upper and lower half and standard deviation of each sub-band
    Halves,
}

impl From<DescriptorArg> for DescriptorKind {
    fn from(arg: DescriptorArg) -> Self {
        match arg {
            DescriptorArg::Paper => Self::Paper,
            DescriptorArg::Halves => Self::Halves,
        }
    }
}

/// What a descriptor depends on.
#[derive(Debug, Args)]
pub struct ViewArgs {
    /// Which square of the frontal plane is the view [default: the templates']
    #[arg(long, value_enum)]
    framing: Option<FramingArg>,
    /// Which statistics describe the view [default: the templates']
    #[arg(long, value_enum)]
    descriptor: Option<DescriptorArg>,
}

impl ViewArgs {
    /// The view parameters: what was asked for, else those of `default`.
    pub fn params(&self, default: ViewParams) -> ViewParams {
        let framing = match self.framing {
            None => default.framing,
            Some(FramingArg::Fit) => Framing::Fit,
            Some(FramingArg::Metric) => Framing::Metric { side: ViewParams::METRIC_SIDE },
        };
        ViewParams { framing, descriptor: self.descriptor.map_or(default.descriptor, Into::into), ..default }
    }
}

/// What is computed in.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum ArithmeticArg {
    /// Single precision
    Float,
    /// Integers alone, as on a microcontroller without FPU: the same bits on every machine
    Fixed,
}

impl From<ArithmeticArg> for ArithmeticKind {
    fn from(arg: ArithmeticArg) -> Self {
        match arg {
            ArithmeticArg::Float => Self::Float,
            ArithmeticArg::Fixed => Self::Fixed,
        }
    }
}

/// The depth's reconstruction.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum FilterArg {
    /// Guided by colour and depth
    Joint,
    /// Guided by depth alone
    Bilateral,
    /// Equation 1 of the paper as it is written: seconds per frame, in floats only
    Exact,
    /// The measured depth as it is
    None,
}

/// How frames are processed.
#[derive(Debug, Args)]
pub struct Processing {
    #[command(flatten)]
    pub view: ViewArgs,
    /// auto: found in each frame; or the camera's pose: height in m, pitch in degrees (looking down), roll in degrees
    #[arg(long, value_name = "auto|HEIGHT,PITCH[,ROLL]", default_value = "auto", value_parser = floor, allow_hyphen_values = true)]
    floor: FloorMode,
    /// How the depth is reconstructed
    #[arg(long, value_enum, default_value = "joint")]
    filter: FilterArg,
    /// What all stages compute in; a template file of floats is converted for fixed
    #[arg(long, value_enum, default_value = "float")]
    arithmetic: ArithmeticArg,
}

/// Parses `--floor`.
fn floor(text: &str) -> Result<FloorMode, String> {
    if text == "auto" {
        return Ok(FloorMode::default());
    }
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|s| s.trim().parse::<f32>()).collect();
    let (height, pitch, roll) = match numbers.as_deref() {
        Ok([height, pitch]) => (*height, *pitch, 0.0),
        Ok([height, pitch, roll]) => (*height, *pitch, *roll),
        _ => {
            return Err(
                "give auto, or the camera's HEIGHT in m, PITCH and ROLL in degrees: 1.2,20 or 1.2,20,0".to_owned()
            );
        }
    };
    Floor::from_pose(height, pitch.to_radians(), roll.to_radians()).map(FloorMode::Fixed).map_err(|e| e.to_string())
}

impl Processing {
    /// What to compute in.
    pub fn arithmetic(&self) -> ArithmeticKind {
        self.arithmetic.into()
    }

    /// All parameters, with the templates' view parameters where none were asked for.
    pub fn params(&self, templates: ViewParams) -> Params {
        let kind = match self.filter {
            FilterArg::Joint => FilterKind::Joint,
            FilterArg::Bilateral => FilterKind::Bilateral,
            FilterArg::Exact => FilterKind::Exact,
            FilterArg::None => FilterKind::None,
        };
        Params {
            view: self.view.params(templates),
            floor: self.floor,
            filter: FilterParams { kind, ..FilterParams::DEFAULT },
            ..Params::DEFAULT
        }
    }
}

/// Number of threads.
#[derive(Debug, Args)]
pub struct Threads {
    /// Threads to use; the output is the same for any number [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,
}

impl Threads {
    /// The number asked for, or one per core.
    pub fn count(&self) -> usize {
        self.threads.map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from)
    }
}
