//! Residuals of correlated noise made white, and how far correlation carries.

use crate::model::series::{Layout, Noise};

/// Autoregressive filters (1 - Σ a_i z⁻ⁱ)/σ, one a channel, over the segments of a series: what they make of
/// that noise is white and of variance 1.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Whitener {
    layout: Layout,
    noise: Noise,
}

impl Whitener {
    pub(crate) fn new(layout: &Layout, noise: &Noise) -> Self {
        Self {
            layout: layout.clone(),
            noise: noise.clone(),
        }
    }

    /// The series with its memory taken out; the first samples of each segment, which have no past, are 0.
    pub(crate) fn whiten(&self, series: &[f64]) -> Vec<f64> {
        let mut white = vec![0.0; series.len()];
        for one in &self.layout.segments {
            let noise = self.noise.of(one.channel);
            let (coefficients, deviation) = (&noise.coefficients, noise.innovation_variance.sqrt());
            let per = if deviation > 0.0 {
                1.0 / deviation
            } else {
                0.0
            };
            let segment = &series[one.range.clone()];
            for k in coefficients.len()..segment.len() {
                let past = segment[..k].iter().rev();
                let recalled: f64 = coefficients
                    .iter()
                    .zip(past)
                    .map(|(a, past)| a * past)
                    .sum();
                white[one.range.start + k] = (segment[k] - recalled) * per;
            }
        }
        white
    }

    /// The series c through the inverse filters, backward in time: cᵀc is sᵀ Γ s, with Γ the covariance of the
    /// noise, and so are products of two series. No covariance is formed.
    pub(crate) fn carried(&self, series: &[f64]) -> Vec<f64> {
        let mut carried = vec![0.0; series.len()];
        for one in &self.layout.segments {
            let noise = self.noise.of(one.channel);
            let (coefficients, deviation) = (&noise.coefficients, noise.innovation_variance.sqrt());
            let segment = &mut carried[one.range.clone()];
            for k in (0..segment.len()).rev() {
                let future = segment[k + 1..].iter();
                let recalled: f64 = coefficients
                    .iter()
                    .zip(future)
                    .map(|(a, future)| a * future)
                    .sum();
                segment[k] = series[one.range.start + k] + recalled;
            }
            segment.iter_mut().for_each(|value| *value *= deviation);
        }
        carried
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::projection::dot;
    use crate::model::series::{Channel, Segment};
    use identify::ResidualNoise;

    /// One channel of these coefficients and variance 1, in segments of these lengths.
    fn whitener(coefficients: &[f64], lengths: &[usize]) -> Whitener {
        let noise = ResidualNoise {
            coefficients: coefficients.to_vec(),
            innovation_variance: 1.0,
            ..ResidualNoise::of(&[])
        };
        let mut start = 0;
        let segments = lengths.iter().map(|length| {
            let range = start..start + length;
            start = range.end;
            Segment {
                recording: 0,
                channel: Channel::Output,
                range,
            }
        });
        let layout = Layout {
            segments: segments.collect(),
            per_k: 0.0,
        };
        let noise = Noise {
            temperature: noise.clone(),
            output: noise,
        };
        Whitener::new(&layout, &noise)
    }

    #[test]
    fn whitening_undoes_the_filter() {
        let whitener = whitener(&[0.8, -0.2], &[5, 4]);
        let white = [1.0, 0.0, 0.0, 3.0, 0.0, 0.0, 1.0, 2.0, 0.0];
        let mut series = [0.0; 9];
        for (start, length) in [(0, 5), (5, 4)] {
            for k in 0..length {
                let past = |i: usize| if k >= i { series[start + k - i] } else { 0.0 };
                series[start + k] = white[start + k] + 0.8 * past(1) - 0.2 * past(2);
            }
        }
        let again = whitener.whiten(&series);
        // The first two of a segment have no past.
        let expected = [0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 2.0, 0.0];
        for (a, b) in again.iter().zip(expected) {
            assert!((a - b).abs() < 1e-12);
        }
    }

    #[test]
    fn what_is_carried_is_the_quadratic_form_of_the_covariance() {
        // First order, stationary from a far past within the segment: Γ_ij = φ^|i-j|/(1-φ²).
        let phi: f64 = 0.7;
        let n = 200;
        // Away from the segment's start, where the noise is stationary.
        let s: Vec<f64> = (0..n)
            .map(|k| {
                if (80..120).contains(&k) {
                    (0.3 * k as f64).sin()
                } else {
                    0.0
                }
            })
            .collect();
        let mut form = 0.0;
        for i in 0..n {
            for j in 0..n {
                form += s[i] * s[j] * phi.powi((i as i32 - j as i32).abs()) / (1.0 - phi * phi);
            }
        }
        let carried = whitener(&[phi], &[n]).carried(&s);
        assert!((dot(&carried, &carried) / form - 1.0).abs() < 1e-9);
    }
}
