//! Common traits of a fleet: verdicts, physics, and how parameters spread.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::{FleetReport, Row};
use crate::report::number::{behind, spoken};

/// An effect, in how many rigs.
#[derive(Debug, Clone, PartialEq)]
pub struct InRigs {
    /// Id of the effect.
    pub effect: String,
    /// Rigs in which it is the only name of a finding.
    pub named: usize,
    /// Rigs in which it is one of several names that cannot be told apart.
    pub ambiguous: usize,
    /// Spread of its size over the rigs where it is the only name.
    pub size: Option<Spread>,
}

/// Spread of a quantity over rigs.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    /// Name of the quantity.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Rigs that have it.
    pub n_rigs: usize,
    /// The lowest value.
    pub lowest: f64,
    /// The median; of an even number the mean of the two in the middle.
    pub median: f64,
    /// The highest value.
    pub highest: f64,
}

impl FleetReport<'_> {
    /// Verdicts and how many rigs have each, the most frequent first.
    #[must_use]
    pub fn verdicts(&self) -> Vec<(&str, usize)> {
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for verdict in self.rows.iter().filter_map(|row| row.verdict.as_deref()) {
            *counts.entry(verdict).or_default() += 1;
        }
        let mut counts: Vec<(&str, usize)> = counts.into_iter().collect();
        counts.sort_by_key(|(_, n_rigs)| std::cmp::Reverse(*n_rigs));
        counts
    }

    /// Effects that were found in rigs whose result is to be used, the most frequent first.
    #[must_use]
    pub fn physics(&self) -> Vec<InRigs> {
        let mut physics: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
        for found in self.sound().flat_map(|row| &row.findings) {
            let counts = physics.entry(&found.effect).or_default();
            if found.could_also_be.is_empty() {
                counts.0 += 1;
            } else {
                counts.1 += 1;
            }
            for other in &found.could_also_be {
                physics.entry(other).or_default().1 += 1;
            }
        }
        let mut physics: Vec<InRigs> = physics
            .into_iter()
            .map(|(effect, (named, ambiguous))| InRigs {
                effect: effect.to_owned(),
                named,
                ambiguous,
                size: self.size_of(effect),
            })
            .collect();
        physics.sort_by_key(|one| std::cmp::Reverse((one.named, one.ambiguous)));
        physics
    }

    /// Parameters over the rigs whose result is to be used, in the order in which rigs have them.
    #[must_use]
    pub fn spreads(&self) -> Vec<Spread> {
        self.parameter_names()
            .into_iter()
            .filter_map(|(name, unit)| {
                let of_rig = |row: &Row| {
                    let mut own = row.parameters.iter();
                    own.find(|one| one.name == name && one.unit == unit)
                        .map(|one| one.value)
                };
                let values = self.sound().filter_map(of_rig).collect();
                Spread::of(name, unit, values)
            })
            .collect()
    }

    /// Names and units of the parameters that rigs have.
    pub(super) fn parameter_names(&self) -> Vec<(&str, &str)> {
        let mut names = Vec::new();
        for one in self.rows.iter().flat_map(|row| &row.parameters) {
            let key = (one.name.as_str(), one.unit.as_str());
            if !names.contains(&key) {
                names.push(key);
            }
        }
        names
    }

    fn size_of(&self, effect: &str) -> Option<Spread> {
        let findings = self.sound().flat_map(|row| &row.findings);
        let sizes: Vec<_> = findings
            .filter(|found| found.effect == effect && found.could_also_be.is_empty())
            .filter_map(|found| found.parameters.first())
            .collect();
        let first = sizes.first()?;
        // Outputs of other units have sizes of other units.
        let alike = sizes
            .iter()
            .filter(|one| one.name == first.name && one.unit == first.unit);
        Spread::of(
            &first.name,
            &first.unit,
            alike.map(|one| one.value).collect(),
        )
    }
}

impl InRigs {
    pub(super) fn json(&self) -> Value {
        json!({
            "effect": self.effect,
            "rigs": self.named,
            "rigs_ambiguous": self.ambiguous,
            "size": self.size.as_ref().map(Spread::json),
        })
    }
}

impl Spread {
    fn of(name: &str, unit: &str, mut values: Vec<f64>) -> Option<Self> {
        values.sort_by(f64::total_cmp);
        let (&lowest, &highest) = (values.first()?, values.last()?);
        let n_rigs = values.len();
        Some(Self {
            name: name.to_owned(),
            unit: unit.to_owned(),
            n_rigs,
            lowest,
            median: 0.5 * (values[(n_rigs - 1) / 2] + values[n_rigs / 2]),
            highest,
        })
    }

    /// The spread in words.
    #[must_use]
    pub fn said(&self) -> String {
        let [lowest, median, highest] = [self.lowest, self.median, self.highest].map(spoken);
        format!("{lowest} … {median} … {highest}{}", behind(&self.unit))
    }

    pub(super) fn json(&self) -> Value {
        json!({
            "name": self.name,
            "unit": self.unit,
            "rigs": self.n_rigs,
            "lowest": self.lowest,
            "median": self.median,
            "highest": self.highest,
        })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may end in a panic")]
mod tests {
    use super::*;

    #[test]
    fn the_median_of_an_even_number_lies_between_the_two_in_the_middle() {
        let spread = |values: &[f64]| Spread::of("tau_s", "s", values.to_vec());
        assert_eq!(spread(&[]), None);
        let odd = spread(&[3.0, 1.0, 2.0]).unwrap();
        assert_eq!(odd.said(), "1.0 … 2.0 … 3.0 s");
        let even = spread(&[4.0, 1.0, 2.0, 3.0]).unwrap();
        assert_eq!(even.said(), "1.0 … 2.5 … 4.0 s");
    }
}
