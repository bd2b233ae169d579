use recording::Recording;

use crate::{Fit, ForwardModel, IdentifyError};

/// Fewest samples at rest from which an offset is taken: fewer would carry their noise into it.
const FEWEST_AT_REST: usize = 10;

/// Where the offset of a validation recording was read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OffsetSource {
    /// From the samples before the drive first rises.
    BeforeDrive {
        /// Their number.
        n_samples: usize,
    },
    /// Over the whole recording: the drive rises at once.
    WholeRecording,
}

/// How well a fitted model meets a recording that it has not seen.
#[derive(Debug, Clone, PartialEq)]
pub struct Validated {
    /// Name of the recording.
    pub name: String,
    /// Root mean square of recording - model, in the output unit.
    pub rmse: f64,
    /// 1 - RMSE / standard deviation of the output.
    pub fit_fraction: f64,
    /// Number of samples.
    pub n_samples: usize,
    /// Offset of this recording, in the output unit.
    pub offset: f64,
    /// Where the offset was read.
    pub offset_source: OffsetSource,
}

/// Predicts a recording with the shared parameters frozen; only the offset is set, by a rule that is
/// the same for every model: from the samples before the drive first rises, or over the whole
/// recording if there are fewer than ten.
///
/// # Errors
///
/// What the model refuses.
pub fn validate<M: ForwardModel>(
    model: &M,
    fit: &Fit,
    recording: &Recording,
) -> Result<Validated, IdentifyError> {
    let mut predicted: Vec<f64> = Vec::with_capacity(recording.len());
    model.simulate(&[fit.shared_values()], recording, &mut |block| {
        predicted.extend(block.displacement.iter().step_by(block.stride));
    })?;
    let errors: Vec<f64> = recording
        .output()
        .iter()
        .zip(&predicted)
        .map(|(y, f)| y - f)
        .collect();
    let at_rest = samples_at_rest(recording.drive());
    let (offset, offset_source) = if at_rest >= FEWEST_AT_REST {
        let source = OffsetSource::BeforeDrive { n_samples: at_rest };
        (mean(&errors[..at_rest]), source)
    } else {
        (mean(&errors), OffsetSource::WholeRecording)
    };
    let n = recording.len() as f64;
    let sum_of_squares: f64 = errors.iter().map(|error| (error - offset).powi(2)).sum();
    let level = mean(recording.output());
    let spread: f64 = recording.output().iter().map(|y| (y - level).powi(2)).sum();
    Ok(Validated {
        name: recording.name().to_owned(),
        rmse: (sum_of_squares / n).sqrt(),
        fit_fraction: 1.0 - (sum_of_squares / spread).sqrt(),
        n_samples: recording.len(),
        offset,
        offset_source,
    })
}

/// Samples before the drive first acts, the one at which it does included: its output is read before.
fn samples_at_rest(drive: &[f64]) -> usize {
    match drive.iter().position(|drive| drive.abs() > 0.0) {
        Some(0) => 0,
        Some(k) => k + 1,
        None => drive.len(),
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
