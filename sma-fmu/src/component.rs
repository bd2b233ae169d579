//! Instance behind a component pointer.

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::fmt;

use crate::slave::{Slave, SlaveError};

/// Status of a call: fmi2OK, fmi3OK.
pub(crate) const OK: c_int = 0;
/// fmi2Error, fmi3Error.
pub(crate) const ERROR: c_int = 3;

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

    fn log(&self, name: &CStr, message: &CStr) {
        let Some(logger) = self.logger else {
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

/// Takes a line of the importer's log in FMI 3.0: environment, status, category, message.
pub type LogMessage = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);

/// The importer's log.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Log {
    /// That of FMI 2.0.
    Fmi2(Callbacks),
    /// That of FMI 3.0, with its first argument.
    Fmi3(Option<LogMessage>, *mut c_void),
}

impl Log {
    /// Tells of an error in the instance of that name.
    pub(crate) fn error(&self, name: &CStr, message: &str) {
        // A zero in a message would end it.
        let Ok(message) = CString::new(message.replace('\0', "?")) else {
            return;
        };
        match *self {
            Self::Fmi2(callbacks) => callbacks.log(name, &message),
            Self::Fmi3(None, _) => {}
            Self::Fmi3(Some(logger), environment) => {
                let category = c"logStatusError";
                // SAFETY: the importer gave a logger that takes these arguments, for as long as there is an instance; both strings
                // end with a zero and outlive the call.
                unsafe { logger(environment, ERROR, category.as_ptr(), message.as_ptr()) };
            }
        }
    }
}

/// Target of a component pointer of this library.
#[derive(Debug)]
pub(crate) struct Component {
    slave: Slave,
    name: CString,
    log: Log,
}

impl Component {
    /// A new one as the pointer of an importer; null where the slave is refused, and the log says why.
    pub(crate) fn given_away(
        slave: Result<Slave, SlaveError>,
        name: CString,
        log: Log,
    ) -> *mut c_void {
        match slave {
            Ok(slave) => Box::into_raw(Box::new(Self { slave, name, log })).cast(),
            Err(error) => {
                log.error(&name, &error.to_string());
                std::ptr::null_mut()
            }
        }
    }

    /// Takes it back, and drops it.
    ///
    /// # Safety
    ///
    /// The pointer is null, or of [`Component::given_away`] and not freed yet.
    pub(crate) unsafe fn freed(pointer: *mut c_void) {
        if !pointer.is_null() {
            // SAFETY: the box was given away above, and comes back once.
            drop(unsafe { Box::from_raw(pointer.cast::<Self>()) });
        }
    }
}

/// Does with the component behind a pointer what a call is for; an error is logged.
///
/// # Safety
///
/// The pointer is null, or of [`Component::given_away`] and not freed, and nobody else uses it meanwhile.
pub(crate) unsafe fn with(
    pointer: *mut c_void,
    act: impl FnOnce(&mut Slave) -> Result<(), SlaveError>,
) -> c_int {
    // SAFETY: as the caller promises, a non-null pointer is that of a boxed component, which is used by this call alone.
    let Some(component) = (unsafe { pointer.cast::<Component>().as_mut() }) else {
        return ERROR;
    };
    match act(&mut component.slave) {
        Ok(()) => OK,
        Err(error) => {
            component.log.error(&component.name, &error.to_string());
            ERROR
        }
    }
}
