//! Slip of a sensor's mount, which looks like a drift of the sensor's zero.

use std::ops::Range;

use identify::{ForwardModel, IdentifyError, ParameterVector};

use crate::model::case::{Case, Node};
use crate::model::projection::{Span, dot};
use crate::model::series::Channel;
use crate::model::tangent::{Sensitivity, sensitivities};
use crate::{Belongs, Candidate, EffectBlock};

/// Powers of the stroke that a slip may go with: a mount holds until the force is large.
const POWERS: [i32; 3] = [1, 2, 4];

/// Share of the square of a jump that is outside a span, from which it is another direction.
const LEAST_OUTSIDE: f64 = 1e-6;

/// A drift of the zero, and the squares that it leaves over those of a mount that slips: only while the rod is out, or once in each
/// recording and at once; `None` of a model without such a drift.
///
/// ```text
/// Σ_k c_k ∫ s^k dt,   k = 1, 2, 4,   s the share of the output's range
/// c from the moment t₁ on
/// ```
///
/// A drift of the sensor knows nothing of the rod, and is slow; it has four values, a slip three, and a jump two. The other parameters
/// may follow any of them, to first order: they were fitted beside the drift. What stands on a bound, or has a prior, stays.
pub(crate) fn slip(
    case: &Case<'_>,
    node: &Node,
) -> Result<Option<(Candidate, f64)>, IdentifyError> {
    let is_of_zero = |effect: &Candidate| {
        let info = effect.info();
        info.belongs_to == Belongs::Recording && info.block == EffectBlock::Displacement
    };
    let drift = node.effects.iter().find(is_of_zero);
    let Some((of_zero, first)) =
        drift.and_then(|one| Some((one, node.model.first_parameter(one)?)))
    else {
        return Ok(None);
    };
    let knots = first..first + of_zero.info().parameters.len();
    let shown = case
        .layout
        .shown(&node.model, case.training, |r| {
            let mut point = node.points[r].clone();
            point[knots.clone()].fill(0.0);
            vec![point]
        })?
        .swap_remove(0);
    let outputs: Vec<Range<usize>> = case
        .layout
        .of_channel(Channel::Output)
        .map(|one| one.range.clone())
        .collect();
    let of_outputs = |series: &[f64]| -> Vec<f64> {
        let own = outputs.iter().flat_map(|range| &series[range.clone()]);
        own.copied().collect()
    };
    let recorded = case.recorded();
    let left: Vec<f64> = recorded.iter().zip(&shown).map(|(y, f)| y - f).collect();
    let vector = ParameterVector::new(node.model.parameters(), case.training.len());
    let is_of_drift = |one: &Sensitivity| {
        one.coordinate
            .is_some_and(|j| knots.contains(&vector.parameter(j)))
    };
    let (drift, others): (Vec<Sensitivity>, Vec<Sensitivity>) = sensitivities(case, node)?
        .into_iter()
        .partition(is_of_drift);
    let has_prior = |j: usize| vector.infos()[vector.parameter(j)].ordinary.is_some();
    let is_free = |one: &&Sensitivity| !one.held && !one.coordinate.is_some_and(has_prior);
    let drift: Vec<Vec<f64>> = drift.iter().map(|one| of_outputs(&one.column)).collect();
    // Of each recording its own.
    let (mut levels, mut slipped) = (Vec::new(), Vec::new());
    for range in &outputs {
        let alone = |column: &[f64]| {
            let mut alone = vec![0.0; recorded.len()];
            alone[range.clone()].copy_from_slice(column);
            of_outputs(&alone)
        };
        levels.push(alone(&vec![1.0; range.len()]));
        slipped.extend(slips(&recorded[range.clone()]).iter().map(|one| alone(one)));
    }
    levels.extend(
        others
            .iter()
            .filter(is_free)
            .map(|one| of_outputs(&one.column)),
    );
    let drifting = without(&of_outputs(&node.residual), &[&levels, &drift]);
    let left = of_outputs(&left);
    let slipping = without(&left, &[&levels, &slipped]);
    let jumping = with_jumps(&left, Span::of(&levels), &joined(&outputs));
    let least = slipping.min(jumping).max(f64::MIN_POSITIVE);
    Ok(Some((of_zero, drifting / least)))
}

/// Ranges of recordings that follow upon one another.
fn joined(ranges: &[Range<usize>]) -> Vec<Range<usize>> {
    let mut end = 0;
    let next = |range: &Range<usize>| {
        let start = end;
        end += range.len();
        start..end
    };
    ranges.iter().map(next).collect()
}

/// Sum of squares that is left of a series outside a span and one jump in each recording, where it helps most.
fn with_jumps(series: &[f64], mut span: Span, recordings: &[Range<usize>]) -> f64 {
    for range in recordings {
        let left = span.outside(series);
        let basis = span.basis().iter();
        let basis: Vec<Vec<f64>> = basis.map(|one| from_each_on(&one[range.clone()])).collect();
        let gains = from_each_on(&left[range.clone()]).into_iter().enumerate();
        let gains = gains.map(|(k, along)| {
            let own = (range.len() - k) as f64;
            let outside = own - basis.iter().map(|one| one[k].powi(2)).sum::<f64>();
            // A jump that the span holds helps nothing.
            if outside > LEAST_OUTSIDE * own {
                along.powi(2) / outside
            } else {
                0.0
            }
        });
        let Some((at, _)) = gains.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)) else {
            continue;
        };
        let mut jump = vec![0.0; series.len()];
        jump[range.start + at..range.end].fill(1.0);
        span.widen(&jump);
    }
    let left = span.outside(series);
    dot(&left, &left)
}

/// Sums of a series from each of its samples to its end.
fn from_each_on(series: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    let sums = series.iter().rev().map(|value| {
        sum += value;
        sum
    });
    let mut sums: Vec<f64> = sums.collect();
    sums.reverse();
    sums
}

/// How far mounts would have slipped, each in its own unit.
fn slips(output: &[f64]) -> Vec<Vec<f64>> {
    let low = output.iter().copied().fold(f64::INFINITY, f64::min);
    let high = output.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let share = |y: f64| (y - low) / (high - low).max(f64::MIN_POSITIVE);
    let slipped = |power: i32| {
        let mut sum = 0.0;
        let rates = output.iter().map(move |&y| share(y).powi(power));
        rates
            .map(|rate| {
                sum += rate;
                sum
            })
            .collect()
    };
    POWERS.map(slipped).to_vec()
}

/// Sum of squares of a series that is left beside some columns.
fn without(series: &[f64], columns: &[&Vec<Vec<f64>>]) -> f64 {
    let left = Span::of(columns.iter().copied().flatten()).outside(series);
    dot(&left, &left)
}

#[cfg(test)]
mod tests {
    use super::{Span, joined, slips, with_jumps, without};

    #[test]
    fn a_slip_goes_with_the_stroke_and_a_drift_does_not() {
        let output: Vec<f64> = (0..400)
            .map(|k| (f64::from(k) * 0.05).sin().max(0.0))
            .collect();
        let mut slipped = 0.0;
        let slip: Vec<f64> = output
            .iter()
            .map(|y| {
                slipped += 0.01 * y * y;
                slipped
            })
            .collect();
        let ramp: Vec<f64> = (0..400).map(|k| 0.005 * f64::from(k)).collect();
        let (level, columns) = (vec![vec![1.0; 400]], slips(&output));
        let share =
            |series: &[f64]| without(series, &[&level, &columns]) / without(series, &[&level]);
        assert!(share(&slip) < 1e-9, "{}", share(&slip));
        assert!(share(&ramp) > 1e-3, "{}", share(&ramp));
    }

    #[test]
    fn a_jump_is_found_in_each_recording_and_a_ramp_is_none() {
        let recordings = joined(&[10..210, 300..500]);
        assert_eq!(recordings, [0..200, 200..400]);
        let level = |range: &std::ops::Range<usize>| -> Vec<f64> {
            (0..400)
                .map(|k| f64::from(u8::from(range.contains(&k))))
                .collect()
        };
        let levels = [level(&recordings[0]), level(&recordings[1])];
        let sine: Vec<f64> = (0..400).map(|k| (f64::from(k) * 0.05).sin()).collect();
        let left = |series: &[f64]| {
            let span = Span::of(levels.iter().chain([&sine]));
            let whole = without(series, &[&levels.to_vec()]);
            with_jumps(series, span, &recordings) / whole
        };
        let jumps: Vec<f64> = (0..400)
            .map(|k| if (60..200).contains(&k) { 0.3 } else if k >= 333 { -0.1 } else { 0.0 } + 0.2 * sine[k])
            .collect();
        assert!(left(&jumps) < 1e-9, "{}", left(&jumps));
        let ramp: Vec<f64> = (0..400).map(|k| 0.01 * f64::from(k % 200)).collect();
        assert!(left(&ramp) > 0.1, "{}", left(&ramp));
    }
}
