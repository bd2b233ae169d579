//! How a resistance follows the transformed fraction of a fitted loop.

use recording::{Recording, Resistance};

use crate::static_effects::{Estimate, NotTestable, StaticEffect, StaticScore};
use crate::uncertainty::{Filter, student_95};
use crate::{Bounds, Fit, ForwardModel, IdentifyError, LoopModel, ResidualNoise, Scale, Scope};

/// Step of a difference, in standard errors of the parameter that is moved.
const STEP: f64 = 0.1;

/// Share of what the current alone explains, below which the fraction is taken to stand still.
const SMALLEST_CHANGE: f64 = 1e-12;

/// The effect of the phase on the resistance, by regression of the voltage on the fraction of a fitted loop.
///
/// ```text
/// u = i R_0 + i R_0 ρ ξ + e
/// ```
///
/// Of the voltage, as the error of a voltage over a small current is large; where the resistance itself was
/// recorded, i is 1 A. The interval allows for an autocorrelated e, and for what the fit leaves open of the loop:
/// the error of an estimate in two steps, of independent noise in each.
pub(crate) fn resistance_change(
    model: &LoopModel,
    fit: &Fit,
    training: &[Recording],
) -> Result<Result<StaticEffect, NotTestable>, IdentifyError> {
    let measured: Vec<Measured<'_>> = training
        .iter()
        .enumerate()
        .filter_map(|(r, recording)| {
            let resistance = recording.resistance()?;
            Some(Measured {
                recording,
                resistance,
                point: fit.point(r),
                r,
            })
        })
        .collect();
    if measured.is_empty() {
        return Ok(Err(NotTestable::NoResistance));
    }
    let still = || Err(NotTestable::NoChange);
    let samples = samples(model, &measured)?;
    let (Some(line), Some(level)) = (Line::through(&samples), Line::level(&samples)) else {
        return Ok(still());
    };
    let noise = line.noise(&samples);
    let Some(of_noise) = line.variances(&samples, &noise) else {
        return Ok(still());
    };
    let of_loop = propagated(model, fit, &measured)?;
    let n = noise.n_samples as f64;
    let current = centered(&samples)[0];
    let bic = criteria(&samples, &noise.coefficients);
    let score = |variance: f64, bic| StaticScore {
        rmse: (variance * n / current).sqrt(),
        unit: "Ω".to_owned(),
        bic,
        converged: fit.converged(),
    };
    let quantile = student_95((noise.n_effective - 2.0).max(1.0));
    let estimate = |name, unit: &str, value: f64, k: usize| {
        let half = quantile * (of_noise[k] + of_loop[k]).sqrt();
        Estimate {
            name,
            value,
            interval: half.is_finite().then_some(Bounds {
                lower: value - half,
                upper: value + half,
            }),
            unit: unit.to_owned(),
        }
    };
    Ok(Ok(StaticEffect {
        effect: "phase-dependent-resistance",
        n_sizes: 1,
        estimates: vec![
            estimate("resistance_change", "1", line.change(), 0),
            estimate("resistance_ohm", "Ω", line.cold_ohm, 1),
        ],
        without: score(level.noise(&samples).variance, bic[0]),
        with: score(noise.variance, bic[1]),
    }))
}

/// A recording with a resistance, and the loop's parameters in it.
struct Measured<'a> {
    recording: &'a Recording,
    resistance: &'a Resistance,
    point: Vec<f64>,
    /// Its number among the training recordings.
    r: usize,
}

#[derive(Debug, Clone, Copy)]
struct Sample {
    voltage_v: f64,
    current_a: f64,
    fraction: f64,
}

/// The samples of each recording.
fn samples(
    model: &LoopModel,
    measured: &[Measured<'_>],
) -> Result<Vec<Vec<Sample>>, IdentifyError> {
    measured
        .iter()
        .map(|one| {
            let fraction = model.fraction(&one.point, one.recording)?;
            let pairs = one.resistance.voltage_and_current().zip(fraction);
            let sample = |((voltage_v, current_a), fraction)| Sample {
                voltage_v,
                current_a,
                fraction,
            };
            Ok(pairs.map(sample).collect())
        })
        .collect()
}

/// u = i (R_0 + D ξ).
#[derive(Debug, Clone, Copy)]
struct Line {
    /// R_0.
    cold_ohm: f64,
    /// D = R_0 ρ.
    rise_ohm: f64,
}

impl Line {
    /// The line of least squares; `None` where nothing moves.
    fn through(samples: &[Vec<Sample>]) -> Option<Self> {
        let [ii, mean, spread, iu, du] = centered(samples);
        let moves = spread > SMALLEST_CHANGE * ii;
        let rise_ohm = du / spread;
        moves.then_some(Self {
            cold_ohm: iu / ii - rise_ohm * mean,
            rise_ohm,
        })
    }

    /// The line of least squares without a rise; `None` where no current flows.
    fn level(samples: &[Vec<Sample>]) -> Option<Self> {
        let [ii, _, _, iu, _] = centered(samples);
        (ii > 0.0).then_some(Self {
            cold_ohm: iu / ii,
            rise_ohm: 0.0,
        })
    }

    /// ρ.
    fn change(&self) -> f64 {
        self.rise_ohm / self.cold_ohm
    }

    fn noise(&self, samples: &[Vec<Sample>]) -> ResidualNoise {
        let residual = |sample: &Sample| {
            let ohm = self.cold_ohm + self.rise_ohm * sample.fraction;
            sample.voltage_v - sample.current_a * ohm
        };
        let residuals: Vec<Vec<f64>> = samples
            .iter()
            .map(|segment| segment.iter().map(residual).collect())
            .collect();
        let segments: Vec<&[f64]> = residuals.iter().map(Vec::as_slice).collect();
        ResidualNoise::of(&segments)
    }

    /// Variances of ρ and R_0 by the noise of the voltage: as of any fit here, B (XᵀΓX) B with B = (XᵀX)⁻¹,
    /// and what the fit has taken off the sum of squares given back.
    fn variances(&self, samples: &[Vec<Sample>], noise: &ResidualNoise) -> Option<[f64; 2]> {
        // Columns i and i (ξ - mean) are orthogonal: B is diagonal.
        let [ii, mean, spread, ..] = centered(samples);
        let mut meat = [[0.0; 2]; 2];
        for segment in samples {
            let mut filter = Filter::new(&noise.coefficients, 2);
            for sample in segment {
                let columns = [
                    sample.current_a,
                    sample.current_a * (sample.fraction - mean),
                ];
                filter.push(|k| columns[k]);
                for (j, row) in meat.iter_mut().enumerate() {
                    for (k, entry) in row.iter_mut().enumerate() {
                        *entry += filter.latest(j) * filter.latest(k);
                    }
                }
            }
        }
        let bread = [1.0 / ii, 1.0 / spread];
        let total = noise.variance * noise.n_samples as f64;
        let trace = noise.innovation_variance * (bread[0] * meat[0][0] + bread[1] * meat[1][1]);
        let taken = if total > 0.0 {
            (trace / total).min(1.0)
        } else {
            0.0
        };
        let factor = noise.innovation_variance * (1.0 + taken);
        // R_0 is the level less D times the mean, ρ = D/R_0: gradients by level and D.
        let cold = [1.0, -mean];
        let change = [
            -self.change() / self.cold_ohm,
            (1.0 + self.change() * mean) / self.cold_ohm,
        ];
        let variance = |gradient: [f64; 2]| {
            let scaled = [gradient[0] * bread[0], gradient[1] * bread[1]];
            let product = |j: usize| meat[j][0] * scaled[0] + meat[j][1] * scaled[1];
            factor * (scaled[0] * product(0) + scaled[1] * product(1))
        };
        let variances = [variance(change), variance(cold)];
        variances.iter().all(|v| v.is_finite()).then_some(variances)
    }
}

/// Schwarz's criterion without and with a rise, both under the noise that is left with it: noise that is found
/// anew without would take the slow change for its own.
fn criteria(samples: &[Vec<Sample>], coefficients: &[f64]) -> [f64; 2] {
    let columns = |s: &Sample| [s.voltage_v, s.current_a, s.current_a * s.fraction];
    // Innovations of each column, of what has enough before it.
    let innovations: Vec<[f64; 3]> = samples
        .iter()
        .flat_map(|segment| segment.windows(coefficients.len() + 1))
        .filter_map(|window| {
            let (now, before) = window.split_last()?;
            let mut innovation = columns(now);
            for (coefficient, past) in coefficients.iter().zip(before.iter().rev()) {
                for (entry, past) in innovation.iter_mut().zip(columns(past)) {
                    *entry -= coefficient * past;
                }
            }
            Some(innovation)
        })
        .collect();
    let product = |j: usize, k: usize| innovations.iter().map(|row| row[j] * row[k]).sum::<f64>();
    // Squares and products of voltage and i ξ, less what the current explains.
    let left = |j, k| product(j, k) - product(1, j) * product(1, k) / product(1, 1);
    let without = left(0, 0);
    let with = without - left(0, 2).powi(2) / left(2, 2);
    let n = innovations.len() as f64;
    let criterion = |sum: f64, parameters: f64| n * (sum / n).ln() + parameters * n.ln();
    [criterion(without, 1.0), criterion(with, 2.0)]
}

/// Σ i², the mean of ξ weighed by i², Σ i² (ξ - mean)², Σ i u, Σ i (ξ - mean) u.
fn centered(samples: &[Vec<Sample>]) -> [f64; 5] {
    let sum = |of: &dyn Fn(&Sample) -> f64| samples.iter().flatten().map(of).sum::<f64>();
    let weight = |sample: &Sample| sample.current_a * sample.current_a;
    let ii = sum(&weight);
    let mean = sum(&|sample| weight(sample) * sample.fraction) / ii;
    [
        ii,
        mean,
        sum(&|sample| weight(sample) * (sample.fraction - mean).powi(2)),
        sum(&|sample| sample.current_a * sample.voltage_v),
        sum(&|sample| sample.current_a * (sample.fraction - mean) * sample.voltage_v),
    ]
}

/// Variances of ρ and R_0 by what the fit leaves open of the loop: gᵀ C g, with the gradient by differences.
fn propagated(
    model: &LoopModel,
    fit: &Fit,
    measured: &[Measured<'_>],
) -> Result<[f64; 2], IdentifyError> {
    let covariance = &fit.covariance;
    let mut gradients = vec![[0.0; 2]; covariance.names.len()];
    for (j, gradient) in gradients.iter_mut().enumerate() {
        let step = STEP * covariance.matrix[j][j].sqrt();
        // What the data do not fix moves no fraction, what stands still has no error.
        if !(step.is_finite() && step > 0.0) {
            continue;
        }
        let mut ends = [None; 2];
        for (end, step) in ends.iter_mut().zip([-step, step]) {
            let moved: Vec<Measured<'_>> = measured
                .iter()
                .map(|one| Measured {
                    point: moved(model, &covariance.names[j], covariance.scales[j], one, step),
                    ..*one
                })
                .collect();
            *end = Line::through(&samples(model, &moved)?);
        }
        if let [Some(low), Some(high)] = ends {
            *gradient = [
                (high.change() - low.change()) / (2.0 * step),
                (high.cold_ohm - low.cold_ohm) / (2.0 * step),
            ];
        }
    }
    let variance = |k: usize| {
        let mut sum = 0.0;
        for (i, row) in covariance.matrix.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                let product = gradients[i][k] * gradients[j][k];
                // An infinite variance has no gradient.
                if product.abs() > 0.0 {
                    sum += product * entry;
                }
            }
        }
        sum.max(0.0)
    };
    Ok([variance(0), variance(1)])
}

/// The point of a recording with one entry of the covariance moved; the point itself, if it has no part in it.
fn moved(model: &LoopModel, name: &str, scale: Scale, one: &Measured<'_>, step: f64) -> Vec<f64> {
    let mut point = one.point.clone();
    for (info, value) in model.parameters().iter().zip(&mut point) {
        let is_meant = match info.scope {
            Scope::Shared => info.name == name,
            Scope::PerRecording => format!("{}[{}]", info.name, one.r) == name,
        };
        if is_meant {
            let to = match scale {
                Scale::Linear => *value + step,
                Scale::Logarithmic => *value * step.exp(),
            };
            *value = to.clamp(info.bounds.lower, info.bounds.upper);
        }
    }
    point
}
