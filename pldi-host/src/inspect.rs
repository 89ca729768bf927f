//! What a recording is like, and what may be wrong with it: its size and rate, its depth's range, whether a floor is
//! seen, whether depth and colour are registered.

mod depth;
mod edges;
mod table;
mod timing;

use pldi_core::pipeline::{Params, QvgaPipeline, QvgaWorkspace};
use serde::{Deserialize, Serialize};

pub use depth::DepthSummary;
pub use timing::Timing;

use crate::Error;
use crate::error::IntrinsicsOrigin;
use crate::input::{DepthScale, Frame, Input, QvgaFrame, Stop};
use depth::Histogram;
use edges::Agreement;

/// All about a recording. Its `Display` is a table for people.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Number of frames.
    pub frames: usize,
    /// How many of them were looked at, evenly spread.
    pub looked_at: usize,
    /// Those of them that could not be read.
    pub unreadable: Vec<Unreadable>,
    /// Duration, rate and gaps.
    pub timing: Timing,
    /// The sizes met, each with the factor by which it exceeds 320x240.
    pub sizes: Vec<Size>,
    /// The intrinsics in use, at the images' size.
    pub intrinsics: Option<Camera>,
    /// Whether there is colour.
    pub colour: bool,
    /// The depths.
    pub depth: DepthSummary,
    /// In how many of the frames looked at a floor was found.
    pub floors: usize,
    /// Height of the camera above the floor in metres: smallest, median, largest.
    pub height: Option<[f32; 3]>,
    /// How far the camera looks down in degrees: smallest, median, largest.
    pub pitch: Option<[f32; 3]>,
    /// Whether depth and colour fit; `None` without colour.
    pub registration: Option<Registration>,
}

/// A frame that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Unreadable {
    /// Its number.
    pub frame: usize,
    /// What is wrong.
    pub error: String,
}

/// A size of images.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Size {
    /// Width in pixels.
    pub width: u16,
    /// Height in pixels.
    pub height: u16,
    /// The factor by which it exceeds 320x240.
    pub factor: u16,
}

/// Intrinsics in pixels, and where they come from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// fx, fy, cx, cy.
    pub k: [f32; 4],
    /// `--intrinsics`, a file, or the default.
    pub origin: String,
}

/// What the comparison of depth jumps and colour edges says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// They coincide.
    Registered,
    /// They would if the depth were shifted.
    Off,
    /// No shift stands out, or there are too few jumps.
    CannotTell,
}

/// How well the depth's jumps coincide with the colour's edges.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Registration {
    /// In a word.
    pub verdict: Verdict,
    /// By how many pixels the depth should be shifted to fit best, right and down.
    pub shift: [i32; 2],
    /// Mean rank (0..1) of the colour's change at the depth's jumps.
    pub agreement: f32,
    /// That of the best shift.
    pub best: f32,
    /// `agreement` divided by its mean over all shifts: 1 = no better than chance.
    pub ratio: f32,
    /// Depth jumps looked at.
    pub jumps: u64,
}

/// Looks at up to `frames` frames of an input, evenly spread; the first ones, where their number is not known beforehand. Of
/// a live one no more are taken. `each` is called after each frame looked at; it ends the work by returning false, as does
/// `stop`.
///
/// # Errors
/// `Interrupted` where `each` or `stop` says so; a mistake in the call that shows in a frame; the first frame's error where
/// no frame can be read; what ends the source early.
pub fn inspect(mut input: Input, frames: usize, stop: &Stop, mut each: impl FnMut() -> bool) -> Result<Summary, Error> {
    let wanted = |index: usize, chosen: &Option<Vec<usize>>| match chosen {
        Some(chosen) => chosen.binary_search(&index).is_ok(),
        None => index < frames,
    };
    if input.is_live() {
        input = input.first(frames);
    }
    let chosen = input.frames_left().map(|count| spread(count, frames));
    let (mut stamps, mut looked_at) = (Vec::new(), 0);
    let mut look = Look::new();
    let mut first_error = None;
    while let Some((index, raw)) = input.raw(stop)? {
        stamps.push(raw.stamp.seconds());
        if !wanted(index, &chosen) {
            continue;
        }
        looked_at += 1;
        if let Err(error) = input.prepare(index, raw).and_then(|frame| look.at(frame)) {
            if error.is_usage() {
                return Err(error);
            }
            look.unreadable.push(Unreadable { frame: index, error: error.to_string() });
            first_error = first_error.or(Some(error));
        }
        if !each() {
            return Err(Error::Interrupted);
        }
    }
    match first_error {
        _ if stop.is_raised() => Err(Error::Interrupted),
        Some(error) if look.unreadable.len() == looked_at => Err(error),
        _ => Ok(look.summary(&stamps, looked_at)),
    }
}

/// Up to `wanted` of the numbers below `count`, evenly spread, the first and the last among them.
fn spread(count: usize, wanted: usize) -> Vec<usize> {
    let wanted = wanted.min(count);
    if wanted <= 1 {
        return (0..wanted).collect();
    }
    (0..wanted).map(|i| i * (count - 1) / (wanted - 1)).collect()
}

/// What was seen so far.
struct Look {
    workspace: Box<QvgaWorkspace>,
    unreadable: Vec<Unreadable>,
    sizes: Vec<Size>,
    intrinsics: Option<([f32; 4], IntrinsicsOrigin)>,
    histogram: Histogram,
    /// Height in metres and pitch in degrees.
    floors: Vec<[f32; 2]>,
    agreement: Option<Agreement>,
}

impl Look {
    fn new() -> Self {
        let workspace = Box::new(QvgaWorkspace::new());
        let (unreadable, sizes, floors) = Default::default();
        let histogram = Histogram::new();
        Self { workspace, unreadable, sizes, intrinsics: None, histogram, floors, agreement: None }
    }

    fn at(&mut self, frame: Frame) -> Result<(), Error> {
        let Frame { qvga: frame, mut images, origin, .. } = frame;
        images.depth = images.depth_mm();
        images.scale = DepthScale::Millimetres;
        let QvgaFrame { factor, original_size: (width, height), intrinsics: k, .. } = frame;
        let size = Size { width, height, factor };
        if !self.sizes.contains(&size) {
            self.sizes.push(size);
        }
        self.intrinsics.get_or_insert_with(|| ([k.fx, k.fy, k.cx, k.cy].map(|v| v * f32::from(factor)), origin));
        self.histogram.add(&images.depth);
        // Frames of another size than the first would need sums of their own.
        if images.colour.is_some() && self.sizes[0] == size {
            self.agreement.get_or_insert_with(|| Agreement::new(factor)).add(&images);
        }
        let pipeline = QvgaPipeline::new(&Params::DEFAULT, &frame.intrinsics).map_err(Error::core)?;
        pipeline.reconstruct(&frame.as_frame().map_err(Error::core)?, &mut self.workspace);
        if let Some(floor) = pipeline.find_floor(&mut self.workspace) {
            self.floors.push([floor.height, floor.pitch().to_degrees()]);
        }
        Ok(())
    }

    fn summary(self, stamps: &[f64], looked_at: usize) -> Summary {
        let of = |k: usize| {
            let mut values: Vec<f32> = self.floors.iter().map(|f| f[k]).collect();
            values.sort_by(f32::total_cmp);
            Some([*values.first()?, values[values.len() / 2], *values.last()?])
        };
        let camera = |(k, origin): (_, IntrinsicsOrigin)| Camera { k, origin: origin.to_string() };
        Summary {
            frames: stamps.len(),
            looked_at,
            timing: Timing::new(stamps),
            intrinsics: self.intrinsics.map(camera),
            colour: self.agreement.is_some(),
            depth: self.histogram.summary(),
            floors: self.floors.len(),
            height: of(0),
            pitch: of(1),
            registration: self.agreement.as_ref().map(registration),
            unreadable: self.unreadable,
            sizes: self.sizes,
        }
    }
}

fn registration(agreement: &Agreement) -> Registration {
    let unknown =
        Registration { verdict: Verdict::CannotTell, shift: [0; 2], agreement: 0.0, best: 0.0, ratio: 0.0, jumps: 0 };
    let Some(found) = agreement.finding() else { return unknown };
    let verdict = match (found.clear, found.small) {
        (false, _) => Verdict::CannotTell,
        (true, true) => Verdict::Registered,
        (true, false) => Verdict::Off,
    };
    Registration {
        verdict,
        shift: found.shift,
        agreement: found.here as f32,
        best: found.best as f32,
        ratio: (found.here / found.mean.max(1e-9)) as f32,
        jumps: found.jumps,
    }
}

#[cfg(test)]
mod tests {
    use super::spread;

    #[test]
    fn frames_are_spread_from_the_first_to_the_last() {
        assert_eq!(spread(10, 3), [0, 4, 9]);
        assert_eq!(spread(3, 20), [0, 1, 2]);
        assert_eq!(spread(5, 1), [0]);
        assert_eq!(spread(1, 9), [0]);
    }
}
