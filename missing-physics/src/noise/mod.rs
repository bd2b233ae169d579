//! Level and class of the noise, and tests for residuals that are no noise.

pub(crate) mod floor;
pub(crate) mod kind;
pub(crate) mod of_drive;
pub(crate) mod slip;
pub(crate) mod slowness;
pub(crate) mod tone;
pub(crate) mod wander;
pub(crate) mod whiten;
