//! FMI 2.0: the functions of its C interface.

use std::ffi::{CString, c_char, c_int, c_uint, c_void};

use sma_export::Fmi;

use crate::calls::{free_state, get_reals, keep_state, restore_state, set_reals};
use crate::component::{Callbacks, Component, ERROR, Log, OK, with};
use crate::pointers::text;
use crate::refusals::{refused, without_variables};
use crate::slave::{Slave, SlaveError, path_of};

/// fmi2CoSimulation.
const CO_SIMULATION: c_int = 1;

/// Says that types are those of the standard's default.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

/// Version of the standard.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

/// Switches the log; errors are always logged.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2SetDebugLogging(
    _component: *mut c_void,
    _on: c_int,
    _n_categories: usize,
    _categories: *const *const c_char,
) -> c_int {
    OK
}

/// Makes an instance of the model in the resources; null if it is refused, and the log says why.
///
/// # Safety
///
/// As the standard has it: strings end with a zero, and the callbacks are there as long as the instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    name: *const c_char,
    kind: c_int,
    guid: *const c_char,
    resources: *const c_char,
    callbacks: *const Callbacks,
    _visible: c_int,
    _logging: c_int,
) -> *mut c_void {
    // SAFETY: the importer's pointer is null or of callbacks that it has filled in.
    let callbacks = unsafe { callbacks.as_ref() };
    let log = Log::Fmi2(callbacks.copied().unwrap_or(Callbacks::silent()));
    // SAFETY: the importer's strings end with a zero.
    let name = unsafe { text(name) };
    // SAFETY: as above.
    let guid = unsafe { text(guid) };
    // SAFETY: as above.
    let resources = unsafe { text(resources) };
    let name = CString::new(name.unwrap_or_default()).unwrap_or_default();
    let slave = match (guid, resources) {
        (Some(_), Some(_)) if kind != CO_SIMULATION => Err(SlaveError::Purpose),
        (Some(guid), Some(resources)) => {
            path_of(resources).and_then(|path| Slave::new(Fmi::V2, guid, &path))
        }
        _ => Err(SlaveError::Untold),
    };
    Component::given_away(slave, name, log)
}

/// Frees an instance.
///
/// # Safety
///
/// The pointer is null, or of [`fmi2Instantiate`] and not freed yet.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(component: *mut c_void) {
    // SAFETY: as the caller promises.
    unsafe { Component::freed(component) };
}

/// Takes note of the start; the model does not depend on it.
///
/// # Safety
///
/// The component is of [`fmi2Instantiate`] and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    component: *mut c_void,
    _has_tolerance: c_int,
    _tolerance: f64,
    start_s: f64,
    _has_stop: c_int,
    _stop_s: f64,
) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { with(component, |slave| slave.setup("SetupExperiment", start_s)) }
}

/// Begins the initialization.
///
/// # Safety
///
/// The component is of [`fmi2Instantiate`] and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(component: *mut c_void) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { with(component, Slave::begin_initialization) }
}

/// Ends the initialization: the rod starts.
///
/// # Safety
///
/// The component is of [`fmi2Instantiate`] and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(component: *mut c_void) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { with(component, Slave::end_initialization) }
}

/// Ends the simulation.
///
/// # Safety
///
/// The component is of [`fmi2Instantiate`] and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(component: *mut c_void) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { with(component, Slave::terminate) }
}

/// Makes the instance what it was at first.
///
/// # Safety
///
/// The component is of [`fmi2Instantiate`] and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(component: *mut c_void) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { with(component, Slave::reset) }
}

/// Reads variables.
///
/// # Safety
///
/// The component is of [`fmi2Instantiate`] and not freed; there are so many references, and room for as many values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(
    component: *mut c_void,
    references: *const c_uint,
    count: usize,
    read: *mut f64,
) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { get_reals(component, "fmi2GetReal", (references, count), (read, count)) }
}

/// Sets inputs and parameters.
///
/// # Safety
///
/// The component is of [`fmi2Instantiate`] and not freed; there are so many references and values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(
    component: *mut c_void,
    references: *const c_uint,
    count: usize,
    given: *const f64,
) -> c_int {
    // SAFETY: as the caller promises.
    unsafe {
        set_reals(
            component,
            "fmi2SetReal",
            (references, count),
            (given, count),
        )
    }
}

/// Moves the rod on by a communication step, s, under the inputs that are set.
///
/// # Safety
///
/// The component is of [`fmi2Instantiate`] and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    component: *mut c_void,
    time_s: f64,
    length_s: f64,
    _is_final: c_int,
) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { with(component, |slave| slave.step(time_s, length_s)) }
}

/// Keeps the state of an instance: in a new place, or in the one that is given.
///
/// # Safety
///
/// The component is of [`fmi2Instantiate`] and not freed; the state is null or of this function and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(component: *mut c_void, state: *mut *mut c_void) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { keep_state(component, state) }
}

/// Takes an instance back to a state that was kept.
///
/// # Safety
///
/// The component is of [`fmi2Instantiate`] and not freed; the state is of [`fmi2GetFMUstate`] of an instance of this
/// model and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(component: *mut c_void, state: *mut c_void) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { restore_state(component, state) }
}

/// Frees a state that was kept, and makes its pointer null.
///
/// # Safety
///
/// The state is null, or of [`fmi2GetFMUstate`] and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(
    _component: *mut c_void,
    state: *mut *mut c_void,
) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { free_state(state) }
}

refused! {
    fmi2SerializedFMUstateSize(*mut c_void, *mut usize);
    fmi2SerializeFMUstate(*mut c_void, *mut c_char, usize);
    fmi2DeSerializeFMUstate(*const c_char, usize, *mut *mut c_void);
    fmi2GetDirectionalDerivative(*const c_uint, usize, *const c_uint, usize, *const f64, *mut f64);
    fmi2SetRealInputDerivatives(*const c_uint, usize, *const c_int, *const f64);
    fmi2GetRealOutputDerivatives(*const c_uint, usize, *const c_int, *mut f64);
    fmi2CancelStep();
    fmi2GetStatus(c_int, *mut c_int);
    fmi2GetRealStatus(c_int, *mut f64);
    fmi2GetIntegerStatus(c_int, *mut c_int);
    fmi2GetBooleanStatus(c_int, *mut c_int);
    fmi2GetStringStatus(c_int, *mut *const c_char);
}

without_variables! {
    fmi2GetInteger(*mut c_int);
    fmi2SetInteger(*const c_int);
    fmi2GetBoolean(*mut c_int);
    fmi2SetBoolean(*const c_int);
    fmi2GetString(*mut *const c_char);
    fmi2SetString(*const *const c_char);
}
