//! How near the verdict is to another.

use comfy_table::{Cell, Table};
use missing_physics::{Diagnosis, Otherwise};
use serde_json::{Value, json};

use super::headline::names;
use crate::report::number::spoken;
use crate::report::table::{folding, right};
use crate::report::words::listed;

/// Title and instructions of [`table`].
pub(super) const HOW_TO_READ: &str = "How near the verdict is to another\nWith the threshold of one rule moved by a quarter the verdict or a finding would be \
     another one, of the same models; with any other threshold moved as far both stay.";

/// Verdicts that other thresholds would give; `None` if none of them would change anything.
pub(super) fn table(diagnosis: &Diagnosis) -> Option<Table> {
    let mut table = folding(["rule", "needs", "with", "verdict", "findings"]);
    for other in &diagnosis.otherwise {
        let rule = other.rule;
        let sign = rule.comparison.sign();
        let needs = |threshold: f64| right(format!("{sign} {}", spoken(threshold)));
        let findings: Vec<String> = other
            .findings
            .iter()
            .map(|one| names(one, &other.findings))
            .collect();
        table.add_row([
            Cell::new(rule.name),
            needs(rule.threshold),
            needs(rule.threshold_times(other.factor)),
            Cell::new(other.verdict.id().replace('_', " ")),
            Cell::new(listed(&findings, "and")),
        ]);
    }
    (!table.is_empty()).then_some(table)
}

pub(super) fn json(other: &Otherwise) -> Value {
    json!({
        "rule": other.rule.name,
        "threshold": other.rule.threshold_times(other.factor),
        "verdict": other.verdict.id(),
        "findings": other.findings.iter().map(|one| json!({
            "effect": one.effect.id(),
            "could_also_be": one.could_also_be.iter().map(|other| other.id()).collect::<Vec<_>>(),
            "probability": one.probability,
        })).collect::<Vec<_>>(),
    })
}
