//! Slip of a sensor's mount, which looks like a drift of the sensor's zero.

use identify::IdentifyError;

use crate::model::case::{Case, Node};
use crate::model::projection::{Span, dot};
use crate::model::series::Channel;
use crate::{Belongs, Candidate, EffectBlock};

/// Powers of the stroke that a slip may go with: a mount holds until the force is large.
const POWERS: [i32; 3] = [1, 2, 4];

/// Squares that a drift of the zero leaves, over those of one that moves only while the rod is out; `None` of a model without
/// such a drift.
///
/// ```text
/// Σ_k c_k ∫ s^k dt,   k = 1, 2, 4,   s the share of the output's range
/// ```
///
/// A drift of the sensor knows nothing of the rod; it has four values, and this three.
pub(crate) fn slip(case: &Case<'_>, node: &Node) -> Result<Option<f64>, IdentifyError> {
    let is_of_zero = |effect: &Candidate| {
        let info = effect.info();
        info.belongs_to == Belongs::Recording && info.block == EffectBlock::Displacement
    };
    let drift = node.effects.iter().find(is_of_zero);
    let Some((drift, first)) = drift.and_then(|one| Some((one, node.model.first_parameter(one)?)))
    else {
        return Ok(None);
    };
    let knots = first..first + drift.info().parameters.len();
    let shown = case
        .layout
        .shown(&node.model, case.training, |r| {
            let mut point = node.points[r].clone();
            point[knots.clone()].fill(0.0);
            vec![point]
        })?
        .swap_remove(0);
    let (mut drifting, mut slipping) = (0.0, 0.0);
    for segment in case.layout.of_channel(Channel::Output) {
        let place = segment.range.clone();
        let recorded = &case.recorded()[place.clone()];
        let left = recorded.iter().zip(&shown[place.clone()]);
        let left: Vec<f64> = left.map(|(recorded, shown)| recorded - shown).collect();
        drifting += without(&node.residual[place], &[]);
        slipping += without(&left, &slips(recorded));
    }
    Ok(Some(drifting / slipping.max(f64::MIN_POSITIVE)))
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

/// Sum of squares of a series that is left beside a mean and some columns.
fn without(series: &[f64], columns: &[Vec<f64>]) -> f64 {
    let level = vec![1.0; series.len()];
    let left = Span::of(std::iter::once(&level).chain(columns)).outside(series);
    dot(&left, &left)
}

#[cfg(test)]
mod tests {
    use super::{slips, without};

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
        let columns = slips(&output);
        let share = |series: &[f64]| without(series, &columns) / without(series, &[]);
        assert!(share(&slip) < 1e-9, "{}", share(&slip));
        assert!(share(&ramp) > 1e-3, "{}", share(&ramp));
    }
}
