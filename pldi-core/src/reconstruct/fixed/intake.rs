//! The streaming front end: rows of colour and depth as the sensor gives them, turned at once into the stored depth and the
//! distances between neighbours. A row is not needed any more once the next one has been pushed.

#[cfg(target_arch = "x86_64")]
use super::arrays as form;
#[cfg(not(target_arch = "x86_64"))]
use super::packed as form;
use super::recursive::Lines;
use super::{DistanceTable, Scratch};
use crate::{DepthRange, Error, Frame, Image};

/// The depth of one row of the frame.
///
/// A sensor with `k` times the frame's width gives the topmost row of the block of `k` rows; each block's leftmost value
/// is taken (a mean would mix surfaces).
#[derive(Debug, Clone, Copy)]
pub enum DepthRow<'a> {
    /// Depth in mm, 0 = no reading.
    Millimetres(&'a [u16]),
    /// Raw disparity of a structured-light sensor (Kinect v1: 11 bits), and what it means.
    Raw(&'a [u16], Disparity),
}

/// How raw disparity becomes depth: z = `scale` / (`offset` - disparity), the pinhole relation with the reference plane's
/// disparity in `offset` (Khoshelham and Elberink 2012, equation 7).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Disparity {
    /// Focal length (px) times baseline (mm) times disparity steps per pixel.
    pub scale: u32,
    /// Disparity of a point at infinity, in steps.
    pub offset: u16,
    /// From this disparity on there is no reading.
    pub none: u16,
}

impl Disparity {
    /// The Kinect v1: f = 580 px, baseline 75 mm, steps of 1/8 px, offset 1090, 2047 = no reading (the nominal values of
    /// the ROS driver's technical description).
    pub const KINECT: Self = Self { scale: 580 * 75 * 8, offset: 1090, none: 2047 };

    /// The depth in mm, rounded to nearest; 0 where there is no reading or the depth does not fit 16 bits.
    #[inline(always)]
    pub fn millimetres(self, disparity: u16) -> u16 {
        if disparity >= self.none || disparity >= self.offset {
            return 0;
        }
        let steps = u32::from(self.offset - disparity);
        u16::try_from(self.scale.saturating_add(steps / 2) / steps).unwrap_or(0)
    }
}

/// Where the red, green and blue pixels of a sensor's mosaic are: the two pixels of the first row, then of the second.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Bayer {
    /// Red green, green blue.
    Rggb,
    /// Green red, blue green: the Kinect v1.
    Grbg,
    /// Green blue, red green.
    Gbrg,
    /// Blue green, green red.
    Bggr,
}

impl Bayer {
    /// The channel (0 red, 1 green, 2 blue) of the pixel in an even or odd row and column.
    #[inline(always)]
    fn channel(self, row: usize, column: usize) -> usize {
        let (first, second) = match self {
            Self::Rggb => ([0, 1], [1, 2]),
            Self::Grbg => ([1, 0], [2, 1]),
            Self::Gbrg => ([1, 2], [0, 1]),
            Self::Bggr => ([2, 1], [1, 0]),
        };
        (if row.is_multiple_of(2) { first } else { second })[column % 2]
    }
}

/// The colour of one row of the frame: the sensor's rows that belong to it, `k` rows of `k` times the frame's width. Each
/// block of `k` x `k` pixels becomes one pixel, its channels' means rounded (halves upwards).
#[derive(Debug, Clone, Copy)]
pub enum ColourRow<'a> {
    /// Three bytes for each pixel: red, green, blue.
    Rgb888(&'a [&'a [u8]]),
    /// 16 bits for each pixel: red in the upper five, green in the middle six, blue in the lower five.
    Rgb565(&'a [&'a [u16]]),
    /// Four bytes for each two pixels: Y U Y V, BT.601 with limited range (as UVC cameras give it).
    Yuyv(&'a [&'a [u8]]),
    /// One byte for each pixel of a mosaic; `k` must be even.
    Bayer(&'a [&'a [u8]], Bayer),
}

impl ColourRow<'_> {
    /// Rows, the length of the first one that has not the length that `k` rows of the frame's width ask for, and that length.
    pub(super) fn check(&self, width: usize) -> Result<usize, Error> {
        fn lengths<T>(rows: &[&[T]], width: usize, values: usize) -> Result<usize, Error> {
            let expected = rows.len() * width * values;
            match rows.iter().find(|row| row.len() != expected || row.is_empty()) {
                None if !rows.is_empty() => Ok(rows.len()),
                wrong => {
                    Err(Error::PixelCount { image: "colour row", expected, found: wrong.map_or(0, |row| row.len()) })
                }
            }
        }
        match self {
            Self::Rgb888(rows) => lengths(rows, width, 3),
            Self::Rgb565(rows) => lengths(rows, width, 1),
            Self::Yuyv(rows) if (rows.len() * width).is_multiple_of(2) => lengths(rows, width, 2),
            Self::Bayer(rows, _) if rows.len().is_multiple_of(2) => lengths(rows, width, 1),
            Self::Yuyv(_) => Err(Error::OutOfRange("width of YUYV rows (must be even)")),
            Self::Bayer(..) => Err(Error::OutOfRange("number of Bayer rows (must be even)")),
        }
    }

    /// The row at the frame's width, from `k` rows of `k` times that.
    pub(super) fn decode<const W: usize>(&self, k: usize, out: &mut [[u8; 3]; W]) {
        if let Self::Rgb888([row]) = self {
            // The usual case: nothing to reduce.
            let out = out.as_flattened_mut();
            if out.len() == row.len() {
                out.copy_from_slice(row);
            }
            return;
        }
        for (x, out) in out.iter_mut().enumerate() {
            let (mut sum, mut count) = ([0u32; 3], [0u32; 3]);
            let mut add = |pixel: [u8; 3]| {
                for c in 0..3 {
                    sum[c] += u32::from(pixel[c]);
                    count[c] += 1;
                }
            };
            let columns = x * k..(x + 1) * k;
            match self {
                Self::Rgb888(rows) => {
                    for row in *rows {
                        row.as_chunks::<3>().0.get(columns.clone()).into_iter().flatten().for_each(|p| add(*p));
                    }
                }
                Self::Rgb565(rows) => {
                    for row in *rows {
                        row.get(columns.clone()).into_iter().flatten().for_each(|p| add(rgb_of_565(*p)));
                    }
                }
                Self::Yuyv(rows) => {
                    for row in *rows {
                        for column in columns.clone() {
                            let quad = row.as_chunks::<4>().0.get(column / 2).copied().unwrap_or_default();
                            add(rgb_of_yuv(quad[2 * (column % 2)], quad[1], quad[3]));
                        }
                    }
                }
                Self::Bayer(rows, pattern) => {
                    for (y, row) in rows.iter().enumerate() {
                        for (column, value) in columns.clone().zip(row.get(columns.clone()).into_iter().flatten()) {
                            let c = pattern.channel(y, column);
                            if let (Some(sum), Some(count)) = (sum.get_mut(c), count.get_mut(c)) {
                                *sum += u32::from(*value);
                                *count += 1;
                            }
                        }
                    }
                }
            }
            *out = core::array::from_fn(|c| ((sum[c] + count[c] / 2) / count[c].max(1)) as u8);
        }
    }
}

/// Red, green and blue with their upper bits repeated below, so that full scale becomes 255.
#[inline(always)]
pub(super) fn rgb_of_565(pixel: u16) -> [u8; 3] {
    let (r, g, b) = (pixel >> 11, pixel >> 5 & 63, pixel & 31);
    [(r << 3 | r >> 2) as u8, (g << 2 | g >> 4) as u8, (b << 3 | b >> 2) as u8]
}

/// BT.601 with limited range, in 1/256.
#[inline(always)]
pub(super) fn rgb_of_yuv(y: u8, u: u8, v: u8) -> [u8; 3] {
    let (y, u, v) = (298 * (i32::from(y) - 16), i32::from(u) - 128, i32::from(v) - 128);
    [y + 409 * v, y - 100 * u - 208 * v, y + 516 * u].map(|c| ((c + 128) >> 8).clamp(0, 255) as u8)
}

/// How far a frame has come in, and the rows that the next one is compared with.
#[derive(Debug)]
pub struct Intake<'a, const W: usize, const H: usize> {
    /// Rows pushed so far.
    pub rows: &'a mut usize,
    /// Whether the last row had colour.
    pub coloured: &'a mut bool,
    /// What is kept of the last row, and room for one that must be converted: left alone between rows.
    pub lines: &'a mut Lines<W>,
    /// Where the distances go.
    pub scratch: Scratch<'a, W, H>,
    /// Where the depth goes, in 1/8 mm.
    pub depth: &'a mut Image<u16, W, H>,
}

/// Where a row goes.
#[derive(Debug)]
pub(super) struct Output<'a, const W: usize> {
    /// Depth in 1/8 mm.
    pub depth: &'a mut [u16; W],
    /// Distances from the left neighbours.
    pub horizontal: &'a mut [u8; W],
    /// Distances from the upper neighbours.
    pub vertical: &'a mut [u8; W],
}

impl<const W: usize, const H: usize> Intake<'_, W, H> {
    /// Takes in the next row. A row without colour is compared by its depth alone.
    ///
    /// # Errors
    /// `PixelCount` for a row of another length than a multiple of the frame's (for colour: that multiple of rows),
    /// `OutOfRange` for a row beyond the last one. Then the row counts as not pushed.
    pub fn push(
        &mut self,
        range: DepthRange,
        table: &DistanceTable,
        depth: DepthRow<'_>,
        colour: Option<ColourRow<'_>>,
    ) -> Result<(), Error> {
        let v = *self.rows;
        let (Some(stored), Some(horizontal), Some(vertical)) =
            (self.depth.get_mut(v), self.scratch.horizontal.get_mut(v), self.scratch.vertical.get_mut(v))
        else {
            return Err(Error::OutOfRange("row of the frame (the frame is complete)"));
        };
        let out = Output { depth: stored, horizontal, vertical };
        let colour = match colour {
            Some(colour) => Some((colour, colour.check(W)?)),
            None => None,
        };
        form::row((range, table), depth, colour, (v, *self.coloured), self.lines, out)?;
        *self.coloured = colour.is_some();
        *self.rows += 1;
        Ok(())
    }

    /// Takes in a whole frame: the same as its rows one after the other.
    pub fn push_frame(&mut self, range: DepthRange, table: &DistanceTable, frame: &Frame<'_, W, H>) {
        *self.rows = 0;
        for (v, depth) in frame.depth.iter().enumerate() {
            let colour = frame.colour.and_then(|colour| colour.get(v)).map(|row| row.as_flattened());
            let rows = [colour.unwrap_or(&[])];
            let colour = colour.is_some().then_some(ColourRow::Rgb888(&rows));
            // The lengths are those of the frame's types.
            let _ = self.push(range, table, DepthRow::Millimetres(depth), colour);
        }
    }
}

/// The row's depths in mm at the frame's width, 0 where there is no reading; not tested against a range.
///
/// # Errors
/// `PixelCount` for a row of another length than a multiple of the frame's.
pub(super) fn decode_depth<const W: usize>(row: DepthRow<'_>, out: &mut [u16; W]) -> Result<(), Error> {
    let (DepthRow::Millimetres(values) | DepthRow::Raw(values, _)) = row;
    if W == 0 || values.is_empty() || !values.len().is_multiple_of(W) {
        return Err(Error::PixelCount { image: "depth row", expected: W, found: values.len() });
    }
    for (to, value) in out.iter_mut().zip(values.iter().step_by((values.len() / W).max(1))) {
        *to = match row {
            DepthRow::Millimetres(_) => *value,
            DepthRow::Raw(_, model) => model.millimetres(*value),
        };
    }
    Ok(())
}
