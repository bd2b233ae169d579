//! How often noise of the same spectrum meets a prediction as well: by circular shifts.

use identify::in_parallel;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::model::projection::dot;

/// Share of a recording by which it is shifted at least.
const LEAST: f64 = 0.05;

/// Shifts that one thread takes at once: of a short recording one alone is less work than its share.
const AT_ONCE: usize = 64;

/// Probability that noise goes along with a prediction as well as a series does.
///
/// `pairs` has a series and what was predicted of it, recording by recording, both without their means. What the
/// prediction does not account for is shifted around in time against it: noise stays what it is, of whatever spectrum,
/// and no longer meets the prediction but by chance. What the prediction accounts for is taken out before, since under a
/// drive that repeats itself it would meet it again (residuals under the full model: ter Braak 1992). No probability is below
/// 1/(1 + `shifts`).
pub(crate) fn by_chance(pairs: &[(Vec<f64>, Vec<f64>)], shifts: usize, seed: u64) -> f64 {
    let product = |of: fn(&(Vec<f64>, Vec<f64>)) -> f64| pairs.iter().map(of).sum::<f64>();
    let found = product(|(series, predicted)| dot(series, predicted));
    let square = product(|(_, predicted)| dot(predicted, predicted));
    if found <= 0.0 || square <= 0.0 {
        return 1.0;
    }
    let slope = found / square;
    let left: Vec<Vec<f64>> = pairs
        .iter()
        .map(|(series, predicted)| {
            let pairs = series.iter().zip(predicted);
            pairs
                .map(|(series, predicted)| series - slope * predicted)
                .collect()
        })
        .collect();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let drawn: Vec<Vec<usize>> = (0..shifts)
        .map(|_| {
            let each = left.iter().map(|left| {
                let n = left.len();
                let least = (LEAST * n as f64) as usize;
                rng.random_range(least..(n - least).max(least + 1))
            });
            each.collect()
        })
        .collect();
    let meets_as_well = |each: &&Vec<usize>| {
        let shifted = left.iter().zip(pairs).zip(*each);
        let along = shifted.map(|((left, (_, predicted)), &shift)| {
            let (begin, end) = left.split_at(shift);
            let (first, last) = predicted.split_at(left.len() - shift);
            dot(end, first) + dot(begin, last)
        });
        along.sum::<f64>() >= found
    };
    let groups: Vec<&[Vec<usize>]> = drawn.chunks(AT_ONCE).collect();
    let as_well = in_parallel(&groups, |group| group.iter().filter(meets_as_well).count());
    let as_well: usize = as_well.into_iter().sum();
    (1 + as_well) as f64 / (1 + shifts) as f64
}

/// A series without its mean.
pub(crate) fn centered(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter().map(|value| value - mean).collect()
}
