//! Figures of a trial as they would be with the threshold of a rule a quarter less or more.

use missing_physics::RULES;

use crate::{CaseLine, Family, Proportion};

/// Shares that are followed.
pub const FOLLOWED: [&str; 6] = [
    "single effect in the set",
    "both of a pair in the sets",
    "clean: a wrong name",
    "outside or deleted: unexplained",
    "any case: confident wrong name",
    "misfit called adequate",
];

/// Figures as they are, and as they would be with one threshold moved.
#[derive(Debug, Clone, PartialEq)]
pub struct Margins {
    /// The shares of [`FOLLOWED`] as decided.
    pub decided: [Proportion; FOLLOWED.len()],
    /// Two an asked rule, in the order of the rules: a quarter less, then a quarter more.
    pub rows: Vec<Margin>,
}

/// Figures with the threshold of a rule moved.
#[derive(Debug, Clone, PartialEq)]
pub struct Margin {
    /// Name of the rule.
    pub rule: &'static str,
    /// Factor of its threshold; of a share or a probability above a half, of what that lacks of 1.
    pub factor: f64,
    /// Cases of which something else would be said.
    pub n_changed: usize,
    /// The shares of [`FOLLOWED`].
    pub shares: [Proportion; FOLLOWED.len()],
}

impl Margins {
    /// `None` where the diagnoses of the cases did not note what else they would have said.
    pub(super) fn of(lines: &[CaseLine]) -> Option<Self> {
        lines.iter().find(|line| line.verdict.audit.is_some())?;
        let rows = RULES.iter().flat_map(|rule| {
            [0.75, 1.25].map(|factor| {
                let moved: Vec<CaseLine> = lines
                    .iter()
                    .map(|line| otherwise(line, rule.name, factor).unwrap_or_else(|| line.clone()))
                    .collect();
                let pairs = lines.iter().zip(&moved);
                Margin {
                    rule: rule.name,
                    factor,
                    n_changed: pairs.filter(|(line, moved)| line != moved).count(),
                    shares: shares(&moved),
                }
            })
        });
        Some(Self {
            decided: shares(lines),
            rows: rows.collect(),
        })
    }
}

/// The case as it would have been decided with a threshold moved; `None` if that changes nothing.
fn otherwise(line: &CaseLine, rule: &str, factor: f64) -> Option<CaseLine> {
    let mut others = line.verdict.otherwise.iter();
    let other = others.find(|one| one.rule == rule && (one.factor - factor).abs() < 1e-9)?;
    let mut moved = line.clone();
    moved.verdict.verdict.clone_from(&other.verdict);
    moved.verdict.findings.clone_from(&other.findings);
    Some(moved)
}

fn shares(lines: &[CaseLine]) -> [Proportion; FOLLOWED.len()] {
    let of = |is_meant: &dyn Fn(&CaseLine) -> bool, is_hit: &dyn Fn(&CaseLine) -> bool| {
        let meant: Vec<&CaseLine> = lines.iter().filter(|line| is_meant(line)).collect();
        Proportion::of(&meant, |line| is_hit(line))
    };
    let seen = |line: &CaseLine, families: &[Family]| {
        families.contains(&line.case.family) && line.is_visible()
    };
    [
        of(&|line| seen(line, &[Family::Single]), &CaseLine::states_all),
        of(&|line| seen(line, &[Family::Pair]), &CaseLine::states_all),
        of(&|line| line.case.family.is_clean(), &CaseLine::is_wrong),
        of(
            &|line| seen(line, &[Family::Outside, Family::Deleted]),
            &CaseLine::is_unexplained,
        ),
        of(&|_| true, &CaseLine::is_wrong_and_sure),
        of(&CaseLine::misfits, &CaseLine::is_adequate),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Otherwise;

    #[test]
    fn a_threshold_that_costs_a_name_is_seen_in_its_row_alone() {
        let published = include_str!("../../results/cases.jsonl");
        let mut lines: Vec<CaseLine> = published
            .lines()
            .map(|line| serde_json::from_str(line).unwrap())
            .filter(|line: &CaseLine| line.case.family == Family::Single && line.is_visible())
            .take(20)
            .collect();
        assert_eq!(Margins::of(&lines), None);
        for line in &mut lines {
            line.verdict.audit = Some([0.9, 0.001]);
        }
        let right = lines.iter_mut().find(|line| line.states_all()).unwrap();
        right.verdict.otherwise = vec![Otherwise {
            rule: "set".to_owned(),
            factor: 0.75,
            verdict: "unexplained".to_owned(),
            findings: Vec::new(),
        }];
        let margins = Margins::of(&lines).unwrap();
        assert_eq!(margins.rows.len(), 2 * RULES.len());
        let [decided, ..] = margins.decided;
        for row in &margins.rows {
            let is_meant = row.rule == "set" && row.factor < 1.0;
            let lost = usize::from(is_meant);
            assert_eq!(row.n_changed, lost);
            assert_eq!(row.shares[0].hits, decided.hits - lost);
            assert_eq!(row.shares[1..], margins.decided[1..]);
        }
    }
}
