//! Recordings sample by sample, with what models say of them, for programs.

use recording::{Quantity, Recording, Sampling};
use serde_json::{Value, json};

use super::plot::Left;

/// A recording as it was fitted, and the predictions of models for it.
#[derive(Debug)]
pub struct Series<'a> {
    /// The recording.
    pub recording: &'a Recording,
    /// True if the models were fitted to it.
    pub is_training: bool,
    /// Predictions, with the start and the offset that were found in this recording.
    pub models: Vec<Left>,
}

/// The series of a call of `command` as one document. All arrays of a recording have one value a sample; time is `null` in static
/// data. Drives are in the unit beside them, outputs in `output_unit`, temperatures in °C.
#[must_use]
pub fn json(command: &str, series: &[Series<'_>]) -> Value {
    let recordings: Vec<Value> = series.iter().map(of_one).collect();
    json!({
        "schema_version": 1,
        "command": command,
        "version": env!("CARGO_PKG_VERSION"),
        "recordings": recordings,
    })
}

fn of_one(one: &Series<'_>) -> Value {
    let recording = one.recording;
    let time_s = match recording.sampling() {
        Sampling::Untimed => None,
        _ => Some(recording.time_s()),
    };
    let is_static = recording.drive_quantity() == Quantity::Temperature;
    let models = one.models.iter().map(|Left { model, prediction }| {
        json!({
            "model": model,
            "output": prediction.output,
            // The input of a static loop stands beside as the drive.
            "temperature_degc": (!is_static).then_some(&prediction.temperature_degc),
        })
    });
    json!({
        "name": recording.name(),
        "role": if one.is_training { "train" } else { "validate" },
        "time_s": time_s,
        "drive": recording.drive(),
        "drive_unit": recording.drive_unit(),
        "output": recording.output(),
        "output_unit": recording.output_unit(),
        "models": models.collect::<Vec<_>>(),
    })
}
