//! The job and the rig that the benches and the programs of this package share and time.

mod job;
mod made;

pub use job::{Job, JobError, N_COORDINATES, ROD_TOML};
pub use made::{MadeUp, made_up};

use std::fmt::Display;

/// Value built from constants of this package, which are within every range.
#[must_use]
pub fn sound<T, E: Display>(built: Result<T, E>) -> T {
    match built {
        Ok(value) => value,
        Err(fault) => unreachable!("a constant of the benches is out of range: {fault}"),
    }
}
