//! How much of what a model leaves is predicted from what drove the rig, and whether by more than chance.

use crate::evidence::blocks::Block;
use crate::evidence::shifts::{by_chance, centered};
use crate::evidence::worth::Evidence;
use crate::model::case::Case;
use crate::model::series::Channel;

/// Shifts by which the probability is found.
pub(crate) const SHIFTS: usize = 999;

/// Part of an unseen residual that a curve of any shape predicts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Audit {
    /// Share of the residual's variance that is predicted; below 0 where the prediction is worse than none.
    pub share: f64,
    /// Upper end of a one-sided 95 % interval of it, by blocks.
    pub share_at_most: f64,
    /// Probability that noise of the same spectrum is met as well.
    pub p_value: f64,
}

/// A model with a curve of any shape on top.
#[derive(Debug, Clone)]
pub(crate) struct Anonymous {
    pub(crate) evidence: Evidence,
    pub(crate) audit: Audit,
}

/// Compares what a model leaves without and with the curve.
pub(crate) fn audit(
    case: &Case<'_>,
    [named, anonymous]: [&Evidence; 2],
    blocks: &[Block],
    seed: u64,
) -> Audit {
    let mut pairs = Vec::new();
    for segment in case.layout.of_channel(Channel::Output) {
        let left = centered(&named.residual[segment.range.clone()]);
        let with = centered(&anonymous.residual[segment.range.clone()]);
        let predicted = left
            .iter()
            .zip(&with)
            .map(|(left, with)| left - with)
            .collect();
        pairs.push((left, predicted));
    }
    let of_output = |evidence: &Evidence| -> Vec<f64> {
        evidence.squares.iter().map(|[output, _]| *output).collect()
    };
    let (before, after) = (of_output(named), of_output(anonymous));
    let share = 1.0 - after.iter().sum::<f64>() / before.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    // Blocks differ by as much from what all say.
    let total: f64 = before.iter().sum();
    let spread: f64 = before
        .iter()
        .zip(&after)
        .map(|(before, after)| ((1.0 - share) * before - after).powi(2))
        .sum();
    let n = blocks.len() as f64;
    let error = (spread * n / (n - 1.0).max(1.0)).sqrt() / total.max(f64::MIN_POSITIVE);
    Audit {
        share,
        share_at_most: (share.max(0.0) + 1.645 * error).min(1.0),
        p_value: by_chance(&pairs, SHIFTS, seed),
    }
}
