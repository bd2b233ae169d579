//! What `sma identify` says.

use std::fmt::Write;

use comfy_table::{Cell, CellAlignment, Table, TableComponent, presets};
use identify::{Fit, OffsetSource, ParameterState, Scope, Validated};
use serde_json::{Value, json};

use super::number::{count, percent, significant};

/// Unseen error over training error from which the text says that the model leaves something out:
/// twice is more than a few parameters fitted to thousands of samples explain.
const SUSPICIOUS_RATIO: f64 = 2.0;

/// The result of `sma identify`.
#[derive(Debug)]
pub(crate) struct Identified<'a> {
    pub(crate) fit: &'a Fit,
    pub(crate) validated: &'a [Validated],
    pub(crate) output_unit: &'a str,
    pub(crate) knows_temperature: bool,
    pub(crate) seed: u64,
}

impl Identified<'_> {
    /// Root mean square over all unseen samples; `None` if there are none.
    fn validate_rmse(&self) -> Option<f64> {
        let n: usize = self.validated.iter().map(|one| one.n_samples).sum();
        let sum: f64 = self
            .validated
            .iter()
            .map(|one| one.rmse * one.rmse * one.n_samples as f64)
            .sum();
        (n > 0).then(|| (sum / n as f64).sqrt())
    }

    /// For people: the verdict first, then the tables.
    pub(crate) fn text(&self) -> String {
        let mut text = self.verdict();
        let _ = write!(text, "\n{}\n\n{}\n", self.parameters(), self.recordings());
        for note in self.notes() {
            let _ = write!(text, "\n{note}");
        }
        text.push('\n');
        // Tables pad their last column.
        text.lines()
            .map(|line| line.trim_end().to_owned() + "\n")
            .collect()
    }

    fn verdict(&self) -> String {
        let unit = self.output_unit;
        let mut text = format!(
            "The model meets the training recordings to {} {unit} RMS ({} of the motion)",
            significant(self.fit.train_rmse),
            percent(self.fit.fit_fraction),
        );
        match self.validate_rmse() {
            None => text.push_str(
                ".\nNo unseen recording was given (--validate): this is not yet a test.\n",
            ),
            Some(rmse) => {
                let _ = writeln!(
                    text,
                    "\nand what it has not seen to {} {unit} RMS.",
                    significant(rmse)
                );
                let ratio = rmse / self.fit.train_rmse;
                if ratio >= SUSPICIOUS_RATIO {
                    let _ = writeln!(
                        text,
                        "The unseen error is {ratio:.1} times the training error: the model leaves something out."
                    );
                }
            }
        }
        text
    }

    fn parameters(&self) -> Table {
        let mut table = table(["parameter", "value", "unit", ""]);
        for parameter in &self.fit.parameters {
            for (r, value) in parameter.values.iter().enumerate() {
                let name = match parameter.info.scope {
                    Scope::Shared => parameter.info.name.to_owned(),
                    Scope::PerRecording => {
                        format!(
                            "{} ({})",
                            parameter.info.name,
                            short(&self.fit.recordings[r].name)
                        )
                    }
                };
                let note = match parameter.info.state {
                    ParameterState::Fixed(_) => "fixed",
                    ParameterState::Free if parameter.at_bound => "at its bound",
                    ParameterState::Free => "",
                };
                table.add_row([
                    Cell::new(name),
                    right(significant(*value)),
                    Cell::new(&parameter.info.unit),
                    Cell::new(note),
                ]);
            }
        }
        table
    }

    fn recordings(&self) -> Table {
        let rmse = format!("RMSE ({})", self.output_unit);
        let mut table = table(["recording", "role", "samples", &rmse, ""]);
        for one in &self.fit.recordings {
            table.add_row([
                Cell::new(short(&one.name)),
                Cell::new("training"),
                right(count(one.n_samples)),
                right(significant(one.rmse)),
                Cell::new(""),
            ]);
        }
        for one in self.validated {
            table.add_row([
                Cell::new(short(&one.name)),
                Cell::new("unseen"),
                right(count(one.n_samples)),
                right(significant(one.rmse)),
                Cell::new(offset_note(one.offset_source)),
            ]);
        }
        table
    }

    fn notes(&self) -> Vec<String> {
        let fit = self.fit;
        let mut notes = vec![format!(
            "{} of {} independent starts ended here; {} simulations, seed {}.",
            fit.agreeing_starts,
            fit.starts,
            count(fit.simulations as usize),
            self.seed,
        )];
        if !self.knows_temperature {
            notes.push(
                "Temperatures are in arbitrary units: heat capacity or resistance of the rod is not given, so \
                 only ratios of temperature differences mean anything."
                    .to_owned(),
            );
        }
        if !fit.termination.is_minimum() {
            notes.push("The search did not converge: do not trust these values.".to_owned());
        }
        notes
    }

    /// For programs: DESIGN's `fit` and `parameters`.
    pub(crate) fn json(&self) -> Value {
        let parameters: Vec<Value> = self
            .fit
            .parameters
            .iter()
            .map(|parameter| {
                json!({
                    "name": parameter.info.name,
                    "unit": parameter.info.unit,
                    "values": parameter.values,
                    "per_recording": parameter.info.scope == Scope::PerRecording,
                    "fixed": matches!(parameter.info.state, ParameterState::Fixed(_)),
                    "at_bound": parameter.at_bound,
                })
            })
            .collect();
        let trained = self.fit.recordings.iter().map(|one| {
            json!({"name": one.name, "role": "train", "n_samples": one.n_samples, "rmse": one.rmse})
        });
        let unseen = self.validated.iter().map(|one| {
            json!({
                "name": one.name,
                "role": "validate",
                "n_samples": one.n_samples,
                "rmse": one.rmse,
                "fit_percent": 100.0 * one.fit_fraction,
                "offset": one.offset,
                "offset_from": match one.offset_source {
                    OffsetSource::BeforeDrive { .. } => "before_drive",
                    OffsetSource::WholeRecording => "whole_recording",
                },
            })
        });
        json!({
            "schema_version": 1,
            "command": "identify",
            "version": env!("CARGO_PKG_VERSION"),
            "seed": self.seed,
            "output_unit": self.output_unit,
            "fit": {
                "train_rmse": self.fit.train_rmse,
                "validate_rmse": self.validate_rmse(),
                "fit_percent": 100.0 * self.fit.fit_fraction,
                "converged": self.fit.termination.is_minimum(),
                "agreeing_starts": self.fit.agreeing_starts,
                "starts": self.fit.starts,
                "simulations": self.fit.simulations,
            },
            "parameters": parameters,
            "recordings": trained.chain(unseen).collect::<Vec<_>>(),
        })
    }
}

fn offset_note(source: OffsetSource) -> String {
    match source {
        OffsetSource::BeforeDrive { n_samples } => {
            format!(
                "offset from the {} samples before the drive rises",
                count(n_samples)
            )
        }
        OffsetSource::WholeRecording => {
            "offset from the whole recording: the drive rises at once".to_owned()
        }
    }
}

fn table<const N: usize>(header: [&str; N]) -> Table {
    let mut table = Table::new();
    table
        .load_preset(presets::NOTHING)
        .set_style(TableComponent::HeaderLines, '─')
        .set_header(header);
    table
}

fn right(text: String) -> Cell {
    Cell::new(text).set_alignment(CellAlignment::Right)
}

/// The last part of a path.
fn short(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or(name)
}
