//! Where a model and its recordings part.

pub(crate) mod bands;
pub(crate) mod blocks;
pub(crate) mod cells;
pub(crate) mod everywhere;
pub(crate) mod located;
pub(crate) mod mismatch;
pub(crate) mod regimes;
pub(crate) mod remainder;
pub(crate) mod spans;
