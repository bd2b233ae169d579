use std::collections::{BTreeMap, BTreeSet};

use sma_effects::EffectId;

use crate::{CaseLine, Family};

/// Verdicts that stand for no name.
const WITHOUT_A_NAME: [&str; 3] = ["unexplained", "adequate", "not_converged"];

/// Which name each visible single effect was given.
#[derive(Debug, Clone, PartialEq)]
pub struct Confusion {
    /// Concealed effects, in the order of the catalogue.
    pub rows: Vec<String>,
    /// Strongest names, in the order of the catalogue, then verdicts without a name.
    pub columns: Vec<String>,
    /// Cases: a row an effect, a column a name.
    pub counts: Vec<Vec<usize>>,
}

impl Confusion {
    pub(super) fn of(lines: &[CaseLine]) -> Self {
        let mut counts: BTreeMap<(&str, &str), usize> = BTreeMap::new();
        let singles = lines
            .iter()
            .filter(|line| line.case.family == Family::Single && line.is_visible());
        for line in singles {
            let name = line.top().unwrap_or(&line.verdict.verdict);
            *counts.entry((line.truth(), name)).or_default() += 1;
        }
        let used = |of: fn(&(&str, &str)) -> String| -> BTreeSet<String> {
            counts.keys().map(of).collect()
        };
        let rows = in_order(&used(|(truth, _)| (*truth).to_owned()));
        let columns = in_order(&used(|(_, name)| (*name).to_owned()));
        let count = |row: &str, column: &str| counts.get(&(row, column)).copied().unwrap_or(0);
        Self {
            counts: rows
                .iter()
                .map(|row| columns.iter().map(|column| count(row, column)).collect())
                .collect(),
            rows,
            columns,
        }
    }
}

/// The used names, in the order of the catalogue, verdicts last.
fn in_order(used: &BTreeSet<String>) -> Vec<String> {
    let effects = EffectId::ALL.into_iter().map(|effect| effect.id());
    effects
        .chain(WITHOUT_A_NAME)
        .filter(|id| used.contains(*id))
        .map(str::to_owned)
        .collect()
}
