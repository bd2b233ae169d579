//! Residual analysis in the manner of an identification toolbox.

use identify::ResidualNoise;
use serde::{Deserialize, Serialize};

use super::seen::Seen;

/// Lags that are looked at: the usual default.
const LAGS: usize = 25;

/// 99 % point of χ² with as many degrees of freedom as lags.
const CHI_SQUARED_99: f64 = 44.3141;

/// Standard errors of a 99 % band.
const NORMAL_99: f64 = 2.5758;

/// Tests of the correlations of the baseline model's residual. They show that something is wrong, never what.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Whiteness {
    /// True if neighbors in the training residual are correlated, p < 0.01.
    ///
    /// ```text
    /// Q = n (n + 2) Σ r_k²/(n - k),   k = 1 … 25,   against χ² of 25 degrees        [Ljung and Box 1978]
    /// ```
    ///
    /// r_k is the residual's autocorrelation (doi:10.1093/biomet/65.2.297).
    pub is_not_white: bool,
    /// True if the residual's correlation with the drive leaves its 99 % band at any lag of 0 … 25 samples, the drive first,
    /// after both have passed the filter that whitens the residual.
    ///
    /// ```text
    /// e_k ← e_k - Σ a_i e_(k-i),   u_k ← u_k - Σ a_i u_(k-i),   a, order ≤ 8 by BIC, of the residual
    /// |c_k| > 2.58 √(Σ R_e(j) R_u(j) / n),   j = -25 … 25        [Ljung, System Identification, 2nd ed., 16.6]
    /// ```
    ///
    /// c is the covariance of residual and drive, R_e and R_u are their autocovariances; the sum ends where the lags end, as
    /// toolboxes have it, and counts as R_e(0) R_u(0) where it is not positive. Without the filter, which does not change how
    /// one follows the other, the band of a slow drive is so wide that almost nothing leaves it.
    pub depends_on_drive: bool,
}

pub(super) fn whiteness(training: &[Seen<'_>]) -> Whiteness {
    let pairs = training.iter().map(|seen| Pair {
        residual: about_mean(&seen.residual),
        drive: about_mean(seen.recording.drive()),
    });
    of(&pairs.collect::<Vec<_>>())
}

/// Series of one recording, each about its mean.
#[derive(Debug)]
struct Pair {
    residual: Vec<f64>,
    drive: Vec<f64>,
}

fn of(pairs: &[Pair]) -> Whiteness {
    let segments: Vec<&[f64]> = pairs.iter().map(|pair| &pair.residual[..]).collect();
    let memory = ResidualNoise::of(&segments).coefficients;
    let filtered: Vec<Pair> = pairs
        .iter()
        .map(|pair| Pair {
            residual: about_mean(&innovations(&pair.residual, &memory)),
            drive: about_mean(&innovations(&pair.drive, &memory)),
        })
        .collect();
    Whiteness {
        is_not_white: is_not_white(pairs),
        depends_on_drive: depends_on_drive(&filtered),
    }
}

fn is_not_white(pairs: &[Pair]) -> bool {
    let n = n_samples(pairs);
    let own = covariances(pairs, |pair| [&pair.residual, &pair.residual]);
    let parts = (1..=LAGS).map(|lag| (own[lag] / own[0]).powi(2) / (n - lag as f64));
    let portmanteau = n * (n + 2.0) * parts.sum::<f64>();
    n > LAGS as f64 && own[0] > 0.0 && portmanteau > CHI_SQUARED_99
}

fn depends_on_drive(pairs: &[Pair]) -> bool {
    let n = n_samples(pairs);
    let own = covariances(pairs, |pair| [&pair.residual, &pair.residual]);
    let drive = covariances(pairs, |pair| [&pair.drive, &pair.drive]);
    let cross = covariances(pairs, |pair| [&pair.residual, &pair.drive]);
    let both = own[0] * drive[0];
    let later: f64 = (1..=LAGS).map(|lag| own[lag] * drive[lag]).sum();
    let variance = match both + 2.0 * later {
        sum if sum > 0.0 => sum / n,
        _ => both / n,
    };
    let band = NORMAL_99 * variance.sqrt();
    n > LAGS as f64 && both > 0.0 && cross.iter().any(|c| c.abs() > band)
}

fn n_samples(pairs: &[Pair]) -> f64 {
    pairs.iter().map(|pair| pair.residual.len()).sum::<usize>() as f64
}

/// Covariances of two series, the second first, at lags 0 to the highest; no recording is continued by the next.
fn covariances(pairs: &[Pair], of: impl Fn(&Pair) -> [&[f64]; 2]) -> Vec<f64> {
    let n = n_samples(pairs).max(1.0);
    let at = |lag: usize| {
        let sums = pairs.iter().map(|pair| {
            let [later, first] = of(pair);
            let products = later.iter().skip(lag).zip(first).map(|(a, b)| a * b);
            products.sum::<f64>()
        });
        sums.sum::<f64>() / n
    };
    (0..=LAGS).map(at).collect()
}

/// Innovations of a series: the part that an autoregressive model does not predict.
fn innovations(series: &[f64], coefficients: &[f64]) -> Vec<f64> {
    let innovation = |k: usize| {
        let past = series[..k].iter().rev().zip(coefficients);
        series[k] - past.map(|(x, a)| a * x).sum::<f64>()
    };
    (coefficients.len()..series.len()).map(innovation).collect()
}

fn about_mean(series: &[f64]) -> Vec<f64> {
    let mean = series.iter().sum::<f64>() / series.len().max(1) as f64;
    series.iter().map(|value| value - mean).collect()
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    const N: usize = 4_000;

    /// Files of one seed each: what of them is said.
    fn share(said: impl Fn(&mut ChaCha8Rng) -> bool) -> f64 {
        const FILES: u64 = 200;
        let n = (0..FILES).filter(|&seed| said(&mut ChaCha8Rng::seed_from_u64(seed)));
        n.count() as f64 / FILES as f64
    }

    /// An autoregressive series of the first order; 0 for white noise.
    fn noise(correlation: f64, random: &mut ChaCha8Rng) -> Vec<f64> {
        let mut last = 0.0;
        (0..N)
            .map(|_| {
                last = correlation * last + random.random::<f64>() - 0.5;
                last
            })
            .collect()
    }

    fn drive() -> Vec<f64> {
        let wave = |k: usize| (k as f64 / 60.0).sin().powi(2);
        (0..N).map(wave).collect()
    }

    fn said(residual: &[f64], drive: &[f64]) -> Whiteness {
        of(&[Pair {
            residual: about_mean(residual),
            drive: about_mean(drive),
        }])
    }

    #[test]
    fn white_noise_is_white_and_knows_nothing_of_the_drive() {
        let is_not_white = share(|random| said(&noise(0.0, random), &drive()).is_not_white);
        let depends = share(|random| said(&noise(0.0, random), &drive()).depends_on_drive);
        // Of one test each, p = 0.01; the lags of a slow drive are nearly one.
        assert!(is_not_white < 0.04, "{is_not_white}");
        assert!(depends < 0.06, "{depends}");
    }

    #[test]
    fn noise_with_a_memory_is_not_white() {
        assert!(share(|random| said(&noise(0.2, random), &drive()).is_not_white) > 0.99);
    }

    #[test]
    fn what_follows_the_drive_depends_on_it() {
        let drive = drive();
        let follows = |random: &mut ChaCha8Rng| {
            let noise = noise(0.0, random);
            let both = noise.iter().zip(&drive);
            let residual: Vec<f64> = both.map(|(noise, drive)| noise + 0.1 * drive).collect();
            said(&residual, &drive).depends_on_drive
        };
        assert!(share(follows) > 0.99);
    }

    #[test]
    fn nothing_is_said_of_nothing() {
        let quiet = Whiteness {
            is_not_white: false,
            depends_on_drive: false,
        };
        assert_eq!(said(&[0.0; 100], &drive()[..100]), quiet);
        assert_eq!(said(&[1.0, -1.0, 2.0], &[0.0, 1.0, 2.0]), quiet);
        assert_eq!(of(&[]), quiet);
    }
}
