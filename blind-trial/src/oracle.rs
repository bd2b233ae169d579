//! Visibility of an effect to an oracle, who knows the plant without the effect, and the noise.

use identify::{
    Fit, ForwardModel, IdentifyError, ParameterVector, Prior, RefineConfig, predict, refine,
};
use recording::{Recording, RecordingParts};
use serde::{Deserialize, Serialize};
use truth_plant::{NoiseKind, Traces, TruthPlant};

/// Correlation times of the 1/f noise of the truth: octaves from 1 sample.
const OCTAVES: u32 = 14;

/// Samples that a prediction of the noise looks back.
const MEMORY: usize = 64;

/// How much of a concealed effect there was to be seen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Oracle {
    /// Root mean square of what it changes in the output, mm.
    pub raw_mm: f64,
    /// Root mean square of the part that the refitted baseline model cannot follow, mm.
    pub left_mm: f64,
    /// Score of one who knows its trace and the noise, standard deviations.
    ///
    /// ```text
    /// t² = Δ' Σ⁻¹ Δ,   Δ = (y₁ - f(θ₁)) - (y₀ - f(θ₀))        with and without it, each with the baseline model's best
    /// ```
    pub t: f64,
    /// Score of one who knows neither what belongs to single runs nor, where it is not the paper's, which loop the rig has: the
    /// model that is refitted leaves both open, as a diagnosis must. `None` in earlier trials.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub t_open: Option<f64>,
}

/// Trace that an effect leaves in the training recordings after the baseline model has been refitted, sample by sample.
#[derive(Debug, Clone)]
pub(crate) struct Left {
    pub(crate) oracle: Oracle,
    /// Δ of the output of each recording, mm.
    pub(crate) output_mm: Vec<Vec<f64>>,
}

/// How a model without the effect sees the training recordings.
#[derive(Clone, Copy)]
pub(crate) struct Eye<'a> {
    pub(crate) model: &'a dyn ForwardModel,
    /// Where a fit of it, or of one with a part of its parameters, ended on the noisy recordings: a start near both ends that are sought.
    pub(crate) fit: &'a Fit,
    /// How the priors of its parameters count.
    pub(crate) prior: Prior,
    pub(crate) training: &'a [Recording],
    /// The true rig: its noise counts.
    pub(crate) truth: &'a TruthPlant,
}

impl Eye<'_> {
    /// Trace that one effect leaves, from quiet traces of every recording with and without it.
    pub(crate) fn left(&self, with: &[Traces], without: &[Traces]) -> Result<Left, IdentifyError> {
        let [with_rest, without_rest] = [self.rest(with)?, self.rest(without)?];
        let quiet = |traces: &[Traces]| -> Vec<Vec<f64>> {
            let outputs = traces.iter().map(|one| &one.quiet_displacement_mm);
            outputs.cloned().collect()
        };
        let raw = apart(&quiet(with), &quiet(without));
        let output_mm = apart(&with_rest.output_mm, &without_rest.output_mm);
        let temperature_k = apart(&with_rest.temperature_k, &without_rest.temperature_k);
        let of_outputs = output_mm.iter().map(|one| self.whitened_squares(one));
        let mut squares: f64 = of_outputs.sum();
        if let Some(noise) = self.truth.temperature_noise {
            squares +=
                sum_of_squares(&temperature_k.concat()) / (noise.deviation * noise.deviation);
        }
        Ok(Left {
            oracle: Oracle {
                raw_mm: rms(&raw.concat()),
                left_mm: rms(&output_mm.concat()),
                t: squares.sqrt(),
                t_open: None,
            },
            output_mm,
        })
    }

    /// Residual of the model, refitted to quiet traces.
    fn rest(&self, traces: &[Traces]) -> Result<Rest, IdentifyError> {
        let pairs = self.training.iter().zip(traces);
        let recordings = pairs
            .map(|(noisy, traces)| quiet(noisy, traces))
            .collect::<Result<Vec<_>, _>>()?;
        let vector = ParameterVector::new(self.model.parameters(), recordings.len());
        let start = self.fit.coordinates(&vector);
        let has_temperature = self.training[0].temperature_degc().is_some();
        let temperature_weight = match self.fit.temperature_rmse_k {
            Some(rmse_k) if rmse_k > 0.0 && has_temperature => {
                (self.fit.train_rmse / rmse_k).powi(2)
            }
            _ => 0.0,
        };
        let config = RefineConfig {
            temperature_weight,
            prior: self.prior,
            ..RefineConfig::default()
        };
        let refined = refine(self.model, &recordings, &[start], &config)?;
        let mut rest = Rest::default();
        for (recording, point) in recordings.iter().zip(&refined.points) {
            let shown = predict(self.model, point, recording)?;
            rest.output_mm.push(less(recording.output(), &shown.output));
            if let Some(recorded) = recording.temperature_degc() {
                rest.temperature_k
                    .push(less(recorded, &shown.temperature_degc));
            }
        }
        Ok(rest)
    }

    /// x' Σ⁻¹ x, Σ the covariance of the output's noise.
    fn whitened_squares(&self, x: &[f64]) -> f64 {
        let covariances = covariances_mm2(self.truth);
        let (coefficients, variance) = predictor(&covariances);
        let innovation = |k: usize| {
            let past = coefficients.iter().zip(x[..k].iter().rev());
            x[k] - past.map(|(a, x)| a * x).sum::<f64>()
        };
        (0..x.len()).map(|k| innovation(k).powi(2)).sum::<f64>() / variance
    }
}

/// Of every recording.
#[derive(Debug, Default)]
struct Rest {
    output_mm: Vec<Vec<f64>>,
    temperature_k: Vec<Vec<f64>>,
}

/// A training recording without its noise.
fn quiet(noisy: &Recording, traces: &Traces) -> Result<Recording, IdentifyError> {
    let has_temperature = noisy.temperature_degc().is_some();
    Ok(Recording::new(RecordingParts {
        name: noisy.name().to_owned(),
        time_s: Some(noisy.time_s().to_vec()),
        drive_quantity: noisy.drive_quantity(),
        drive: noisy.drive().to_vec(),
        output_unit: noisy.output_unit().to_owned(),
        output: traces.quiet_displacement_mm.clone(),
        temperature_degc: has_temperature.then(|| traces.quiet_thermocouple_degc.clone()),
        ambient_degc: noisy.ambient_degc().map(<[f64]>::to_vec),
        ..RecordingParts::default()
    })?)
}

fn less(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// Differences of as many series.
fn apart(a: &[Vec<f64>], b: &[Vec<f64>]) -> Vec<Vec<f64>> {
    a.iter().zip(b).map(|(a, b)| less(a, b)).collect()
}

/// Covariances of the output's noise at lags 0, 1, …, mm²: the process and the rounding of the converter. Of outliers
/// only what is around them counts: who knows the noise knows them.
fn covariances_mm2(plant: &TruthPlant) -> Vec<f64> {
    let Some(noise) = plant.displacement_noise else {
        return vec![1.0];
    };
    let variance_mm2 = (1e3 * noise.deviation).powi(2);
    let correlation = |lag: usize| -> f64 {
        let lag = lag as f64;
        match noise.kind {
            NoiseKind::Ar1 { correlation } => correlation.powf(lag),
            NoiseKind::OneOverF => {
                let octaves = (0..OCTAVES).map(|octave| (-lag / f64::from(1_u32 << octave)).exp());
                octaves.sum::<f64>() / f64::from(OCTAVES)
            }
            _ => f64::from(u8::from(lag < 0.5)),
        }
    };
    let mut covariances: Vec<f64> = (0..=MEMORY)
        .map(|lag| variance_mm2 * correlation(lag))
        .collect();
    if let Some(converter) = plant.converter {
        let step_mm = 1e3 * converter.full_scale_m / f64::from(1_u32 << converter.bits);
        covariances[0] += step_mm * step_mm / 12.0;
    }
    covariances
}

/// The best linear prediction from the past, and the variance of its error (Levinson and Durbin).
fn predictor(covariances: &[f64]) -> (Vec<f64>, f64) {
    let mut coefficients: Vec<f64> = Vec::new();
    let mut variance = covariances[0];
    for order in 1..covariances.len() {
        let known = coefficients.iter().zip(covariances[1..order].iter().rev());
        let missing = covariances[order] - known.map(|(a, c)| a * c).sum::<f64>();
        let last = missing / variance;
        let turned = coefficients.iter().rev();
        coefficients = coefficients
            .iter()
            .zip(turned)
            .map(|(a, b)| a - last * b)
            .collect();
        coefficients.push(last);
        variance *= 1.0 - last * last;
    }
    (coefficients, variance)
}

fn sum_of_squares(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum()
}

fn rms(x: &[f64]) -> f64 {
    (sum_of_squares(x) / x.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_predictor_of_an_autoregressive_process_is_its_coefficient() {
        let covariances: Vec<f64> = (0..6).map(|lag| 4.0 * 0.8_f64.powi(lag)).collect();
        let (coefficients, variance) = predictor(&covariances);
        assert!((coefficients[0] - 0.8).abs() < 1e-12);
        assert!(coefficients[1..].iter().all(|a| a.abs() < 1e-12));
        assert!((variance - 4.0 * 0.36).abs() < 1e-12);
    }
}
