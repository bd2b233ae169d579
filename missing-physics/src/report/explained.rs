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
    if n_stretches == 0 {
        return Explained {
            train,
            validate: None,
            validate_interval: None,
            by_findings: None,
        };
    }
    let validate = share([before, after], ceiling);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut drawn: Vec<f64> = (0..DRAWS)
        .filter_map(|_| {
            let stretches = (0..n_stretches).map(|_| rng.random_range(0..n_stretches));
            share_of([before, after], stretches, ceiling)
        })
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
        by_findings: None,
    }
}

/// Share of the explainable error of unseen recordings that a model explains, from the errors of the baseline model and of it; `None`
/// where nothing can be explained.
pub(crate) fn share([before, after]: [&Unseen; 2], ceiling: f64) -> Option<f64> {
    share_of([before, after], 0..before.stretches.len(), ceiling)
}

fn share_of(
    [before, after]: [&Unseen; 2],
    stretches: impl Iterator<Item = usize>,
    ceiling: f64,
) -> Option<f64> {
    let (mut n, mut sums) = (0.0, [0.0; 2]);
    for k in stretches {
        n += before.stretches[k].0;
        sums[0] += before.stretches[k].1;
        sums[1] += after.stretches[k].1;
    }
    let [before, after] = sums.map(|sum| sum / n);
    let explainable = before - ceiling.min(after);
    (explainable > 0.0).then(|| (before - after) / explainable)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_is_of_what_can_be_explained() {
        let of = |squares: [f64; 2]| Unseen::of_squares(squares.map(|sum| (2.0, sum)).to_vec());
        let [before, half, nearer] = [[8.0, 12.0], [4.0, 8.0], [1.0, 1.0]].map(of);
        // Mean squares of 5, 3 and ½, of which 1 stays.
        assert_eq!(share([&before, &half], 1.0), Some(0.5));
        // A model below the ceiling lowers it.
        assert_eq!(share([&before, &nearer], 1.0), Some(1.0));
        assert_eq!(share([&nearer, &nearer], 1.0), None);
        let all = explained([&before, &half], None, 1.0, 1);
        assert_eq!(all.validate, Some(0.5));
        let [low, high] = all.validate_interval.unwrap();
        // Of either stretch alone.
        assert!((low - 0.4).abs() < 1e-12 && (high - 2.0 / 3.0).abs() < 1e-12);
    }
}
