//! The two objects of a pipeline: what is computed once, and the memory of a frame.

use crate::border;
use crate::checked;
use crate::params::{self, pldi_params};
use crate::status::Checked;
use crate::status::pldi_status::{self, *};
use core::ffi::c_void;
use core::fmt;
use pldi_core::pipeline::{FixedImages, QvgaFixedPipeline, QvgaFixedWorkspace, Report};
use pldi_core::reconstruct::fixed::Disparity;
use zerocopy::FromZeros;

/// Bytes of a pldi_pipeline on every target. What the tables do not need is kept for later versions.
pub const PLDI_PIPELINE_SIZE: usize = 5120;

/// Alignment of a pldi_pipeline.
pub const PLDI_PIPELINE_ALIGN: usize = 8;

/// Bytes of a pldi_workspace on every target: 480 KiB. What the images do not need is kept for later versions.
pub const PLDI_WORKSPACE_SIZE: usize = 491_520;

/// Alignment of a pldi_workspace.
pub const PLDI_WORKSPACE_ALIGN: usize = 8;

/// What is computed once for a camera and a set of parameters. Only pldi_pipeline_init writes to it: afterwards any number of
/// workspaces, on any number of cores, may use it. It holds no pointers.
pub struct pldi_pipeline(Pipeline);

/// The memory of a frame on its way, and its results. It holds no pointers.
pub struct pldi_workspace(Workspace);

#[repr(C, align(8))]
struct Pipeline {
    magic: u32,
    disparity: Disparity,
    inner: QvgaFixedPipeline,
}

#[repr(C, align(8))]
struct Workspace {
    magic: u32,
    state: State,
    /// The checksum of the templates that the results were made with.
    templates: u32,
    inner: QvgaFixedWorkspace,
}

/// How far a frame is. A number: C may write anything there.
#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(transparent)]
pub(crate) struct State(u32);

impl State {
    /// Neither rows nor results.
    pub(crate) const EMPTY: Self = Self(0);
    /// Rows come in.
    pub(crate) const ROWS: Self = Self(1);
    /// There are results.
    pub(crate) const DONE: Self = Self(2);
}

/// The first word of an initialised object: another one for each version, whose insides may differ.
const fn magic(name: [u8; 4]) -> u32 {
    u32::from_le_bytes(name) ^ crate::VERSION.rotate_left(7)
}

const PIPELINE: u32 = magic(*b"pldP");
const WORKSPACE: u32 = magic(*b"pldW");

// The sizes that C sees are true, on this target and on any other for which this is compiled.
const _: () = {
    assert!(size_of::<pldi_pipeline>() <= PLDI_PIPELINE_SIZE, "the tables have grown: PLDI_PIPELINE_SIZE");
    assert!(align_of::<pldi_pipeline>() == PLDI_PIPELINE_ALIGN);
    assert!(size_of::<pldi_workspace>() <= PLDI_WORKSPACE_SIZE, "the images have grown: PLDI_WORKSPACE_SIZE");
    assert!(align_of::<pldi_workspace>() == PLDI_WORKSPACE_ALIGN);
};

/// The pipeline of the default parameters, made by the compiler.
static DEFAULT: pldi_pipeline = match params_of_defaults() {
    Ok(pipeline) => pldi_pipeline(Pipeline { magic: PIPELINE, disparity: Disparity::KINECT, inner: pipeline }),
    Err(_) => panic!("the defaults are in range"),
};

const fn params_of_defaults() -> Result<QvgaFixedPipeline, pldi_core::Error> {
    QvgaFixedPipeline::constant(&params::CORE, &params::CAMERA)
}

/// Bytes that a pipeline takes: PLDI_PIPELINE_SIZE.
#[unsafe(no_mangle)]
pub extern "C" fn pldi_pipeline_size() -> usize {
    PLDI_PIPELINE_SIZE
}

/// The alignment of a pipeline: PLDI_PIPELINE_ALIGN.
#[unsafe(no_mangle)]
pub extern "C" fn pldi_pipeline_align() -> usize {
    PLDI_PIPELINE_ALIGN
}

/// Bytes that a workspace takes: PLDI_WORKSPACE_SIZE.
#[unsafe(no_mangle)]
pub extern "C" fn pldi_workspace_size() -> usize {
    PLDI_WORKSPACE_SIZE
}

/// The alignment of a workspace: PLDI_WORKSPACE_ALIGN.
#[unsafe(no_mangle)]
pub extern "C" fn pldi_workspace_align() -> usize {
    PLDI_WORKSPACE_ALIGN
}

/// The pipeline of the default parameters, tables and all in constant memory (flash). Linked only where it is called.
#[unsafe(no_mangle)]
pub extern "C" fn pldi_default_pipeline() -> *const pldi_pipeline {
    &DEFAULT
}

/// Makes a pipeline in `memory` (of any content), and leaves a pointer to it in `pipeline`. Again for other parameters.
/// After an error *pipeline is NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pldi_pipeline_init(
    memory: *mut c_void,
    size: usize,
    params: *const pldi_params,
    pipeline: *mut *mut pldi_pipeline,
) -> pldi_status {
    let init = || {
        // SAFETY: what the header asks for.
        unsafe { border::put(pipeline, core::ptr::null_mut())? };
        let place = place::<pldi_pipeline>(memory, size, PLDI_PIPELINE_SIZE)?;
        // SAFETY: what the header asks for.
        let params = unsafe { border::shared(params)? };
        border::apart(place, params, 1)?;
        let (params, camera, disparity) = checked::checked(params)?;
        // The default one first, then its tables in place: made on the stack, they would take more than there is.
        // SAFETY: `place` found the memory large and aligned enough; it may be written to, as the header asks, and the default one
        // is not in it, because that is constant. Then it holds a pipeline, that nobody else uses.
        let made = unsafe {
            place.copy_from_nonoverlapping(&raw const DEFAULT, 1);
            &mut (*place).0
        };
        made.disparity = disparity;
        if made.inner.set(&params, &camera).is_err() {
            // All groups were checked by their names, so this does not happen.
            made.magic = 0;
            return Err(PLDI_ERROR_INTERNAL);
        }
        // SAFETY: what the header asks for.
        unsafe { border::put(pipeline, place) }
    };
    init().into()
}

/// Makes a workspace in `memory` (of any content), and leaves a pointer to it in `workspace`. Once is enough: frames need not be
/// cleaned up after. After an error *workspace is NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pldi_init(
    memory: *mut c_void,
    size: usize,
    workspace: *mut *mut pldi_workspace,
) -> pldi_status {
    let init = || {
        // SAFETY: what the header asks for.
        unsafe { border::put(workspace, core::ptr::null_mut())? };
        let place = place::<pldi_workspace>(memory, size, PLDI_WORKSPACE_SIZE)?;
        border::apart(place, workspace, 1)?;
        // SAFETY: `place` found the memory large and aligned enough, and it may be written to, as the header asks. Nothing is
        // read. The images are valid as zeros (`zeroed` below). In place, because half a megabyte must not pass through a stack.
        unsafe {
            let store = &raw mut (*place).0;
            (&raw mut (*store).inner.images).write_bytes(0, 1);
            (&raw mut (*store).inner.report).write(Report::new());
            (&raw mut (*store).state).write(State::EMPTY);
            (&raw mut (*store).templates).write(0);
            (&raw mut (*store).magic).write(WORKSPACE);
        }
        // SAFETY: what the header asks for.
        unsafe { border::put(workspace, place) }
    };
    init().into()
}

/// Images may be made of zeros.
const fn zeroed<T: FromZeros>() {}

const _: () = zeroed::<FixedImages<{ crate::PLDI_WIDTH }, { crate::PLDI_HEIGHT }>>();

/// Where an object can be made: memory that is there, aligned and large enough.
fn place<T>(memory: *mut c_void, size: usize, needed: usize) -> Checked<*mut T> {
    let place = memory.cast::<T>();
    if place.is_null() {
        Err(PLDI_ERROR_NULL)
    } else if !place.is_aligned() {
        Err(PLDI_ERROR_ALIGNMENT)
    } else if size < needed {
        Err(PLDI_ERROR_MEMORY)
    } else {
        Ok(place)
    }
}

impl pldi_pipeline {
    /// The pipeline behind a pointer.
    ///
    /// # Safety
    /// As [`border::shared`], for the magic word; where that is right, for the whole of it.
    pub(crate) unsafe fn get<'a>(pipeline: *const Self) -> Checked<&'a Self> {
        // SAFETY: the caller's promise; the word comes first, and any bits are a number.
        unsafe { border::begins_with(pipeline, PIPELINE)? };
        // SAFETY: the caller's promise, and the word that only `pldi_pipeline_init` writes.
        unsafe { border::shared(pipeline) }
    }

    pub(crate) fn inner(&self) -> &QvgaFixedPipeline {
        &self.0.inner
    }

    pub(crate) fn disparity(&self) -> Disparity {
        self.0.disparity
    }
}

impl pldi_workspace {
    /// The workspace behind a pointer.
    ///
    /// # Safety
    /// As [`border::shared`], for the magic word; where that is right, for the whole of it.
    pub(crate) unsafe fn get<'a>(workspace: *const Self) -> Checked<&'a Self> {
        // SAFETY: the caller's promise; the word comes first, and any bits are a number.
        unsafe { border::begins_with(workspace, WORKSPACE)? };
        // SAFETY: the caller's promise, and the word that only `pldi_init` writes.
        unsafe { border::shared(workspace) }
    }

    /// The workspace behind a pointer, to be worked in.
    ///
    /// # Safety
    /// As [`border::exclusive`], for the magic word; where that is right, for the whole of it.
    pub(crate) unsafe fn get_mut<'a>(workspace: *mut Self) -> Checked<&'a mut Self> {
        // SAFETY: the caller's promise; the word comes first, and any bits are a number.
        unsafe { border::begins_with(workspace, WORKSPACE)? };
        // SAFETY: the caller's promise, and the word that only `pldi_init` writes.
        unsafe { border::exclusive(workspace) }
    }

    pub(crate) fn inner(&self) -> &QvgaFixedWorkspace {
        &self.0.inner
    }

    pub(crate) fn inner_mut(&mut self) -> &mut QvgaFixedWorkspace {
        &mut self.0.inner
    }

    /// Checks that calls come in their order.
    pub(crate) fn expect(&self, state: State) -> Checked<()> {
        if self.0.state == state { Ok(()) } else { Err(PLDI_ERROR_ORDER) }
    }

    /// Notes how far the frame is, and with which templates.
    pub(crate) fn set(&mut self, state: State, templates: u32) {
        (self.0.state, self.0.templates) = (state, templates);
    }

    /// The checksum of the templates that the results were made with.
    pub(crate) fn templates(&self) -> u32 {
        self.0.templates
    }
}

impl fmt::Debug for pldi_pipeline {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("pldi_pipeline").finish_non_exhaustive()
    }
}

impl fmt::Debug for pldi_workspace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("pldi_workspace").finish_non_exhaustive()
    }
}
