//! Fleets: many rigs, a unit of work each, whose result is a file named by everything that it depends on.

mod error;
mod folder;
mod listed;
mod manifest;
#[cfg(test)]
mod tests;
mod unit;
mod units;

pub use error::FleetError;
pub use listed::{Fleet, Listed, RigFiles};
pub use unit::{Failure, Input, Role, Task, Unit, UnitStatus, named};
pub use units::{UnitFault, Units};
