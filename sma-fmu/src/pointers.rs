//! Texts and values behind pointers of an importer.

use std::ffi::{CStr, c_char};

/// The text behind a pointer; `None` for the null pointer and for bytes that are not UTF-8.
///
/// # Safety
///
/// The pointer is null, or of bytes that end with a zero and stay as they are.
pub(crate) unsafe fn text<'a>(pointer: *const c_char) -> Option<&'a str> {
    if pointer.is_null() {
        return None;
    }
    // SAFETY: as the caller promises, there is a zero behind the bytes.
    let bytes = unsafe { CStr::from_ptr(pointer) };
    bytes.to_str().ok()
}

/// The values behind a pointer; `None` for the null pointer where there should be some.
///
/// # Safety
///
/// The pointer is null, or of so many values that stay as they are.
pub(crate) unsafe fn values<'a, T>(pointer: *const T, count: usize) -> Option<&'a [T]> {
    if count == 0 {
        return Some(&[]);
    }
    if pointer.is_null() {
        return None;
    }
    // SAFETY: as the caller promises, there are so many values.
    Some(unsafe { std::slice::from_raw_parts(pointer, count) })
}
