//! Probability that noise alone wanders by as much as an apparent drift.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, FisherF};

/// Means of a recording that are compared with their neighbors.
const MEANS: usize = 16;

/// Draws of the ratio of noise alone.
const DRAWS: usize = 4_000;

/// Octaves of a drift, half a cycle of the recording to four: below those that neighboring means tell of.
const OCTAVES: f64 = 3.0;

/// Probability that noise whose spectrum goes on as 1/f toward low frequencies wanders by as much as a drift; from what the drift
/// adds to each recording, what is left of it with the drift, and the number of the drift's knots.
///
/// ```text
/// F = Σ var(added)/(3/2 Σ a),   a = ½ mean (m_(k+1) - m_k)² of 16 means   [Allan's variance, 2 of its octaves in 1/f noise]
/// ```
pub(crate) fn by_wander<'a>(
    pairs: impl Iterator<Item = (&'a [f64], &'a [f64])>,
    n_knots: usize,
    seed: u64,
) -> f64 {
    let (mut added, mut wanders, mut n) = (0.0, 0.0, 0);
    for (drift, left) in pairs {
        if left.len() < 2 * MEANS {
            continue;
        }
        let mean = drift.iter().sum::<f64>() / drift.len() as f64;
        added += drift.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / drift.len() as f64;
        let means: Vec<f64> = (0..MEANS)
            .map(|k| {
                let part = &left[k * left.len() / MEANS..(k + 1) * left.len() / MEANS];
                part.iter().sum::<f64>() / part.len() as f64
            })
            .collect();
        let steps = means.windows(2).map(|pair| (pair[1] - pair[0]).powi(2));
        wanders += 0.5 * steps.sum::<f64>() / (MEANS - 1) as f64;
        n += 1;
    }
    let expected = 0.5 * OCTAVES * wanders;
    let degrees = [n * n_knots, n * (MEANS - 1)].map(|degrees| degrees as f64);
    let Ok(ratios) = FisherF::new(degrees[0], degrees[1]) else {
        return 0.0;
    };
    let rng = ChaCha8Rng::seed_from_u64(seed);
    let drawn = ratios.sample_iter(rng).take(DRAWS);
    let as_large = drawn.filter(|ratio| ratio * expected >= added).count();
    as_large as f64 / DRAWS as f64
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    #[test]
    fn a_drift_stands_out_of_white_noise_and_not_of_noise_that_wanders_as_much() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let white: Vec<f64> = (0..3_200)
            .map(|_| StandardNormal.sample(&mut rng))
            .collect();
        let drift: Vec<f64> = (0..3_200).map(|k| 1e-3 * f64::from(k)).collect();
        let p = by_wander(std::iter::once((&drift[..], &white[..])), 4, 1);
        assert!(p < 1e-3, "{p}");
        // Every octave as large: steps between means of the drift's own size.
        let slow: Vec<f64> = white
            .chunks(200)
            .flat_map(|part| vec![part[0]; 200])
            .collect();
        let p = by_wander(std::iter::once((&drift[..], &slow[..])), 4, 1);
        assert!(p > 0.05, "{p}");
    }
}
