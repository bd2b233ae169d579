//! Decision on a finished population of models: nothing here simulates or fits.

#[cfg(test)]
mod any;
mod known;
mod leading;
mod names;
mod rules;
mod said;
#[cfg(test)]
mod tests;
mod trace;
mod verdict;

pub(crate) use known::{Known, OF_THERMOMETER, Oddness};
pub(crate) use leading::leading;
pub(crate) use names::Named;
pub(crate) use names::OF_FORMULAS;
#[cfg(test)]
pub(crate) use names::most_of_formula;
pub use rules::{Basis, Comparison, RULES, Rule, RuleId};
pub use said::Verdict;
pub use trace::Trace;
pub(crate) use trace::Traces;
pub(crate) use verdict::{Decided, decide};
