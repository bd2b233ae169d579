//! A rig, its recordings, and models of it with effects.

pub(crate) mod candidate;
pub(crate) mod case;
pub(crate) mod coarse;
pub(crate) mod elsewhere;
pub(crate) mod extended_model;
pub(crate) mod projection;
pub(crate) mod rig;
pub(crate) mod series;
pub(crate) mod straight;
#[cfg(test)]
pub(crate) mod synthetic;
pub(crate) mod tangent;
pub(crate) mod turning;
pub(crate) mod unseen;
