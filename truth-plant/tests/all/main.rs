//! All tests of `truth-plant` that see its public API, in one program: each by itself would be linked with everything again.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

mod additions;
mod agreement;
mod controlled;
mod draws;
mod errors;
mod loops;
mod lumped;
mod physics;
