//! The row of one rig.

use serde_json::{Value, json};

use crate::fleet::{Failure, Unit};

/// State of a rig.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RowStatus {
    /// There is a result.
    Done,
    /// Its input is refused, or the program crashed on it; the same again would fail again.
    Failed,
    /// There is no result yet: another call runs it.
    Open,
}

impl RowStatus {
    /// Name in tables and documents.
    #[must_use]
    pub fn id(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Failed => "failed",
            Self::Open => "open",
        }
    }
}

/// A rig and its result.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Name of the rig.
    pub rig: String,
    /// Name of its unit; `None` if its files cannot be read.
    pub unit: Option<String>,
    /// State of the rig.
    pub status: RowStatus,
    /// Exit code of the command; `None` if it was not run or crashed.
    pub exit_code: Option<i32>,
    /// Reason for there being no result.
    pub failure: Option<Failure>,
    /// Verdict of the diagnosis; of an identification `identified` or `not_converged`.
    pub verdict: Option<String>,
    /// Rules that say that no rig can be like that.
    pub implausible: Vec<String>,
    /// Missing physics.
    pub findings: Vec<Found>,
    /// Unit of the output and of all errors.
    pub output_unit: Option<String>,
    /// RMS error of the baseline model on the training recordings.
    pub train_rmse: Option<f64>,
    /// That on the unseen ones.
    pub validate_rmse: Option<f64>,
    /// RMS error on the training recordings of the model with what was found.
    pub extended_train_rmse: Option<f64>,
    /// That on the unseen ones.
    pub extended_validate_rmse: Option<f64>,
    /// Noise of the output, at least.
    pub noise_lower: Option<f64>,
    /// Noise of the output, at most.
    pub noise_upper: Option<f64>,
    /// Parameters that recordings share and that were not fixed, of the baseline model and of what was found.
    pub parameters: Vec<Estimated>,
}

/// A value with its interval.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimated {
    /// Name, with its unit.
    pub name: String,
    /// The value.
    pub value: f64,
    /// Its 95 % interval, where there is one.
    pub ci95: Option<[f64; 2]>,
    /// Its unit.
    pub unit: String,
}

/// An effect that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Id of the effect.
    pub effect: String,
    /// Effects that it could be instead.
    pub could_also_be: Vec<String>,
    /// Probability of the name.
    pub probability: Option<f64>,
    /// Its parameters, the size first.
    pub parameters: Vec<Estimated>,
}

impl Row {
    /// Row of a rig whose unit has a result.
    #[must_use]
    pub fn of(rig: &str, name: &str, unit: &Unit) -> Self {
        let result = &unit.result;
        let is_diagnosis = unit.task.command == "diagnose";
        let plain = if is_diagnosis {
            &result["baseline"]
        } else {
            &result["fit"]
        };
        let extended = &result["extended"];
        let verdict = match (is_diagnosis, unit.failure.is_some()) {
            (_, true) => None,
            (true, false) => text(&result["verdict"]),
            (false, false) => Some(match result["fit"]["converged"].as_bool() {
                Some(true) => "identified".to_owned(),
                _ => "not_converged".to_owned(),
            }),
        };
        let findings = each(&result["findings"], finding);
        Self {
            rig: rig.to_owned(),
            unit: Some(name.to_owned()),
            status: if unit.failure.is_some() {
                RowStatus::Failed
            } else {
                RowStatus::Done
            },
            exit_code: unit.exit_code,
            failure: unit.failure.clone(),
            verdict,
            implausible: each(&result["implausible"], |one| text(&one["rule"])),
            parameters: parameters(result, is_diagnosis, &findings),
            findings,
            output_unit: text(&result["output_unit"]),
            train_rmse: plain["train_rmse"].as_f64(),
            validate_rmse: plain["validate_rmse"].as_f64(),
            extended_train_rmse: extended["train_rmse"].as_f64(),
            extended_validate_rmse: extended["validate_rmse"].as_f64(),
            noise_lower: result["noise_floor"]["lower"].as_f64(),
            noise_upper: result["noise_floor"]["upper"].as_f64(),
        }
    }

    /// Row of a rig without a result.
    #[must_use]
    pub fn without(rig: &str, unit: Option<String>, status: RowStatus, failure: Failure) -> Self {
        Self {
            rig: rig.to_owned(),
            unit,
            status,
            exit_code: None,
            failure: Some(failure),
            verdict: None,
            implausible: Vec::new(),
            findings: Vec::new(),
            output_unit: None,
            train_rmse: None,
            validate_rmse: None,
            extended_train_rmse: None,
            extended_validate_rmse: None,
            noise_lower: None,
            noise_upper: None,
            parameters: Vec::new(),
        }
    }

    /// Reason for there being no result; empty if there is one.
    #[must_use]
    pub fn sentence(&self) -> &str {
        let failure = self.failure.as_ref();
        failure.map_or("", |failure| failure.sentence.as_str())
    }

    /// Rig and sentence, where that does not begin with the rig.
    #[must_use]
    pub fn said(&self) -> String {
        named(&self.rig, self.sentence())
    }

    /// True if the result is to be used: the search converged, and a rig can be like that.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.status == RowStatus::Done && self.exit_code == Some(0)
    }

    /// For programs.
    pub(super) fn json(&self) -> Value {
        let sized = |all: &[Estimated]| -> Vec<Value> {
            all.iter()
                .map(|one| json!({"name": one.name, "value": one.value, "ci95": one.ci95, "unit": one.unit}))
                .collect()
        };
        let findings = self.findings.iter().map(|found| {
            json!({
                "effect": found.effect,
                "could_also_be": found.could_also_be,
                "probability": found.probability,
                "parameters": sized(&found.parameters),
            })
        });
        json!({
            "rig": self.rig,
            "unit": self.unit,
            "status": self.status.id(),
            "exit_code": self.exit_code,
            "failure": self.failure,
            "verdict": self.verdict,
            "implausible": self.implausible,
            "findings": findings.collect::<Vec<_>>(),
            "output_unit": self.output_unit,
            "train_rmse": self.train_rmse,
            "validate_rmse": self.validate_rmse,
            "extended_train_rmse": self.extended_train_rmse,
            "extended_validate_rmse": self.extended_validate_rmse,
            "noise_lower": self.noise_lower,
            "noise_upper": self.noise_upper,
            "parameters": sized(&self.parameters),
        })
    }
}

/// A sentence on a rig, which it names once: a rig of one recording has its name.
#[must_use]
pub fn named(rig: &str, sentence: &str) -> String {
    match sentence.strip_prefix(rig) {
        Some(rest) if rest.starts_with(':') => sentence.to_owned(),
        _ => format!("{rig}: {sentence}"),
    }
}

fn text(value: &Value) -> Option<String> {
    value.as_str().map(str::to_owned)
}

/// Elements of an array that can be read; none if it is none.
fn each<T>(array: &Value, read: impl Fn(&Value) -> Option<T>) -> Vec<T> {
    let elements = array.as_array().into_iter().flatten();
    elements.filter_map(read).collect()
}

fn interval(value: &Value) -> Option<[f64; 2]> {
    Some([value[0].as_f64()?, value[1].as_f64()?])
}

fn finding(finding: &Value) -> Option<Found> {
    let sized = |one: &Value| {
        Some(Estimated {
            name: text(&one["name"])?,
            value: one["value"].as_f64()?,
            ci95: interval(&one["ci95"]),
            unit: text(&one["unit"])?,
        })
    };
    Some(Found {
        effect: text(&finding["effect"])?,
        could_also_be: each(&finding["could_also_be"], text),
        probability: finding["probability"].as_f64(),
        parameters: each(&finding["parameters"], sized),
    })
}

/// Those of the baseline model and of what was found, from the model with it where there is one. What else that model has only
/// makes room for what nobody can tell apart.
fn parameters(result: &Value, is_diagnosis: bool, findings: &[Found]) -> Vec<Estimated> {
    if !is_diagnosis {
        return each(&result["parameters"], shared);
    }
    let plain = each(&result["baseline"]["parameters"], shared);
    if findings.is_empty() || result["extended"].is_null() {
        return plain;
    }
    let found = findings.iter().flat_map(|found| &found.parameters);
    let names: Vec<&str> = found.chain(&plain).map(|one| one.name.as_str()).collect();
    let mut parameters = each(&result["extended"]["parameters"], shared);
    parameters.retain(|one| names.contains(&one.name.as_str()));
    parameters
}

/// A parameter that all recordings of a rig share, unless it was fixed.
fn shared(parameter: &Value) -> Option<Estimated> {
    let is_open = parameter["per_recording"] == false && parameter["fixed"] == false;
    let read = || {
        Some(Estimated {
            name: text(&parameter["name"])?,
            value: parameter["values"][0].as_f64()?,
            ci95: interval(&parameter["ci95"][0]),
            unit: text(&parameter["unit"])?,
        })
    };
    is_open.then(read).flatten()
}
