//! Report of `sma diagnose`: text for people, JSON for programs.
//!
//! The order is that in which a reader asks: the verdict; what was found, how surely and why; the error before and after;
//! what is left, and whether it repeats; what to record next. The evidence behind it is [`Depth::Evidence`].

mod details;
mod findings;
mod headline;
mod json;
mod left;
mod otherwise;
mod runs;
mod traces;

use std::fmt::Write;

use comfy_table::Table;
use identify::Bounds;
use missing_physics::{Diagnosis, LoopFamily, NextExperiment, Part, RuleId, Verdict};
use sma_effects::EffectId;

pub use details::{HOW_TO_READ_CATALOGUE, HOW_TO_READ_REGIMES, in_frequency, regimes};
pub use findings::{found, literature, what};
pub use headline::{headline, unit};

use super::label::label;
use super::number::{count, significant};
use super::repeated;
use super::table::unpadded;
use super::words::{full_stop, wrapped};
use crate::sanity::{self, Implausible};

/// Title of the differences from run to run.
pub const FROM_RUN_TO_RUN: &str = "Differences from run to run, relative to the first";

/// Title of the place of the error.
pub const WHERE: &str = "Where the error of the baseline model lies";

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

/// How much a report says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Depth {
    /// The verdict and its reasons: a page of a terminal.
    Verdict,
    /// The evidence as well: parameters, regimes, catalogue, curves.
    Evidence,
}

impl Diagnosed<'_> {
    /// For people, in lines of 100 columns.
    #[must_use]
    pub fn text(&self, depth: Depth) -> String {
        let diagnosis = self.diagnosis;
        let mut text = lines(&self.first_lines());
        if diagnosis.verdict == Verdict::NotConverged {
            return text;
        }
        let found = self.what_was_found();
        if !found.is_empty() {
            let _ = write!(text, "\n{}", lines(&found));
        }
        let _ = write!(
            text,
            "\n{}\n{}\n\n{}",
            left::ladder(diagnosis),
            wrapped(left::how_to_read_ladder(diagnosis)),
            lines(&self.what_is_left())
        );
        if depth == Depth::Evidence {
            text += &self.evidence();
        } else {
            text += &lines(&[self.counted()]);
        }
        unpadded(&text)
    }

    /// The verdict and its reasons, a paragraph a line: the top of a page.
    #[must_use]
    pub fn verdict(&self) -> String {
        let mut lines = self.first_lines();
        if self.diagnosis.verdict != Verdict::NotConverged {
            lines.extend(self.what_was_found());
            lines.extend(self.what_is_left());
        }
        lines.join("\n") + "\n"
    }

    /// Implausible values, then the headline.
    fn first_lines(&self) -> Vec<String> {
        let implausible = sanity::lines(&self.implausible);
        let implausible = implausible.lines().map(ToOwned::to_owned);
        let headline = [headline(self.diagnosis)];
        implausible
            .chain(headline)
            .chain(self.other_minima())
            .chain(self.cut_short())
            .collect()
    }

    /// Doubt of the baseline model's own error, in a sentence; `None` if its starts agree.
    fn other_minima(&self) -> Option<String> {
        let diagnosis = self.diagnosis;
        let is_open = !diagnosis.baseline.fit.converged();
        let extended = diagnosis.extended.as_ref();
        let is_another =
            extended.is_some_and(|one| one.model.loop_family() != LoopFamily::Proximity);
        (is_open && is_another).then(|| {
            "No two starts of the baseline model end at one minimum, so its error may be smaller than stated. With a loop \
             of another family they do."
                .to_owned()
        })
    }

    /// Parts of the search that were left out, in a sentence; `None` if it went to its end.
    fn cut_short(&self) -> Option<String> {
        let parts = self.diagnosis.left_out.iter().map(|part| match part {
            Part::OtherLoops => "loops of other families",
            Part::MoreEffects => "further effects beside those found, and others in their place",
            Part::OtherStarts => "other starting points of the chosen model",
            Part::NextRun => "a run that would tell rivals apart",
        });
        let parts: Vec<&str> = parts.collect();
        (!parts.is_empty()).then(|| {
            format!(
                "CUT SHORT, as --effort or --time-limit-s asked. Not searched to the end: {}.",
                parts.join("; ")
            )
        })
    }

    fn what_was_found(&self) -> Vec<String> {
        let mut lines = findings::findings(self.diagnosis);
        lines.extend(findings::suspects(self.diagnosis));
        if lines.is_empty() && self.diagnosis.verdict == Verdict::Unexplained {
            lines.push("No effect of the catalogue reduces the error significantly.".to_owned());
        }
        lines
    }

    fn what_is_left(&self) -> Vec<String> {
        let diagnosis = self.diagnosis;
        let repeats = diagnosis.repeats.as_ref().and_then(repeated::said);
        let next = diagnosis.next_experiment.as_ref();
        let mut lines: Vec<String> = left::explained(diagnosis).into_iter().collect();
        lines.extend(left::noise(diagnosis));
        lines.extend(left::rest(diagnosis));
        lines.extend(repeats);
        lines.extend(runs::said(diagnosis));
        lines.extend(next.map(next_experiment));
        lines
    }

    fn evidence(&self) -> String {
        let diagnosis = self.diagnosis;
        let mut text = String::new();
        for (title, _, estimates) in found(diagnosis) {
            let _ = write!(text, "\n{title}\n{estimates}\n");
        }
        if let Some(runs) = self.runs() {
            let _ = write!(text, "\n{FROM_RUN_TO_RUN}\n{runs}\n");
        }
        text += &self.mismatch(WHERE, &diagnosis.mismatch);
        if let Some(left) = &diagnosis.remainder {
            text += &self.mismatch("Where the rest of the error lies", &left.mismatch);
            if let Some(shape) = &left.shape {
                text += &details::curves(shape);
            }
        }
        let _ = write!(
            text,
            "\nThe catalogue\n{HOW_TO_READ_CATALOGUE}\n{}\n",
            self.catalogue()
        );
        if let Some(others) = otherwise::table(diagnosis) {
            let _ = write!(text, "\n{}\n{others}\n", otherwise::HOW_TO_READ);
        }
        text
    }

    /// Errors from the baseline model down to the noise.
    #[must_use]
    pub fn ladder(&self) -> Table {
        left::ladder(self.diagnosis)
    }

    /// Instructions for reading [`Self::ladder`].
    #[must_use]
    pub fn how_to_read_ladder(&self) -> &'static str {
        left::how_to_read_ladder(self.diagnosis)
    }

    /// Differences from run to run; `None` if all runs are taken for alike.
    #[must_use]
    pub fn runs(&self) -> Option<Table> {
        runs::runs(self.diagnosis, |name| self.label(name))
    }

    /// A recording's name for people.
    #[must_use]
    pub fn label<'b>(&self, name: &'b str) -> &'b str {
        let baseline = &self.diagnosis.baseline;
        let trained = baseline.fit.recordings.iter().map(|one| one.name.as_str());
        let unseen = baseline.validated.iter().map(|one| one.name.as_str());
        label(name, trained.chain(unseen))
    }

    /// True if the model describes the recordings: if not, drive and output do not belong together, or the rig is another one.
    #[must_use]
    pub fn describes(&self) -> bool {
        self.diagnosis.verdict != Verdict::Unexplained
            || traces::failed(self.diagnosis, RuleId::Describes).is_none()
    }

    /// Further notes, a line each.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let fit = &self.diagnosis.baseline.fit;
        let mut notes = self.input_notes.clone();
        notes.push(format!(
            "{} of {} independent starts of the baseline model ended here; {} simulations, seed {}",
            fit.agreeing_starts,
            fit.starts,
            count(self.diagnosis.simulations.total() as usize),
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

/// Paragraphs, each from a new line on.
fn lines(paragraphs: &[String]) -> String {
    paragraphs
        .iter()
        .map(|paragraph| wrapped(paragraph) + "\n")
        .collect()
}

/// The run that would tell more.
fn next_experiment(next: &NextExperiment) -> String {
    let mut text = format!("Next: {}", full_stop(&next.sentence));
    if let Some(run) = &next.run {
        let [from, to] = [run.decisive.start, run.decisive.end].map(|k| run.dt_s * k as f64);
        // Writing to a string does not fail.
        let _ = write!(
            text,
            " Look at {} to {} s of it.",
            significant(from),
            significant(to)
        );
    }
    text
}
