#![doc = include_str!("../README.md")]
// Names of the standards.
#![allow(non_snake_case, non_camel_case_types)]

mod calls;
mod component;
mod fmi2;
mod fmi3;
mod pointers;
mod refusals;
mod slave;

use sma_export::FMU_MARK;

pub use component::{Callbacks, LogMessage, Logger};
pub use fmi2::*;
pub use fmi3::*;

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
