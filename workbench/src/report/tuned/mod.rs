//! What `sma tune` says.

use std::fmt::Write;

use comfy_table::{Cell, Table};
use pid_tune::{
    Agreement, BoundEnd, CostWeights, FrontPoint, LoopAnalysis, Oscillation, Outcome, Percentiles,
    PidGains, PidParams, Robustness, SecondOpinion, Sensitivity, Source, StartFrom, Terms, Tuned,
    Verdict,
};
use serde_json::{Value, json};

use super::number::{percent, significant};
use super::table::{right, table, unpadded};
use crate::rig::{BEYOND, Rig};
use crate::track::Track;

/// Rows of the front that a person reads; JSON has all.
const FRONT_ROWS: usize = 16;

/// Names of the gains.
const GAINS: [&str; 3] = ["kp", "ki", "kd"];

/// The result of `sma tune`.
#[derive(Debug)]
pub struct TunedReport<'a> {
    /// The rig.
    pub rig: &'a Rig,
    /// As the sensor reads it.
    pub set_point: f64,
    /// The controller but for its gains.
    pub pid: PidParams,
    /// Length of the response that is judged, s.
    pub duration_s: f64,
    /// Weights of the terms of the cost.
    pub weights: CostWeights,
    /// The gains that were found.
    pub found: Tuned,
    /// Where another optimizer ends.
    pub opinion: SecondOpinion,
    /// The paper's gains, those found, and where somebody else's optimizer ended.
    pub candidates: Vec<Candidate>,
    /// Whether the response to the step still oscillates in the end under the gains found, by more than 2 % of
    /// it; with the effects, if the model has any.
    pub oscillates: bool,
    /// Limit cycles of the plain part under the paper's gains and under those found.
    pub analyses: [LoopAnalysis; 2],
    /// What the gains are worth on rods as likely as the identified one; `None` if that was not asked for.
    pub robust: Option<Robustness>,
    /// What depends on which parameter.
    pub varied: Vec<Sensitivity<'a>>,
    /// Gains that no others beat in all terms.
    pub front: Vec<FrontPoint>,
    /// Responses to references.
    pub tracks: Vec<Track>,
}

/// A controller and what its response to the step costs.
#[derive(Debug, Clone, Copy)]
pub struct Candidate {
    /// Its name.
    pub name: &'static str,
    /// Its gains.
    pub gains: PidGains,
    /// Terms of the cost.
    pub terms: Terms,
    /// The cost.
    pub cost: f64,
}

/// The five terms of eq. 13 as numbers; those of a step are `NaN` where there is none.
fn values(terms: &Terms) -> [f64; 5] {
    let step = terms.step.map_or([f64::NAN; 3], |step| {
        [step.rise_time_s, step.settling_time_s, step.overshoot]
    });
    [terms.mse, terms.energy, step[0], step[1], step[2]]
}

fn weights(weights: &CostWeights) -> [f64; 5] {
    [
        weights.mse,
        weights.energy,
        weights.rise_time,
        weights.settling_time,
        weights.overshoot,
    ]
}

impl TunedReport<'_> {
    /// For people: the verdict first, then the tables.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = self.verdict();
        let front = self.front_table().map(|table| table.to_string());
        for part in [
            self.terms_table().to_string(),
            format!("{}{}", self.cycles_table(), self.margins()),
            self.tracks_table().to_string(),
            self.robust_table().to_string(),
        ]
        .into_iter()
        .chain(front)
        {
            let _ = write!(text, "\n{part}\n");
        }
        unpadded(&text)
    }

    /// The gains and what they do, in sentences.
    #[must_use]
    pub fn verdict(&self) -> String {
        let found = &self.found;
        let units = self.gain_units();
        let gains: Vec<String> = gains(&found.gains)
            .iter()
            .zip(GAINS.iter().zip(&units))
            .map(|(value, (name, unit))| format!("{name} {} {unit}", significant(*value)))
            .collect();
        let mut text = String::new();
        if !self.rig.converged {
            text +=
                "The model was NOT CONVERGED when it was identified: do not trust what follows.\n";
        }
        if self.rig.drive_max > BEYOND * self.rig.largest_drive {
            let _ = writeln!(
                text,
                "The drive may reach {} {unit}; the model was fitted to at most {} {unit}: beyond, it is a guess.",
                significant(self.rig.drive_max),
                significant(self.rig.largest_drive),
                unit = self.rig.drive_unit,
            );
        }
        let _ = writeln!(text, "{}", gains.join(", "));
        let _ = writeln!(text, "{}", self.form());
        if let Some(step) = found.terms.step {
            let left_s = self.duration_s - self.pid.dt_s;
            let within = |verb: &str, time_s: f64| {
                if time_s >= left_s {
                    format!("does not {verb} within {} s", significant(left_s))
                } else {
                    format!("{verb}s within {} s", significant(time_s))
                }
            };
            let _ = writeln!(
                text,
                "The step to {} {} {}, {} and overshoots {}.",
                significant(self.set_point),
                self.rig.output_unit,
                within("rise", step.rise_time_s),
                within("settle", step.settling_time_s),
                percent(step.overshoot)
            );
        }
        let rest = "The loop comes to rest, from cold, from hot and from near the set point.";
        if !self.rig.effects.is_empty() {
            let _ = writeln!(
                text,
                "All of it is with {}; in the end the response to the step {} 2 % of it. But limit cycles and margins \
                 are of the plain part of the model, without effects:",
                self.rig.effects.join(", "),
                if self.oscillates {
                    "OSCILLATES by more than"
                } else {
                    "does not oscillate by more than"
                }
            );
        }
        let [_, analysis] = &self.analyses;
        match largest(analysis) {
            None => text += rest,
            Some(cycle) => {
                let _ = write!(
                    text,
                    "THE LOOP CYCLES: ±{} {} peak, at {} Hz.",
                    significant(cycle.amplitude),
                    self.rig.output_unit,
                    significant(cycle.frequency_hz)
                );
            }
        }
        if let Some(Some(step)) = self.robust.map(|robust| robust.step) {
            let _ = write!(
                text,
                "\nOf {} rods as likely as the identified one, {} oscillate by more than 2 % of the step and {} do not settle.",
                self.robust.map_or(0, |robust| robust.draws),
                percent(step.oscillating_share),
                percent(step.unsettled_share)
            );
        }
        text + "\n"
    }

    /// The controller as one would write it down for firmware.
    fn form(&self) -> String {
        let sign = if self.rig.is_turned() {
            ", signs of output and reference changed"
        } else {
            ""
        };
        format!(
            "parallel form every {} s, drive 0 to {} {}, integral clamped at the limits, derivative of the measurement \
             filtered over {} s{sign}",
            significant(self.pid.dt_s),
            significant(self.rig.drive_max),
            self.rig.drive_unit,
            significant(self.pid.derivative_filter_s),
        )
    }

    /// Drive per error, per error and second, and drive seconds per error.
    fn gain_units(&self) -> [String; 3] {
        let (drive, output) = (&self.rig.drive_unit, &self.rig.output_unit);
        [
            format!("{drive}/{output}"),
            format!("{drive}/({output} s)"),
            format!("{drive} s/{output}"),
        ]
    }

    /// Terms of eq. 13, raw and weighted, a column a controller.
    #[must_use]
    pub fn terms_table(&self) -> Table {
        let mut header = vec!["", "unit"];
        header.extend(self.candidates.iter().map(|one| one.name));
        let mut table = table(header);
        let units = self.gain_units();
        for (k, name) in GAINS.iter().enumerate() {
            let mut row = vec![Cell::new(name), Cell::new(&units[k])];
            row.extend(
                self.candidates
                    .iter()
                    .map(|one| right(significant(gains(&one.gains)[k]))),
            );
            table.add_row(row);
        }
        let (drive, output) = (&self.rig.drive_unit, &self.rig.output_unit);
        let terms = [
            ("mean square error", format!("{output}²")),
            ("energy ½Σu²Δt", format!("{drive}² s")),
            ("rise time", "s".to_owned()),
            ("settling time", "s".to_owned()),
            ("overshoot", "1".to_owned()),
        ];
        let weights = weights(&self.weights);
        for (k, (name, unit)) in terms.iter().enumerate() {
            let mut row = vec![Cell::new(name), Cell::new(unit)];
            row.extend(self.candidates.iter().map(|one| {
                let value = values(&one.terms)[k];
                right(format!(
                    "{} ({})",
                    significant(value),
                    significant(weights[k] * value)
                ))
            }));
            table.add_row(row);
        }
        let mut row = vec![Cell::new("cost (weighted sum)"), Cell::new("1")];
        row.extend(
            self.candidates
                .iter()
                .map(|one| right(significant(one.cost))),
        );
        table.add_row(row);
        table
    }

    /// What was foreseen of limit cycles and what simulation says.
    #[must_use]
    pub fn cycles_table(&self) -> Table {
        let unit = &self.rig.output_unit;
        let mut table = table([
            "limit cycles",
            "start",
            "foreseen (first harmonic)",
            "simulated (first harmonic)",
            "",
        ]);
        for (name, analysis) in ["paper", "tuned"].iter().zip(&self.analyses) {
            for outcome in &analysis.outcomes {
                let foreseen = outcome.forecast.map_or("rest".to_owned(), |forecast| {
                    let source = match (forecast.source, forecast.reliable) {
                        (Source::Chatter, _) => "",
                        (Source::DescribingFunction, true) => " (describing function)",
                        (Source::DescribingFunction, false) => " (describing function, unreliable)",
                    };
                    format!(
                        "±{} {unit}, {} Hz{source}",
                        significant(forecast.amplitude),
                        significant(forecast.frequency_hz)
                    )
                });
                let simulated = outcome.oscillation.map_or("rest".to_owned(), |found| {
                    format!(
                        "±{} {unit}, {} Hz",
                        significant(found.sine_amplitude),
                        significant(found.frequency_hz)
                    )
                });
                table.add_row([
                    name,
                    start(outcome),
                    &foreseen,
                    &simulated,
                    agreement(outcome),
                ]);
            }
        }
        table
    }

    /// How near to instability the plain part is, a line each after an empty one.
    #[must_use]
    pub fn margins(&self) -> String {
        let mut text = String::new();
        for (name, analysis) in ["paper", "tuned"].iter().zip(&self.analyses) {
            if let Some(margins) = analysis.margins {
                let said = if margins.stable {
                    format!(
                        "gain margin {}, phase margin {}°, delay margin {} s, peak sensitivity {}",
                        significant(margins.gain_margin),
                        significant(margins.phase_margin_rad.to_degrees()),
                        significant(margins.delay_margin_s),
                        significant(margins.peak_sensitivity),
                    )
                } else {
                    "small swings would grow there; what becomes of them the simulations above say"
                        .to_owned()
                };
                let _ = write!(text, "\n{name}, at the steepest slope of the loop: {said}");
            }
        }
        let delay_s = self.analyses[1]
            .margins
            .map(|margins| margins.delay_margin_s);
        if delay_s.is_some_and(|delay_s| delay_s < self.pid.dt_s) {
            text += "\nThe delay margin is less than a sample: try --dead-time-samples 1, as most rigs have it.";
        }
        text
    }

    /// Errors on each reference.
    pub fn tracks_table(&self) -> Table {
        let rmse = format!("RMSE ({})", self.rig.output_unit);
        let error = format!("steady error ({})", self.rig.output_unit);
        let mut table = table(["simulated", "controller", &rmse, &error, "saturated", ""]);
        for track in &self.tracks {
            table.add_row([
                Cell::new(&track.name),
                Cell::new(track.controller),
                right(significant(track.rmse())),
                right(
                    track
                        .steady_state_error()
                        .map_or("-".to_owned(), significant),
                ),
                right(percent(track.saturated_share())),
                Cell::new(track.recorded_rmse.map_or(String::new(), |rmse| {
                    format!("recorded under its own controller: {}", significant(rmse))
                })),
            ]);
        }
        table
    }

    /// The spread over rods as likely as the identified one.
    pub fn robust_table(&self) -> Table {
        let mut table = table([
            "what the tuned gains stand",
            "rise time (s)",
            "settling time (s)",
            "overshoot",
        ]);
        if let Some((robust, step)) = self.robust.and_then(|robust| Some((robust, robust.step?))) {
            let of = |percentiles: Percentiles, shown: fn(f64) -> String| {
                right(format!(
                    "{} ({} … {})",
                    shown(percentiles.p50),
                    shown(percentiles.p5),
                    shown(percentiles.p95)
                ))
            };
            table.add_row([
                Cell::new(format!("{} draws: median (5 … 95 %)", robust.draws)),
                of(step.rise_time_s, significant),
                of(step.settling_time_s, significant),
                of(step.overshoot, percent),
            ]);
        }
        for one in &self.varied {
            let (Some(minus), Some(plus)) = (one.minus.terms.step, one.plus.terms.step) else {
                continue;
            };
            let pair = |of: fn(&pid_tune::StepTerms) -> f64, shown: fn(f64) -> String| {
                right(format!("{} / {}", shown(of(&minus)), shown(of(&plus))))
            };
            table.add_row([
                Cell::new(format!("{} -20 / +20 %", one.name)),
                pair(|step| step.rise_time_s, significant),
                pair(|step| step.settling_time_s, significant),
                pair(|step| step.overshoot, percent),
            ]);
        }
        table
    }

    /// Some controllers of the front, if it was asked for.
    #[must_use]
    pub fn front_table(&self) -> Option<Table> {
        if self.front.is_empty() {
            return None;
        }
        let mse = format!("MSE ({}²)", self.rig.output_unit);
        let energy = format!("energy ({}² s)", self.rig.drive_unit);
        let mut table = table(["kp", "ki", "kd", &mse, &energy]);
        for point in self
            .front
            .iter()
            .step_by(self.front.len().div_ceil(FRONT_ROWS))
        {
            let numbers = gains(&point.gains)
                .into_iter()
                .chain([point.terms.mse, point.terms.energy]);
            table.add_row(
                numbers
                    .map(|value| right(significant(value)))
                    .collect::<Vec<_>>(),
            );
        }
        Some(table)
    }

    /// What else is worth knowing, a line each.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let mut notes = vec![format!(
            "all of this is simulated on the model: {} s at {} s a sample, drive 0 to {} {}; {} responses, seed {}",
            significant(self.duration_s),
            significant(self.pid.dt_s),
            significant(self.rig.drive_max),
            self.rig.drive_unit,
            self.found.evaluations,
            self.found.seed
        )];
        for (name, end) in GAINS.iter().zip(self.found.at_bound) {
            if end == Some(BoundEnd::Upper) {
                notes.push(format!("{name} is the largest that was looked for"));
            }
        }
        let [from_optimum, from_elsewhere] =
            [self.opinion.from_optimum, self.opinion.from_elsewhere];
        for (opinion, start) in [(from_optimum, "there"), (from_elsewhere, "elsewhere")] {
            notes.push(format!(
                "argmin's simplex, from {start}, ends {} ({} times the cost)",
                match opinion.verdict {
                    Verdict::Agrees => "at the same cost",
                    Verdict::EndedHigher => "higher, caught on the way",
                    Verdict::EndedLower =>
                        "LOWER: the search did not find the best; try another --seed",
                },
                significant(opinion.ratio)
            ));
        }
        notes
    }

    /// The responses, a row a sample.
    #[must_use]
    pub fn responses(&self) -> String {
        let unit = &self.rig.output_unit;
        let mut text = format!("reference,controller,time_s,setpoint_{unit},output_{unit},drive\n");
        for track in &self.tracks {
            for k in 0..track.time_s.len() {
                let _ = writeln!(
                    text,
                    "{},{},{},{},{},{}",
                    track.name,
                    track.controller,
                    track.time_s[k],
                    track.setpoint[k],
                    track.output[k],
                    track.drive[k]
                );
            }
        }
        text
    }

    /// For programs.
    #[must_use]
    pub fn json(&self) -> Value {
        let [mse, energy, rise_time, settling_time, overshoot] = weights(&self.weights);
        let limit_cycles: Vec<Value> = ["paper", "tuned"]
            .iter()
            .zip(&self.analyses)
            .map(|(name, analysis)| {
                json!({
                    "controller": name,
                    "margins": analysis.margins.map(|margins| json!({
                        "stable": margins.stable,
                        "gain_margin": finite(margins.gain_margin),
                        "phase_margin_deg": finite(margins.phase_margin_rad.to_degrees()),
                        "delay_margin_s": finite(margins.delay_margin_s),
                        "peak_sensitivity": finite(margins.peak_sensitivity),
                    })),
                    "starts": analysis.outcomes.iter().map(|outcome| json!({
                        "start": start(outcome),
                        "foreseen": outcome.forecast.map(|forecast| json!({
                            "amplitude": forecast.amplitude,
                            "frequency_hz": forecast.frequency_hz,
                            "reliable": forecast.reliable,
                        })),
                        "simulated": outcome.oscillation.map(|found| json!({
                            "amplitude": found.sine_amplitude,
                            "frequency_hz": found.frequency_hz,
                        })),
                        "agreement": agreement(outcome),
                    })).collect::<Vec<_>>(),
                })
            })
            .collect();
        json!({
            "schema_version": 1,
            "command": "tune",
            "version": env!("CARGO_PKG_VERSION"),
            "seed": self.found.seed,
            "output_unit": self.rig.output_unit,
            "drive_unit": self.rig.drive_unit,
            "signs_turned": self.rig.is_turned(),
            "effects": self.rig.effects,
            "oscillates": self.oscillates,
            "set_point": self.set_point,
            "sample_time_s": self.pid.dt_s,
            "duration_s": self.duration_s,
            "drive_max": self.rig.drive_max,
            "weights": {
                "mse": mse, "energy": energy, "rise_time": rise_time,
                "settling_time": settling_time, "overshoot": overshoot,
            },
            "controllers": self.candidates.iter().map(|one| json!({
                "name": one.name,
                "gains": gains_json(&one.gains),
                "terms": terms_json(&one.terms),
                "cost": one.cost,
            })).collect::<Vec<_>>(),
            "limit_cycles": limit_cycles,
            "robustness": self.robust.map(|robust| json!({
                "draws": robust.draws,
                "mse": percentiles_json(&robust.mse),
                "energy": percentiles_json(&robust.energy),
                "rise_time_s": robust.step.map(|step| percentiles_json(&step.rise_time_s)),
                "settling_time_s": robust.step.map(|step| percentiles_json(&step.settling_time_s)),
                "overshoot": robust.step.map(|step| percentiles_json(&step.overshoot)),
                "unsettled_share": robust.step.map(|step| step.unsettled_share),
                "oscillating_share": robust.step.map(|step| step.oscillating_share),
            })),
            "sensitivities": self.varied.iter().map(|one| json!({
                "parameter": one.name,
                "minus_20_percent": terms_json(&one.minus.terms),
                "plus_20_percent": terms_json(&one.plus.terms),
            })).collect::<Vec<_>>(),
            "front": self.front.iter().map(|point| json!({
                "gains": gains_json(&point.gains),
                "mse": point.terms.mse,
                "energy": point.terms.energy,
            })).collect::<Vec<_>>(),
            "references": self.tracks.iter().map(|track| json!({
                "name": track.name,
                "controller": track.controller,
                "simulated": true,
                "rmse": track.rmse(),
                "steady_state_error": track.steady_state_error(),
                "saturated_share": track.saturated_share(),
                "recorded_rmse": track.recorded_rmse,
            })).collect::<Vec<_>>(),
        })
    }
}

fn gains(gains: &PidGains) -> [f64; 3] {
    [gains.kp, gains.ki, gains.kd]
}

fn gains_json(gains: &PidGains) -> Value {
    json!({"kp": gains.kp, "ki": gains.ki, "kd": gains.kd})
}

fn terms_json(terms: &Terms) -> Value {
    json!({
        "mse": terms.mse,
        "energy": terms.energy,
        "rise_time_s": terms.step.map(|step| step.rise_time_s),
        "settling_time_s": terms.step.map(|step| step.settling_time_s),
        "overshoot": terms.step.map(|step| step.overshoot),
    })
}

fn percentiles_json(percentiles: &Percentiles) -> Value {
    json!({"p5": percentiles.p5, "p50": percentiles.p50, "p95": percentiles.p95})
}

/// JSON knows no infinity.
fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// The largest cycle that any simulation ends in.
fn largest(analysis: &LoopAnalysis) -> Option<Oscillation> {
    analysis
        .outcomes
        .iter()
        .filter_map(|outcome| outcome.oscillation)
        .max_by(|a, b| a.amplitude.total_cmp(&b.amplitude))
}

fn start(outcome: &Outcome) -> &'static str {
    match outcome.start {
        StartFrom::Rest => "cold",
        StartFrom::Hot => "hot",
        StartFrom::Near => "near",
    }
}

fn agreement(outcome: &Outcome) -> &'static str {
    match outcome.agreement {
        Agreement::Confirmed => "confirmed",
        Agreement::Inaccurate => "cycles, but otherwise",
        Agreement::Refuted => "refuted: the simulation counts",
    }
}
