//! Made-up rigs, and how often their diagnosis is right.
//!
//! A rig is the plain model with some of the catalogue's effects and noise, as recordings: [`made_up`]. A
//! [`Study`] is a numbered list of rigs; [`run_case`] diagnoses one, a [`Journal`](blind_trial::Journal) keeps what
//! came out, and [`summary`] counts it. [`Injected`] puts effects on real recordings.

mod case_line;
mod error;
mod injected;
mod made;
mod run_case;
mod study;
mod summary;

pub use blind_trial::Errors;
pub use case_line::{CaseId, CaseLine, Interval, Named, Outcome, Shares, Step, Truth};
pub use error::StudyError;
pub use injected::{Behind, Injected};
pub use made::{Made, MadeUp, NoiseKind, made_up, made_up_of_length};
pub use run_case::run_case;
pub use study::Study;
pub use summary::summary;
