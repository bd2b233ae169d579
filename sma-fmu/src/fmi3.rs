//! FMI 3.0: the functions of its C interface.

use std::ffi::{CString, c_char, c_int, c_uint, c_void};
use std::path::Path;

use sma_export::Fmi;

use crate::calls::{free_state, get_reals, keep_state, restore_state, set_reals};
use crate::component::{Component, ERROR, Log, LogMessage, OK, with};
use crate::pointers::text;
use crate::refusals::{refused, without_variables};
use crate::slave::{Slave, SlaveError};

/// Version of the standard.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Switches the log; errors are always logged.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3SetDebugLogging(
    _component: *mut c_void,
    _on: bool,
    _n_categories: usize,
    _categories: *const *const c_char,
) -> c_int {
    OK
}

/// Makes an instance of the model in the resources; null if it is refused, and the log says why.
///
/// # Safety
///
/// As the standard has it: strings end with a zero, and the log is there as long as the instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: bool,
    _logging: bool,
    _event_mode_used: bool,
    _early_return_allowed: bool,
    _intermediate_variables: *const c_uint,
    _n_intermediate_variables: usize,
    environment: *mut c_void,
    logger: Option<LogMessage>,
    _intermediate_update: *const c_void,
) -> *mut c_void {
    // SAFETY: the importer's strings end with a zero.
    let name = unsafe { text(name) };
    // SAFETY: as above.
    let token = unsafe { text(token) };
    // SAFETY: as above.
    let resources = unsafe { text(resources) };
    let name = CString::new(name.unwrap_or_default()).unwrap_or_default();
    let slave = match (token, resources.map(Path::new)) {
        (Some(token), Some(path)) if path.is_absolute() => Slave::new(Fmi::V3, token, path),
        (Some(_), Some(path)) => Err(SlaveError::Path {
            path: path.to_owned(),
        }),
        _ => Err(SlaveError::Untold),
    };
    Component::given_away(slave, name, Log::Fmi3(logger, environment))
}

/// Refuses: the unit is one of co-simulation, which the log says.
///
/// # Safety
///
/// As the standard has it: the name ends with a zero, and the log takes its arguments.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    name: *const c_char,
    _token: *const c_char,
    _resources: *const c_char,
    _visible: bool,
    _logging: bool,
    environment: *mut c_void,
    logger: Option<LogMessage>,
) -> *mut c_void {
    // SAFETY: as the caller promises.
    unsafe { refused(name, logger, environment) }
}

/// Refuses: the unit is one of co-simulation, which the log says.
///
/// # Safety
///
/// As the standard has it: the name ends with a zero, and the log takes its arguments.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    name: *const c_char,
    _token: *const c_char,
    _resources: *const c_char,
    _visible: bool,
    _logging: bool,
    environment: *mut c_void,
    logger: Option<LogMessage>,
    _clock_update: *const c_void,
    _lock_preemption: *const c_void,
    _unlock_preemption: *const c_void,
) -> *mut c_void {
    // SAFETY: as the caller promises.
    unsafe { refused(name, logger, environment) }
}

/// Null for an instance of another purpose.
///
/// # Safety
///
/// The name is null or ends with a zero, and the log takes its arguments.
unsafe fn refused(
    name: *const c_char,
    logger: Option<LogMessage>,
    environment: *mut c_void,
) -> *mut c_void {
    // SAFETY: as the caller promises.
    let name = unsafe { text(name) };
    let name = CString::new(name.unwrap_or_default()).unwrap_or_default();
    Component::given_away(
        Err(SlaveError::Purpose),
        name,
        Log::Fmi3(logger, environment),
    )
}

/// Frees an instance.
///
/// # Safety
///
/// The pointer is null, or of [`fmi3InstantiateCoSimulation`] and not freed yet.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(component: *mut c_void) {
    // SAFETY: as the caller promises.
    unsafe { Component::freed(component) };
}

/// Begins the initialization at a time, s, on which the model does not depend.
///
/// # Safety
///
/// The component is of [`fmi3InstantiateCoSimulation`] and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    component: *mut c_void,
    _has_tolerance: bool,
    _tolerance: f64,
    start_s: f64,
    _has_stop: bool,
    _stop_s: f64,
) -> c_int {
    let begin = |slave: &mut Slave| {
        slave.setup("EnterInitializationMode", start_s)?;
        slave.begin_initialization()
    };
    // SAFETY: as the caller promises.
    unsafe { with(component, begin) }
}

/// Ends the initialization: the rod starts.
///
/// # Safety
///
/// The component is of [`fmi3InstantiateCoSimulation`] and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(component: *mut c_void) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { with(component, Slave::end_initialization) }
}

/// Ends the simulation.
///
/// # Safety
///
/// The component is of [`fmi3InstantiateCoSimulation`] and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Terminate(component: *mut c_void) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { with(component, Slave::terminate) }
}

/// Makes the instance what it was at first.
///
/// # Safety
///
/// The component is of [`fmi3InstantiateCoSimulation`] and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(component: *mut c_void) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { with(component, Slave::reset) }
}

/// Reads variables.
///
/// # Safety
///
/// The component is of [`fmi3InstantiateCoSimulation`] and not freed; there are so many references, and room for so many values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    component: *mut c_void,
    references: *const c_uint,
    count: usize,
    read: *mut f64,
    room: usize,
) -> c_int {
    // SAFETY: as the caller promises.
    unsafe {
        get_reals(
            component,
            "fmi3GetFloat64",
            (references, count),
            (read, room),
        )
    }
}

/// Sets inputs and parameters.
///
/// # Safety
///
/// The component is of [`fmi3InstantiateCoSimulation`] and not freed; there are so many references and values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    component: *mut c_void,
    references: *const c_uint,
    count: usize,
    given: *const f64,
    n_given: usize,
) -> c_int {
    // SAFETY: as the caller promises.
    unsafe {
        set_reals(
            component,
            "fmi3SetFloat64",
            (references, count),
            (given, n_given),
        )
    }
}

/// Moves the rod on by a communication step, s, under the inputs that are set. A step goes to its end, and nothing happens in it that
/// the importer would have to be told of.
///
/// # Safety
///
/// The component is of [`fmi3InstantiateCoSimulation`] and not freed; each place of a result is null or can be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    component: *mut c_void,
    time_s: f64,
    length_s: f64,
    _is_final: bool,
    event_needed: *mut bool,
    terminates: *mut bool,
    early_return: *mut bool,
    last_s: *mut f64,
) -> c_int {
    // SAFETY: as the caller promises.
    let status = unsafe { with(component, |slave| slave.step(time_s, length_s)) };
    for place in [event_needed, terminates, early_return] {
        if !place.is_null() {
            // SAFETY: as the caller promises; nothing is read from it before.
            unsafe { place.write(false) };
        }
    }
    if !last_s.is_null() {
        let reached_s = if status == OK {
            time_s + length_s
        } else {
            time_s
        };
        // SAFETY: as above.
        unsafe { last_s.write(reached_s) };
    }
    status
}

/// Keeps the state of an instance: in a new place, or in the one that is given.
///
/// # Safety
///
/// The component is of [`fmi3InstantiateCoSimulation`] and not freed; the state is null or of this function and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(component: *mut c_void, state: *mut *mut c_void) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { keep_state(component, state) }
}

/// Takes an instance back to a state that was kept.
///
/// # Safety
///
/// The component is of [`fmi3InstantiateCoSimulation`] and not freed; the state is of [`fmi3GetFMUState`] of an instance of this
/// model and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(component: *mut c_void, state: *mut c_void) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { restore_state(component, state) }
}

/// Frees a state that was kept, and makes its pointer null.
///
/// # Safety
///
/// The state is null, or of [`fmi3GetFMUState`] and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(
    _component: *mut c_void,
    state: *mut *mut c_void,
) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { free_state(state) }
}

refused! {
    fmi3EnterEventMode();
    fmi3EnterStepMode();
    fmi3EnterConfigurationMode();
    fmi3ExitConfigurationMode();
    fmi3EvaluateDiscreteStates();
    fmi3UpdateDiscreteStates(*mut bool, *mut bool, *mut bool, *mut bool, *mut bool, *mut f64);
    fmi3GetNumberOfVariableDependencies(c_uint, *mut usize);
    fmi3GetVariableDependencies(c_uint, *mut usize, *mut c_uint, *mut usize, *mut c_int, usize);
    fmi3SerializedFMUStateSize(*mut c_void, *mut usize);
    fmi3SerializeFMUState(*mut c_void, *mut u8, usize);
    fmi3DeserializeFMUState(*const u8, usize, *mut *mut c_void);
    fmi3GetDirectionalDerivative(*const c_uint, usize, *const c_uint, usize, *const f64, usize, *mut f64, usize);
    fmi3GetAdjointDerivative(*const c_uint, usize, *const c_uint, usize, *const f64, usize, *mut f64, usize);
    fmi3GetOutputDerivatives(*const c_uint, usize, *const c_int, *mut f64, usize);
    fmi3GetIntervalDecimal(*const c_uint, usize, *mut f64, *mut c_int);
    fmi3GetIntervalFraction(*const c_uint, usize, *mut u64, *mut u64, *mut c_int);
    fmi3GetShiftDecimal(*const c_uint, usize, *mut f64);
    fmi3GetShiftFraction(*const c_uint, usize, *mut u64, *mut u64);
    fmi3SetIntervalDecimal(*const c_uint, usize, *const f64);
    fmi3SetIntervalFraction(*const c_uint, usize, *const u64, *const u64);
    fmi3SetShiftDecimal(*const c_uint, usize, *const f64);
    fmi3SetShiftFraction(*const c_uint, usize, *const u64, *const u64);
    fmi3ActivateModelPartition(c_uint, f64);
    fmi3EnterContinuousTimeMode();
    fmi3CompletedIntegratorStep(bool, *mut bool, *mut bool);
    fmi3SetTime(f64);
    fmi3SetContinuousStates(*const f64, usize);
    fmi3GetContinuousStates(*mut f64, usize);
    fmi3GetContinuousStateDerivatives(*mut f64, usize);
    fmi3GetNominalsOfContinuousStates(*mut f64, usize);
    fmi3GetEventIndicators(*mut f64, usize);
    fmi3GetNumberOfEventIndicators(*mut usize);
    fmi3GetNumberOfContinuousStates(*mut usize);
}

without_variables! {
    fmi3GetFloat32(*mut f32, usize);
    fmi3SetFloat32(*const f32, usize);
    fmi3GetInt8(*mut i8, usize);
    fmi3SetInt8(*const i8, usize);
    fmi3GetUInt8(*mut u8, usize);
    fmi3SetUInt8(*const u8, usize);
    fmi3GetInt16(*mut i16, usize);
    fmi3SetInt16(*const i16, usize);
    fmi3GetUInt16(*mut u16, usize);
    fmi3SetUInt16(*const u16, usize);
    fmi3GetInt32(*mut i32, usize);
    fmi3SetInt32(*const i32, usize);
    fmi3GetUInt32(*mut u32, usize);
    fmi3SetUInt32(*const u32, usize);
    fmi3GetInt64(*mut i64, usize);
    fmi3SetInt64(*const i64, usize);
    fmi3GetUInt64(*mut u64, usize);
    fmi3SetUInt64(*const u64, usize);
    fmi3GetBoolean(*mut bool, usize);
    fmi3SetBoolean(*const bool, usize);
    fmi3GetString(*mut *const c_char, usize);
    fmi3SetString(*const *const c_char, usize);
    fmi3GetBinary(*mut usize, *mut *const u8, usize);
    fmi3SetBinary(*const usize, *const *const u8, usize);
    fmi3GetClock(*mut bool);
    fmi3SetClock(*const bool);
}
