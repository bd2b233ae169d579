//! All tests of `wiener` that see its public API, in one program: each by itself would be linked with everything again.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

mod common;
#[cfg(feature = "std")]
mod ensemble;
mod errors;
#[cfg(feature = "std")]
mod fleet;
mod paper_sadeghi;
mod performance_recording;
mod properties;
