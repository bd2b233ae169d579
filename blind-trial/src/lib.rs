#![doc = include_str!("../README.md")]

mod aliases;
mod answer;
mod case;
mod case_line;
mod chance;
mod competitors;
mod error;
mod family;
mod folder;
mod in_order;
pub mod injected;
mod journal;
mod known;
mod like;
mod oracle;
mod proportion;
mod run_case;
mod runs;
pub mod scores;
mod sizes;
mod trial;
mod verdict;

pub use answer::{Answer, Concealed, True, seal};
pub use case::Case;
pub use case_line::{CaseLine, Next, Revealed};
pub use competitors::{Competitors, Forward, Whiteness};
pub use error::TrialError;
pub use family::{CaseId, Era, Family, Plan};
pub use in_order::in_order;
pub use journal::{Journal, Line};
pub use like::{Like, LikeError};
pub use oracle::Oracle;
pub use proportion::Proportion;
pub use run_case::{Ran, run_case};
pub use trial::{Progress, RunConfig, Trial};
pub use verdict::{Errors, Estimate, Named, Verdict};
