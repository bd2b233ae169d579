//! Made-up rigs, and how often their diagnosis is right.
//!
//! A rig is the plain model with some of the catalogue's effects and noise, as recordings: [`made_up`]. A
//! [`Study`] is a numbered list of rigs; [`run_case`] diagnoses one, [`Results`] keeps what came out, and
//! [`summary`] counts it.

mod case_line;
mod error;
mod in_order;
mod made;
mod proportion;
mod results;
mod run_case;
mod study;
mod summary;

pub use case_line::{CaseLine, Errors, Interval, Named, Outcome, Shares, Step, Truth};
pub use error::StudyError;
pub use in_order::in_order;
pub use made::{Made, MadeUp, NoiseKind, made_up, made_up_of_length};
pub use proportion::Proportion;
pub use results::Results;
pub use run_case::run_case;
pub use study::Study;
pub use summary::summary;
