//! What effects would do to first order, and how that goes with what a model leaves.

pub(crate) mod scores;
pub(crate) mod screening;
