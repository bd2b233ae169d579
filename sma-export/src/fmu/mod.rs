//! A model as a functional mock-up unit: FMI 2.0 or 3.0, co-simulation.

mod description;
mod unit;
mod variables;

pub use unit::fmu;
pub use variables::{FMU_LIBRARY, FMU_MARK, FMU_TIME, Fmi, FmuVariable, fmu_guid};
