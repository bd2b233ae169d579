//! Behind the verdict: where the error lies, and what the recordings say of each effect.

use std::fmt::Write;

use comfy_table::{Cell, Table};
use missing_physics::{Candidate, Curve, Entry, Mismatch, Shape, Status, Verdict};
use sma_effects::Need;

use super::Diagnosed;
use super::findings::or_else;
use crate::report::number::{percent, significant, spoken, spoken_percent};
use crate::report::table::{folding, right, table};
use crate::report::words::block_name;

/// Regimes and stretches of time that a person reads; JSON has all.
const ROWS: usize = 5;

/// Least p that is shown as a number: fewer draws of noise were as large as can be counted.
const LEAST_P: f64 = 0.005;

/// Instructions for reading [`regimes`].
pub const HOW_TO_READ_REGIMES: &str = "Share: of the squared error on the training recordings; regimes overlap, so that shares add up to more than 100 %. \
     p: how often noise alone gathers as much in that regime.";

/// Instructions for reading [`Diagnosed::catalogue`].
pub const HOW_TO_READ_CATALOGUE: &str = "Excluded: an effect above this size would have shown (95 % confidence); a smaller one may be there. Not testable: no plausible size would show in \
     these recordings, or something is not known.";

/// The regimes in which a model errs most.
#[must_use]
pub fn regimes(mismatch: &Mismatch) -> Option<Table> {
    let mut table = table(["regime", "share of the error", "of the samples", "p"]);
    for cell in mismatch.cells.iter().take(ROWS) {
        let p = if cell.p_value <= LEAST_P {
            format!("< {LEAST_P}")
        } else {
            spoken(cell.p_value)
        };
        table.add_row([
            Cell::new(&cell.at),
            right(percent(cell.share)),
            right(percent(cell.occupancy)),
            right(p),
        ]);
    }
    (!table.is_empty()).then_some(table)
}

/// The band of frequencies with most of the error.
#[must_use]
pub fn in_frequency(mismatch: &Mismatch) -> Option<String> {
    let bands = mismatch.bands.iter();
    let band = bands.max_by(|a, b| a.share.total_cmp(&b.share))?;
    Some(format!(
        "In frequency: {} of the squared error between {} and {} Hz",
        spoken_percent(band.share),
        spoken(band.hz[0]),
        spoken(band.hz[1])
    ))
}

/// The missing term, branch by branch, as far as it is told from zero.
pub(super) fn curves(shape: &Shape) -> String {
    let mut text = format!(
        "A curve in the {} describes {} of the error above the noise; points whose interval exceeds their value are left out:\n",
        block_name(shape.block),
        spoken_percent(shape.share)
    );
    let mut table = table([shape.variable, "branch", shape.value.as_str(), "± 95 %"]);
    for Curve { heating, points } in &shape.curves {
        for [variable, value, half] in points.iter().filter(|[_, value, half]| value.abs() > *half)
        {
            table.add_row([
                right(significant(*variable)),
                Cell::new(if *heating { "heating" } else { "cooling" }),
                right(significant(*value)),
                right(significant(*half)),
            ]);
        }
    }
    if table.is_empty() {
        return String::new();
    }
    let _ = writeln!(text, "{table}");
    text
}

/// Why recordings say nothing of an effect, sizes being written by `size`.
fn why_not_testable(entry: &Entry, size: impl Fn(f64) -> String) -> String {
    let Some(least) = entry.minimum_detectable else {
        return "would leave no trace in these recordings".to_owned();
    };
    let first = entry.effect.info().parameters.first();
    if first.is_none_or(|first| least <= first.largest()) {
        return "other parameters may hide it: what they leave of its trace is less than formulas are exact to".to_owned();
    }
    let mut said = format!("would show from {} on, more than is plausible", size(least));
    if let Some(absorption) = entry.absorption {
        let _ = write!(
            said,
            "; refitting the baseline model hides {} of its trace",
            percent(absorption)
        );
    }
    said
}

impl Diagnosed<'_> {
    /// Regimes, stretches of time and frequencies of an error under a title; empty if it lies nowhere in particular.
    pub(super) fn mismatch(&self, title: &str, mismatch: &Mismatch) -> String {
        let (regimes, stretches) = (regimes(mismatch), self.stretches(mismatch));
        if mismatch.blocks.is_empty() && regimes.is_none() && stretches.is_none() {
            return String::new();
        }
        let mut text = format!("\n{title}");
        let likely: Vec<String> = mismatch
            .blocks
            .iter()
            .filter(|(_, probability)| *probability >= 0.01)
            .map(|(block, probability)| {
                format!("{} {}", block_name(*block), spoken_percent(*probability))
            })
            .collect();
        if !likely.is_empty() {
            let _ = write!(text, ": {}", likely.join(", "));
        }
        text.push('\n');
        if let Some(regimes) = regimes {
            let _ = writeln!(text, "{HOW_TO_READ_REGIMES}\n{regimes}");
        }
        if let Some(stretches) = stretches {
            let _ = writeln!(text, "\n{stretches}");
        }
        if let Some(said) = in_frequency(mismatch) {
            let _ = writeln!(text, "{said}.");
        }
        text
    }

    /// The worst stretches of time.
    #[must_use]
    pub fn stretches(&self, mismatch: &Mismatch) -> Option<Table> {
        let mut table = table(["recording", "from s", "to s", "share of the error"]);
        for span in mismatch.spans.iter().take(ROWS) {
            table.add_row([
                Cell::new(self.label(&span.recording)),
                right(significant(span.start_s)),
                right(significant(span.end_s)),
                right(percent(span.share)),
            ]);
        }
        (!table.is_empty()).then_some(table)
    }

    /// How many effects are found, possible, excluded and not testable, in a sentence.
    pub(super) fn counted(&self) -> String {
        let catalogue = &self.diagnosis.catalogue;
        let groups = [
            "detected",
            "suspected",
            "possible",
            "excluded",
            "not testable",
            "not tried",
        ];
        let said: Vec<String> = groups
            .into_iter()
            .filter_map(|group| {
                let of_group = catalogue.iter().filter(|entry| self.said(entry).0 == group);
                let n = of_group.count();
                (n > 0).then(|| format!("{n} {group}"))
            })
            .collect();
        format!(
            "Of {} effects: {}; limits with -v.",
            catalogue.len(),
            said.join(", ")
        )
    }

    /// Every effect: what the recordings say of it.
    #[must_use]
    pub fn catalogue(&self) -> Table {
        let mut table = folding(["effect", "", "what these recordings say"]);
        let mut entries: Vec<&Entry> = self.diagnosis.catalogue.iter().collect();
        // Stable: within a group the order of the catalogue stays.
        entries.sort_by_key(|entry| match entry.status {
            Status::Detected => 0,
            Status::Ambiguous => 1,
            Status::Excluded { .. } => 2,
            Status::NotTestable => 3,
            Status::Unknown { .. } => 4,
        });
        for entry in entries {
            let (group, said) = self.said(entry);
            table.add_row([entry.effect.id(), group, &said]);
        }
        table
    }

    /// True if a part of the error is left that nothing is known of: then no effect has a limit.
    fn is_open(&self) -> bool {
        matches!(
            self.diagnosis.verdict,
            Verdict::ExplainedInPart | Verdict::Unexplained
        )
    }

    fn is_suspect(&self, effect: Candidate) -> bool {
        let mut suspects = self.diagnosis.suspects.iter();
        suspects.any(|suspect| suspect.effect == effect)
    }

    /// Evidence of the recordings on an effect: its status in a word, and its size or the reason.
    fn said(&self, entry: &Entry) -> (&'static str, String) {
        if self
            .without
            .iter()
            .any(|left_out| entry.effect == *left_out)
        {
            return ("not tried", "left out by --without".to_owned());
        }
        let parameter = entry.effect.info().parameters.first();
        let size = |size: f64| match (entry.unit, parameter) {
            ("1", Some(parameter)) => format!("{} ({})", spoken(size), parameter.name),
            ("1", None) => spoken(size),
            (unit, _) => format!("{} {unit}", spoken(size)),
        };
        match entry.status {
            Status::Detected => ("detected", or_else(&self.diagnosis.findings, entry.effect)),
            Status::Ambiguous if self.is_suspect(entry.effect) => (
                "suspected",
                "reduces the error, but not enough for a finding".to_owned(),
            ),
            Status::Ambiguous => ("possible", "may be there under another name".to_owned()),
            Status::Excluded { upper } => ("excluded", format!("above {}", size(upper))),
            Status::NotTestable if self.is_open() => (
                "not testable",
                "no limit while a part of the error is unexplained".to_owned(),
            ),
            Status::NotTestable => ("not testable", why_not_testable(entry, size)),
            Status::Unknown { need } => ("not testable", format!("needs {}", self.needed(need))),
        }
    }

    /// Missing knowledge of the rig, in words.
    #[must_use]
    pub fn needed(&self, need: Need) -> String {
        match need {
            Need::AbsoluteTemperature => format!(
                "temperatures in kelvins: {} in rod.toml",
                self.missing_for_temperature.join(", ")
            ),
            Need::MassPerMeter => "diameter_mm and density_kg_per_m3 in rod.toml".to_owned(),
            Need::SurfacePerMeter => "diameter_mm in rod.toml".to_owned(),
            Need::RunLength => "a recording with time".to_owned(),
            Need::LargestDrive => "a recording that is driven".to_owned(),
            Need::ElectricalDrive => {
                "a drive that depends on the resistance, not a power".to_owned()
            }
            Need::TemperatureChannel => "a recorded temperature of the rod".to_owned(),
            Need::Load => "recordings under a second load".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use sma_effects::EffectId;

    use super::*;

    #[test]
    fn why_an_effect_is_not_testable_is_said_by_what_would_show() {
        let entry = |least: Option<f64>| Entry {
            effect: EffectId::Backlash.into(),
            status: Status::NotTestable,
            t: None,
            absorption: Some(0.998),
            minimum_detectable: least,
            unit: "of the stroke",
        };
        let said = |least: Option<f64>| why_not_testable(&entry(least), |size| format!("{size}"));
        let [_, largest] = EffectId::Backlash.info().parameters[0].bounds;
        assert!(said(None).starts_with("would leave no trace"));
        assert!(said(Some(0.5 * largest)).starts_with("other parameters may hide"));
        let more = said(Some(2.0 * largest));
        assert!(more.starts_with("would show from") && more.contains("99.8 %"));
    }
}
