//! A controller for programs.

use pid_tune::{
    Agreement, AntiWindup, DerivativeOf, Margins, Outcome, Passage, Percentiles, PidGains,
    StartFrom, Terms,
};
use serde_json::{Value, json};

use super::{Candidate, MISSES, TunedReport, weights};
use crate::Rest;

impl TunedReport<'_> {
    /// For programs.
    #[must_use]
    pub fn json(&self) -> Value {
        let [mse, energy, rise_time, settling_time, overshoot] = weights(&self.weights);
        let limit_cycles: Vec<Value> = self
            .compared()
            .iter()
            .zip(self.analyses.iter().zip(&self.rests))
            .map(|(name, (analysis, rests))| {
                json!({
                    "controller": name,
                    "ends": rests.iter().map(rest_json).collect::<Vec<_>>(),
                    "plain_part": analysis.outcomes.iter().map(outcome_json).collect::<Vec<_>>(),
                })
            })
            .collect();
        let opinions = [self.opinion.from_optimum, self.opinion.from_elsewhere];
        let second_opinion = opinions.map(|one| {
            json!({
                "start": gains_json(&one.start),
                "gains": gains_json(&one.gains),
                "cost": (one.ratio < MISSES).then_some(one.cost),
                "ratio": finite(one.ratio).filter(|ratio| *ratio < MISSES),
            })
        });
        let mut document = json!({
            "schema_version": 1,
            "command": "tune",
            "version": env!("CARGO_PKG_VERSION"),
            "seed": self.found.seed,
            "output_unit": self.rig.output_unit,
            "drive_unit": self.rig.drive_unit,
            "signs_turned": self.rig.is_turned(),
            "effects": self.rig.effects,
            "sensor": {
                "step": self.sensor.step,
                "noise": self.sensor.noise,
                "correlation_s": self.sensor.correlation_s,
            },
            "supply": {
                "step": self.resolution.step.unwrap_or(0.0),
                "dead_zone": self.resolution.dead_zone.unwrap_or(0.0),
            },
            "dead_time_samples": self.dead_time_samples,
            "controller": {
                "anti_windup": match self.pid.anti_windup {
                    AntiWindup::Off => "off",
                    AntiWindup::Clamping => "clamping",
                    AntiWindup::BackCalculation { .. } => "back-calculation",
                },
                "derivative_of": match self.pid.derivative_of {
                    DerivativeOf::Measurement => "measurement",
                    DerivativeOf::Error => "error",
                },
                "derivative_filter_s": self.pid.derivative_filter_s,
                "setpoint_weight": self.pid.setpoint_weight,
                "feed_forward": self.feed_forward,
            },
            "requirements": self.requirements.map(|required| json!({
                "gain_margin": required.gain_margin,
                "phase_margin_deg": required.phase_margin_rad.to_degrees(),
                "sensor_step": required.sensor_step,
                "largest_kick": required.largest_kick,
            })),
            "rods": self.n_rods,
            "rests_on_rods": self.found.rest_on,
            "lowest_cost": self.found.lowest,
            "set_point": self.set_point,
            "sample_time_s": self.pid.dt_s,
            "duration_s": self.duration_s,
            "drive_max": self.rig.drive_max,
            "weights": {
                "mse": mse, "energy": energy, "rise_time": rise_time,
                "settling_time": settling_time, "overshoot": overshoot, "wear": self.wear,
            },
            "controllers": self.candidates.iter().map(candidate_json).collect::<Vec<_>>(),
            "second_opinion": second_opinion,
            "checked": self.checked.as_ref().map(|checked| json!({
                "recording": checked.name,
                "as_promised": checked.kept.is_kept(),
                "inside_share": checked.kept.inside_share,
                "rmse": checked.kept.rmse,
                "expected_rmse": checked.kept.expected_rmse,
                "farthest_off_at_s": checked.kept.worst.map(|(at_s, _)| at_s),
            })),
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
                "restless_share": self.restless_share,
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
        });
        self.put_schedules(&mut document);
        document
    }
}

fn candidate_json(one: &Candidate) -> Value {
    json!({
        "name": one.name,
        "gains": gains_json(&one.gains),
        "terms": terms_json(&one.terms),
        "cost": one.cost,
        "margins": one.margins.as_ref().map(margins_json),
        "noise_gain": one.passage.and_then(|passage| finite(passage.noise_gain)),
        "bandwidth_hz": one.passage.and_then(bandwidth),
        "kick": one.kick,
        "drive_travel_per_s": one.ending.travel_per_s,
    })
}

fn bandwidth(passage: Passage) -> Option<f64> {
    finite(passage.bandwidth_hz)
}

fn margins_json(margins: &Margins) -> Value {
    json!({
        "stable": margins.stable,
        "gain_margin": finite(margins.gain_margin),
        "phase_margin_deg": finite(margins.phase_margin_rad.to_degrees()),
        "delay_margin_s": finite(margins.delay_margin_s),
        "peak_sensitivity": finite(margins.peak_sensitivity),
    })
}

fn rest_json(rest: &Rest) -> Value {
    json!({
        "start": rest.side.name(),
        "end": rest.end.name(),
        "mean_error": rest.mean_error,
        "output_swing": rest.output_swing,
        "drive_swing": rest.drive_swing,
    })
}

fn outcome_json(outcome: &Outcome) -> Value {
    json!({
        "start": match outcome.start {
            StartFrom::Rest => "cold",
            StartFrom::Hot => "hot",
            StartFrom::Near => "near",
        },
        "foreseen": outcome.forecast.map(|forecast| json!({
            "amplitude": forecast.amplitude,
            "frequency_hz": forecast.frequency_hz,
            "reliable": forecast.reliable,
        })),
        "simulated": outcome.oscillation.map(|found| json!({
            "amplitude": found.sine_amplitude,
            "frequency_hz": found.frequency_hz,
        })),
        "agreement": match outcome.agreement {
            Agreement::Confirmed => "confirmed",
            Agreement::Inaccurate => "inaccurate",
            Agreement::Refuted => "refuted",
        },
    })
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
