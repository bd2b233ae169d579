//! Result of a diagnosis and its parts.

pub(crate) mod catalogue;
pub(crate) mod diagnosis;
pub(crate) mod drift;
pub(crate) mod errors;
pub(crate) mod explained;
pub(crate) mod formula;
pub(crate) mod held;
pub(crate) mod judged;
pub(crate) mod ladder;
pub(crate) mod remains;
pub(crate) mod reporting;
pub(crate) mod saved;
pub(crate) mod sentence;
pub(crate) mod told;

pub(crate) use diagnosis::{Diagnosis, Simulations};
pub(crate) use reporting::{Baseline, Reporting};
