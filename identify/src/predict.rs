use recording::Recording;

use crate::{ForwardModel, IdentifyError};

/// Output and temperature that a model predicts for a recording's drive.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// Output, in the unit of the model's gain; a value a sample.
    pub output: Vec<f64>,
    /// Temperature of the rod, °C (the input of a static loop, in its unit); a value a sample.
    pub temperature_degc: Vec<f64>,
}

/// Simulates a recording at one point, gain and offset included: [`Fit::point`](crate::Fit::point) or
/// [`SavedModel::point`](crate::SavedModel::point).
///
/// # Errors
///
/// Any error of the model.
pub fn predict(
    model: &dyn ForwardModel,
    point: &[f64],
    recording: &Recording,
) -> Result<Prediction, IdentifyError> {
    let mut prediction = Prediction {
        output: Vec::with_capacity(recording.len()),
        temperature_degc: Vec::with_capacity(recording.len()),
    };
    model.simulate(&[point.to_vec()], recording, &mut |block| {
        let own = |values: &[f64], kept: &mut Vec<f64>| {
            kept.extend(values.iter().step_by(block.stride));
        };
        own(block.displacement, &mut prediction.output);
        own(block.temperature_degc, &mut prediction.temperature_degc);
    })?;
    Ok(prediction)
}
