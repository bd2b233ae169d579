//! Residual of a fitted model of a rig that has not changed: a process in time, not white noise.
//!
//! ```text
//! e(t) = σ ε + a u₁(t) + b r(t) u₂(t),   r = |dy/dt| over its root mean square,   ⟨u_i(t) u_i(t')⟩ = exp(-|t - t'|/ℓ_i)
//! ```
//!
//! It has three parts: noise, a slow discrepancy, and one of timing, which shows where the output moves. Both processes are
//! Markov, so that a Kalman filter of two states makes a series of any length white, one sample after the other, however the
//! samples stand.

/// Standard deviations σ, a, b and memories ℓ₁, ℓ₂ of what is left.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Discrepancy {
    /// Of single samples, in the unit of the output.
    pub(crate) noise: f64,
    /// Of the slow part, in the unit of the output.
    pub(crate) slow: f64,
    /// How long that is remembered, s.
    pub(crate) slow_s: f64,
    /// Of the part that goes with the rate of the output, in the unit of the output.
    pub(crate) timing: f64,
    /// How long that is remembered, s.
    pub(crate) timing_s: f64,
}

/// When a recording was sampled, and how fast the model moved then.
#[derive(Debug, Clone)]
pub(crate) struct Sampled {
    pub(crate) time_s: Vec<f64>,
    /// |dy/dt| over its root mean square.
    pub(crate) rate: Vec<f64>,
    /// False for samples that are not compared.
    pub(crate) is_compared: Vec<bool>,
}

/// The filter of one recording.
#[derive(Debug, Clone)]
pub(crate) struct Filter {
    steps: Vec<Step>,
    /// Logarithm of the determinant of the covariance.
    pub(crate) ln_determinant: f64,
}

/// Of a sample that is not compared nothing but what is kept.
#[derive(Debug, Clone, Copy, Default)]
struct Step {
    kept: [f64; 2],
    shown: [f64; 2],
    gain: [f64; 2],
    per_deviation: f64,
}

impl Discrepancy {
    /// Its standard deviation where the output moves at a rate, in the unit of the output; `rate` is over its root mean square.
    pub(crate) fn deviation(self, rate: f64) -> f64 {
        let timing = self.timing * rate;
        (self.noise * self.noise + self.slow * self.slow + timing * timing).sqrt()
    }

    /// This discrepancy with a noise of at least so much, in the unit of the output: samples that are means have less.
    pub(crate) fn with_noise(self, least: f64) -> Self {
        Self {
            noise: self.noise.max(least),
            ..self
        }
    }

    /// This discrepancy with its variances multiplied by `factor`.
    pub(crate) fn enlarged(self, factor: f64) -> Self {
        let root = factor.sqrt();
        Self {
            noise: root * self.noise,
            slow: root * self.slow,
            timing: root * self.timing,
            ..self
        }
    }
}

impl Filter {
    pub(crate) fn of(discrepancy: &Discrepancy, sampled: &Sampled) -> Self {
        let memory_s = [discrepancy.slow_s, discrepancy.timing_s];
        let mut p = [[1.0, 0.0], [0.0, 1.0]];
        let mut ln_determinant = 0.0;
        let mut steps = Vec::with_capacity(sampled.time_s.len());
        for (k, (&now_s, rate)) in sampled.time_s.iter().zip(&sampled.rate).enumerate() {
            let mut kept = [0.0; 2];
            if k > 0 {
                let dt_s = now_s - sampled.time_s[k - 1];
                kept = memory_s.map(|memory_s| (-dt_s / memory_s).exp());
                for i in 0..2 {
                    for j in 0..2 {
                        p[i][j] *= kept[i] * kept[j];
                    }
                    p[i][i] += 1.0 - kept[i] * kept[i];
                }
            }
            if !sampled.is_compared[k] {
                steps.push(Step {
                    kept,
                    ..Step::default()
                });
                continue;
            }
            let shown = [discrepancy.slow, discrepancy.timing * rate];
            let ph = [0, 1].map(|i| p[i][0] * shown[0] + p[i][1] * shown[1]);
            let variance =
                ph[0] * shown[0] + ph[1] * shown[1] + discrepancy.noise * discrepancy.noise;
            let gain = ph.map(|own| own / variance);
            for i in 0..2 {
                for j in 0..2 {
                    p[i][j] -= gain[i] * ph[j];
                }
            }
            ln_determinant += variance.ln();
            steps.push(Step {
                kept,
                shown,
                gain,
                per_deviation: 1.0 / variance.sqrt(),
            });
        }
        Self {
            steps,
            ln_determinant,
        }
    }

    /// A series of this recording made white, in place.
    pub(crate) fn whiten(&self, series: &mut [f64]) {
        let mut state = [0.0; 2];
        for (step, value) in self.steps.iter().zip(series) {
            state = [0, 1].map(|i| state[i] * step.kept[i]);
            let innovation = *value - step.shown[0] * state[0] - step.shown[1] * state[1];
            state = [0, 1].map(|i| state[i] + step.gain[i] * innovation);
            *value = innovation * step.per_deviation;
        }
    }
}

#[cfg(test)]
mod tests {
    use identify::dense::{Matrix, definite_inverse};

    use super::*;

    const DISCREPANCY: Discrepancy = Discrepancy {
        noise: 0.3,
        slow: 0.8,
        slow_s: 5.0,
        timing: 1.7,
        timing_s: 0.9,
    };

    #[test]
    fn products_of_white_series_are_those_under_the_inverse_covariance() {
        let n = 40;
        let time_s: Vec<f64> = (0..n)
            .map(|k| 0.2 * k as f64 + 0.05 * (k % 3) as f64)
            .collect();
        let rate: Vec<f64> = (0..n).map(|k| (0.3 * k as f64).sin().abs()).collect();
        let covariance = Matrix::from_fn(n, n, |i, j| {
            let apart_s = (time_s[i] - time_s[j]).abs();
            let noise = if i == j { 0.3 * 0.3 } else { 0.0 };
            let slow = 0.8 * 0.8 * (-apart_s / 5.0).exp();
            noise + slow + 1.7 * 1.7 * rate[i] * rate[j] * (-apart_s / 0.9).exp()
        });
        let (inverse, ln_determinant) = definite_inverse(&covariance).unwrap();
        let sampled = Sampled {
            time_s,
            rate,
            is_compared: vec![true; n],
        };
        let filter = Filter::of(&DISCREPANCY, &sampled);
        assert!((filter.ln_determinant - ln_determinant).abs() < 1e-9);
        let series = |of: f64| -> Vec<f64> { (0..n).map(|k| (of * k as f64).cos()).collect() };
        let (one, other) = (series(0.2), series(0.5));
        let column = |series: &[f64]| Matrix::from_fn(n, 1, |i, _| series[i]);
        let expected = (column(&one).transpose() * inverse * column(&other))[(0, 0)];
        let white = |mut series: Vec<f64>| {
            filter.whiten(&mut series);
            series
        };
        let pairs = white(one).into_iter().zip(white(other));
        let found: f64 = pairs.map(|(a, b)| a * b).sum();
        assert!((found - expected).abs() < 1e-9 * expected.abs().max(1.0));
    }

    #[test]
    fn samples_that_are_not_compared_are_as_none() {
        let is_compared = |k: &usize| !(7..15).contains(k);
        let of = |which: Vec<usize>| {
            let sampled = Sampled {
                time_s: which.iter().map(|&k| 0.2 * k as f64).collect(),
                rate: which
                    .iter()
                    .map(|&k| (0.3 * k as f64).sin().abs())
                    .collect(),
                is_compared: which.iter().map(is_compared).collect(),
            };
            let filter = Filter::of(&DISCREPANCY, &sampled);
            let mut series: Vec<f64> = which.iter().map(|&k| (0.2 * k as f64).cos()).collect();
            filter.whiten(&mut series);
            (filter.ln_determinant, series)
        };
        let (of_all, all) = of((0..40).collect());
        let (of_few, few) = of((0..40).filter(is_compared).collect());
        assert!((of_all - of_few).abs() < 1e-9);
        assert!(all[7..15].iter().all(|value| value.abs() <= 0.0));
        let compared = (0..40).filter(is_compared).zip(few);
        for (k, value) in compared {
            assert!((all[k] - value).abs() < 1e-9, "{k}");
        }
    }
}
