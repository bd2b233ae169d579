//! All tests of `pso` that see its public API, in one program: each by itself would be linked with everything again.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

mod equations;
mod errors;
mod functions;
mod properties;
mod reproducible;
