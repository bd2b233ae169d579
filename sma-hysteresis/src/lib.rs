#![no_std]
#![doc = include_str!("../README.md")]

mod elementary;
mod error;
mod family;
mod hysteresis;
mod limiting_loop;
mod memory;
mod path;
mod proximity;
mod roots;
mod vectors;

pub use elementary::{
    ATAN_COEFFICIENTS, EXPONENTIAL_COEFFICIENTS, SIN_COEFFICIENTS, TAN_FRAC_PI_8, atan, expm1,
    inverse_fourth_root, inverse_sqrt, ln, sin_quarter,
};
pub use error::HysteresisError;
pub use family::{LoopFamily, SecondPopulation};
pub use hysteresis::{Hysteresis, Sensed};
pub use limiting_loop::{Branch, LimitingLoop, LoopParams};
pub use memory::{Memory, NESTING_CAPACITY, Rule};
pub use path::{REVERSAL_DEAD_BAND_K, Reversal};
pub use proximity::{ExponentialProximity, Proximity, SineProximity};
