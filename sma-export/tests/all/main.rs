//! All tests of `sma-export` that see its public API, in one program.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

mod common;
mod errors;
mod header;
mod module;
