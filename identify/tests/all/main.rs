//! All tests of `identify` that see its public API, in one program: each by itself would be linked with everything again.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

mod antagonist;
mod bologna;
mod common;
mod coverage;
mod cross_check;
mod doubts;
mod ended;
mod many_parameters;
mod odd_step;
mod recover;
mod specific_heat;
mod starts;
mod state_of_runs;
mod static_effects;
mod static_fatigue;
mod static_loop;
mod thermal;
