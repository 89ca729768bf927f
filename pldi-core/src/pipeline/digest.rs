//! Check sums of what the stages leave behind: the same on every target, in both arithmetics, or something is wrong.

use super::{Arithmetic, Pipeline, Workspace};
use crate::crc::crc32;
use crate::ground::Cluster;
use crate::templates::Templates;
use crate::{Error, Frame};

/// The stages, in the order of [`Digests`].
pub const STAGES: [&str; 8] =
    ["depth", "floor", "ground", "clusters", "n", "coefficients", "descriptors", "hypotheses"];

/// CRC-32 of what each of [`STAGES`] left, numbers little-endian; those of stages that were not reached are 0.
pub type Digests = [u32; STAGES.len()];

/// Numbers whose bits can be summed up.
pub trait Bits {
    /// The check sum of the numbers' little-endian bytes, continued from `crc`.
    fn feed(&self, crc: u32) -> u32;
}

macro_rules! numbers {
    ($($number:ty),*) => {$(
        impl Bits for $number {
            fn feed(&self, crc: u32) -> u32 {
                crc32(crc, &self.to_le_bytes())
            }
        }
    )*};
}

numbers!(u8, u16, u32, i32, f32);

impl<T: Bits> Bits for [T] {
    fn feed(&self, crc: u32) -> u32 {
        self.iter().fold(crc, |crc, value| value.feed(crc))
    }
}

impl<T: Bits, const N: usize> Bits for [T; N] {
    fn feed(&self, crc: u32) -> u32 {
        self.as_slice().feed(crc)
    }
}

impl<T: Bits> Bits for Cluster<T> {
    fn feed(&self, crc: u32) -> u32 {
        let rejection = self.rejection.map_or(0, |reason| reason as u8 + 1);
        let crc = rejection.feed(self.bbox.feed(self.pixels.feed(crc)));
        self.size.feed(self.center.feed(self.top.feed(self.centroid.feed(crc))))
    }
}

/// Takes a frame all the way like [`Pipeline::run`], and tells what each stage left.
///
/// # Errors
/// As [`Pipeline::run`].
pub fn run<A: Arithmetic, const W: usize, const H: usize>(
    pipeline: &Pipeline<A, W, H>,
    frame: &Frame<'_, W, H>,
    templates: &Templates<'_>,
    workspace: &mut Workspace<A, W, H>,
) -> Result<Digests, Error> {
    pipeline.reconstruct(frame, workspace);
    recognise(pipeline, templates, workspace)
}

/// All stages after the first like [`Pipeline::recognise`], and what each stage left, the first one included.
///
/// # Errors
/// As [`Pipeline::recognise`].
pub fn recognise<A: Arithmetic, const W: usize, const H: usize>(
    pipeline: &Pipeline<A, W, H>,
    templates: &Templates<'_>,
    workspace: &mut Workspace<A, W, H>,
) -> Result<Digests, Error> {
    let mut sums = [0; STAGES.len()];
    let [depth, floor_sum, ground, clusters, n, coefficients, descriptors, hypotheses] = &mut sums;
    workspace.report.clear();
    *depth = A::feed_depth(&workspace.images, 0);
    let Some(floor) = pipeline.find_floor(workspace) else { return Ok(sums) };
    *floor_sum = floor.feed(0);
    pipeline.find_candidates(&floor, workspace)?;
    *ground = A::feed_ground(&workspace.images, 0);
    *clusters = workspace.report.clusters.feed(0);
    pipeline.diffuse_candidates(workspace);
    *n = A::feed_n(&workspace.images, 0);
    for i in 0..workspace.report.clusters.len() {
        if workspace.report.clusters.get(i).is_none_or(|cluster| cluster.rejection.is_some()) {
            continue;
        }
        let Some(descriptor) = pipeline.describe(i, &floor, workspace) else { continue };
        *coefficients = A::feed_coefficients(&workspace.images, *coefficients);
        *descriptors = descriptor.feed(*descriptors);
        for h in A::nearest(templates, &descriptor)? {
            *hypotheses = [h.class, h.object, h.view].feed(*hypotheses);
            *hypotheses = h.score.feed(h.distance.feed(*hypotheses));
        }
    }
    Ok(sums)
}
