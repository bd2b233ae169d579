//! All tests of `sma-thermal` that see its public API, in one program: each by itself would be linked with everything again.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

mod errors;
mod paper_sadeghi;
mod properties;
