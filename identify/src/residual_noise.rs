//! Autoregressive model of the residuals, from which intervals learn how few independent samples there really are.

/// Highest order of the autoregressive model: sensors and filters need one to three, and the order is
/// chosen by BIC.
const HIGHEST_ORDER: usize = 8;

/// Autoregressive model of residuals.
///
/// ```text
/// e_k = Σ a_i e_(k-i) + w_k,   order by BIC [Schwarz1978], a by Levinson's recursion
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualNoise {
    /// a_1 … a_p; empty for white residuals.
    pub coefficients: Vec<f64>,
    /// Variance of w, in the square of the residual's unit.
    pub innovation_variance: f64,
    /// Variance of e, in the square of the residual's unit.
    pub variance: f64,
    /// Correlation of neighbors, lag 1.
    pub lag_1: f64,
    /// Number of residuals N.
    pub n_samples: usize,
    /// Independent residuals that would tell as much of their variance, N/(1 + 2 Σ ρ_k²).
    pub n_effective: f64,
}

impl ResidualNoise {
    /// Fits the model to segments of residuals, none of them continued by the next.
    #[must_use]
    pub fn of(segments: &[&[f64]]) -> Self {
        Self::of_at_least(segments, 0.0)
    }

    /// That of residuals in which there is noise of at least a standard deviation, whether they show it or not.
    #[must_use]
    pub fn of_at_least(segments: &[&[f64]], deviation: f64) -> Self {
        let n_samples: usize = segments.iter().map(|segment| segment.len()).sum();
        let n = n_samples.max(1) as f64;
        let covariance = |lag: usize| {
            let sum: f64 = segments
                .iter()
                .flat_map(|segment| segment.iter().zip(segment.iter().skip(lag)))
                .map(|(before, after)| before * after)
                .sum();
            sum / n
        };
        let mut covariances: Vec<f64> = (0..=HIGHEST_ORDER).map(covariance).collect();
        covariances[0] = covariances[0].max(deviation * deviation);
        let variance = covariances[0];
        let (coefficients, innovation_variance) = best_order(&covariances, n);
        Self {
            n_effective: n / sum_of_squared_correlations(&coefficients, &covariances),
            lag_1: if variance > 0.0 {
                covariances[1] / variance
            } else {
                0.0
            },
            coefficients,
            innovation_variance,
            variance,
            n_samples,
        }
    }
}

/// The order of lowest BIC, by Levinson's recursion over the autocovariances.
fn best_order(covariances: &[f64], n: f64) -> (Vec<f64>, f64) {
    let mut coefficients: Vec<f64> = Vec::new();
    let mut variance = covariances[0];
    let mut best = (f64::INFINITY, coefficients.clone(), variance);
    for order in 0..covariances.len() {
        if variance <= 0.0 {
            break;
        }
        let bic = n * variance.ln() + order as f64 * n.ln();
        if bic < best.0 {
            best = (bic, coefficients.clone(), variance);
        }
        if order + 1 == covariances.len() {
            break;
        }
        let predicted: f64 = (0..order)
            .map(|i| coefficients[i] * covariances[order - i])
            .sum();
        let reflection = (covariances[order + 1] - predicted) / variance;
        let reversed: Vec<f64> = coefficients.iter().rev().copied().collect();
        for (a, b) in coefficients.iter_mut().zip(reversed) {
            *a -= reflection * b;
        }
        coefficients.push(reflection);
        variance *= 1.0 - reflection * reflection;
    }
    (best.1, best.2)
}

/// 1 + 2 Σ ρ_k², with the correlations that the model implies, until they have died out.
fn sum_of_squared_correlations(coefficients: &[f64], covariances: &[f64]) -> f64 {
    const LONGEST: usize = 100_000;
    let order = coefficients.len();
    if order == 0 {
        return 1.0;
    }
    let mut recent: Vec<f64> = (0..order)
        .map(|lag| covariances[lag] / covariances[0])
        .collect();
    let mut sum = 1.0 + 2.0 * recent[1..].iter().map(|rho| rho * rho).sum::<f64>();
    for _ in order..LONGEST {
        let next: f64 = (0..order)
            .map(|i| coefficients[i] * recent[order - 1 - i])
            .sum();
        sum += 2.0 * next * next;
        recent.rotate_left(1);
        recent[order - 1] = next;
        if recent.iter().all(|rho| rho.abs() < 1e-4) {
            break;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    fn series(phi: f64, n: usize) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut state = 0.0;
        (0..n)
            .map(|_| {
                let innovation: f64 = StandardNormal.sample(&mut rng);
                state = phi * state + innovation;
                state
            })
            .collect()
    }

    #[test]
    fn white_residuals_have_no_memory() {
        let noise = ResidualNoise::of(&[&series(0.0, 20_000)]);
        assert!(noise.coefficients.is_empty());
        assert!((noise.variance - 1.0).abs() < 0.03 && noise.lag_1.abs() < 0.02);
        assert!((noise.n_effective - 20_000.0).abs() < 1.0);
    }

    #[test]
    fn correlated_residuals_count_for_fewer() {
        let noise = ResidualNoise::of(&[&series(0.9, 10_000), &series(0.9, 10_000)]);
        assert!((noise.lag_1 - 0.9).abs() < 0.02);
        assert!((noise.innovation_variance - 1.0).abs() < 0.05);
        // N (1 - φ²)/(1 + φ²)
        assert!((noise.n_effective / (20_000.0 * 0.19 / 1.81) - 1.0).abs() < 0.2);
    }

    #[test]
    fn residuals_that_vanish_are_white() {
        let noise = ResidualNoise::of(&[&[0.0; 50]]);
        assert!(noise.coefficients.is_empty() && noise.lag_1 == 0.0);
    }
}
