//! Which rules were asked, of what, and what they said.

use crate::decide::rules::{Rule, RuleId};

/// A rule that was asked.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// The rule.
    pub rule: &'static Rule,
    /// Name that it was asked of; empty if it was asked of the whole.
    pub of: String,
    /// The statistic.
    pub value: f64,
    /// True if it passed.
    pub passed: bool,
}

/// All that were asked.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Traces(pub(crate) Vec<Trace>);

impl Traces {
    /// Asks a rule, and remembers what it said.
    pub(crate) fn ask(&mut self, id: RuleId, of: &str, value: f64) -> bool {
        let rule = id.rule();
        let passed = rule.passes(value);
        self.0.push(Trace {
            rule,
            of: of.to_owned(),
            value,
            passed,
        });
        passed
    }
}
