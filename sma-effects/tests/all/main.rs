//! All tests of `sma-effects` that see its public API, in one program: each by itself would be linked with everything again.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

mod accuracy;
mod catalogue;
mod direction;
mod energy;
mod errors;
mod facts;
mod hypothesis;
mod lanes;
mod second_route;
mod support;
mod zero;
