//! Predictions of residuals by a curve without physics, by what is concealed.

use std::collections::BTreeMap;

use missing_physics::RuleId;

use super::figure::median;
use super::view::VISIBLE_T;
use crate::{CaseLine, Proportion};

/// Predictions in cases of one kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Audited {
    /// Concealed additions, or the noise where nothing is concealed.
    pub kind: String,
    /// Of the baseline model's residual.
    pub baseline: Predicted,
    /// Of the residual of the model with what was found, where something was.
    pub extended: Predicted,
}

/// Predictions of residuals by a curve, on blocks that it has not seen.
#[derive(Debug, Clone, PartialEq)]
pub struct Predicted {
    /// Median of the share of the residual's square; `None` without a case.
    pub share: Option<f64>,
    /// Cases in which that is beyond chance, by the rule `predicted`.
    pub beyond_chance: Proportion,
}

/// Audits by kind, in the order of their names; nothing where no diagnosis noted them.
pub(super) fn audits(lines: &[CaseLine]) -> Vec<Audited> {
    let mut kinds: BTreeMap<String, Vec<&CaseLine>> = BTreeMap::new();
    for line in lines.iter().filter(|line| line.verdict.audit.is_some()) {
        kinds.entry(kind(line)).or_default().push(line);
    }
    let audited = kinds.into_iter().map(|(kind, lines)| Audited {
        kind,
        baseline: predicted(lines.iter().filter_map(|line| line.verdict.audit)),
        extended: predicted(
            lines
                .iter()
                .filter_map(|line| line.verdict.audit_of_extended),
        ),
    });
    audited.collect()
}

fn kind(line: &CaseLine) -> String {
    let answer = &line.opened.answer;
    let concealed: Vec<&str> = answer
        .concealed
        .iter()
        .map(|one| one.addition.as_str())
        .collect();
    if concealed.is_empty() {
        return format!("nothing, {} noise", answer.noise);
    }
    let oracles = &line.opened.oracles;
    let is_hidden = !oracles.is_empty() && oracles.iter().all(|oracle| oracle.t < VISIBLE_T);
    let hidden = if is_hidden { ", not visible" } else { "" };
    format!("{}{hidden}", concealed.join(" + "))
}

fn predicted(audits: impl Iterator<Item = [f64; 2]>) -> Predicted {
    let audits: Vec<[f64; 2]> = audits.collect();
    let shares = audits.iter().map(|[share, _]| *share).collect();
    let predicted = RuleId::Predicted.rule();
    Predicted {
        share: median(shares, "").value(),
        beyond_chance: Proportion::of(&audits, |[_, p_value]| predicted.passes(*p_value)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_predicted_is_told_by_what_is_concealed() {
        let published = include_str!("../../results/cases.jsonl");
        let of = |number: usize| -> CaseLine {
            serde_json::from_str(published.lines().nth(number).unwrap()).unwrap()
        };
        let mut lines = vec![of(0), of(0), of(0)];
        assert_eq!(audits(&lines), []);
        for (line, share) in lines.iter_mut().zip([0.1, 0.5, 0.3]) {
            line.verdict.audit = Some([share, 0.02 - 0.1 * (share - 0.3)]);
        }
        let [audited] = &audits(&lines)[..] else {
            panic!("one kind");
        };
        assert!(audited.kind.starts_with("nothing, "), "{}", audited.kind);
        assert_eq!(audited.baseline.share, Some(0.3));
        assert_eq!(audited.baseline.beyond_chance, Proportion { hits: 1, n: 3 });
        assert_eq!(audited.extended.beyond_chance.n, 0);
    }
}
