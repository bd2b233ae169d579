//! Functions that the standards ask for and a unit has no use for.

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

/// Functions for variables of types that the unit does not have: no variable is no error.
macro_rules! without_variables {
    ($($name:ident($($value:ty),+);)+) => {
        $(
            /// Reads or sets variables of a type that the unit does not have.
            #[unsafe(no_mangle)]
            pub extern "C" fn $name(
                _: *mut c_void,
                _: *const c_uint,
                count: usize,
                $(_: $value),+
            ) -> c_int {
                if count == 0 { OK } else { ERROR }
            }
        )+
    };
}

pub(crate) use {refused, without_variables};
