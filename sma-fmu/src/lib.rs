#![doc = include_str!("../README.md")]
// Names of the standard.
#![allow(non_snake_case, non_camel_case_types)]

mod slave;

use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_void};
use std::fmt;

use sma_export::FMU_MARK;

use slave::{Slave, SlaveError, Snapshot};

/// Status of a call: fmi2OK.
const OK: c_int = 0;
/// fmi2Error.
const ERROR: c_int = 3;
/// fmi2CoSimulation.
const CO_SIMULATION: c_int = 1;

/// Version and purpose of this library, which the program looks for before it packs it.
#[unsafe(no_mangle)]
#[used]
pub static SMA_FMU_MARK: [u8; FMU_MARK.len()] = mark();

const fn mark() -> [u8; FMU_MARK.len()] {
    let mut bytes = [0; FMU_MARK.len()];
    let mut k = 0;
    while k < bytes.len() {
        bytes[k] = FMU_MARK.as_bytes()[k];
        k += 1;
    }
    bytes
}

/// Writes a line of the importer's log: environment, name of the instance, status, category, format, arguments.
pub type Logger =
    unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);

/// `fmi2CallbackFunctions` of the standard; this library calls the first alone.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Callbacks {
    /// Logger; null for none.
    pub logger: Option<Logger>,
    /// Allocator.
    pub allocate_memory: *const c_void,
    /// Its counterpart.
    pub free_memory: *const c_void,
    /// Function that says that a step has ended.
    pub step_finished: *const c_void,
    /// First argument of the logger.
    pub environment: *mut c_void,
}

impl fmt::Debug for Callbacks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Callbacks")
            .field("has_logger", &self.logger.is_some())
            .finish_non_exhaustive()
    }
}

impl Callbacks {
    /// Without a log.
    #[must_use]
    pub const fn silent() -> Self {
        Self {
            logger: None,
            allocate_memory: std::ptr::null(),
            free_memory: std::ptr::null(),
            step_finished: std::ptr::null(),
            environment: std::ptr::null_mut(),
        }
    }

    fn log(&self, name: &CStr, message: &str) {
        let Some(logger) = self.logger else {
            return;
        };
        // A zero in a message would end it.
        let Ok(message) = CString::new(message.replace('\0', "?")) else {
            return;
        };
        // SAFETY: the importer gave a logger that takes these arguments, for as long as there is an instance; all strings
        // end with a zero and outlive the call.
        unsafe {
            logger(
                self.environment,
                name.as_ptr(),
                ERROR,
                c"logStatusError".as_ptr(),
                c"%s".as_ptr(),
                message.as_ptr(),
            );
        }
    }
}

/// Target of a component pointer of this library.
#[derive(Debug)]
struct Component {
    slave: Slave,
    name: CString,
    callbacks: Callbacks,
}

impl Component {
    /// Status of a call; an error is logged.
    fn status(&self, result: Result<(), SlaveError>) -> c_int {
        match result {
            Ok(()) => OK,
            Err(error) => {
                self.callbacks.log(&self.name, &error.to_string());
                ERROR
            }
        }
    }
}

/// The component behind a pointer; `None` for the null pointer.
///
/// # Safety
///
/// The pointer is null, or of [`fmi2Instantiate`] and not freed, and nobody else uses it meanwhile.
unsafe fn component<'a>(pointer: *mut c_void) -> Option<&'a mut Component> {
    // SAFETY: as the caller promises, a non-null pointer is that of a boxed component, which is used by this call alone.
    unsafe { pointer.cast::<Component>().as_mut() }
}

/// The text behind a pointer; `None` for the null pointer and for bytes that are not UTF-8.
///
/// # Safety
///
/// The pointer is null, or of bytes that end with a zero and stay as they are.
unsafe fn text<'a>(pointer: *const c_char) -> Option<&'a str> {
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
unsafe fn values<'a, T>(pointer: *const T, count: usize) -> Option<&'a [T]> {
    if count == 0 {
        return Some(&[]);
    }
    if pointer.is_null() {
        return None;
    }
    // SAFETY: as the caller promises, there are so many values.
    Some(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// Does with the component behind a pointer what a call is for.
///
/// # Safety
///
/// As [`component`].
unsafe fn with(
    pointer: *mut c_void,
    act: impl FnOnce(&mut Slave) -> Result<(), SlaveError>,
) -> c_int {
    // SAFETY: the caller's promise is that of this function.
    let Some(component) = (unsafe { component(pointer) }) else {
        return ERROR;
    };
    let result = act(&mut component.slave);
    component.status(result)
}

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
    let callbacks = callbacks.copied().unwrap_or(Callbacks::silent());
    // SAFETY: the importer's strings end with a zero.
    let name = unsafe { text(name) };
    // SAFETY: as above.
    let guid = unsafe { text(guid) };
    // SAFETY: as above.
    let resources = unsafe { text(resources) };
    let name = CString::new(name.unwrap_or_default()).unwrap_or_default();
    let (Some(guid), Some(resources)) = (guid, resources) else {
        callbacks.log(&name, "GUID and resource location: expected text");
        return std::ptr::null_mut();
    };
    if kind != CO_SIMULATION {
        callbacks.log(&name, "type of the unit: expected co-simulation");
        return std::ptr::null_mut();
    }
    match Slave::new(guid, resources) {
        Ok(slave) => {
            let component = Component {
                slave,
                name,
                callbacks,
            };
            Box::into_raw(Box::new(component)).cast()
        }
        Err(error) => {
            callbacks.log(&name, &error.to_string());
            std::ptr::null_mut()
        }
    }
}

/// Frees an instance.
///
/// # Safety
///
/// The pointer is null, or of [`fmi2Instantiate`] and not freed yet.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(component: *mut c_void) {
    if !component.is_null() {
        // SAFETY: the box was given away in fmi2Instantiate, and comes back once.
        drop(unsafe { Box::from_raw(component.cast::<Component>()) });
    }
}

/// Takes note of start and end, which the model does not depend on.
///
/// # Safety
///
/// The component is of [`fmi2Instantiate`] and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    component: *mut c_void,
    _has_tolerance: c_int,
    _tolerance: f64,
    _start_s: f64,
    _has_stop: c_int,
    _stop_s: f64,
) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { with(component, |slave| slave.setup()) }
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
    let reset = |slave: &mut Slave| {
        slave.reset();
        Ok(())
    };
    // SAFETY: as the caller promises.
    unsafe { with(component, reset) }
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
    let references = unsafe { values(references, count) };
    let get = |slave: &mut Slave| {
        let null = |what| SlaveError::Null {
            call: "fmi2GetReal",
            count,
            what,
        };
        let references = references.ok_or_else(|| null("value references"))?;
        if read.is_null() && !references.is_empty() {
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
/// The component is of [`fmi2Instantiate`] and not freed; there are so many references and values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(
    component: *mut c_void,
    references: *const c_uint,
    count: usize,
    given: *const f64,
) -> c_int {
    // SAFETY: as the caller promises.
    let references = unsafe { values(references, count) };
    // SAFETY: as the caller promises.
    let given = unsafe { values(given, count) };
    let set = |slave: &mut Slave| {
        let null = |what| SlaveError::Null {
            call: "fmi2SetReal",
            count,
            what,
        };
        let references = references.ok_or_else(|| null("value references"))?;
        let given = given.ok_or_else(|| null("values"))?;
        let mut pairs = references.iter().zip(given);
        pairs.try_for_each(|(&reference, &value)| slave.set(reference, value))
    };
    // SAFETY: as the caller promises.
    unsafe { with(component, set) }
}

/// Moves the rod on by a communication step, s, under the inputs that are set.
///
/// # Safety
///
/// The component is of [`fmi2Instantiate`] and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    component: *mut c_void,
    _time_s: f64,
    length_s: f64,
    _is_final: c_int,
) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { with(component, |slave| slave.step(length_s)) }
}

/// Keeps the state of an instance: in a new place, or in the one that is given.
///
/// # Safety
///
/// The component is of [`fmi2Instantiate`] and not freed; the state is null or of this function and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(component: *mut c_void, state: *mut *mut c_void) -> c_int {
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
/// The component is of [`fmi2Instantiate`] and not freed; the state is of [`fmi2GetFMUstate`] of an instance of this
/// model and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(component: *mut c_void, state: *mut c_void) -> c_int {
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
/// The state is null, or of [`fmi2GetFMUstate`] and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(
    _component: *mut c_void,
    state: *mut *mut c_void,
) -> c_int {
    // SAFETY: as the caller promises.
    let Some(state) = (unsafe { state.as_mut() }) else {
        return OK;
    };
    if !state.is_null() {
        // SAFETY: the box was given away in fmi2GetFMUstate, and comes back once.
        drop(unsafe { Box::from_raw(state.cast::<Snapshot>()) });
        *state = std::ptr::null_mut();
    }
    OK
}

/// Functions of the standard that a unit without such variables or abilities refuses.
macro_rules! refused {
    ($($name:ident($($argument:ty),*);)+) => {
        $(
            /// Refuses: the unit says in its description that it has none of this.
            #[unsafe(no_mangle)]
            pub extern "C" fn $name(_: *mut c_void, $(_: $argument),*) -> c_int {
                ERROR
            }
        )+
    };
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

/// Functions for variables of types that the unit does not have: no variable is no error.
macro_rules! without_variables {
    ($($name:ident($value:ty);)+) => {
        $(
            /// Reads or sets variables of a type that the unit does not have.
            #[unsafe(no_mangle)]
            pub extern "C" fn $name(
                _: *mut c_void,
                _: *const c_uint,
                count: usize,
                _: $value,
            ) -> c_int {
                if count == 0 { OK } else { ERROR }
            }
        )+
    };
}

without_variables! {
    fmi2GetInteger(*mut c_int);
    fmi2SetInteger(*const c_int);
    fmi2GetBoolean(*mut c_int);
    fmi2SetBoolean(*const c_int);
    fmi2GetString(*mut *const c_char);
    fmi2SetString(*const *const c_char);
}
