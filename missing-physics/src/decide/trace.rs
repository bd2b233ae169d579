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
#[derive(Debug, Clone, Default)]
pub(crate) struct Traces {
    /// Steps to the verdict, in order.
    pub(crate) steps: Vec<Trace>,
    /// Questions asked aside, for a verdict without names.
    aside: Vec<Trace>,
    /// A rule with another threshold, if one has.
    other: Option<(RuleId, f64)>,
}

impl Traces {
    /// Nothing asked yet, with the threshold of one rule times a factor.
    pub(crate) fn with_threshold_times(rule: &Rule, factor: f64) -> Self {
        Self {
            other: Some((rule.id, rule.threshold_times(factor))),
            ..Self::default()
        }
    }

    /// Nothing asked yet, by the same thresholds.
    pub(crate) fn begun_again(&self) -> Self {
        Self {
            other: self.other,
            ..Self::default()
        }
    }

    pub(crate) fn threshold(&self, id: RuleId) -> f64 {
        let other = self.other.filter(|(rule, _)| *rule == id);
        other.map_or(id.rule().threshold, |(_, threshold)| threshold)
    }

    /// Asks a rule, and remembers what it said.
    pub(crate) fn ask(&mut self, id: RuleId, of: &str, value: f64) -> bool {
        let rule = id.rule();
        let passed = rule.passes_at(value, self.threshold(id));
        self.steps.push(Trace {
            rule,
            of: of.to_owned(),
            value,
            passed,
        });
        passed
    }

    /// Keeps what others were asked, as asked aside.
    pub(crate) fn set_aside(&mut self, others: Self) {
        self.aside.extend(others.steps);
    }

    /// True if a rule was asked of a name and said this.
    pub(crate) fn has(&self, id: RuleId, of: &str, passed: bool) -> bool {
        let mut own = self.steps.iter();
        own.any(|trace| trace.rule.id == id && trace.of == of && trace.passed == passed)
    }

    /// True if some answer of a rule would be another one with its threshold times a factor.
    pub(crate) fn hang_on(&self, rule: &Rule, factor: f64) -> bool {
        let threshold = rule.threshold_times(factor);
        // A set ends at the threshold: its last value does not tell where it would have ended.
        let is_sought = rule.id == RuleId::Set;
        let mut own = self.steps.iter().chain(&self.aside);
        own.any(|trace| {
            let is_other = rule.passes_at(trace.value, threshold) != trace.passed;
            trace.rule.id == rule.id && (is_sought || is_other)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_hangs_on_its_threshold_where_a_quarter_more_or_less_turns_it() {
        let [told, own] = [RuleId::Told, RuleId::Own].map(RuleId::rule);
        let mut traces = Traces::default();
        assert!(!traces.hang_on(told, 1.25));
        assert!(traces.ask(RuleId::Told, "backlash", 1.1));
        assert!(traces.hang_on(told, 1.25) && !traces.hang_on(told, 0.75));
        // What another rule was asked says nothing of this one.
        assert!(!traces.hang_on(own, 1.25));
        assert!(!traces.ask(RuleId::Own, "backlash", 0.012));
        assert!(traces.hang_on(own, 1.25) && !traces.hang_on(own, 0.75));
    }

    #[test]
    fn what_is_asked_aside_hangs_as_well_and_is_no_step() {
        let mut others = Traces::default();
        others.ask(RuleId::Told, "backlash", 1.1);
        let mut traces = Traces::default();
        traces.set_aside(others);
        assert!(traces.steps.is_empty());
        assert!(traces.hang_on(RuleId::Told.rule(), 1.25));
    }

    #[test]
    fn a_set_hangs_on_its_threshold_wherever_it_ended() {
        let mut traces = Traces::default();
        traces.ask(RuleId::Set, "backlash", 0.9999);
        for factor in [0.75, 1.25] {
            assert!(traces.hang_on(RuleId::Set.rule(), factor));
        }
    }

    #[test]
    fn another_threshold_is_that_of_one_rule_and_stays_when_begun_again() {
        let moved = Traces::with_threshold_times(RuleId::Told.rule(), 1.25);
        for mut traces in [moved.begun_again(), moved] {
            assert!(!traces.ask(RuleId::Told, "backlash", 1.1));
            assert!(traces.ask(RuleId::Matters, "backlash", 1.1));
            assert!(!traces.steps[0].passed && traces.steps[1].passed);
        }
    }
}
