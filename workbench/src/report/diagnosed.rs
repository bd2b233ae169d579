//! Report of `sma diagnose` for people.

use std::fmt::Write;

use comfy_table::{Cell, Table};
use identify::Bounds;
use missing_physics::{
    Candidate, Curve, Diagnosis, EffectId, Entry, Finding, Mismatch, Need, NextExperiment,
    Remainder, Role, Shape, Status, Verdict,
};

use super::label::label;
use super::number::{count, percent, significant, spoken, spoken_percent};
use super::runs::runs;
use super::table::{folding, right, table, unpadded};
use super::verdict::{block_name, named, unit, verdict};
use crate::sanity::{self, Implausible};

/// Regimes and stretches of time that a person reads; JSON has all.
const ROWS: usize = 5;

/// Title of what differs from run to run.
pub const FROM_RUN_TO_RUN: &str = "From run to run, over the first";

/// The result of `sma diagnose`.
#[derive(Debug)]
pub struct Diagnosed<'a> {
    /// Result of the diagnosis.
    pub diagnosis: &'a Diagnosis,
    /// Effects that were not to be found.
    pub without: &'a [EffectId],
    /// Range of the specific heat, J/(kg K), if the intervals hold for it.
    pub specific_heat: Option<Bounds>,
    /// Range of the resistivity that stands in for the resistance, Ω m, if the intervals hold for it.
    pub resistivity: Option<Bounds>,
    /// Rule of the hysteresis' memory, as the flag names it.
    pub memory: &'static str,
    /// Keys of the rod file without which temperatures are arbitrary.
    pub missing_for_temperature: Vec<&'static str>,
    /// Why the last model cannot be, if it cannot.
    pub implausible: Vec<Implausible>,
    /// Notes on anomalies of the recordings.
    pub input_notes: Vec<String>,
}

impl Diagnosed<'_> {
    /// For people: the verdict first, then the tables.
    #[must_use]
    pub fn text(&self) -> String {
        let diagnosis = self.diagnosis;
        let mut text = self.verdict();
        if diagnosis.verdict == Verdict::NotConverged {
            return text;
        }
        let _ = write!(text, "\n{}\n", self.ladder());
        for (title, _, estimates) in found(diagnosis) {
            let _ = write!(text, "\n{title}\n{estimates}\n");
        }
        if let Some(runs) = self.runs() {
            let _ = write!(text, "\n{FROM_RUN_TO_RUN}\n{runs}\n");
        }
        let title = "Where the plain model and the recordings part";
        text += &self.mismatch(title, &diagnosis.mismatch);
        if let Some(left) = &diagnosis.remainder {
            text += &self.remainder(left);
        }
        let _ = write!(text, "\nThe catalogue\n{}\n", self.catalogue());
        if let Some(next) = &diagnosis.next_experiment {
            text += &next_experiment(next);
        }
        unpadded(&text)
    }

    /// Implausible values, then the missing effects: a few lines.
    #[must_use]
    pub fn verdict(&self) -> String {
        sanity::lines(&self.implausible) + &verdict(self.diagnosis)
    }

    /// Errors from the plain model down to the noise.
    pub fn ladder(&self) -> Table {
        let diagnosis = self.diagnosis;
        let rmse = format!("RMSE{}, training", unit(diagnosis));
        let mut table = table(["model", rmse.as_str(), "unseen, predicted", "calibrated"]);
        for rung in &diagnosis.ladder {
            let is_suspect = |one: &Finding| rung.added.contains(&one.effect);
            let name = match named(&rung.added, "and") {
                name if name.is_empty() => "plain".to_owned(),
                name if diagnosis.suspects.iter().any(is_suspect) => {
                    format!("+ {name} (suspected)")
                }
                name => format!("+ {name}"),
            };
            table.add_row([
                Cell::new(name),
                right(significant(rung.train_rmse)),
                right(rung.predicted_rmse.map_or("-".to_owned(), significant)),
                right(rung.unseen_rmse.map_or("-".to_owned(), significant)),
            ]);
        }
        let floor = diagnosis.noise_floor;
        let size = match floor.upper {
            Some(upper) => format!("{} … {}", significant(floor.lower), significant(upper)),
            None => format!("≥ {}", significant(floor.lower)),
        };
        let class = floor.class.id().replace('_', " ");
        table.add_row([
            Cell::new(format!("noise ({class})")),
            right(size),
            Cell::new(""),
            Cell::new(""),
        ]);
        table
    }

    fn mismatch(&self, title: &str, mismatch: &Mismatch) -> String {
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
            let _ = writeln!(text, "{regimes}");
        }
        if let Some(stretches) = stretches {
            let _ = writeln!(text, "\n{stretches}");
        }
        if let Some(said) = in_frequency(mismatch) {
            let _ = writeln!(text, "{said}");
        }
        text
    }

    /// Differences from run to run; `None` if all runs are taken for alike.
    #[must_use]
    pub fn runs(&self) -> Option<Table> {
        runs(self.diagnosis, |name| self.label(name))
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

    fn remainder(&self, left: &Remainder) -> String {
        let mut text = self.mismatch("What remains", &left.mismatch);
        if let Some(shape) = &left.shape {
            text += &curves(shape);
        }
        text
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

    /// Evidence of the recordings on an effect: its status in a word, and its size or the reason.
    fn said(&self, entry: &Entry) -> (&'static str, String) {
        if self
            .without
            .iter()
            .any(|left_out| entry.effect == *left_out)
        {
            return ("not tried", "left out by --without".to_owned());
        }
        let size = |size: f64| match entry.unit {
            "1" => spoken(size),
            unit => format!("{} {unit}", spoken(size)),
        };
        match entry.status {
            Status::Detected if self.diagnosis.findings.is_empty() => (
                "suspected",
                "helps, and is not licensed as a name".to_owned(),
            ),
            Status::Detected => ("detected", self.or_else(entry.effect)),
            Status::Ambiguous => ("possible", "may be there under another name".to_owned()),
            Status::Excluded { upper } => ("excluded", format!("above {}", size(upper))),
            Status::NotTestable => {
                let mut said = entry.minimum_detectable.map_or(
                    "would leave no trace in these recordings".to_owned(),
                    |least| format!("would show from {} up, more than is plausible", size(least)),
                );
                if let Some(absorption) = entry
                    .absorption
                    .filter(|_| entry.minimum_detectable.is_some())
                {
                    let _ = write!(said, "; refitting hides {} of it", percent(absorption));
                }
                ("not testable", said)
            }
            Status::Unknown { need } => ("not testable", format!("needs {}", self.needed(need))),
        }
    }

    /// Alternatives to a finding; empty if there are none.
    fn or_else(&self, effect: Candidate) -> String {
        let findings = &self.diagnosis.findings;
        let found = findings.iter().find(|one| one.effect == effect);
        let others = found.map_or(&[][..], |one| &one.could_also_be);
        if others.is_empty() {
            String::new()
        } else {
            format!(
                "or {}: these recordings cannot tell which",
                named(others, "or")
            )
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

    /// A recording's name for people.
    #[must_use]
    pub fn label<'b>(&self, name: &'b str) -> &'b str {
        let baseline = &self.diagnosis.baseline;
        let trained = baseline.fit.recordings.iter().map(|one| one.name.as_str());
        let unseen = baseline.validated.iter().map(|one| one.name.as_str());
        label(name, trained.chain(unseen))
    }

    /// Further notes, a line each.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let fit = &self.diagnosis.baseline.fit;
        let mut notes = self.input_notes.clone();
        notes.push(format!(
            "{} of {} independent starts of the plain model ended here; {} simulations, seed {}",
            fit.agreeing_starts,
            fit.starts,
            count(self.diagnosis.simulations as usize),
            self.diagnosis.seed,
        ));
        if let Some(range) = self.specific_heat {
            notes.push(format!(
                "the intervals of what scales with the specific heat hold for {} to {} J/(kg K)",
                significant(range.lower),
                significant(range.upper)
            ));
        }
        if let Some(range) = self.resistivity {
            notes.push(format!(
                "rod.toml does not give resistance_ohm_per_m: what is counted in watts holds for {} to {} µΩ m",
                significant(1e6 * range.lower),
                significant(1e6 * range.upper)
            ));
        }
        if !self.missing_for_temperature.is_empty() {
            notes.push(format!(
                "temperatures are arbitrary, only ratios of their differences mean anything: rod.toml does not give {}",
                self.missing_for_temperature.join(", ")
            ));
        }
        notes
    }
}

/// The regimes in which a model errs most.
#[must_use]
pub fn regimes(mismatch: &Mismatch) -> Option<Table> {
    let mut table = table(["regime", "share of the error", "of the samples", "p"]);
    for cell in mismatch.cells.iter().take(ROWS) {
        table.add_row([
            Cell::new(&cell.at),
            right(percent(cell.share)),
            right(percent(cell.occupancy)),
            right(spoken(cell.p_value)),
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
        "In frequency: {} of it between {} and {} Hz",
        spoken_percent(band.share),
        spoken(band.hz[0]),
        spoken(band.hz[1])
    ))
}

/// Findings and suspects, as far as there are any: title, effects, table of their parameters.
pub fn found(diagnosis: &Diagnosis) -> impl Iterator<Item = (&str, &[Finding], Table)> {
    let suspects = "Suspects: they help, and are no findings";
    [
        ("What is missing", &diagnosis.findings, true),
        // No probability: it is against the rest of the catalogue, which does not account for the misfit.
        (suspects, &diagnosis.suspects, false),
    ]
    .into_iter()
    .filter(|(_, findings, _)| !findings.is_empty())
    .map(|(title, findings, sure)| (title, &findings[..], estimates(findings, sure)))
}

/// Effects with their parameters, a row a parameter.
fn estimates(findings: &[Finding], with_probability: bool) -> Table {
    let mut header = vec![
        "effect",
        "probability",
        "parameter",
        "value",
        "95 % interval",
        "unit",
        "literature",
        "plausible",
    ];
    if !with_probability {
        header.remove(1);
    }
    let mut table = table(header);
    for finding in findings {
        for (k, one) in finding.parameters.iter().enumerate() {
            let [effect, probability, plausible] = if k == 0 {
                let plausible = if finding.plausible { "yes" } else { "NO" };
                [
                    finding.effect.id(),
                    &spoken_percent(finding.probability),
                    plausible,
                ]
                .map(ToOwned::to_owned)
            } else {
                ["", "", ""].map(ToOwned::to_owned)
            };
            let range = |ends: Option<[f64; 2]>, none: &str, shown: fn(f64) -> String| {
                ends.map_or(none.to_owned(), |ends| ends.map(shown).join(" … "))
            };
            let mut row = vec![
                Cell::new(effect),
                right(probability),
                Cell::new(one.name),
                right(significant(one.value)),
                Cell::new(range(one.ci95, "not fixed", significant)),
                Cell::new(one.unit),
                Cell::new(range(one.literature, "", spoken)),
                Cell::new(plausible),
            ];
            if !with_probability {
                row.remove(1);
            }
            table.add_row(row);
        }
    }
    table
}

/// The missing term, branch by branch.
fn curves(shape: &Shape) -> String {
    let mut text = format!(
        "A curve in the {} describes {} of what could be explained:\n",
        block_name(shape.block),
        spoken_percent(shape.share)
    );
    let mut table = table([shape.variable, "branch", shape.value.as_str(), "± 95 %"]);
    for Curve { heating, points } in &shape.curves {
        for [variable, value, half] in points {
            table.add_row([
                right(significant(*variable)),
                Cell::new(if *heating { "heating" } else { "cooling" }),
                right(significant(*value)),
                right(significant(*half)),
            ]);
        }
    }
    let _ = writeln!(text, "{table}");
    text
}

/// The run that would tell more.
fn next_experiment(next: &NextExperiment) -> String {
    let mut text = format!(
        "\nNext experiment: tells {}\n",
        named(&next.separates, "from")
    );
    if let Some(run) = &next.run {
        let highest = run.drive.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let _ = writeln!(
            text,
            " {}: {} s, drive up to {}; the explanations lie {} standard deviations apart, {} in a repetition of the \
             training; look at {} to {} s\n --save-next FILE writes it, ready to play",
            run.name,
            significant(run.duration_s()),
            significant(highest),
            spoken(run.separation),
            spoken(run.separation_now),
            significant(run.dt_s * run.decisive.start as f64),
            significant(run.dt_s * run.decisive.end as f64),
        );
    }
    text
}

/// Range in the literature of the first size that has one.
#[must_use]
pub fn literature(finding: &Finding) -> Option<[f64; 2]> {
    let parameters = finding
        .effect
        .info()
        .parameters
        .iter()
        .zip(&finding.parameters);
    parameters
        .filter(|(info, _)| info.role == Role::Size)
        .find_map(|(_, estimate)| estimate.literature)
}
