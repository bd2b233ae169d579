//! Uncertainty of a size by how inexact the formula of the loop beside it is.

use identify::{Bounds, Fit, FittedParameter, IdentifyError};

use crate::decide::OF_FORMULAS;
use crate::model::case::Case;
use crate::search::roads::Search;
use crate::{Candidate, CandidateSet, LoopFamily, Role};

/// Independent shapes in which the formula of a loop may err: some five bends of either branch beyond the three that are free. Our choice. The
/// error is as likely of one as of another, and an effect that acts like the loop takes up its share.
const SHAPES: f64 = 10.0;

/// Standard errors of half a 95 % interval.
pub(crate) const HALF_95: f64 = 1.96;

/// Root mean square of that part of the error of the loop's formula which has the shape of an effect: 0 beside the baseline model's loop,
/// and of what does not act like a loop.
fn of_formula(case: &Case<'_>, effect: Candidate) -> f64 {
    if case.setting.loop_family == LoopFamily::Proximity || !effect.info().like_loop {
        return 0.0;
    }
    OF_FORMULAS * case.output_deviation() / SHAPES.sqrt()
}

/// Standard error of an effect's first size by the error of the loop's formula, where a size of 1 shows so much.
pub(crate) fn error_of_formula(case: &Case<'_>, effect: Candidate, shown_per_unit: f64) -> f64 {
    match of_formula(case, effect) {
        error if error > 0.0 => error / shown_per_unit,
        _ => 0.0,
    }
}

/// Widens the intervals of sizes by the error of the loop's formula. All sizes of an effect have one relative error: that of the formula over
/// the root mean square that the effect explains. An end may lie beyond what is possible: then the size is not told.
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
        let nodes = (less.and_then(|less| search.get(less)), search.get(effects));
        // Without it another vanishes: what it explains by itself is not known.
        let (Some(less), Some(with)) = nodes else {
            continue;
        };
        let explained = (less.mean_square() - with.mean_square()).max(0.0).sqrt();
        let sizes = effect.info().parameters.iter();
        for size in sizes.filter(|parameter| parameter.role == Role::Size) {
            let of_size = |fitted: &&mut FittedParameter| fitted.info.name == size.name;
            for fitted in fit.parameters.iter_mut().filter(of_size) {
                let range = fitted.info.bounds.width();
                for (&value, interval) in fitted.values.iter().zip(&mut fitted.intervals) {
                    let own = error * (value - size.neutral()).abs() / explained;
                    // What explains nothing may have any size.
                    let half = HALF_95 * if own < range { own } else { range };
                    if let Some(interval) = interval {
                        *interval = widened_by(*interval, value, half);
                    }
                }
            }
        }
    }
    Ok(fit)
}

/// An interval around a value with another half, in quadrature on either side.
fn widened_by(own: Bounds, value: f64, half: f64) -> Bounds {
    Bounds {
        lower: value - (value - own.lower).hypot(half),
        upper: value + (own.upper - value).hypot(half),
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
    fn a_size_whose_formula_may_make_it_is_not_told() {
        let own = Bounds {
            lower: 0.8,
            upper: 1.0,
        };
        let wide = widened_by(own, 0.9, 0.9);
        // Beyond 0 and beyond the whole: a size over its half interval of less than 1.
        assert!(wide.lower < 0.0 && wide.upper > 1.8);
        let narrow = widened_by(own, 0.9, 0.0);
        assert_eq!(
            [narrow.lower, narrow.upper].map(f64::to_bits),
            [0.8_f64, 1.0].map(f64::to_bits)
        );
    }
}
