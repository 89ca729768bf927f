//! Pointers from C: checked as far as a pointer can be, then references.
//!
//! What cannot be checked is what the header asks of the caller: that a pointer which is not NULL points to as many
//! bytes as it says, which nobody else writes to during the call.

use crate::status::Checked;
use crate::status::pldi_status::*;

/// Whether a `T` may lie there.
fn check<T>(pointer: *const T) -> Checked<()> {
    if pointer.is_null() {
        Err(PLDI_ERROR_NULL)
    } else if !pointer.is_aligned() {
        Err(PLDI_ERROR_ALIGNMENT)
    } else {
        Ok(())
    }
}

/// Checks an object's pointer and its first word.
///
/// # Safety
/// A pointer that is neither null nor misaligned (for `T`) points to a word.
pub(crate) unsafe fn begins_with<T>(pointer: *const T, magic: u32) -> Checked<()> {
    const { assert!(align_of::<T>() >= align_of::<u32>() && size_of::<T>() >= size_of::<u32>()) };
    check(pointer)?;
    // SAFETY: not null and aligned; the rest is the caller's promise. Any bits are a number.
    let word = unsafe { pointer.cast::<u32>().read() };
    if word == magic { Ok(()) } else { Err(PLDI_ERROR_NOT_INITIALISED) }
}

/// The object that a pointer points to.
///
/// # Safety
/// A pointer that is neither null nor misaligned points to a `T` that is valid for `'a` and that nobody writes to.
pub(crate) unsafe fn shared<'a, T>(pointer: *const T) -> Checked<&'a T> {
    check(pointer)?;
    // SAFETY: not null and aligned; the rest is the caller's promise.
    Ok(unsafe { &*pointer })
}

/// The object that a pointer points to, to be changed.
///
/// # Safety
/// A pointer that is neither null nor misaligned points to a `T` that is valid for `'a` and that nobody else uses.
pub(crate) unsafe fn exclusive<'a, T>(pointer: *mut T) -> Checked<&'a mut T> {
    check(pointer)?;
    // SAFETY: not null and aligned; the rest is the caller's promise.
    Ok(unsafe { &mut *pointer })
}

/// Writes a result; the place need not hold anything before.
///
/// # Safety
/// A pointer that is neither null nor misaligned may be written to.
pub(crate) unsafe fn put<T>(pointer: *mut T, value: T) -> Checked<()> {
    check(pointer)?;
    // SAFETY: not null and aligned; the rest is the caller's promise.
    unsafe { pointer.write(value) };
    Ok(())
}

/// The values that a pointer points to; for none, the pointer may be anything.
///
/// # Safety
/// A pointer that is neither null nor misaligned points to `count` values that are valid for `'a` and that nobody
/// writes to.
pub(crate) unsafe fn slice<'a, T>(pointer: *const T, count: usize) -> Checked<&'a [T]> {
    if count == 0 {
        return Ok(&[]);
    }
    check(pointer)?;
    size_in_bytes::<T>(count)?;
    // SAFETY: not null, aligned and not larger than memory can be; the rest is the caller's promise.
    Ok(unsafe { core::slice::from_raw_parts(pointer, count) })
}

/// Bytes of so many values; no object is larger than `isize::MAX`.
fn size_in_bytes<T>(count: usize) -> Checked<usize> {
    count.checked_mul(size_of::<T>()).filter(|bytes| isize::try_from(*bytes).is_ok()).ok_or(PLDI_ERROR_LENGTH)
}

/// Refuses memory (`count` values from `pointer` on) that shares bytes with an object.
pub(crate) fn apart<T, U>(object: *const T, pointer: *const U, count: usize) -> Checked<()> {
    let (start, other) = (object.addr(), pointer.addr());
    let (end, other_end) = (start.saturating_add(size_of::<T>()), other.saturating_add(size_in_bytes::<U>(count)?));
    if start < other_end && other < end { Err(PLDI_ERROR_OVERLAP) } else { Ok(()) }
}

/// Results in the caller's array, as far as it goes, and their number.
///
/// # Safety
/// `array` may be written to at `capacity` places and `count` at one, as far as they are neither null nor misaligned.
pub(crate) unsafe fn fill<T>(
    results: impl Iterator<Item = T>,
    array: *mut T,
    capacity: usize,
    count: *mut usize,
) -> Checked<()> {
    check(count)?;
    if capacity > 0 {
        check(array)?;
    }
    size_in_bytes::<T>(capacity)?;
    let mut found = 0;
    for result in results {
        if found < capacity {
            // SAFETY: within the caller's array, which is not null, aligned and no larger than memory can be.
            unsafe { array.add(found).write(result) };
        }
        found += 1;
    }
    // SAFETY: not null and aligned; the caller promises that it may be written to.
    unsafe { count.write(found) };
    if found > capacity { Err(PLDI_ERROR_ARRAY_SHORT) } else { Ok(()) }
}
