//! The baseline model, with what belongs to recordings and runs left open as far as it is asked for.

pub(crate) mod opened;
mod run_states;
mod unknowns;
