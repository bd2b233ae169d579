//! Answers of the rules that decided.

use missing_physics::{Diagnosis, RuleId, Trace};

fn of(diagnosis: &Diagnosis, id: RuleId) -> impl Iterator<Item = &Trace> {
    let traces = diagnosis.traces.iter();
    traces.filter(move |trace| trace.rule.id == id)
}

/// Statistic of a rule when it was first asked; `None` if it was not asked.
pub(super) fn value(diagnosis: &Diagnosis, id: RuleId) -> Option<f64> {
    of(diagnosis, id).next().map(|trace| trace.value)
}

/// Statistic of a rule when it first passed; `None` if it never did.
pub(super) fn passed(diagnosis: &Diagnosis, id: RuleId) -> Option<f64> {
    let mut passed = of(diagnosis, id).filter(|trace| trace.passed);
    passed.next().map(|trace| trace.value)
}

/// Statistic of a rule when it first failed; `None` if it never did.
pub(super) fn failed(diagnosis: &Diagnosis, id: RuleId) -> Option<f64> {
    let mut failed = of(diagnosis, id).filter(|trace| !trace.passed);
    failed.next().map(|trace| trace.value)
}

/// Last answer of a rule on an effect; `None` if it was not asked of it.
pub(super) fn of_effect<'d>(
    diagnosis: &'d Diagnosis,
    id: RuleId,
    effect: &str,
) -> Option<&'d Trace> {
    of(diagnosis, id).filter(|trace| trace.of == effect).last()
}
