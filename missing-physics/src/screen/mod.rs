//! Traces of effects to first order, and their scores against the residual of a model.

pub(crate) mod scores;
pub(crate) mod screening;
