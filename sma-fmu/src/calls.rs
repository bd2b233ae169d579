//! Calls that FMI 2.0 and 3.0 have in common.

use std::ffi::{c_int, c_uint, c_void};

use crate::component::{ERROR, OK, with};
use crate::pointers::values;
use crate::slave::{Slave, SlaveError, Snapshot};

/// Reads variables; the second part of each pair is the length of its array.
///
/// # Safety
///
/// The component is of an instance and not freed; there are so many references, and room for so many values.
pub(crate) unsafe fn get_reals(
    component: *mut c_void,
    call: &'static str,
    (references, count): (*const c_uint, usize),
    (read, room): (*mut f64, usize),
) -> c_int {
    // SAFETY: as the caller promises.
    let references = unsafe { values(references, count) };
    let get = |slave: &mut Slave| {
        let null = |what| SlaveError::Null { call, count, what };
        let references = references.ok_or_else(|| null("value references"))?;
        if room < count || read.is_null() && count > 0 {
            return Err(null("values"));
        }
        for (k, &reference) in references.iter().enumerate() {
            let value = slave.get(reference)?;
            // SAFETY: the k-th of so many places that the caller has made.
            let place = unsafe { read.add(k) };
            // SAFETY: as above; nothing is read from it before.
            unsafe { place.write(value) };
        }
        Ok(())
    };
    // SAFETY: as the caller promises.
    unsafe { with(component, get) }
}

/// Sets inputs and parameters.
///
/// # Safety
///
/// The component is of an instance and not freed; there are so many references and values.
pub(crate) unsafe fn set_reals(
    component: *mut c_void,
    call: &'static str,
    (references, count): (*const c_uint, usize),
    (given, n_given): (*const f64, usize),
) -> c_int {
    // SAFETY: as the caller promises.
    let references = unsafe { values(references, count) };
    // SAFETY: as the caller promises.
    let given = unsafe { values(given, n_given) };
    let set = |slave: &mut Slave| {
        let null = |what| SlaveError::Null { call, count, what };
        let references = references.ok_or_else(|| null("value references"))?;
        let given = given.filter(|given| given.len() == count);
        let given = given.ok_or_else(|| null("values"))?;
        let mut pairs = references.iter().zip(given);
        pairs.try_for_each(|(&reference, &value)| slave.set(reference, value))
    };
    // SAFETY: as the caller promises.
    unsafe { with(component, set) }
}

/// Keeps the state of an instance: in a new place, or in the one that is given.
///
/// # Safety
///
/// The component is of an instance and not freed; the state is null or of this function and not freed.
pub(crate) unsafe fn keep_state(component: *mut c_void, state: *mut *mut c_void) -> c_int {
    // SAFETY: as the caller promises.
    let Some(state) = (unsafe { state.as_mut() }) else {
        return ERROR;
    };
    let keep = |slave: &mut Slave| {
        let snapshot = slave.snapshot();
        // SAFETY: null, or a box that was given away below and is used by this call alone.
        match unsafe { state.cast::<Snapshot>().as_mut() } {
            Some(place) => *place = snapshot,
            None => *state = Box::into_raw(Box::new(snapshot)).cast(),
        }
        Ok(())
    };
    // SAFETY: as the caller promises.
    unsafe { with(component, keep) }
}

/// Takes an instance back to a state that was kept.
///
/// # Safety
///
/// The component is of an instance and not freed; the state is null, or of [`keep_state`] of an instance of this model
/// and not freed.
pub(crate) unsafe fn restore_state(component: *mut c_void, state: *mut c_void) -> c_int {
    // SAFETY: as the caller promises.
    let Some(snapshot) = (unsafe { state.cast::<Snapshot>().as_ref() }) else {
        return ERROR;
    };
    let restore = |slave: &mut Slave| {
        slave.restore(snapshot);
        Ok(())
    };
    // SAFETY: as the caller promises.
    unsafe { with(component, restore) }
}

/// Frees a state that was kept, and makes its pointer null.
///
/// # Safety
///
/// The state is null, or of [`keep_state`] and not freed.
pub(crate) unsafe fn free_state(state: *mut *mut c_void) -> c_int {
    // SAFETY: as the caller promises.
    let Some(state) = (unsafe { state.as_mut() }) else {
        return OK;
    };
    if !state.is_null() {
        // SAFETY: the box was given away in `keep_state`, and comes back once.
        drop(unsafe { Box::from_raw(state.cast::<Snapshot>()) });
        *state = std::ptr::null_mut();
    }
    OK
}
