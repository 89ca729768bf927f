//! The memory of the pipeline in integers: what the stages need one after the other lies in the same place.
//!
//! | | during the filter | on the ground | for the views |
//! |---|---|---|---|
//! | `depth`, 2 bytes a pixel | depth | depth | depth |
//! | `shared`, 4 bytes a pixel | distances u8, u8; mask u16 | labels u8; counts u16, then marks u8 and map labels u8; density u16; contour points | labels u8; N u16; view, then coefficients i32 |
//! | `lines`, 32 bytes a column | the last row, then four lines at once | - | - |
//!
//! The floor's search has its points where the ground map comes to lie. Nothing here is unsafe: bytes are cut into arrays by
//! `zerocopy`, which checks sizes and alignments; the sizes are constants, so nothing is left of the checks.

use crate::Image;
use crate::floor::fixed::ransac;
use crate::ground::{ContourPoint, MAP_DEPTH, MAP_WIDTH, MAX_CONTOUR_POINTS, Map};
use crate::reconstruct::fixed::{Intake, Scratch, recursive::Lines};
use crate::wavelet::{SIZE, fixed::Plane};
use zerocopy::{FromBytes, FromZeros, Immutable, IntoBytes, KnownLayout};

/// What the shared memory holds at the moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromZeros)]
#[repr(u8)]
enum Content {
    /// Nothing of use.
    Nothing = 0,
    /// Labels, density and so many contour points.
    Ground(usize),
    /// Labels, N and a view or its coefficients.
    Views,
}

/// The images between the stages. Some lie in the same memory: what is there depends on the stage that ran last.
///
/// Zeroed memory is one of [`FixedImages::new`], so that memory of any origin can become one in place.
#[derive(Debug, Clone, FromZeros)]
#[allow(missing_copy_implementations, reason = "half a megabyte should not be copied by accident")]
pub struct FixedImages<const W: usize, const H: usize> {
    depth: Image<u16, W, H>,
    shared: Image<u32, W, H>,
    lines: Lines<W>,
    rows: usize,
    coloured: bool,
    content: Content,
}

/// The ground map, as [`FixedImages::ground`] gives it.
#[derive(Debug, Clone, Copy)]
pub struct Ground<'a> {
    /// The number of each cell's cluster, from 1; 0 = none.
    pub map_labels: &'a Map<u8>,
    /// Points per cell as if seen from 2 m, Q10, saturated.
    pub density: &'a Map<u16>,
    /// The points of all contours.
    pub points: &'a [ContourPoint],
}

/// N and the view, as [`FixedImages::views`] gives them.
#[derive(Debug, Clone, Copy)]
pub struct Views<'a, const W: usize, const H: usize> {
    /// N, 65535 = 1; 0 = none.
    pub n: &'a Image<u16, W, H>,
    /// The last candidate's view (N in 1/128 of its unit), or its wavelet coefficients once it has been described.
    pub plane: &'a Plane,
}

/// The depth, the pixels' labels, the counts and the density.
pub(super) type Counting<'a, const W: usize, const H: usize> =
    (&'a Image<u16, W, H>, &'a mut Image<u8, W, H>, &'a mut Map<u16>, &'a mut Map<u16>);

/// What the search for the ground's clusters works on.
pub(super) struct Clearing<'a, const W: usize, const H: usize> {
    pub(super) depth: &'a Image<u16, W, H>,
    pub(super) labels: &'a mut Image<u8, W, H>,
    pub(super) marks: &'a mut Map<u8>,
    pub(super) map_labels: &'a mut Map<u8>,
    pub(super) density: &'a mut Map<u16>,
    pub(super) points: &'a mut [ContourPoint],
    /// How many of them are in use.
    pub(super) used: &'a mut usize,
}

/// What N and the views are made in.
pub(super) struct Gallery<'a, const W: usize, const H: usize> {
    pub(super) depth: &'a Image<u16, W, H>,
    pub(super) labels: &'a mut Image<u8, W, H>,
    pub(super) n: &'a mut Image<u16, W, H>,
    pub(super) plane: &'a mut Plane,
}

impl<const W: usize, const H: usize> FixedImages<W, H> {
    /// Everything must fit, and the clusters' sums of coordinates must not overflow.
    const FITS: () = {
        let map = MAP_WIDTH * MAP_DEPTH;
        assert!(
            4 * W * H >= W * H + 4 * map + MAX_CONTOUR_POINTS * size_of::<ContourPoint>(),
            "the ground map is larger"
        );
        assert!(4 * W * H >= 3 * W * H + size_of::<Plane>(), "N and a view are larger");
        assert!(W * H <= 320 * 240 && (W * H).is_multiple_of(4) && H <= W, "larger than QVGA, or of an odd shape");
    };

    /// Empty images.
    pub const fn new() -> Self {
        const { Self::FITS };
        Self {
            depth: [[0; W]; H],
            shared: [[0; W]; H],
            lines: [[[0; 4]; 2]; W],
            rows: 0,
            coloured: false,
            content: Content::Nothing,
        }
    }

    /// The reconstructed depth in 1/8 mm, 0 = none. While a frame is coming in: the measured one.
    pub fn depth(&self) -> &Image<u16, W, H> {
        &self.depth
    }

    /// Rows of the frame that have come in.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The number of each pixel's cluster, from 1; 0 = none. `None` before the ground map's stage.
    pub fn labels(&self) -> Option<&Image<u8, W, H>> {
        if self.content == Content::Nothing {
            return None;
        }
        cut(self.shared.as_bytes()).map(|(labels, _)| labels)
    }

    /// The ground map; `None` before its stage, and once its memory is used for N.
    pub fn ground(&self) -> Option<Ground<'_>> {
        let Content::Ground(used) = self.content else { return None };
        let (_, rest) = cut::<Image<u8, W, H>>(self.shared.as_bytes())?;
        let (_, rest) = cut::<Map<u8>>(rest)?;
        let (map_labels, rest) = cut(rest)?;
        let (density, rest) = cut(rest)?;
        let (points, _) = <[ContourPoint]>::ref_from_prefix_with_elems(rest, used).ok()?;
        Some(Ground { map_labels, density, points })
    }

    /// N and the last view; `None` before N is computed.
    pub fn views(&self) -> Option<Views<'_, W, H>> {
        if self.content != Content::Views {
            return None;
        }
        let (_, rest) = cut::<Image<u8, W, H>>(self.shared.as_bytes())?;
        let (n, rest) = cut(rest)?;
        let (plane, _) = cut(rest)?;
        Some(Views { n, plane })
    }

    /// Puts a reconstructed depth in, in 1/8 mm: for simulations and comparisons.
    pub fn set_depth(&mut self, depth: impl FnMut(usize, usize) -> u16) {
        self.content = Content::Nothing;
        let mut depth = depth;
        for (v, row) in self.depth.iter_mut().enumerate() {
            row.iter_mut().enumerate().for_each(|(u, d)| *d = depth(u, v));
        }
    }

    /// Forgets the rows that have come in.
    pub(super) fn begin(&mut self) {
        (self.rows, self.coloured, self.content) = (0, false, Content::Nothing);
    }

    pub(super) fn intake(&mut self) -> Option<Intake<'_, W, H>> {
        self.content = Content::Nothing;
        let scratch = filter_scratch(&mut self.shared)?;
        Some(Intake {
            rows: &mut self.rows,
            coloured: &mut self.coloured,
            lines: &mut self.lines,
            scratch,
            depth: &mut self.depth,
        })
    }

    pub(super) fn filter(&mut self) -> Option<(&mut Image<u16, W, H>, Scratch<'_, W, H>, &mut Lines<W>)> {
        self.content = Content::Nothing;
        Some((&mut self.depth, filter_scratch(&mut self.shared)?, &mut self.lines))
    }

    /// The depth, and room for the points of the floor's search.
    pub(super) fn floor(&mut self) -> Option<(&Image<u16, W, H>, &mut [ransac::Points])> {
        self.content = Content::Nothing;
        let bytes = self.shared.as_mut_bytes();
        let (points, _) = <[ransac::Points]>::mut_from_prefix_with_elems(bytes, ransac::SCRATCH).ok()?;
        Some((&self.depth, points))
    }

    /// What the count of the points works on.
    pub(super) fn counts(&mut self) -> Option<Counting<'_, W, H>> {
        self.content = Content::Nothing;
        let (labels, rest) = cut_mut(self.shared.as_mut_bytes())?;
        let (counts, rest) = cut_mut(rest)?;
        let (density, _) = cut_mut(rest)?;
        Some((&self.depth, labels, counts, density))
    }

    /// What comes after the density: the counts are given up.
    pub(super) fn clearing(&mut self) -> Option<Clearing<'_, W, H>> {
        self.content = Content::Ground(0);
        let Content::Ground(used) = &mut self.content else { return None };
        let (labels, rest) = cut_mut(self.shared.as_mut_bytes())?;
        let (marks, rest) = cut_mut(rest)?;
        let (map_labels, rest) = cut_mut(rest)?;
        let (density, rest) = cut_mut(rest)?;
        let (points, _) = <[ContourPoint]>::mut_from_prefix_with_elems(rest, MAX_CONTOUR_POINTS).ok()?;
        Some(Clearing { depth: &self.depth, labels, marks, map_labels, density, points, used })
    }

    /// What comes after the ground map: all of it but the labels is given up. Without labels, no pixel has one.
    pub(super) fn gallery(&mut self) -> Option<Gallery<'_, W, H>> {
        let before = core::mem::replace(&mut self.content, Content::Views);
        let (labels, rest) = cut_mut::<Image<u8, W, H>>(self.shared.as_mut_bytes())?;
        if before == Content::Nothing {
            labels.as_flattened_mut().fill(0);
        }
        let (n, rest) = cut_mut(rest)?;
        let (plane, _) = cut_mut(rest)?;
        Some(Gallery { depth: &self.depth, labels, n, plane })
    }
}

impl<const W: usize, const H: usize> Default for FixedImages<W, H> {
    fn default() -> Self {
        Self::new()
    }
}

fn filter_scratch<const W: usize, const H: usize>(shared: &mut Image<u32, W, H>) -> Option<Scratch<'_, W, H>> {
    let (horizontal, rest) = cut_mut(shared.as_mut_bytes())?;
    let (vertical, rest) = cut_mut(rest)?;
    let (mask, _) = cut_mut(rest)?;
    Some(Scratch { horizontal, vertical, mask })
}

/// The first bytes as a `T`, and those behind.
fn cut<T: FromBytes + Immutable + KnownLayout>(bytes: &[u8]) -> Option<(&T, &[u8])> {
    T::ref_from_prefix(bytes).ok()
}

/// The first bytes as a `T` to write to, and those behind.
fn cut_mut<T: FromBytes + IntoBytes + KnownLayout>(bytes: &mut [u8]) -> Option<(&mut T, &mut [u8])> {
    T::mut_from_prefix(bytes).ok()
}

const _: () = assert!(size_of::<Plane>() == 4 * SIZE * SIZE);
