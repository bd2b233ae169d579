//! All tests of `pid-tune` that see its public API, in one program: each by itself would be linked with everything again.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

mod closed_loop;
mod common;
mod cost;
#[cfg(feature = "std")]
mod describing;
mod errors;
mod feed_forward;
#[cfg(feature = "std")]
mod front;
mod gain_schedule;
#[cfg(feature = "std")]
mod inverse;
#[cfg(feature = "std")]
mod limit_cycle;
#[cfg(feature = "std")]
mod limit_cycle_map;
#[cfg(feature = "std")]
mod margins;
mod paper_sadeghi;
mod pid;
mod properties;
mod published_step_info;
mod reference;
#[cfg(feature = "std")]
mod robustness;
#[cfg(feature = "std")]
mod rules;
#[cfg(feature = "std")]
mod schedule_shape;
#[cfg(feature = "std")]
mod screen;
#[cfg(feature = "std")]
mod tuner;
