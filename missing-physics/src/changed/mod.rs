//! Changes of a rig since it was recorded as it should be.
//!
//! [`Reference::of`] fits the laws of the rig to its reference runs, each with a state of its own (surroundings, heat loss,
//! stroke), and measures how well they meet a run that is left out. [`Reference::changed`] asks which effect has appeared in
//! other runs, or which law is another there. It compares the changes by generalized least squares over all runs together,
//! against the residual that a fitted model leaves of a rig that has not changed ([`discrepancy`]).

mod answered;
mod apart;
mod change;
mod comparison;
mod discrepancy;
mod evidence;
mod first_order;
mod joint;
mod likeliest;
mod partial_loops;
mod reference;
mod standing;
mod system;
mod version;

pub use change::{
    Change, ChangeVerdict, Changed, Changing, Considered, FEWEST_COOLINGS, FEWEST_RUNS,
    LEAST_EXCESS, LEAST_EXPLAINED, LEAST_UNCHANGED, LeftOut, MOST_EXCESS,
};
pub use evidence::{ChangeEvidence, StateSpread, TracedRun};
pub use reference::Reference;
pub use standing::Standing;
