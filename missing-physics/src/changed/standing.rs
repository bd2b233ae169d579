//! Why a change that was considered is named, or is not.

use crate::changed::change::{Change, ChangeVerdict, LEAST_EXCESS, LEAST_UNCHANGED};

/// Standing of one considered change in the answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// It is the finding.
    Named,
    /// It is one of the alternatives that these runs do not tell from the finding.
    CouldAlsoBe,
    /// It is another parameter of what is named.
    PartOfNamed,
    /// Likelier changes hold the probability already.
    LessLikely,
    /// No change keeps too much probability for any name.
    NoChangeIsLikely,
    /// Runs of the reference that were left out leave as much without it.
    WithinReference,
    /// It is the likeliest, and the runs leave too much beside it.
    LeavesTooMuch,
    /// The reference is too short for any name.
    ReferenceTooShort,
}

impl Change {
    /// Standing of each of the changes that were considered, in their order.
    #[must_use]
    pub fn standings(&self) -> Vec<Standing> {
        (0..self.considered.len())
            .map(|place| self.standing(place))
            .collect()
    }

    fn standing(&self, place: usize) -> Standing {
        let what = self.considered[place].what;
        match (self.verdict, &self.finding) {
            (ChangeVerdict::ReferenceTooShort, _) => Standing::ReferenceTooShort,
            (ChangeVerdict::Changed, Some(_)) if place == 0 => Standing::Named,
            (ChangeVerdict::Changed, Some(finding)) => {
                let is_alternative = finding.could_also_be.contains(&what);
                if what.id() == finding.leading.what.id() {
                    Standing::PartOfNamed
                } else if is_alternative {
                    Standing::CouldAlsoBe
                } else {
                    Standing::LessLikely
                }
            }
            _ if self.unchanged >= LEAST_UNCHANGED => Standing::NoChangeIsLikely,
            _ if self.excess[0] <= LEAST_EXCESS => Standing::WithinReference,
            _ if place == 0 => Standing::LeavesTooMuch,
            _ => Standing::LessLikely,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::changed::change::{Changed, Changing, Considered};

    fn change(verdict: ChangeVerdict, unchanged: f64) -> Change {
        let one = |law| Considered {
            what: Changing::Law(law),
            parameter: law,
            unit: "1".to_owned(),
            change: 1.0,
            ci95: None,
            probability: 0.3,
            nats: 3.0,
        };
        let considered: Vec<_> = ["tau_s", "zeta", "gain"].map(one).to_vec();
        Change {
            verdict,
            finding: (verdict == ChangeVerdict::Changed).then(|| Changed {
                leading: considered[0].clone(),
                could_also_be: vec![considered[1].what],
            }),
            considered,
            unchanged,
            coolings: 4,
            left_out: Vec::new(),
            laws: Vec::new(),
            runs: Vec::new(),
            excess: [1.5, 1.0],
            share_compared: 1.0,
            output_unit: "mm".to_owned(),
        }
    }

    #[test]
    fn every_considered_change_has_a_reason() {
        use Standing::{
            CouldAlsoBe, LeavesTooMuch, LessLikely, Named, NoChangeIsLikely, ReferenceTooShort,
            WithinReference,
        };
        let as_before = Change {
            excess: [0.9, 0.8],
            ..change(ChangeVerdict::Unchanged, 0.01)
        };
        assert_eq!(as_before.standings(), [WithinReference; 3]);
        let of = |verdict, unchanged| change(verdict, unchanged).standings();
        assert_eq!(
            of(ChangeVerdict::Changed, 0.01),
            [Named, CouldAlsoBe, LessLikely]
        );
        assert_eq!(of(ChangeVerdict::Unchanged, 0.6), [NoChangeIsLikely; 3]);
        assert_eq!(of(ChangeVerdict::Unexplained, 0.6), [NoChangeIsLikely; 3]);
        assert_eq!(
            of(ChangeVerdict::Unexplained, 0.01),
            [LeavesTooMuch, LessLikely, LessLikely]
        );
        assert_eq!(
            of(ChangeVerdict::ReferenceTooShort, 0.01),
            [ReferenceTooShort; 3]
        );
    }
}
