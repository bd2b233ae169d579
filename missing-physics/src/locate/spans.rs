//! Stretches of time that hold most of the error.

use recording::order::falling;

use crate::Span;
use crate::locate::located::Located;
use crate::pullback::scene::Scene;

/// Most stretches.
const MOST_SPANS: usize = 5;

/// Share of the explainable error at which the stretches found are enough.
const ENOUGH: f64 = 0.9;

/// Smallest share of a stretch.
const SMALLEST_SHARE: f64 = 0.03;

/// A square counts from this many times the floor's.
const ABOVE_FLOOR: f64 = 2.0;

/// Excess over the floor, in standard deviations of white noise's, below which a stretch may be noise.
const CLEAR: f64 = 4.0;

/// Samples of one recording.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stretch {
    recording: usize,
    first: usize,
    /// The one after the last.
    end: usize,
    /// Sum of what the squares exceed the threshold by.
    sum: f64,
}

/// The stretches with the largest sums of squares beyond the mean and twice the floor, one after the other.
pub(crate) fn spans(located: &Located<'_>, scene: &Scene) -> Vec<Span> {
    let noise = located.floor * located.floor;
    let explainable = located.explainable();
    let threshold = (ABOVE_FLOOR * noise).max(located.node.mean_square());
    let mut scores: Vec<Vec<f64>> = scene
        .passages
        .iter()
        .map(|passage| {
            let residual = &located.node.residual[passage.range.clone()];
            residual
                .iter()
                .map(|value| value * value - threshold)
                .collect()
        })
        .collect();
    let (mut spans, mut covered): (Vec<Span>, f64) = (Vec::new(), 0.0);
    while spans.len() < MOST_SPANS && covered < ENOUGH {
        let Some(stretch) = heaviest(&scores) else {
            break;
        };
        let passage = &scene.passages[stretch.recording];
        let residual = &located.node.residual[passage.range.clone()];
        let squares = residual[stretch.first..stretch.end].iter();
        let excess: f64 = squares.map(|value| value * value - noise).sum();
        let n_samples = (stretch.end - stretch.first) as f64;
        let share = excess / explainable;
        if share < SMALLEST_SHARE || excess < CLEAR * noise * (2.0 * n_samples).sqrt() {
            break;
        }
        scores[stretch.recording][stretch.first..stretch.end].fill(f64::NEG_INFINITY);
        covered += share;
        let last = stretch.end - 1;
        spans.push(Span {
            recording: located.case.training[stretch.recording].name().to_owned(),
            start_s: passage.time_s[stretch.first],
            end_s: passage.time_s[last] + passage.dt_s[last],
            share,
        });
    }
    falling(&mut spans, |span| span.share);
    spans
}

/// The stretch of the largest positive sum (Kadane's scan).
fn heaviest(scores: &[Vec<f64>]) -> Option<Stretch> {
    let mut best: Option<Stretch> = None;
    for (recording, scores) in scores.iter().enumerate() {
        let (mut first, mut sum) = (0, 0.0);
        for (k, score) in scores.iter().enumerate() {
            sum += score;
            if sum <= 0.0 {
                (first, sum) = (k + 1, 0.0);
            } else if best.is_none_or(|best| sum > best.sum) {
                best = Some(Stretch {
                    recording,
                    first,
                    end: k + 1,
                    sum,
                });
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_heaviest_stretch_bridges_a_short_dip() {
        let scores = vec![
            vec![-1.0, 3.0, -1.0, 4.0, -9.0, 5.0],
            vec![f64::NEG_INFINITY, 2.0],
        ];
        let found = heaviest(&scores).unwrap();
        assert_eq!((found.recording, found.first, found.end), (0, 1, 4));
        assert_eq!(heaviest(&[vec![-1.0, -2.0]]), None);
    }
}
