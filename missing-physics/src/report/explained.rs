//! How much of the error on recordings that were not used is explained, and how surely.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::model::unseen::Unseen;
use crate::report::diagnosis::Explained;

/// Times that the stretches are drawn anew.
const DRAWS: usize = 500;

/// Shares of the explainable error that are explained, from the errors of the plain and of the extended model; `ceiling` is the
/// mean square that there is no way below.
pub(crate) fn explained(
    [before, after]: [&Unseen; 2],
    train: Option<f64>,
    ceiling: f64,
    seed: u64,
) -> Explained {
    let n_stretches = before.stretches.len();
    let share = |pick: &mut dyn FnMut(usize) -> usize| {
        let (mut n, mut sums) = (0.0, [0.0; 2]);
        for k in 0..n_stretches {
            let k = pick(k);
            n += before.stretches[k].0;
            sums[0] += before.stretches[k].1;
            sums[1] += after.stretches[k].1;
        }
        let [before, after] = sums.map(|sum| sum / n);
        let explainable = before - ceiling.min(after);
        (explainable > 0.0).then(|| (before - after) / explainable)
    };
    if n_stretches == 0 {
        return Explained {
            train,
            validate: None,
            validate_interval: None,
        };
    }
    let validate = share(&mut |k| k);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut drawn: Vec<f64> = (0..DRAWS)
        .filter_map(|_| share(&mut |_| rng.random_range(0..n_stretches)))
        .collect();
    drawn.sort_by(f64::total_cmp);
    let quantile = |share: f64| {
        let place = (share * drawn.len() as f64) as usize;
        drawn.get(place.min(drawn.len().saturating_sub(1))).copied()
    };
    Explained {
        train,
        validate,
        validate_interval: quantile(0.025)
            .zip(quantile(0.975))
            .filter(|_| validate.is_some())
            .map(|(low, high)| [low, high]),
    }
}
