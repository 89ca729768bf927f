//! What a call came to.

use core::ffi::{CStr, c_char};
use pldi_core::{Error, TemplateError};

/// What a call came to. A frame without floor or objects is PLDI_OK.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i32)]
pub enum pldi_status {
    /// All went well.
    PLDI_OK = 0,
    /// A pointer is NULL that must not be.
    PLDI_ERROR_NULL = 1,
    /// A pointer is not a multiple of its type's alignment.
    PLDI_ERROR_ALIGNMENT = 2,
    /// The memory for an object is too small.
    PLDI_ERROR_MEMORY = 3,
    /// Two buffers share bytes: an input or an output lies in the workspace.
    PLDI_ERROR_OVERLAP = 4,
    /// An object was not initialised, was overwritten, or comes from another version of the library.
    PLDI_ERROR_NOT_INITIALISED = 5,
    /// The parameters were not filled by pldi_default_params of this version.
    PLDI_ERROR_VERSION = 6,
    /// Calls in the wrong order.
    PLDI_ERROR_ORDER = 7,
    /// The intrinsics are out of range, or for images of another size than 320x240.
    PLDI_ERROR_INTRINSICS = 8,
    /// The range of valid depths is empty or begins at 0.
    PLDI_ERROR_DEPTH_RANGE = 9,
    /// The relation of raw disparity and depth is of no use.
    PLDI_ERROR_DISPARITY = 10,
    /// A parameter of the filter is out of range.
    PLDI_ERROR_FILTER = 11,
    /// A parameter of the floor is out of range.
    PLDI_ERROR_FLOOR = 12,
    /// A parameter of the sensory area is out of range.
    PLDI_ERROR_AREA = 13,
    /// A limit of the candidates is out of range.
    PLDI_ERROR_LIMITS = 14,
    /// A parameter of the view is out of range.
    PLDI_ERROR_VIEW = 15,
    /// An unknown number in place of a format or a mode.
    PLDI_ERROR_FORMAT = 16,
    /// A frame or a row has another number of values than its format asks for.
    PLDI_ERROR_LENGTH = 17,
    /// The template bytes are fewer than their header says.
    PLDI_ERROR_TEMPLATES_CUT = 18,
    /// The bytes are no template file.
    PLDI_ERROR_TEMPLATES_FORMAT = 19,
    /// The template file is of a version that this library does not read.
    PLDI_ERROR_TEMPLATES_VERSION = 20,
    /// The template bytes were changed: the checksum does not fit.
    PLDI_ERROR_TEMPLATES_CHECKSUM = 21,
    /// A field of the template file is out of range.
    PLDI_ERROR_TEMPLATES_FIELD = 22,
    /// The templates were made with other view parameters than the pipeline's.
    PLDI_ERROR_TEMPLATES_PARAMETERS = 23,
    /// The templates hold floats.
    PLDI_ERROR_TEMPLATES_ENCODING = 24,
    /// The results were made with another template set.
    PLDI_ERROR_TEMPLATES_OTHER = 25,
    /// The frame has more clusters or contour points than there is room for.
    PLDI_ERROR_CAPACITY = 26,
    /// The array for the results is too short; it was filled as far as it goes.
    PLDI_ERROR_ARRAY_SHORT = 27,
    /// None of the above.
    PLDI_ERROR_INTERNAL = 28,
}

use pldi_status::*;

/// What an object of the border gives: a value, or the status to return.
pub(crate) type Checked<T> = Result<T, pldi_status>;

impl pldi_status {
    const ALL: [Self; 29] = [
        PLDI_OK,
        PLDI_ERROR_NULL,
        PLDI_ERROR_ALIGNMENT,
        PLDI_ERROR_MEMORY,
        PLDI_ERROR_OVERLAP,
        PLDI_ERROR_NOT_INITIALISED,
        PLDI_ERROR_VERSION,
        PLDI_ERROR_ORDER,
        PLDI_ERROR_INTRINSICS,
        PLDI_ERROR_DEPTH_RANGE,
        PLDI_ERROR_DISPARITY,
        PLDI_ERROR_FILTER,
        PLDI_ERROR_FLOOR,
        PLDI_ERROR_AREA,
        PLDI_ERROR_LIMITS,
        PLDI_ERROR_VIEW,
        PLDI_ERROR_FORMAT,
        PLDI_ERROR_LENGTH,
        PLDI_ERROR_TEMPLATES_CUT,
        PLDI_ERROR_TEMPLATES_FORMAT,
        PLDI_ERROR_TEMPLATES_VERSION,
        PLDI_ERROR_TEMPLATES_CHECKSUM,
        PLDI_ERROR_TEMPLATES_FIELD,
        PLDI_ERROR_TEMPLATES_PARAMETERS,
        PLDI_ERROR_TEMPLATES_ENCODING,
        PLDI_ERROR_TEMPLATES_OTHER,
        PLDI_ERROR_CAPACITY,
        PLDI_ERROR_ARRAY_SHORT,
        PLDI_ERROR_INTERNAL,
    ];

    /// What was wrong and what to do.
    const fn text(self) -> &'static CStr {
        match self {
            PLDI_OK => c"no error",
            PLDI_ERROR_NULL => c"a pointer is NULL: only colour and some outputs may be",
            PLDI_ERROR_ALIGNMENT => {
                c"a pointer is misaligned: use PLDI_WORKSPACE_ALIGN, PLDI_PIPELINE_ALIGN, and the alignment of the type"
            }
            PLDI_ERROR_MEMORY => {
                c"the memory is too small: give at least PLDI_WORKSPACE_SIZE or PLDI_PIPELINE_SIZE bytes"
            }
            PLDI_ERROR_OVERLAP => c"a buffer lies in the workspace: give it memory of its own",
            PLDI_ERROR_NOT_INITIALISED => {
                c"not initialised, overwritten, or made by another version: call its init or open function first"
            }
            PLDI_ERROR_VERSION => {
                c"parameters of another version: call pldi_default_params first, with header and library of one version"
            }
            PLDI_ERROR_ORDER => {
                c"calls in the wrong order: pldi_begin_frame, pldi_push_row for every row once, pldi_finish_frame, results"
            }
            PLDI_ERROR_INTRINSICS => {
                c"intrinsics out of range or not for 320x240: scale them, focal lengths and centre in pixels, Q16"
            }
            PLDI_ERROR_DEPTH_RANGE => c"empty depth range: 1 <= depth_min <= depth_max",
            PLDI_ERROR_DISPARITY => c"disparity out of range: scale and offset must be positive",
            PLDI_ERROR_FILTER => c"a parameter of the filter is out of range: see pldi_filter",
            PLDI_ERROR_FLOOR => c"a parameter of the floor is out of range: see pldi_pose and pldi_floor_search",
            PLDI_ERROR_AREA => c"the sensory area is out of range: see pldi_area",
            PLDI_ERROR_LIMITS => c"the limits are out of range: see pldi_limits",
            PLDI_ERROR_VIEW => {
                c"the view is out of range: leave its defaults or call pldi_params_for_templates"
            }
            PLDI_ERROR_FORMAT => c"unknown format or mode: use the constants of the header",
            PLDI_ERROR_LENGTH => {
                c"wrong number of values: a frame has 320x240, a row a whole multiple of 320, its colour as many rows"
            }
            PLDI_ERROR_TEMPLATES_CUT => c"the template file is cut: give all its bytes and their number",
            PLDI_ERROR_TEMPLATES_FORMAT => c"not a template file: it does not begin with PLDT",
            PLDI_ERROR_TEMPLATES_VERSION => c"template file of another version: build it with this version's pldi",
            PLDI_ERROR_TEMPLATES_CHECKSUM => c"the template file is damaged: write it to flash again",
            PLDI_ERROR_TEMPLATES_FIELD => {
                c"a field of the template file is out of range, or bytes follow behind it: build it again"
            }
            PLDI_ERROR_TEMPLATES_PARAMETERS => {
                c"templates of other view parameters: call pldi_params_for_templates before pldi_pipeline_init"
            }
            PLDI_ERROR_TEMPLATES_ENCODING => {
                c"templates of floats: convert them with pldi templates convert, or build with --arithmetic fixed"
            }
            PLDI_ERROR_TEMPLATES_OTHER => c"another template set than the frame was processed with: give that one",
            PLDI_ERROR_CAPACITY => {
                c"too many clusters or contour points in the frame: take the next frame, or narrow the sensory area"
            }
            PLDI_ERROR_ARRAY_SHORT => c"the array is too short: the count says how many entries there are",
            PLDI_ERROR_INTERNAL => c"an error that this version of the library has no name for",
        }
    }
}

/// What a status says, in English: what was wrong and what to do. Never NULL, and never to be freed.
#[unsafe(no_mangle)]
pub extern "C" fn pldi_status_text(status: i32) -> *const c_char {
    let known = pldi_status::ALL.iter().find(|known| **known as i32 == status);
    known.map_or(c"no status of this library", |known| known.text()).as_ptr()
}

impl From<TemplateError> for pldi_status {
    fn from(error: TemplateError) -> Self {
        match error {
            TemplateError::Cut { .. } => PLDI_ERROR_TEMPLATES_CUT,
            TemplateError::NotTemplates => PLDI_ERROR_TEMPLATES_FORMAT,
            TemplateError::Version(_) => PLDI_ERROR_TEMPLATES_VERSION,
            TemplateError::Checksum { .. } => PLDI_ERROR_TEMPLATES_CHECKSUM,
            TemplateError::Field(_) => PLDI_ERROR_TEMPLATES_FIELD,
            TemplateError::Parameters { .. } => PLDI_ERROR_TEMPLATES_PARAMETERS,
            TemplateError::Encoding { .. } => PLDI_ERROR_TEMPLATES_ENCODING,
            _ => PLDI_ERROR_INTERNAL,
        }
    }
}

/// Errors of a frame's way; those of parameters are told apart where they are checked.
impl From<Error> for pldi_status {
    fn from(error: Error) -> Self {
        match error {
            Error::PixelCount { .. } => PLDI_ERROR_LENGTH,
            Error::IntrinsicsSize { .. } => PLDI_ERROR_INTRINSICS,
            Error::Capacity(_) => PLDI_ERROR_CAPACITY,
            Error::Templates(error) => error.into(),
            // Of the rows, all that is left is a mosaic of an odd number of rows.
            Error::OutOfRange(_) => PLDI_ERROR_LENGTH,
            _ => PLDI_ERROR_INTERNAL,
        }
    }
}

impl From<Checked<()>> for pldi_status {
    fn from(result: Checked<()>) -> Self {
        result.map_or_else(|status| status, |()| PLDI_OK)
    }
}
