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

/// Share of the square of a step outside a span, from which it is another direction.
const LEAST_OUTSIDE: f64 = 1e-6;

/// The drift of the zero of a model, and its squared error over that of a mount that slips, gradually or at once, whichever is nearer;
/// `None` of a model without such a drift.
///
/// ```text
/// gradually   Σ_k c_k ∫ s^k dt,   k = 1, 2, 4,   s the share of the output's range
/// at once     c from the moment t₁ on, in each recording its own
/// ```
///
/// A drift of the sensor knows nothing of the rod, and is slow; it has four values, the gradual slip three, and a step two. The other
/// parameters may follow any of them, to first order: they were fitted beside the drift. What stands on a bound, or has a prior, stays.
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
    let levels = Span::of(&levels);
    let drifting = beside(&of_outputs(&node.residual), levels.clone(), &drift);
    let left = of_outputs(&left);
    let slipping = beside(&left, levels.clone(), &slipped);
    let stepping = with_steps(&left, levels, &outputs);
    let least = slipping.min(stepping).max(f64::MIN_POSITIVE);
    Ok(Some((of_zero, drifting / least)))
}

/// Sum of squares outside a span and one step in each recording, each where it reduces the sum most. The place of a step is chosen
/// among all samples: by Schwarz's criterion it costs the logarithm of their number.
fn with_steps(series: &[f64], mut span: Span, recordings: &[Range<usize>]) -> f64 {
    let mut places = 0.0;
    for range in recordings {
        let left = span.outside(series);
        let basis = span.basis().iter();
        let basis: Vec<Vec<f64>> = basis.map(|one| from_each_on(&one[range.clone()])).collect();
        let mut best = (0, 0.0);
        for (k, along) in from_each_on(&left[range.clone()]).into_iter().enumerate() {
            let own = (range.len() - k) as f64;
            let outside = own - basis.iter().map(|one| one[k].powi(2)).sum::<f64>();
            // A step that the span holds gains nothing.
            let is_apart = outside > LEAST_OUTSIDE * own;
            let gain = if is_apart {
                along.powi(2) / outside
            } else {
                0.0
            };
            if gain > best.1 {
                best = (k, gain);
            }
        }
        if best.1 > 0.0 {
            let mut step = vec![0.0; series.len()];
            step[range.start + best.0..range.end].fill(1.0);
            span.widen(&step);
            places += (range.len() as f64).ln();
        }
    }
    beside(series, span, &[]) * (1.0 + places / series.len() as f64)
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

/// Sum of squares of a series that is left outside a span and some columns.
fn beside(series: &[f64], mut span: Span, columns: &[Vec<f64>]) -> f64 {
    for column in columns {
        span.widen(column);
    }
    let left = span.outside(series);
    dot(&left, &left)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::{Span, beside, slips, with_steps};

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
        let share = |series: &[f64]| {
            beside(series, Span::of(&level), &columns) / beside(series, Span::of(&level), &[])
        };
        assert!(share(&slip) < 1e-9, "{}", share(&slip));
        assert!(share(&ramp) > 1e-3, "{}", share(&ramp));
    }

    #[test]
    fn a_step_is_found_in_each_recording_and_a_ramp_is_none() {
        let recordings = [0..200, 200..400];
        let levels = recordings.clone().map(|range| {
            let level = (0..400).map(|k| f64::from(u8::from(range.contains(&k))));
            level.collect::<Vec<f64>>()
        });
        let sine: Vec<f64> = (0..400).map(|k| (f64::from(k) * 0.05).sin()).collect();
        let span = || Span::of(levels.iter().chain([&sine]));
        let steps = (0..400).map(|k| {
            let stepped = match k {
                60..200 => 0.3,
                333.. => -0.1,
                _ => 0.0,
            };
            stepped + 0.2 * sine[k]
        });
        let steps: Vec<f64> = steps.collect();
        let left = with_steps(&steps, span(), &recordings);
        assert!(left < 1e-9, "{left}");
        // In noise, four hat functions in each recording, as a drift has them, leave less of a ramp than a step does.
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut noisy = |k: usize| {
            let normal: f64 = StandardNormal.sample(&mut rng);
            0.003 * (k % 200) as f64 + 0.1 * normal
        };
        let ramps: Vec<f64> = (0..400).map(&mut noisy).collect();
        let hats = (0..8).map(|knot| {
            let hat = |k: usize| {
                let way = (k % 200) as f64 / 200.0 * 4.0 - (knot % 4 + 1) as f64;
                if k / 200 == knot / 4 {
                    (1.0 - way.abs()).max(0.0)
                } else {
                    0.0
                }
            };
            (0..400).map(hat).collect::<Vec<f64>>()
        });
        let drifting = beside(&ramps, Span::of(&levels), &hats.collect::<Vec<_>>());
        let stepping = with_steps(&ramps, span(), &recordings);
        assert!(drifting < stepping, "{drifting} {stepping}");
    }
}
