//! All tests of `rig-files` that see its public API, in one program.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

// The rig of the tests of fits.
#[allow(dead_code, reason = "tests of fits use the rest")]
#[path = "../../../identify/tests/all/common/mod.rs"]
mod common;
mod rod_file;
mod saved_model;
mod supply;
