#![no_std]
#![doc = include_str!("../README.md")]

mod error;
mod heat_balance;
mod reach;
mod rod;

pub use error::ThermalError;
pub use heat_balance::{HeatBalance, HeatBalanceParams, Heating, Sample, ThermalConstants};
pub use reach::Reach;
pub use rod::RodParams;
