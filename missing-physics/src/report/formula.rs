//! Uncertainty of a size by how inexact the formula of the loop beside it is.

use identify::{Bounds, Fit, IdentifyError};

use crate::decide::OF_FORMULAS;
use crate::model::case::{Case, Node};
use crate::search::roads::Search;
use crate::{Candidate, CandidateSet, LoopFamily, Role};

/// Independent shapes in which the formula of a loop may err: five bends of either branch beyond those that are free. The error is as
/// likely of one as of another, and an effect that acts like the loop takes up its share.
const SHAPES: f64 = 10.0;

/// Standard errors of half a 95 % interval.
pub(crate) const HALF_95: f64 = 1.96;

/// Root mean square of that part of the error of the loop's formula which has the shape of an effect: 0 beside the baseline model's loop,
/// and of what does not act like a loop.
fn of_formula(case: &Case<'_>, effect: Candidate) -> f64 {
    if case.setting.loop_family == LoopFamily::Proximity || !effect.info().like_loop {
        return 0.0;
    }
    let deviation = (case.output_squares() / case.layout.n_outputs() as f64).sqrt();
    OF_FORMULAS * deviation / SHAPES.sqrt()
}

/// Standard error of an effect's first size by the error of the loop's formula, where a size of 1 shows so much.
pub(crate) fn error_of_formula(case: &Case<'_>, effect: Candidate, shown_per_unit: f64) -> f64 {
    match of_formula(case, effect) {
        error if error > 0.0 => error / shown_per_unit,
        _ => 0.0,
    }
}

/// A fit of the model with these effects, the intervals of sizes as wide as the error of the loop's formula makes them. All sizes of an effect
/// are as uncertain by it as what the effect explains.
pub(crate) fn with_error_of_formula(
    search: &mut Search<'_>,
    effects: CandidateSet,
    mut fit: Fit,
) -> Result<Fit, IdentifyError> {
    for effect in effects.iter() {
        let error = of_formula(search.case, effect);
        if error <= 0.0 {
            continue;
        }
        let less = search.without(effects, effect)?;
        let squares = [less, Some(effects)].map(|set| {
            let node = set.and_then(|set| search.get(set));
            node.map_or(f64::NAN, Node::mean_square)
        });
        let share = error / (squares[0] - squares[1]).sqrt();
        if !share.is_finite() {
            continue;
        }
        let sizes = effect.info().parameters.iter();
        for size in sizes.filter(|parameter| parameter.role == Role::Size) {
            let fitted = fit.parameters.iter_mut();
            for fitted in fitted.filter(|fitted| fitted.info.name == size.name) {
                let each = fitted.values.iter().zip(&mut fitted.intervals);
                for (value, own) in each.filter_map(|(value, own)| Some((*value, own.as_mut()?))) {
                    let error = share * (value - size.neutral()).abs();
                    let half = 0.5 * own.width();
                    if half > 0.0 {
                        let factor = half.hypot(HALF_95 * error) / half;
                        *own = stretched(*own, value, factor, fitted.info.bounds);
                    }
                }
            }
        }
    }
    Ok(fit)
}

/// An interval around a value, so many times as wide, within what is possible.
fn stretched(own: Bounds, value: f64, factor: f64, possible: Bounds) -> Bounds {
    Bounds {
        lower: (value - factor * (value - own.lower)).max(possible.lower),
        upper: (value + factor * (own.upper - value)).min(possible.upper),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::synthetic::Synthetic;
    use crate::{EffectId, EffectSet, EffectValues, Setting};

    #[test]
    fn what_acts_like_another_loop_is_as_uncertain_as_its_formula() {
        let synthetic = Synthetic::of(EffectSet::EMPTY, EffectValues::default(), 1);
        let papers = synthetic.case();
        let setting = Setting {
            loop_family: LoopFamily::Relays,
            ..papers.setting
        };
        let relays = Case::new(papers.base, papers.fit, papers.training, setting);
        let of = |case: &Case<'_>, effect: EffectId, shown: f64| {
            error_of_formula(case, effect.into(), shown)
        };
        let nothing = [
            of(&papers, EffectId::Backlash, 1.0),
            of(&relays, EffectId::DeadTime, 1.0),
        ];
        assert_eq!(nothing.map(f64::to_bits), [0; 2]);
        // A fiftieth of 5 mm times a deviation of some 0.4 strokes, a third of it along one shape.
        let one = of(&relays, EffectId::Backlash, 1.0);
        assert!((0.005..0.02).contains(&one), "{one}");
        assert!((of(&relays, EffectId::Backlash, 4.0) / one - 0.25).abs() < 1e-12);
    }

    #[test]
    fn an_interval_is_stretched_on_either_side_of_its_value_within_what_is_possible() {
        let own = Bounds {
            lower: 0.1,
            upper: 0.4,
        };
        let possible = Bounds {
            lower: 0.0,
            upper: 1.0,
        };
        let wide = stretched(own, 0.2, 1.5, possible);
        assert!((wide.lower - 0.05).abs() < 1e-12 && (wide.upper - 0.5).abs() < 1e-12);
        let wider = stretched(own, 0.2, 10.0, possible);
        assert_eq!(
            [wider.lower, wider.upper].map(f64::to_bits),
            [0.0, 1.0_f64].map(f64::to_bits)
        );
    }
}
