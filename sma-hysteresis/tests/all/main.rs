//! All tests of `sma-hysteresis` that see its public API, in one program: each by itself would be linked with everything again.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

mod asymmetry;
mod common;
mod elementary;
mod errors;
mod families;
mod paper_sadeghi;
mod properties;
