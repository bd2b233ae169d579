//! All tests of `missing-physics` that see its public API, in one program: each by itself would be linked with everything again.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

mod another_each_run;
mod beside_drifts;
mod bologna;
mod boston;
mod common;
mod detectable;
mod families;
mod house;
mod many_samples;
mod noise_classes;
mod own_hypotheses;
mod saved;
mod since_reference;
mod smaller_effect;
mod spoiled_unseen;
mod stopped;
mod supply_limit;
mod thermometer;
mod unrelated;
