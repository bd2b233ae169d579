//! How much of the belief falls on each of some models, given how they did on blocks.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Exp1};

/// Draws of the blocks' weights.
const DRAWS: usize = 1000;

/// Probabilities of models from the densities that they gave to the same blocks, and the logarithms of their priors.
///
/// The blocks at hand are a sample of those that there could be: their weights are drawn (Bayesian bootstrap, Rubin 1981),
/// and what is left to chance in the sum of the differences between two models is left open between them (pseudo-BMA+,
/// Yao, Vehtari, Simpson and Gelman 2018). Where all models are wrong, likelihoods as they are would be sure of the one
/// that is wrong by least.
pub(crate) fn masses(models: &[(f64, &[f64])], seed: u64) -> Vec<f64> {
    let n_blocks = models.first().map_or(0, |(_, nats)| nats.len());
    let mut masses = vec![0.0; models.len()];
    for drawn in weights(n_blocks, seed) {
        let per = n_blocks as f64 / drawn.iter().sum::<f64>();
        let worth: Vec<f64> = models
            .iter()
            .map(|(prior, nats)| {
                let pairs = drawn.iter().zip(*nats);
                prior + per * pairs.map(|(weight, nats)| weight * nats).sum::<f64>()
            })
            .collect();
        let highest = worth.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let odds: Vec<f64> = worth.iter().map(|worth| (worth - highest).exp()).collect();
        let total: f64 = odds.iter().sum();
        for (mass, odds) in masses.iter_mut().zip(odds) {
            *mass += odds / total / DRAWS as f64;
        }
    }
    masses
}

/// Probability that the sum of one number a block is not above 0, by the same draws.
pub(crate) fn not_above_zero(numbers: &[f64], seed: u64) -> f64 {
    let sum = |drawn: &Vec<f64>| -> f64 {
        let pairs = drawn.iter().zip(numbers);
        pairs.map(|(weight, number)| weight * number).sum()
    };
    let draws = weights(numbers.len(), seed);
    draws.filter(|drawn| sum(drawn) <= 0.0).count() as f64 / DRAWS as f64
}

/// Weights of blocks, draw by draw.
fn weights(n_blocks: usize, seed: u64) -> impl Iterator<Item = Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let draws = std::iter::repeat_with(move || {
        let own = (0..n_blocks).map(|_| Exp1.sample(&mut rng));
        own.collect()
    });
    draws.take(DRAWS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_models_share_by_their_priors_and_the_better_takes_all() {
        let even = [1.0; 16];
        let better = [2.0; 16];
        let shared = masses(&[(0.0, &even), (-3.0, &even)], 1);
        assert!((shared[1] / shared[0] - (-3.0_f64).exp()).abs() < 1e-9);
        assert!(masses(&[(0.0, &even), (-3.0, &better)], 1)[1] > 0.999);
    }

    #[test]
    fn a_sum_is_as_sure_as_its_blocks_agree() {
        let alike = [-1.0; 16];
        let mut torn = [1.0; 16];
        torn[5] = -16.0;
        assert!((not_above_zero(&alike, 1) - 1.0).abs() < 1e-12);
        let probability = not_above_zero(&torn, 1);
        assert!((0.2..0.8).contains(&probability), "{probability}");
        assert!(not_above_zero(&alike.map(|one| -one), 1) < 1e-12);
    }

    #[test]
    fn what_one_block_alone_says_is_not_believed() {
        let even = [0.0; 16];
        let mut lucky = [-1.0; 16];
        lucky[3] = 30.0;
        let shared = masses(&[(0.0, &even), (0.0, &lucky)], 1);
        // 15 nats ahead in sum: odds of three millions to one, were the blocks as sure as they are many.
        assert!((0.4..0.95).contains(&shared[1]), "{}", shared[1]);
    }
}
