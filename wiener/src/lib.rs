#![cfg_attr(not(feature = "std"), no_std)]
#![doc = include_str!("../README.md")]

mod cascade;
mod drive;
#[cfg(feature = "std")]
mod ensemble;
mod error;
#[cfg(feature = "std")]
mod fleet;
mod lanes;
mod plant;
mod run;
mod start;
#[cfg(feature = "std")]
mod vectors;

pub use cascade::{State, Wiener, WienerParams};
pub use drive::Drive;
#[cfg(feature = "std")]
pub use ensemble::{Ensemble, Member};
pub use error::WienerError;
#[cfg(feature = "std")]
pub use fleet::{Block, Fleet, MEDIUM, NARROW, WIDE, lockstep, padded};
pub use lanes::{Drives, Lanes, Shown, Started, Stretch};
pub use plant::{Input, Output, Plant};
pub use run::{Profile, run};
pub use start::Start;
#[cfg(feature = "std")]
pub use vectors::widest_vectors;

/// The blocks of the cascade, for those who put their own together.
pub use sma_hysteresis as hysteresis;
/// The heat balance, for those who put their own together.
pub use sma_thermal as thermal;
