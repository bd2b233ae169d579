#![cfg_attr(not(feature = "std"), no_std)]
#![doc = include_str!("../README.md")]

mod closed_loop;
mod cost;
mod error;
mod feed_forward;
mod pid;
mod reference;
mod step_response;

pub use closed_loop::{
    ClosedLoop, ClosedLoopParams, Disturbances, MAX_DEAD_TIME_SAMPLES, Snapshot,
};
pub use cost::{CostWeights, ResponseTerms, Terms};
pub use error::TuneError;
pub use feed_forward::feed_forward_a;
pub use pid::{
    AntiWindup, Command, DerivativeOf, DriveLimits, Pid, PidGains, PidParams, PidState, Sample,
};
pub use reference::Reference;
pub use step_response::StepTerms;
