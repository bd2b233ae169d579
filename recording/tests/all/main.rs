//! All tests of `recording` that see its public API, in one program: each by itself would be linked with everything again.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

mod drive_noise;
mod errors;
mod held_drive;
mod inspect;
mod limited;
mod loggers;
mod mended;
mod properties;
mod reading;
mod real;
mod repeats;
mod slips;
mod used;
