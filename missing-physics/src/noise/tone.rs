//! A tone in what is left: no noise has one, and no effect of a rod.

use recording::order::falling;

use crate::noise::slowness::MEDIAN;

/// Number of lags at which a residual is compared with itself; they begin at a quarter of the recording.
const LAGS: usize = 64;

/// Most samples at which the lags begin.
const FARTHEST: usize = 300;

/// Least samples at which they begin: beyond the memory that differences of noise have.
const NEAREST: usize = 64;

/// Deviations of a normal distribution beyond which a difference counts no more: two outliers at one distance are no tone.
const OUTLIER: f64 = 3.0;

/// Lags at which a tone is heard, at least: a mismatch that comes back with a repeated drive does so at one distance, and a tone at many.
const HEARD: usize = 8;

/// Sum of squares of all correlations of differences of white noise.
const OF_NEIGHBORS: f64 = 1.5;

/// How much a residual repeats itself at long lags, sample by sample, in standard deviations of the correlation of white noise;
/// 0 of a recording too short to tell, of less than 256 samples.
///
/// ```text
/// |Σ d_k d_(k+lag)| / (Σ d_k² √(1.5 (n - lag)) / n),   d_k = r_(k+1) - r_k, cut at three deviations;   the eighth largest
/// ```
///
/// Differences forget what is slow: mismatches of physics, and noise that grows toward low frequencies. Those of white noise have a
/// correlation of -½ with their neighbors, and the sum of squares of all correlations is 1.5.
pub(crate) fn tone(residual: &[f64]) -> f64 {
    let first = (residual.len() / 4).min(FARTHEST);
    if first < NEAREST {
        return 0.0;
    }
    let mut steps: Vec<f64> = residual.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mut magnitudes: Vec<f64> = steps.iter().map(|step| step.abs()).collect();
    magnitudes.sort_by(f64::total_cmp);
    let most = OUTLIER * magnitudes[magnitudes.len() / 2] / MEDIAN;
    if most > 0.0 {
        for step in &mut steps {
            *step = step.clamp(-most, most);
        }
    }
    let n = steps.len() as f64;
    let all: f64 = steps.iter().map(|step| step * step).sum();
    let correlation = |lag: usize| {
        let later = steps[lag..].iter();
        let product: f64 = steps.iter().zip(later).map(|(a, b)| a * b).sum();
        let deviation = all * (OF_NEIGHBORS * (n - lag as f64)).sqrt() / n;
        product.abs() / deviation.max(f64::MIN_POSITIVE)
    };
    let mut correlations: Vec<f64> = (first..first + LAGS).map(correlation).collect();
    falling(&mut correlations, |one| *one);
    correlations[HEARD - 1]
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    #[test]
    fn a_tone_is_heard_in_noise_and_noise_has_none() {
        let mut tones = 0;
        for (seed, n) in (0..100).zip([6000, 600, 300, 256].into_iter().cycle()) {
            let rng = ChaCha8Rng::seed_from_u64(seed);
            let mut colored: Vec<f64> = StandardNormal.sample_iter(rng).take(n).collect();
            for k in 1..colored.len() {
                colored[k] += 0.95 * colored[k - 1];
            }
            tones += usize::from(tone(&colored) > 6.0);
            let hum = colored
                .iter()
                .enumerate()
                .map(|(k, value)| value + 2.0 * (1.3 * k as f64).sin());
            assert!(tone(&hum.collect::<Vec<f64>>()) > 6.0);
        }
        assert_eq!(tones, 0);
    }

    #[test]
    fn outliers_are_no_tone() {
        for seed in 0..100 {
            let rng = ChaCha8Rng::seed_from_u64(seed);
            let mut noise: Vec<f64> = StandardNormal.sample_iter(rng).take(800).collect();
            // At one distance, which is among the lags.
            for k in [150, 370, 590] {
                noise[k] = 40.0;
            }
            assert!(tone(&noise) < 6.0, "{}", tone(&noise));
        }
    }

    #[test]
    fn a_mismatch_that_comes_back_with_the_drive_is_no_tone() {
        let rng = ChaCha8Rng::seed_from_u64(1);
        let mut noise: Vec<f64> = StandardNormal.sample_iter(rng).take(600).collect();
        // Three equal cycles of 170 samples, among the lags, with a mismatch at each step of the drive.
        for k in [40, 80, 120]
            .iter()
            .flat_map(|at| [*at, at + 170, at + 340])
        {
            for (more, value) in noise[k..k + 5].iter_mut().enumerate() {
                *value += 30.0 * 0.5_f64.powi(more as i32);
            }
        }
        assert!(tone(&noise) < 6.0, "{}", tone(&noise));
    }
}
