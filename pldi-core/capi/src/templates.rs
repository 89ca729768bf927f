//! Template sets in the caller's memory.

use crate::border;
use crate::status::Checked;
use crate::status::pldi_status::{self, *};
use core::ffi::{c_char, c_void};
use pldi_core::templates::Templates;

/// Words of a pldi_templates.
pub const PLDI_TEMPLATES_WORDS: usize = 20;

/// A template set that has been checked: some words of the caller's, which point into the template file's bytes. May be
/// copied. The bytes must stay where they are; many cores may use one set.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct pldi_templates {
    /// Not to be touched.
    pub words: [usize; PLDI_TEMPLATES_WORDS],
}

/// A name within the template file: `length` bytes of UTF-8, not followed by a zero. Valid as long as the file's bytes are.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct pldi_text {
    /// The first byte; never NULL after a call that gave PLDI_OK.
    pub text: *const c_char,
    /// Bytes.
    pub length: usize,
}

/// What lies in the words.
#[repr(C)]
struct Held {
    magic: u32,
    set: Templates<'static>,
}

const _: () = assert!(size_of::<Held>() <= size_of::<pldi_templates>(), "more words");
const _: () = assert!(align_of::<Held>() == align_of::<pldi_templates>());

const MAGIC: u32 = u32::from_le_bytes(*b"pldT") ^ crate::VERSION.rotate_left(7);

impl pldi_text {
    pub(crate) fn new(text: &str) -> Self {
        // What is empty points somewhere all the same.
        let text = if text.is_empty() { c"".to_bytes() } else { text.as_bytes() };
        Self { text: text.as_ptr().cast(), length: text.len() }
    }
}

impl pldi_templates {
    /// The set behind a pointer.
    ///
    /// # Safety
    /// As [`border::shared`], and the bytes that it was made of are still there.
    pub(crate) unsafe fn get<'a>(templates: *const Self) -> Checked<&'a Templates<'static>> {
        let held = templates.cast::<Held>();
        // SAFETY: the caller's promise.
        unsafe { border::begins_with(held, MAGIC)? };
        // SAFETY: the caller's promise, and the word that only `pldi_templates_open` writes.
        Ok(unsafe { &border::shared(held)?.set })
    }
}

/// Checks a template file that lies in memory (flash, best), `size` bytes of any alignment, and makes a set of it. Nothing is
/// copied: the bytes must stay. Reads all of them once, for the checksum. After an error the set is not initialised.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pldi_templates_open(
    templates: *mut pldi_templates,
    bytes: *const c_void,
    size: usize,
) -> pldi_status {
    let open = || {
        let place = templates.cast::<Held>();
        // SAFETY: what the header asks for.
        unsafe { border::put(place.cast::<usize>(), 0)? };
        if bytes.is_null() {
            return Err(PLDI_ERROR_NULL);
        }
        border::apart(templates, bytes.cast::<u8>(), size)?;
        // SAFETY: what the header asks for: the bytes stay as long as the set is used.
        let set = Templates::parse(unsafe { border::slice(bytes.cast::<u8>(), size)? })?;
        set.require_encoding(pldi_core::templates::Encoding::Logarithmic)?;
        // SAFETY: what the header asks for; a `Held` fits.
        unsafe { border::put(place, Held { magic: MAGIC, set }) }
    };
    open().into()
}

/// The number of templates and of classes; either place may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pldi_templates_count(
    templates: *const pldi_templates,
    count: *mut usize,
    classes: *mut usize,
) -> pldi_status {
    let told = || {
        // SAFETY: what the header asks for.
        let set = unsafe { pldi_templates::get(templates)? };
        for (place, number) in [(count, set.len()), (classes, set.classes().len())] {
            if !place.is_null() {
                // SAFETY: what the header asks for.
                unsafe { border::put(place, number)? };
            }
        }
        Ok(())
    };
    told().into()
}

/// The name of a class; of length 0 where there is no such class.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pldi_templates_class_name(
    templates: *const pldi_templates,
    class_id: u16,
    name: *mut pldi_text,
) -> pldi_status {
    let told = || {
        // SAFETY: what the header asks for.
        let set = unsafe { pldi_templates::get(templates)? };
        // SAFETY: what the header asks for.
        unsafe { border::put(name, pldi_text::new(set.class_name(class_id))) }
    };
    told().into()
}
