//! The distances of a row with the colours packed into words: the form for machines without instructions for several
//! numbers at once.
//!
//! One pass over the row does all: it reads depth and colour as they come, compares them with the row above and with the
//! left pixel, which is still in registers, and leaves the pixel in the place of the one above.

use super::DistanceTable;
use super::intake::{ColourRow, DepthRow, Output, decode_depth, rgb_of_565, rgb_of_yuv};
use super::recursive::Lines;
use crate::{DepthRange, Error};
use core::hint::{black_box, cold_path};
use zerocopy::{FromBytes, IntoBytes};

/// Depth in mm or [`NONE`], and colour in three fields of eleven bits.
type Cell = [u32; 2];

/// A pixel and the one above.
type Pair = [Cell; 2];

/// In place of a depth where there is no reading: the difference of two such is 0, that to a reading is above 2^16.
const NONE: u32 = 1 << 20;

/// The lowest bit of each field.
const ONES: u32 = 1 << 22 | 1 << 11 | 1;

/// Below this, 765 levels and the largest step of depth are below 2^31: 40 * 765 + 302 codes in Q16.
const SMALL: u32 = 40 << 16;

/// Three channels in a word.
#[inline(always)]
fn pack([r, g, b]: [u8; 3]) -> u32 {
    u32::from(r) | u32::from(g) << 11 | u32::from(b) << 22
}

/// What a loop over pixels holds in registers.
struct Scale {
    /// [`ONES`].
    ones: u32,
    /// Codes per level of colour, Q16.
    per_level: u32,
    /// Codes per mm, Q16.
    per_mm: u32,
    /// What is added to the codes, Q16: a half, and in place of the colours' what [`Scale::contrast`] has too much.
    base: u32,
    /// Depth differences beyond this many mm are beyond all codes.
    max_step: u32,
}

impl Scale {
    fn new(table: &DistanceTable) -> Self {
        Self {
            // Else the compiler makes a second constant of it, for which there is no register.
            ones: black_box(ONES),
            per_level: table.per_level,
            per_mm: table.per_mm,
            base: (1u32 << 15).wrapping_sub(768 * table.per_level),
            max_step: u32::from(table.max_step),
        }
    }

    /// The sum of the channels' differences of two packed colours, and 768: at most 1533.
    #[inline(always)]
    fn contrast(&self, p: u32, q: u32) -> u32 {
        // 256 + p - q in each field: none borrows from the next one, and bit 8 tells the sign.
        let difference = (p | self.ones << 8).wrapping_sub(q);
        let negative = self.ones & !(difference >> 8);
        // Where it is negative, 512 less that: 256 and the size in each field.
        let sizes = (difference ^ (negative << 9).wrapping_sub(negative)).wrapping_add(negative);
        // The uppermost field has ten bits, and no sum reaches beyond eleven.
        sizes.wrapping_add(sizes >> 11).wrapping_add(sizes >> 22) & 0x7FF
    }

    /// The code between two pixels. `SIGNED`: the distance is below 2^31.
    #[inline(always)]
    fn code<const COLOUR: bool, const SIGNED: bool>(&self, p: Cell, q: Cell) -> u8 {
        let mut step = p[0].abs_diff(q[0]);
        if step > self.max_step {
            cold_path();
            if step < 1 << 16 {
                return 255;
            }
            step = 0;
        }
        let distance = if COLOUR {
            // 46 * 1533 codes in Q16 may be beyond 2^32 until the base has been added.
            self.per_level.wrapping_mul(self.contrast(p[1], q[1])).wrapping_add(self.base)
        } else {
            1 << 15
        };
        let distance = distance.wrapping_add(self.per_mm * step);
        // The first form is one instruction of some machines.
        if SIGNED { (distance as i32 >> 16).clamp(0, 255) as u8 } else { (distance >> 16).min(255) as u8 }
    }
}

/// A row's colours as the sensor gives them, at the frame's width.
trait Colours {
    /// The pixel's colour, packed.
    fn at(&self, x: usize) -> u32;
}

/// Red, green, blue.
struct Rgb888<'a, const W: usize>(&'a [[u8; 3]; W]);

/// Five, six and five bits.
struct Rgb565<'a, const W: usize>(&'a [u16; W]);

/// Luminance, and one of the two colour differences in turn.
struct Yuyv<'a, const W: usize>(&'a [[u8; 2]; W]);

/// No colours.
struct Nothing;

impl<const W: usize> Colours for Rgb888<'_, W> {
    #[inline(always)]
    fn at(&self, x: usize) -> u32 {
        pack(self.0[x])
    }
}

impl<const W: usize> Colours for Rgb565<'_, W> {
    #[inline(always)]
    fn at(&self, x: usize) -> u32 {
        pack(rgb_of_565(self.0[x]))
    }
}

impl<const W: usize> Colours for Yuyv<'_, W> {
    #[inline(always)]
    fn at(&self, x: usize) -> u32 {
        let [y, _] = self.0[x];
        let [_, u] = self.0.get(x & !1).copied().unwrap_or_default();
        // The width is even.
        let [_, v] = self.0.get(x | 1).copied().unwrap_or_default();
        pack(rgb_of_yuv(y, u, v))
    }
}

impl Colours for Nothing {
    #[inline(always)]
    fn at(&self, _: usize) -> u32 {
        0
    }
}

/// Takes in row `v`: depth into `out.depth` (1/8 mm), distances into the others. The topmost row's distances from above mean
/// nothing. `coloured` says whether the row above had colour.
///
/// # Errors
/// `PixelCount` for a depth row of another length than a multiple of the frame's; then nothing has changed. The colour row
/// has been checked: it has `k` times the frame's width.
pub fn row<const W: usize>(
    (range, table): (DepthRange, &DistanceTable),
    depth: DepthRow<'_>,
    colour: Option<(ColourRow<'_>, usize)>,
    (v, coloured): (usize, bool),
    lines: &mut Lines<W>,
    out: Output<'_, W>,
) -> Result<(), Error> {
    // 16, 2 and 3 bytes of the 32 for each.
    let Ok((pairs, rest)) = <[Pair; W]>::mut_from_prefix(lines.as_mut_bytes()) else { return Ok(()) };
    let Ok((depths, rest)) = <[u16; W]>::mut_from_prefix(rest) else { return Ok(()) };
    let Ok((decoded, _)) = <[[u8; 3]; W]>::mut_from_prefix(rest) else { return Ok(()) };
    let depth: &[u16; W] = match depth {
        DepthRow::Millimetres(values) if let Ok(values) = values.try_into() => values,
        _ => {
            decode_depth(depth, depths)?;
            &*depths
        }
    };
    match colour {
        None => decode(range, depth, Nothing, pairs, out.depth),
        Some((ColourRow::Rgb888([row]), _)) if let Ok(row) = row.as_chunks().0.try_into() => {
            decode(range, depth, Rgb888::<W>(row), pairs, out.depth);
        }
        Some((ColourRow::Rgb565([row]), _)) if let Ok(row) = (*row).try_into() => {
            decode(range, depth, Rgb565::<W>(row), pairs, out.depth);
        }
        Some((ColourRow::Yuyv([row]), _)) if let Ok(row) = row.as_chunks().0.try_into() => {
            decode(range, depth, Yuyv::<W>(row), pairs, out.depth);
        }
        Some((row, k)) => {
            row.decode(k, decoded);
            decode(range, depth, Rgb888::<W>(decoded), pairs, out.depth);
        }
    }
    if v == 0 {
        pairs.iter_mut().for_each(|[here, above]| *above = *here);
    }
    let colour = colour.is_some() && table.per_level > 0;
    let small = table.per_level < SMALL;
    let scale = &Scale::new(table);
    match (colour, small) {
        (false, _) => from_left::<false, true, W>(scale, pairs, out.horizontal),
        (true, true) => from_left::<true, true, W>(scale, pairs, out.horizontal),
        (true, false) => from_left::<true, false, W>(scale, pairs, out.horizontal),
    }
    match (colour && coloured, small) {
        (false, _) => from_above::<false, true, W>(scale, pairs, out.vertical),
        (true, true) => from_above::<true, true, W>(scale, pairs, out.vertical),
        (true, false) => from_above::<true, false, W>(scale, pairs, out.vertical),
    }
    Ok(())
}

/// A row's pixels, and their depths in 1/8 mm, saturated. This and the next ones are functions of their own, so that each
/// has the registers for itself.
#[inline(never)]
fn decode<C: Colours, const W: usize>(
    range: DepthRange,
    depth: &[u16; W],
    colours: C,
    pairs: &mut [Pair; W],
    eighths: &mut [u16; W],
) {
    let (min, max) = (u32::from(range.min), u32::from(range.max));
    // Most depths are in range, and fit 16 bits in 1/8 mm: one comparison.
    let usual = (max.min(8191) + 1).saturating_sub(min);
    for x in 0..W {
        let mut mm = u32::from(depth[x]);
        let mut stored = mm << 3;
        if mm.wrapping_sub(min) >= usual {
            cold_path();
            (mm, stored) = if mm < min || mm > max { (NONE, 0) } else { (mm, 65_535) };
        }
        eighths[x] = stored as u16;
        pairs[x][0] = [mm, colours.at(x)];
    }
}

/// The codes between pixels and their left neighbours; the first one's is 0.
#[inline(never)]
fn from_left<const COLOUR: bool, const SIGNED: bool, const W: usize>(
    scale: &Scale,
    pairs: &[Pair; W],
    codes: &mut [u8; W],
) {
    for x in 1..W {
        codes[x] = scale.code::<COLOUR, SIGNED>(pairs[x][0], pairs[x - 1][0]);
    }
    if let Some(first) = codes.first_mut() {
        *first = 0;
    }
}

/// The codes between pixels and those above, which they replace.
#[inline(never)]
fn from_above<const COLOUR: bool, const SIGNED: bool, const W: usize>(
    scale: &Scale,
    pairs: &mut [Pair; W],
    codes: &mut [u8; W],
) {
    for x in 0..W {
        let [here, above] = pairs[x];
        codes[x] = scale.code::<COLOUR, SIGNED>(here, above);
        pairs[x][1] = here;
    }
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::super::FilterParams;
    use super::super::intake::Bayer;
    use super::*;
    use crate::reconstruct::{self, FilterKind};
    use proptest::prelude::*;

    const W: usize = 22;

    #[test]
    fn the_contrast_is_the_sum_of_the_differences() {
        let scale = Scale::new(&DistanceTable::new(&FilterParams::new(&reconstruct::FilterParams::DEFAULT).unwrap()));
        let levels = [0u8, 1, 2, 127, 128, 129, 254, 255];
        for i in 0..8usize.pow(6) {
            let level = |c: u32| levels[i / 8usize.pow(c) % 8];
            let (p, q) = ([level(0), level(1), level(2)], [level(3), level(4), level(5)]);
            let sum = p.iter().zip(q).map(|(p, q)| u32::from(p.abs_diff(q))).sum::<u32>();
            assert_eq!(scale.contrast(pack(p), pack(q)), 768 + sum, "{p:?} {q:?}");
        }
    }

    /// Rows of a frame: each with a format or none, in bytes that are its colours or words.
    fn rows() -> impl Strategy<Value = Vec<(u8, Vec<u16>, Vec<u8>)>> {
        let depth = prop_oneof![6 => 1000u16..1100, 2 => any::<u16>(), 1 => Just(0u16), 1 => 8180u16..8200];
        let near = prop_oneof![3 => 100u8..110, 1 => any::<u8>()];
        let row = (0u8..8, proptest::collection::vec(depth, 2 * W), proptest::collection::vec(near, 6 * W));
        proptest::collection::vec(row, 1..8)
    }

    proptest! {
        #[test]
        fn one_pixel_after_the_other_is_as_arrays(
            rows in rows(),
            joint in any::<bool>(),
            (colour, mm) in prop_oneof![Just((30.0f32, 0.04f32)), (1.0f32..2.0, 0.001f32..0.25), (1.0f32..1000.0, 0.001f32..0.25)],
            range in prop_oneof![
                Just(DepthRange::KINECT),
                (any::<u16>(), any::<u16>()).prop_map(|(min, max)| DepthRange { min: min.max(1), max }),
                (500u16..1050, 1050u16..9000).prop_map(|(min, max)| DepthRange { min, max }),
            ],
        ) {
            let kind = if joint { FilterKind::Joint } else { FilterKind::Bilateral };
            let float = reconstruct::FilterParams { kind, sigma_colour: colour, sigma_depth: mm, ..reconstruct::FilterParams::DEFAULT };
            let table = DistanceTable::new(&FilterParams::new(&float).unwrap());
            let mut lines = [[[[-1; 4]; 2]; W]; 2];
            let mut coloured = false;
            for (v, (format, depth, bytes)) in rows.iter().enumerate() {
                let words: Vec<u16> = bytes.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect();
                let (rgb, yuyv, rgb565) = ([&bytes[..3 * W]], [&bytes[..2 * W]], [&words[..W]]);
                let (twice, bayer) = ([&words[..2 * W], &words[W..]], [&bytes[..2 * W], &bytes[2 * W..4 * W]]);
                let colour = match format {
                    0 => None,
                    1 => Some((ColourRow::Rgb565(&rgb565), 1)),
                    2 => Some((ColourRow::Yuyv(&yuyv), 1)),
                    3 => Some((ColourRow::Rgb565(&twice), 2)),
                    4 => Some((ColourRow::Bayer(&bayer, Bayer::Grbg), 2)),
                    _ => Some((ColourRow::Rgb888(&rgb), 1)),
                };
                let depth = match v % 3 {
                    2 => DepthRow::Millimetres(depth),
                    _ => DepthRow::Millimetres(&depth[..W]),
                };
                let mut depths = [[7; W]; 2];
                let mut codes = [[[7; W]; 2]; 2];
                let forms = [row::<W>, super::super::arrays::row::<W>];
                for (((form, lines), eighths), codes) in forms.iter().zip(&mut lines).zip(&mut depths).zip(&mut codes) {
                    let [horizontal, vertical] = codes;
                    let out = Output { depth: eighths, horizontal, vertical };
                    form((range, &table), depth, colour, (v, coloured), lines, out).unwrap();
                    if v == 0 {
                        *vertical = [0; W];
                    }
                }
                prop_assert_eq!(depths[0], depths[1]);
                prop_assert_eq!(codes[0], codes[1]);
                coloured = colour.is_some();
            }
        }
    }
}
