//! Sums over a recording for a shape f, from which gain, offset and cost follow in closed form.

use recording::Recording;
use wiener::{Block, widest_vectors};

use crate::ParameterState;

/// Points simulated together by one thread: the lanes of a full chunk.
pub(crate) const BATCH: usize = 32;

/// A training recording with the weights of its samples.
#[derive(Debug, Clone)]
pub(crate) struct Weighed<'a> {
    pub(crate) recording: &'a Recording,
    /// Weight of each sample; `None`: all 1.
    weights: Option<Vec<f64>>,
    /// Σ w.
    total: f64,
    /// Σ w y / Σ w.
    mean: f64,
    /// Σ w (y - mean)².
    spread: f64,
}

/// Weighted sums over one recording at one point: y from its mean, f from its first value, or sums of
/// a shape far from zero would cancel.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Moments {
    first: f64,
    f: f64,
    ff: f64,
    fy: f64,
    /// Σ (temperature - recorded temperature)².
    pub(crate) temperature: f64,
}

/// Gain and offsets that fit best at one point.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Solved {
    pub(crate) gain: f64,
    /// One a recording.
    pub(crate) offsets: Vec<f64>,
    /// Σ w (y - gain f - offset)².
    pub(crate) output: f64,
    /// Σ (temperature - recorded temperature)².
    pub(crate) temperature: f64,
}

impl<'a> Weighed<'a> {
    pub(crate) fn new(recording: &'a Recording, weights: Option<Vec<f64>>) -> Self {
        let weight = |k: usize| weights.as_ref().map_or(1.0, |weights| weights[k]);
        let output = recording.output();
        let total: f64 = (0..output.len()).map(weight).sum();
        let mean = (0..output.len())
            .map(|k| weight(k) * output[k])
            .sum::<f64>()
            / total;
        let spread = (0..output.len())
            .map(|k| weight(k) * (output[k] - mean).powi(2))
            .sum();
        Self {
            recording,
            weights,
            total,
            mean,
            spread,
        }
    }

    /// Σ w (y - mean)².
    pub(crate) fn spread(&self) -> f64 {
        self.spread
    }

    /// Σ w y / Σ w.
    pub(crate) fn mean(&self) -> f64 {
        self.mean
    }

    /// Weight of a sample.
    #[inline(always)]
    pub(crate) fn weight(&self, sample: usize) -> f64 {
        self.weights.as_ref().map_or(1.0, |weights| weights[sample])
    }

    /// Adds a block of outputs to the moments of its members.
    pub(crate) fn add(&self, moments: &mut [Moments; BATCH], block: &Block<'_>) {
        let moments = &mut moments[block.first_member..];
        widest_vectors(
            #[inline(always)]
            || self.add_output(moments, block),
        );
        if let Some(recorded) = self.recording.temperature_degc() {
            widest_vectors(
                #[inline(always)]
                || add_temperature(moments, block, recorded),
            );
        }
    }

    #[inline(always)]
    fn add_output(&self, moments: &mut [Moments], block: &Block<'_>) {
        let output = &self.recording.output()[block.first_sample..];
        let mut first = [0.0; BATCH];
        for l in 0..block.members {
            if block.first_sample == 0 {
                moments[l].first = block.displacement[l];
            }
            first[l] = moments[l].first;
        }
        let mut sums = [[0.0; BATCH]; 3];
        for (row, shapes) in block.displacement.chunks_exact(block.stride).enumerate() {
            let weight = self.weight(block.first_sample + row);
            let y = output[row] - self.mean;
            for (l, &f) in shapes.iter().enumerate().take(BATCH) {
                let f = f - first[l];
                let weighed = weight * f;
                sums[0][l] += weighed;
                sums[1][l] += weighed * f;
                sums[2][l] += weighed * y;
            }
        }
        for l in 0..block.members {
            moments[l].f += sums[0][l];
            moments[l].ff += sums[1][l];
            moments[l].fy += sums[2][l];
        }
    }
}

#[inline(always)]
fn add_temperature(moments: &mut [Moments], block: &Block<'_>, recorded: &[f64]) {
    let recorded = &recorded[block.first_sample..];
    let mut sums = [0.0; BATCH];
    for (row, shown) in block
        .temperature_degc
        .chunks_exact(block.stride)
        .enumerate()
    {
        for (l, &temperature_degc) in shown.iter().enumerate().take(BATCH) {
            let error_k = temperature_degc - recorded[row];
            sums[l] += error_k * error_k;
        }
    }
    for l in 0..block.members {
        moments[l].temperature += sums[l];
    }
}

/// min Σ w (y - gain f - offset)² over gain and offsets, in closed form.
///
/// `moments` has one entry a recording.
pub(crate) fn solve_linear(
    recordings: &[Weighed<'_>],
    moments: &[Moments],
    gain: ParameterState,
    offset: ParameterState,
) -> Solved {
    // Sums over all recordings of products of f and y, each from its mean where the offset is free,
    // from the fixed offset otherwise.
    let (mut ff, mut fy, mut yy) = (0.0, 0.0, 0.0);
    for (weighed, m) in recordings.iter().zip(moments) {
        match offset {
            ParameterState::Free => {
                ff += m.ff - m.f * m.f / weighed.total;
                fy += m.fy;
                yy += weighed.spread;
            }
            ParameterState::Fixed(offset) => {
                let shift = weighed.mean - offset;
                let whole = m.f + weighed.total * m.first;
                ff += m.ff + m.first * (m.f + whole);
                fy += m.fy + shift * whole;
                yy += weighed.spread + weighed.total * shift * shift;
            }
        }
    }
    let gain = match gain {
        ParameterState::Fixed(gain) => gain,
        // A shape that never moves explains nothing; one that is NaN must stay NaN.
        ParameterState::Free if ff <= 0.0 => 0.0,
        ParameterState::Free => fy / ff,
    };
    let offsets = recordings
        .iter()
        .zip(moments)
        .map(|(weighed, m)| match offset {
            ParameterState::Free => weighed.mean - gain * (m.first + m.f / weighed.total),
            ParameterState::Fixed(offset) => offset,
        })
        .collect();
    let output = yy - 2.0 * gain * fy + gain * gain * ff;
    Solved {
        gain,
        offsets,
        // Below zero by rounding only; NaN stays NaN.
        output: if output < 0.0 { 0.0 } else { output },
        temperature: moments.iter().map(|m| m.temperature).sum(),
    }
}
