use super::VISIBLE_T;
use crate::{CaseLine, Family};

/// Outcome of each single effect, size by size: it shows which effects an experiment can reveal.
#[derive(Debug, Clone, PartialEq)]
pub struct Reach {
    /// One an addition, in the order of the cases.
    pub rows: Vec<Reached>,
}

/// Outcome of one addition.
#[derive(Debug, Clone, PartialEq)]
pub struct Reached {
    /// Concealed addition.
    pub addition: String,
    /// Its name in the catalogue.
    pub effect: String,
    /// Sizes over the usual one with the outcome of each, the smallest first.
    pub sizes: Vec<(f64, Became)>,
}

/// Outcome of a concealed effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Became {
    /// Nobody could have seen it.
    Hidden,
    /// It could be seen, and was not found.
    Missed,
    /// It was found to help, without a name.
    Suspected,
    /// It is one of several that would do as well.
    InSet,
    /// It alone was named.
    Named,
}

impl Became {
    /// In words.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Hidden => "not visible",
            Self::Missed => "missed",
            Self::Suspected => "suspected",
            Self::InSet => "one of a set",
            Self::Named => "named",
        }
    }
}

impl Reach {
    pub(super) fn of(lines: &[CaseLine]) -> Self {
        let mut rows: Vec<Reached> = Vec::new();
        for line in lines
            .iter()
            .filter(|line| line.case.family == Family::Single)
        {
            let (Some(concealed), Some(oracle)) = (
                line.opened.answer.concealed.first(),
                line.opened.oracles.first(),
            ) else {
                continue;
            };
            let Some(effect) = &concealed.effect else {
                continue;
            };
            let became = became(line, effect, oracle.t);
            let row = rows
                .iter()
                .position(|row| row.addition == concealed.addition);
            let row = row.unwrap_or_else(|| {
                rows.push(Reached {
                    addition: concealed.addition.clone(),
                    effect: effect.clone(),
                    sizes: Vec::new(),
                });
                rows.len() - 1
            });
            rows[row].sizes.push((concealed.size, became));
        }
        for row in &mut rows {
            row.sizes.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        Self { rows }
    }
}

fn became(line: &CaseLine, effect: &str, t: f64) -> Became {
    let findings = &line.verdict.findings;
    let set = findings.iter().find(|one| one.set().any(|id| id == effect));
    match set {
        Some(finding) if finding.could_also_be.is_empty() => Became::Named,
        Some(_) => Became::InSet,
        None if line.verdict.suspects.iter().any(|id| id == effect) => Became::Suspected,
        None if t < VISIBLE_T => Became::Hidden,
        None => Became::Missed,
    }
}
