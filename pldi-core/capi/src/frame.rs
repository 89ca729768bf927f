//! A frame's way: as a whole, or row by row.

use crate::border;
use crate::pipeline::{State, pldi_pipeline, pldi_workspace};
use crate::status::Checked;
use crate::status::pldi_status::{self, *};
use crate::templates::pldi_templates;
use core::ffi::c_void;
use pldi_core::reconstruct::fixed::{Bayer, ColourRow, DepthRow};
use pldi_core::templates::Templates;
use pldi_core::{Error, Frame};

/// The most sensor rows that belong to a row of a frame: 2560 x 1920 pixels.
pub const PLDI_MAX_REDUCTION: usize = 8;

/// What the values of a row of depth are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum pldi_depth_format {
    /// Millimetres, 0 = no reading.
    PLDI_DEPTH_MM = 0,
    /// Raw disparity; pldi_params says what it means.
    PLDI_DEPTH_RAW = 1,
}

/// What the values of a row of colour are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum pldi_colour_format {
    /// 3 bytes a pixel: red, green, blue.
    PLDI_COLOUR_RGB888 = 0,
    /// A uint16_t a pixel: red in the upper five bits, green in the middle six, blue in the lower five.
    PLDI_COLOUR_RGB565 = 1,
    /// 4 bytes for two pixels: Y U Y V, BT.601 with limited range.
    PLDI_COLOUR_YUYV = 2,
    /// 1 byte a pixel of a mosaic: red green, green blue. An even number of rows.
    PLDI_COLOUR_BAYER_RGGB = 3,
    /// A mosaic: green red, blue green (Kinect v1).
    PLDI_COLOUR_BAYER_GRBG = 4,
    /// A mosaic: green blue, red green.
    PLDI_COLOUR_BAYER_GBRG = 5,
    /// A mosaic: blue green, green red.
    PLDI_COLOUR_BAYER_BGGR = 6,
}

/// The depth of a row of the frame: 320 values, or a whole multiple, of which each block's leftmost is taken. A sensor with k
/// times the frame's width gives every k-th of its rows.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct pldi_depth_row {
    /// One of pldi_depth_format.
    pub format: u32,
    /// The values.
    pub values: *const u16,
    /// How many.
    pub count: usize,
}

/// The colour of a row of the frame: k rows of k * 320 pixels, whose k x k blocks become a pixel each.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct pldi_colour_row {
    /// One of pldi_colour_format.
    pub format: u32,
    /// The first row; aligned to 2 bytes for RGB565.
    pub data: *const c_void,
    /// Bytes of a row's pixels.
    pub row_bytes: usize,
    /// Bytes from the beginning of a row to that of the next. Not looked at for a single row.
    pub stride: usize,
    /// Rows: k, 1 to PLDI_MAX_REDUCTION.
    pub rows: u32,
}

/// Takes a whole frame all the way. `depth` has 320 * 240 values in mm, 0 = no reading; `colour` as many pixels of 3 bytes, red, green, blue,
/// registered to the depth, or is NULL. `depth_count` and `colour_bytes` say how much there is.
///
/// A frame without depth, floor or objects is PLDI_OK: the results say so.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pldi_process_frame(
    pipeline: *const pldi_pipeline,
    workspace: *mut pldi_workspace,
    templates: *const pldi_templates,
    depth: *const u16,
    depth_count: usize,
    colour: *const u8,
    colour_bytes: usize,
) -> pldi_status {
    let process = || {
        separate(workspace, pipeline, templates)?;
        // SAFETY: what the header asks for.
        let pipeline = unsafe { pldi_pipeline::get(pipeline)? };
        border::apart(workspace, depth, depth_count)?;
        border::apart(workspace, colour, if colour.is_null() { 0 } else { colour_bytes })?;
        // SAFETY: what the header asks for; neither lies in the workspace.
        let (workspace, templates) = unsafe { (pldi_workspace::get_mut(workspace)?, pldi_templates::get(templates)?) };
        if depth.is_null() {
            return Err(PLDI_ERROR_NULL);
        }
        // SAFETY: what the header asks for.
        let depth = unsafe { border::slice(depth, depth_count)? };
        let colour = if colour.is_null() {
            None
        } else {
            // SAFETY: what the header asks for.
            Some(unsafe { border::slice(colour, colour_bytes)? })
        };
        let frame = Frame::new(depth, colour)?;
        require(pipeline, templates)?;
        workspace.set(State::EMPTY, 0);
        pipeline.inner().reconstruct(&frame, workspace.inner_mut());
        recognise(pipeline, workspace, templates)
    };
    process().into()
}

/// Begins a frame that comes in row by row; what came in of another one is forgotten, and so are its results.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pldi_begin_frame(
    pipeline: *const pldi_pipeline,
    workspace: *mut pldi_workspace,
) -> pldi_status {
    let begin = || {
        border::apart(workspace, pipeline, 1)?;
        // SAFETY: what the header asks for.
        let (pipeline, workspace) = unsafe { (pldi_pipeline::get(pipeline)?, pldi_workspace::get_mut(workspace)?) };
        pipeline.inner().begin(workspace.inner_mut());
        workspace.set(State::ROWS, 0);
        Ok(())
    };
    begin().into()
}

/// Takes in the next row: depth, and colour or NULL. When the call returns, the row's buffers are free. After an error the row
/// counts as not pushed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pldi_push_row(
    pipeline: *const pldi_pipeline,
    workspace: *mut pldi_workspace,
    depth: *const pldi_depth_row,
    colour: *const pldi_colour_row,
) -> pldi_status {
    let push = || {
        border::apart(workspace, pipeline, 1)?;
        // SAFETY: what the header asks for.
        let (pipeline, depth) = unsafe { (pldi_pipeline::get(pipeline)?, border::shared(depth)?) };
        border::apart(workspace, depth, 1)?;
        border::apart(workspace, depth.values, depth.count)?;
        let colour = if colour.is_null() {
            None
        } else {
            // SAFETY: what the header asks for.
            let colour = unsafe { border::shared(colour)? };
            border::apart(workspace, colour, 1)?;
            border::apart(workspace, colour.data.cast::<u8>(), colour.extent()?)?;
            Some(colour)
        };
        // SAFETY: what the header asks for; none of the buffers lies in the workspace.
        let workspace = unsafe { pldi_workspace::get_mut(workspace)? };
        workspace.expect(State::ROWS)?;
        if workspace.inner().images.rows() >= crate::PLDI_HEIGHT {
            return Err(PLDI_ERROR_ORDER);
        }
        // SAFETY: what the header asks for.
        let depth = unsafe { depth.row(pipeline)? };
        match colour {
            None => pipeline.inner().push(depth, None, workspace.inner_mut())?,
            // SAFETY: what the header asks for.
            Some(colour) => unsafe {
                colour.with(|colour| pipeline.inner().push(depth, Some(colour), workspace.inner_mut()))?;
            },
        }
        Ok(())
    };
    push().into()
}

/// Takes a frame whose 240 rows are in all the way: the same results as of pldi_process_frame.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pldi_finish_frame(
    pipeline: *const pldi_pipeline,
    workspace: *mut pldi_workspace,
    templates: *const pldi_templates,
) -> pldi_status {
    let finish = || {
        separate(workspace, pipeline, templates)?;
        // SAFETY: what the header asks for.
        let (pipeline, workspace, templates) = unsafe {
            (pldi_pipeline::get(pipeline)?, pldi_workspace::get_mut(workspace)?, pldi_templates::get(templates)?)
        };
        workspace.expect(State::ROWS)?;
        require(pipeline, templates)?;
        // All that it can complain of is a missing row.
        pipeline.inner().finish(workspace.inner_mut()).map_err(|_| PLDI_ERROR_ORDER)?;
        recognise(pipeline, workspace, templates)
    };
    finish().into()
}

/// The objects of a call have each their own memory.
fn separate(
    workspace: *const pldi_workspace,
    pipeline: *const pldi_pipeline,
    templates: *const pldi_templates,
) -> Checked<()> {
    border::apart(workspace, pipeline, 1)?;
    border::apart(workspace, templates, 1)
}

/// Checks that templates fit the parameters, before a frame is given up for them.
fn require(pipeline: &pldi_pipeline, templates: &Templates<'_>) -> Checked<()> {
    let view = pipeline.inner().params().view;
    Ok(templates.require(view.hash, pldi_core::templates::Encoding::Logarithmic)?)
}

/// From the reconstructed depth to the results.
fn recognise(pipeline: &pldi_pipeline, workspace: &mut pldi_workspace, templates: &Templates<'_>) -> Checked<()> {
    let result = pipeline.inner().recognise(templates, workspace.inner_mut());
    match result {
        // What was found before there was no more room may be looked at.
        Ok(()) | Err(Error::Capacity(_)) => workspace.set(State::DONE, templates.checksum()),
        Err(_) => workspace.set(State::EMPTY, 0),
    }
    Ok(result?)
}

impl pldi_depth_row {
    /// The row as the core takes it.
    ///
    /// # Safety
    /// As [`border::slice`].
    unsafe fn row<'a>(&self, pipeline: &pldi_pipeline) -> Checked<DepthRow<'a>> {
        const MM: u32 = pldi_depth_format::PLDI_DEPTH_MM as u32;
        const RAW: u32 = pldi_depth_format::PLDI_DEPTH_RAW as u32;
        // SAFETY: the caller's promise.
        let values = unsafe { border::slice(self.values, self.count)? };
        match self.format {
            MM => Ok(DepthRow::Millimetres(values)),
            RAW => Ok(DepthRow::Raw(values, pipeline.disparity())),
            _ => Err(PLDI_ERROR_FORMAT),
        }
    }
}

/// What is left of a format once the width of its values is known.
#[derive(Clone, Copy)]
enum Bytes {
    Rgb888,
    Yuyv,
    Bayer(Bayer),
}

impl pldi_colour_row {
    /// Bytes from the first row's first to the last row's last.
    fn extent(&self) -> Checked<usize> {
        let rows = self.count()?;
        let before = (rows - 1).checked_mul(self.stride);
        before.and_then(|before| before.checked_add(self.row_bytes)).ok_or(PLDI_ERROR_LENGTH)
    }

    fn count(&self) -> Checked<usize> {
        usize::try_from(self.rows).ok().filter(|rows| (1..=PLDI_MAX_REDUCTION).contains(rows)).ok_or(PLDI_ERROR_LENGTH)
    }

    /// Hands the rows to `take`, as the core takes them.
    ///
    /// # Safety
    /// As [`border::slice`], for each of the rows.
    unsafe fn with(&self, take: impl FnOnce(ColourRow<'_>) -> Result<(), Error>) -> Checked<()> {
        use pldi_colour_format::*;
        const FORMATS: [(u32, Bytes); 6] = [
            (PLDI_COLOUR_RGB888 as u32, Bytes::Rgb888),
            (PLDI_COLOUR_YUYV as u32, Bytes::Yuyv),
            (PLDI_COLOUR_BAYER_RGGB as u32, Bytes::Bayer(Bayer::Rggb)),
            (PLDI_COLOUR_BAYER_GRBG as u32, Bytes::Bayer(Bayer::Grbg)),
            (PLDI_COLOUR_BAYER_GBRG as u32, Bytes::Bayer(Bayer::Gbrg)),
            (PLDI_COLOUR_BAYER_BGGR as u32, Bytes::Bayer(Bayer::Bggr)),
        ];
        let count = self.count()?;
        if self.format == PLDI_COLOUR_RGB565 as u32 {
            if !self.row_bytes.is_multiple_of(2) {
                return Err(PLDI_ERROR_LENGTH);
            }
            // SAFETY: the caller's promise.
            let rows = unsafe { self.rows::<u16>()? };
            return Ok(take(ColourRow::Rgb565(rows.get(..count).unwrap_or(&[])))?);
        }
        let bytes = FORMATS.iter().find(|(number, _)| *number == self.format).ok_or(PLDI_ERROR_FORMAT)?.1;
        // SAFETY: the caller's promise.
        let rows = unsafe { self.rows::<u8>()? };
        let rows = rows.get(..count).unwrap_or(&[]);
        Ok(take(match bytes {
            Bytes::Rgb888 => ColourRow::Rgb888(rows),
            Bytes::Yuyv => ColourRow::Yuyv(rows),
            Bytes::Bayer(pattern) => ColourRow::Bayer(rows, pattern),
        })?)
    }

    /// The rows, those that there are not empty.
    ///
    /// # Safety
    /// As [`border::slice`], for each of the rows.
    unsafe fn rows<'a, T>(&self) -> Checked<[&'a [T]; PLDI_MAX_REDUCTION]> {
        let mut rows: [&[T]; PLDI_MAX_REDUCTION] = [&[]; PLDI_MAX_REDUCTION];
        // Not beyond the end of memory, whatever the stride says.
        self.extent()?;
        for (i, row) in rows.iter_mut().take(self.count()?).enumerate() {
            let start = self.data.wrapping_byte_add(i.wrapping_mul(self.stride));
            if self.data.is_null() {
                return Err(PLDI_ERROR_NULL);
            }
            // SAFETY: the caller's promise.
            *row = unsafe { border::slice(start.cast::<T>(), self.row_bytes / size_of::<T>())? };
        }
        Ok(rows)
    }
}
