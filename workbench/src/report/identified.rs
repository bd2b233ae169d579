//! Report of `sma identify`: text for people, JSON for programs.

use std::fmt::Write;

use comfy_table::{Cell, Table};
use identify::{
    Bounds, CrossCheck, CrossVerdict, Fit, FittedParameter, OffsetSource, OneWay, ParameterState,
    Scope, ThermalModel, Validated,
};
use serde_json::{Value, json};

use super::label::label;
use super::number::{behind, count, percent, significant};
use super::table::{right, table, unpadded};
use crate::sanity::{self, Implausible};

/// Unseen error over training error from which the text says that the model leaves something out:
/// twice is more than a few parameters fitted to thousands of samples explain.
const SUSPICIOUS_RATIO: f64 = 2.0;

/// The result of `sma identify`.
#[derive(Debug)]
pub struct Identified<'a> {
    /// The fit.
    pub fit: &'a Fit,
    /// Results of the model on the validation recordings, which are not in the fit.
    pub validated: &'a [Validated],
    /// Which of them hold the data of a training recording.
    pub seen: Vec<bool>,
    /// Why the model cannot be, if it cannot.
    pub implausible: Vec<Implausible>,
    /// Where argmin ended, if it was asked.
    pub cross_check: Option<&'a CrossCheck>,
    /// Keys of the rod file without which temperatures are arbitrary.
    pub missing_for_temperature: Vec<&'static str>,
    /// True if temperatures are in kelvins.
    pub knows_temperature: bool,
    /// Families of loops for which the intervals hold beside the paper's, where the recordings have one rate only.
    pub other_loops: Option<Vec<&'static str>>,
    /// Range of the specific heat, J/(kg K), if the intervals hold for it.
    pub specific_heat: Option<Bounds>,
    /// True if the model is a static loop, without a heat balance.
    pub is_static: bool,
    /// The model, if it is a heat balance without a loop.
    pub thermal: Option<&'a ThermalModel>,
    /// The one way that the input of a loop goes, if it goes one way.
    pub one_way: Option<OneWay>,
    /// Rule of the hysteresis' memory, as the flag names it.
    pub memory: &'static str,
    /// Notes on anomalies of the recordings.
    pub input_notes: Vec<String>,
}

impl Identified<'_> {
    /// Root mean square over all unseen samples; `None` if there are none.
    fn validate_rmse(&self) -> Option<f64> {
        let pairs = self.validated.iter().zip(&self.seen);
        let unseen = pairs.filter(|(_, seen)| !**seen).map(|(one, _)| one);
        Validated::rmse_of_all(unseen)
    }

    /// Unit of the output behind a number: nothing where it has none.
    fn unit(&self) -> String {
        behind(&self.fit.output_unit)
    }

    /// For people: the verdict first, then the tables.
    #[must_use]
    pub fn text(&self) -> String {
        let text = format!(
            "{}\n{}\n\n{}\n",
            self.verdict(),
            self.parameters(),
            self.recordings()
        );
        unpadded(&text)
    }

    /// How near the model comes, in a sentence or two.
    #[must_use]
    pub fn verdict(&self) -> String {
        let (fit, unit) = (self.fit, self.unit());
        let mut text = self.warnings();
        let _ = write!(
            text,
            "The model meets the training recordings to {}{unit} RMS (fit {})",
            significant(fit.train_rmse),
            percent(fit.fit_fraction),
        );
        match self.validate_rmse() {
            None if !self.validated.is_empty() => text.push_str(
                ".\nWhat was given as unseen is training data: this is not yet a test.\n",
            ),
            None => text.push_str(
                ".\nNo unseen recording was given (--validate): this is not yet a test.\n",
            ),
            Some(rmse) => {
                let _ = writeln!(
                    text,
                    "\nand what it has not seen to {}{unit} RMS.",
                    significant(rmse)
                );
                let ratio = rmse / fit.train_rmse;
                if ratio >= SUSPICIOUS_RATIO {
                    let _ = writeln!(
                        text,
                        "The unseen error is {ratio:.1} times the training error: the model leaves something out."
                    );
                }
            }
        }
        if self.thermal.is_some() {
            text.push_str(
                "The output is the temperature: this is the heat balance alone. Of the loop it says nothing.\n",
            );
        }
        if let Some(families) = &self.other_loops {
            text.push_str(
                "ONE RATE: the drive rises to one level at one rate, so that the time constant and the loop trade against one \
                 another",
            );
            if families.is_empty() {
                text.push_str("; loops of other families come less near");
            } else {
                let _ = write!(
                    text,
                    ";\nthe intervals hold for loops of other families, too, which come as near: {}",
                    families.join(", ")
                );
            }
            text.push_str(". Record another rate, and fit both together.\n");
        }
        if let Some(check) = self.cross_check {
            let _ = writeln!(text, "{}", self.checked(check));
        }
        text
    }

    /// Why not to believe what follows.
    fn warnings(&self) -> String {
        let fit = self.fit;
        let mut text = String::new();
        if !fit.converged() {
            text.push_str("NOT CONVERGED: do not trust these values. ");
            let _ = if fit.termination.is_minimum() {
                writeln!(
                    text,
                    "No two starts ended in the same place; try --starts {}.",
                    4 * fit.starts
                )
            } else {
                writeln!(
                    text,
                    "The search ended before it found a minimum; try another --seed."
                )
            };
        }
        let held: Vec<String> = fit
            .held_by_bounds()
            .map(|one| {
                let value = significant(one.values[0]);
                format!("{} {value}{}", one.info.name, behind(&one.info.unit))
            })
            .collect();
        if !held.is_empty() {
            let _ = writeln!(
                text,
                "NOT CONVERGED: on a bound of the search: {}. The recordings pull it further, or say nothing of it.",
                held.join(", ")
            );
        }
        for beyond in &fit.beyond_reach {
            let (name, side, of) = if beyond.is_heating {
                ("heating", "above", "highest")
            } else {
                ("cooling", "below", "lowest")
            };
            let _ = writeln!(
                text,
                "NOT CONVERGED: the {name} branch of the loop, at {:.1} °C, lies {side} all temperatures reached \
                 ({of}: {:.1} °C). These recordings do not tell where it is, nor how wide the loop is.",
                beyond.branch_degc, beyond.reached_degc
            );
        }
        sanity::lines(&self.implausible) + &text
    }

    /// Meaning of the point where argmin ended.
    fn checked(&self, check: &CrossCheck) -> String {
        let place: Vec<String> = check
            .shared
            .iter()
            .filter(|(name, ..)| *name != "gain")
            .map(|(name, value, _)| format!("{name} {}", significant(*value)))
            .collect();
        let (rmse, unit) = (significant(check.rmse), self.unit());
        match check.verdict {
            CrossVerdict::Agrees => {
                format!("argmin, from its own start, ends at the same floor: {rmse}{unit}.")
            }
            CrossVerdict::EndedHigher => format!(
                "argmin, from its own start, ends higher: {rmse}{unit}, at {}. It was caught on the way; that \
                 says nothing against the fit.",
                place.join(", ")
            ),
            CrossVerdict::EndedLower => format!(
                "argmin, from its own start, ends lower: {rmse}{unit}, at {}. The fit is not the lowest minimum; \
                 try --starts {}.",
                place.join(", "),
                4 * self.fit.starts
            ),
        }
    }

    /// Values and intervals.
    pub fn parameters(&self) -> Table {
        let mut table = table(["parameter", "value", "95 % interval", "unit", ""]);
        for parameter in self.fit.parameters.iter().filter(|one| !is_rest(one)) {
            for (r, value) in parameter.values.iter().enumerate() {
                let name = match parameter.info.scope {
                    Scope::Shared => parameter.info.name.to_owned(),
                    Scope::PerRecording => {
                        format!(
                            "{} ({})",
                            parameter.info.name,
                            self.label(&self.fit.recordings[r].name)
                        )
                    }
                };
                let of_branch = self.one_way.and_then(|way| of_branch(parameter, way));
                let note = match (of_branch, parameter.info.state) {
                    (Some(OfBranch::Undetermined(why) | OfBranch::Its(why)), _) => why,
                    (None, ParameterState::Fixed(_)) => "fixed",
                    (None, ParameterState::Free) if parameter.at_bound => "at its bound",
                    (None, ParameterState::Free) => "",
                };
                let is_told = !matches!(of_branch, Some(OfBranch::Undetermined(_)));
                table.add_row([
                    Cell::new(name),
                    right(if is_told {
                        significant(*value)
                    } else {
                        String::new()
                    }),
                    Cell::new(parameter.intervals[r].map_or(String::new(), interval)),
                    Cell::new(&parameter.info.unit),
                    Cell::new(note),
                ]);
            }
        }
        table
    }

    /// The last part of a recording's path, or all of it where two would look alike.
    #[must_use]
    pub fn label<'b>(&self, name: &'b str) -> &'b str {
        let trained = self.fit.recordings.iter().map(|one| one.name.as_str());
        let names = trained.chain(self.validated.iter().map(|one| one.name.as_str()));
        label(name, names)
    }

    /// How near the model comes to each recording.
    #[must_use]
    pub fn recordings(&self) -> Table {
        let rmse = format!("RMSE{}", self.unit());
        let mut table = table(["recording", "role", "samples", &rmse, "of range", ""]);
        for one in &self.fit.recordings {
            table.add_row([
                Cell::new(self.label(&one.name)),
                Cell::new("training"),
                right(count(one.n_samples)),
                right(significant(one.rmse)),
                right(of_range(one.rmse, one.output_range)),
                Cell::new(""),
            ]);
        }
        for (one, seen) in self.validated.iter().zip(&self.seen) {
            table.add_row([
                Cell::new(self.label(&one.name)),
                Cell::new(if *seen { "trained on" } else { "unseen" }),
                right(count(one.n_samples)),
                right(significant(one.rmse)),
                right(of_range(one.rmse, one.output_range)),
                Cell::new(match self.thermal {
                    Some(_) => own_note(one.offset_source).to_owned(),
                    None => offset_note(one.offset_source),
                }),
            ]);
        }
        table
    }

    /// Further notes, a line each.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let fit = self.fit;
        let mut notes = vec![
            "fit is 1 - RMSE / standard deviation of the recording".to_owned(),
            format!(
                "{} of {} independent starts ended here; {} simulations, seed {}",
                fit.agreeing_starts,
                fit.starts,
                count(fit.simulations as usize),
                fit.seed,
            ),
            format!(
                "neighboring residuals correlate by {:.2}: {} samples count as {}, and the intervals allow for that",
                fit.noise.lag_1,
                count(fit.noise.n_samples),
                count(fit.noise.n_effective as usize),
            ),
        ];
        if let Some(rmse_k) = fit.temperature_rmse_k {
            notes.push(format!(
                "the recorded temperature is met to {} K RMS",
                significant(rmse_k)
            ));
        }
        notes.extend(
            fit.unfixed
                .iter()
                .map(|direction| format!("not fixed by these data: {direction}")),
        );
        if let Some(range) = self.specific_heat {
            notes.push(format!(
                "the intervals of temperatures hold for a specific heat of {} to {} J/(kg K)",
                significant(range.lower),
                significant(range.upper)
            ));
        }
        notes.extend(self.of_temperature());
        notes.extend(self.input_notes.iter().cloned());
        notes
    }

    /// Notes on temperatures: their scale, or that it is arbitrary, and the limits of the model.
    fn of_temperature(&self) -> Vec<String> {
        let fit = self.fit;
        if self.is_static {
            let without_time = "without time only the loop is identified: no time constant, and nothing of what follows from it; \
                                `sma diagnose` says what else these recordings tell";
            let one_way = self.one_way.map(|way| one_way_note(way).to_owned());
            return one_way
                .into_iter()
                .chain([without_time.to_owned()])
                .collect();
        }
        let mut notes = Vec::new();
        if let Some(thermal) = self.thermal {
            notes.extend(thermal_notes(thermal, fit, &self.missing_for_temperature));
        }
        notes.push(if self.knows_temperature {
            let peak = fit.recordings.iter().map(|one| one.peak_temperature_degc);
            format!(
                "the model's rod reaches {:.0} °C; if that is absurd, look at what rod.toml says of it",
                peak.fold(f64::NEG_INFINITY, f64::max)
            )
        } else {
            let why = if self.missing_for_temperature.is_empty() {
                "the paper leaves their scale open".to_owned()
            } else {
                format!(
                    "rod.toml does not give {}",
                    self.missing_for_temperature.join(", ")
                )
            };
            format!(
                "temperatures are arbitrary, only ratios of their differences mean anything: {why}"
            )
        });
        notes
    }

    /// For programs: DESIGN's `fit` and `parameters`.
    pub fn json(&self) -> Value {
        let trained = self.fit.recordings.iter().map(|one| {
            json!({"name": one.name, "role": "train", "n_samples": one.n_samples, "rmse": one.rmse})
        });
        let unseen = self.validated.iter().zip(&self.seen).map(|(one, seen)| {
            json!({
                "name": one.name,
                "role": "validate",
                "is_training_data": seen,
                "n_samples": one.n_samples,
                "rmse": one.rmse,
                "fit_percent": one.fit_fraction.map(|fraction| 100.0 * fraction),
                "offset": self.thermal.is_none().then_some(one.offset),
                "offset_from": match one.offset_source {
                    OffsetSource::BeforeDrive { .. } => "before_drive",
                    OffsetSource::WholeRecording { .. } => "whole_recording",
                    OffsetSource::NeverDriven => "never_driven",
                },
            })
        });
        json!({
            "schema_version": 1,
            "command": "identify",
            "version": env!("CARGO_PKG_VERSION"),
            "seed": self.fit.seed,
            "output_unit": self.fit.output_unit,
            "fit": {
                "train_rmse": self.fit.train_rmse,
                "validate_rmse": self.validate_rmse(),
                "fit_percent": 100.0 * self.fit.fit_fraction,
                "converged": self.fit.is_found(),
                "held_by_bounds": self.fit.held_by_bounds().map(|one| one.info.name).collect::<Vec<_>>(),
                "beyond_reach": self.fit.beyond_reach.iter().map(|one| json!({
                    "branch": if one.is_heating { "heating" } else { "cooling" },
                    "branch_degc": one.branch_degc,
                    "reached_degc": one.reached_degc,
                })).collect::<Vec<_>>(),
                "agreeing_starts": self.fit.agreeing_starts,
                "starts": self.fit.starts,
                "simulations": self.fit.simulations,
                "aic": self.fit.aic,
                "bic": self.fit.bic,
                "temperature_rmse_k": self.fit.temperature_rmse_k,
                "termination": format!("{:?}", self.fit.termination),
            },
            "implausible": sanity::to_json(&self.implausible),
            "residuals": {
                "lag_1": self.fit.noise.lag_1,
                "ar_coefficients": self.fit.noise.coefficients,
                "n_effective": self.fit.noise.n_effective,
            },
            "correlation": {
                "names": self.fit.covariance.names,
                "matrix": self.fit.covariance.correlation(),
            },
            "not_fixed": self.fit.unfixed.iter().map(ToString::to_string).collect::<Vec<_>>(),
            "cross_check": self.cross_check.map(|check| json!({
                "rmse": check.rmse,
                "cost_ratio": check.ratio,
                "verdict": match check.verdict {
                    CrossVerdict::Agrees => "agrees",
                    CrossVerdict::EndedHigher => "ended_higher",
                    CrossVerdict::EndedLower => "ended_lower",
                },
                "simulations": check.simulations,
            })),
            "other_loops_carried": self.other_loops,
            "specific_heat_range_carried": self.specific_heat.map(|range| [range.lower, range.upper]),
            "temperature_scale": if self.knows_temperature { "known" } else { "assumed" },
            "memory": self.thermal.is_none().then_some(self.memory),
            "input_notes": self.input_notes,
            "parameters": self.parameters_json(),
            "recordings": trained.chain(unseen).collect::<Vec<_>>(),
        })
    }
}

impl Identified<'_> {
    /// The parameters for programs: those that one branch does not tell have no values, and say why.
    fn parameters_json(&self) -> Vec<Value> {
        let mut parameters = parameters_json(self.fit);
        let Some(way) = self.one_way else {
            return parameters;
        };
        for (json, parameter) in parameters.iter_mut().zip(&self.fit.parameters) {
            match of_branch(parameter, way) {
                Some(OfBranch::Undetermined(why)) => {
                    json["values"] = json!([null]);
                    json["not_determined"] = json!(why);
                }
                Some(OfBranch::Its(of)) => json["note"] = json!(of),
                None => {}
            }
        }
        parameters
    }
}

/// Information that one branch of a loop gives on a parameter.
#[derive(Debug, Clone, Copy)]
enum OfBranch {
    /// Nothing, and why.
    Undetermined(&'static str),
    /// The value of this branch.
    Its(&'static str),
}

/// Information on a parameter if the input goes one way only; `None` for a parameter that this does not affect.
fn of_branch(parameter: &FittedParameter, way: OneWay) -> Option<OfBranch> {
    let (missing, branch) = match way {
        OneWay::Heating => ("not determined: no cooling", "of the heating branch"),
        OneWay::Cooling => ("not determined: no heating", "of the cooling branch"),
    };
    match parameter.info.name {
        "loop_half_width_k" | "loop_half_width" | "zeta" => Some(OfBranch::Undetermined(missing)),
        "loop_center_degc" | "loop_center" => Some(OfBranch::Its(branch)),
        _ => None,
    }
}

fn one_way_note(way: OneWay) -> &'static str {
    match way {
        OneWay::Heating => {
            "the input only rises: one branch of the loop is seen; neither its half width nor its center apart from that branch can be told; record the cooling"
        }
        OneWay::Cooling => {
            "the input only falls: one branch of the loop is seen; neither its half width nor its center apart from that branch can be told; record the heating"
        }
    }
}

/// The parameters of a fit for programs.
#[must_use]
pub fn parameters_json(fit: &Fit) -> Vec<Value> {
    fit.parameters
        .iter()
        .map(|parameter| {
            json!({
                "name": parameter.info.name,
                "unit": parameter.info.unit,
                "values": parameter.values,
                "ci95": parameter.intervals.iter().map(|one| one.map(|one| [one.lower, one.upper])).collect::<Vec<_>>(),
                "per_recording": parameter.info.scope == Scope::PerRecording,
                "fixed": matches!(parameter.info.state, ParameterState::Fixed(_)),
                "at_bound": parameter.at_bound,
            })
        })
        .collect()
}

/// True if a parameter only says that the recordings start at rest.
fn is_rest(parameter: &FittedParameter) -> bool {
    parameter.info.scope == Scope::PerRecording
        && matches!(parameter.info.state, ParameterState::Fixed(_))
}

/// Nothing for an output that never changes.
fn of_range(rmse: f64, range: f64) -> String {
    if range > 0.0 {
        percent(rmse / range)
    } else {
        String::new()
    }
}

fn interval(interval: Bounds) -> String {
    format!(
        "{} … {}",
        significant(interval.lower),
        significant(interval.upper)
    )
}

fn offset_note(source: OffsetSource) -> String {
    match source {
        OffsetSource::BeforeDrive { n_samples } => {
            format!(
                "offset from the {} samples before the drive rises",
                count(n_samples)
            )
        }
        OffsetSource::WholeRecording { at_rest } => {
            format!(
                "offset from the whole recording: only {at_rest} samples before the drive rises"
            )
        }
        OffsetSource::NeverDriven => "never driven: tests nothing".to_owned(),
    }
}

/// Where the start and the surroundings of an unseen recording were read.
fn own_note(source: OffsetSource) -> &'static str {
    match source {
        OffsetSource::BeforeDrive { .. } => {
            "its own values from the samples before the drive rises"
        }
        OffsetSource::WholeRecording { .. } => "its own values from the whole recording",
        OffsetSource::NeverDriven => "never driven: tests nothing",
    }
}

/// Notes on a heat balance: results and limits.
fn thermal_notes(thermal: &ThermalModel, fit: &Fit, missing: &[&str]) -> Vec<String> {
    let is_free = |name: &str| {
        let parameter = fit.parameter(name);
        parameter.is_some_and(|one| one.info.state == ParameterState::Free)
    };
    let mut notes = Vec::new();
    if is_free("ambient_degc") {
        notes.push(
            "nothing states the temperature of the surroundings: it is found from each recording; ambient_degc in [surroundings] or a column would state it"
                .to_owned(),
        );
    }
    if is_free("ambient_level_k") {
        notes.push(
            "at rest the rod is not as warm as the stated surroundings: ambient_level_k is the difference"
                .to_owned(),
        );
    }
    let seconds = |name: &str| fit.parameter(name).map_or(f64::NAN, |one| one.values[0]);
    notes.push(match (thermal.has_lag(), thermal.tells_which_lags()) {
        (false, _) => "no lag of the sensor shows".to_owned(),
        (true, true) => {
            "the sensor lags: the steady rise tells its time constant from the rod's".to_owned()
        }
        (true, false) => format!(
            "two time constants show, in a row, together {} s: these data do not tell which is the sensor's; the longer is called the rod's",
            significant(seconds("tau_s") + seconds(ThermalModel::LAG))
        ),
    });
    if !thermal.tells_which_lags() {
        notes.push(format!(
            "watts are not told, only the steady rise per unit of drive: rod.toml does not give {}",
            missing.join(", ")
        ));
    }
    notes
}
