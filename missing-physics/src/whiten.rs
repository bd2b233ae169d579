//! Residuals of correlated noise made white, and how far correlation carries.

/// Autoregressive filter 1 - Σ a_i z⁻ⁱ over segments, none of them continued by the next.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Whitener {
    coefficients: Vec<f64>,
    /// Lengths of the segments.
    segments: Vec<usize>,
}

impl Whitener {
    pub(crate) fn new(coefficients: &[f64], segments: &[usize]) -> Self {
        Self {
            coefficients: coefficients.to_vec(),
            segments: segments.to_vec(),
        }
    }

    /// The series with its memory taken out; the first samples of each segment, which have no past, are 0.
    pub(crate) fn whiten(&self, series: &[f64]) -> Vec<f64> {
        let order = self.coefficients.len();
        let mut white = vec![0.0; series.len()];
        self.each_segment(series, |start, segment| {
            for k in order..segment.len() {
                let recalled: f64 = self
                    .coefficients
                    .iter()
                    .enumerate()
                    .map(|(i, a)| a * segment[k - 1 - i])
                    .sum();
                white[start + k] = segment[k] - recalled;
            }
        });
        white
    }

    /// sᵀ Γ s / σ_w², with Γ the covariance of noise that this filter whitens to variance σ_w²: the norm of s
    /// through the inverse filter, backward in time. No covariance is formed.
    pub(crate) fn carried(&self, series: &[f64]) -> f64 {
        let order = self.coefficients.len();
        let mut sum = 0.0;
        self.each_segment(series, |_, segment| {
            let mut recent = vec![0.0; order];
            for &value in segment.iter().rev() {
                let recalled: f64 = self
                    .coefficients
                    .iter()
                    .zip(&recent)
                    .map(|(a, past)| a * past)
                    .sum();
                let carried = value + recalled;
                sum += carried * carried;
                if order > 0 {
                    recent.rotate_right(1);
                    recent[0] = carried;
                }
            }
        });
        sum
    }

    fn each_segment(&self, series: &[f64], mut visit: impl FnMut(usize, &[f64])) {
        let mut start = 0;
        for &length in &self.segments {
            visit(start, &series[start..start + length]);
            start += length;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whitening_undoes_the_filter() {
        let whitener = Whitener::new(&[0.8, -0.2], &[5, 4]);
        let white = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
        let mut series = [0.0; 9];
        for (start, length) in [(0, 5), (5, 4)] {
            for k in 0..length {
                let past = |i: usize| if k >= i { series[start + k - i] } else { 0.0 };
                series[start + k] = white[start + k] + 0.8 * past(1) - 0.2 * past(2);
            }
        }
        let again = whitener.whiten(&series);
        // The first two of a segment have no past.
        let expected = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        for (a, b) in again.iter().zip(expected) {
            assert!((a - b).abs() < 1e-12);
        }
    }

    #[test]
    fn what_is_carried_is_the_quadratic_form_of_the_covariance() {
        // First order, stationary from a far past within the segment: Γ_ij = φ^|i-j|/(1-φ²).
        let phi: f64 = 0.7;
        let n = 200;
        let whitener = Whitener::new(&[phi], &[n]);
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
        assert!((whitener.carried(&s) / form - 1.0).abs() < 1e-9);
    }
}
