//! Names whose sizes are told from none.

use std::f64::consts::FRAC_1_SQRT_2;

use identify::{Bounds, Fit, IdentifyError, ParameterState};

use crate::decide::{Decided, Named, RuleId, Traces};
use crate::model::case::is_beyond;
use crate::model::elsewhere::is_drift;
use crate::report::diagnosis::ExtendedStage;
use crate::report::drift::{Curve, changes, is_curve_of_time, is_slow};
use crate::report::formula::{HALF_95, OfFormula};
use crate::{Candidate, CandidateSet, Role};

/// Decision without names whose sizes may be zero, without drifts that are not slow, and without other names that end at a bound which is no end
/// of what can be; such names become suspects.
///
/// A size may be the error of the formula of the loop beside it, unless that is an alternative to the name, and to no other: then it is what it is
/// if the name is right. Several such names together may well be one error of the formula.
///
/// Recordings that were not used may tell what the training does not: how much of its change comes true there. Drifts
/// are not asked, since each is fitted to every recording.
pub(crate) fn told(
    mut decided: Decided,
    extended: &ExtendedStage,
    of_formula: &OfFormula,
    mut comes_true: impl FnMut(Candidate) -> Result<Option<CameTrue>, IdentifyError>,
) -> Result<Decided, IdentifyError> {
    let fit = &extended.stage.fit;
    let is_shared = |named: &Named| {
        let mut others = named.others.iter();
        others.any(|(other, _)| *other == Candidate::other_loop())
    };
    let is_one_shared = decided.named.iter().filter(|one| is_shared(one)).count() == 1;
    let mut is_told = |named: &Named, traces: &mut Traces| {
        let effect = named.effect;
        let of_formula = (!(is_one_shared && is_shared(named))).then_some(of_formula);
        let Some(mut size) = told_by(effect, fit, of_formula) else {
            return Ok::<_, IdentifyError>(true);
        };
        let is_asked = size > 0.0 && size < traces.threshold(RuleId::Told) && !is_drift(effect);
        if is_asked && let Some(there) = comes_true(effect)? {
            size = size.max(there.told(effect, of_formula));
        }
        Ok(traces.ask(RuleId::Told, effect.id(), size))
    };
    let mut fallen = CandidateSet::EMPTY;
    for named in &decided.named {
        if !is_told(named, &mut decided.traces)? {
            fallen = fallen.with(named.effect);
        }
    }
    decided.fall(fallen);
    Ok(decided)
}

/// How an effect does on recordings that were not used.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CameTrue {
    /// Share of its change that comes true, and the standard error of that.
    pub(crate) share: [f64; 2],
    /// Mean square that it explains.
    pub(crate) explained: f64,
}

impl CameTrue {
    /// Its size there over half of its interval: 0 if its change does not come true as it is.
    fn told(&self, effect: Candidate, of_formula: Option<&OfFormula>) -> f64 {
        let [share, error] = self.share;
        let by_formula = of_formula.map_or(0.0, |by| by.relative_where(effect, self.explained));
        if RuleId::UnseenGain.rule().passes(share) {
            share / (HALF_95 * error.hypot(share * by_formula))
        } else {
            0.0
        }
    }
}

/// Size of an effect over half of its interval, by its formula too if that may make it; `None` of an effect without a size, as a loop of another
/// family is.
fn told_by(effect: Candidate, fit: &Fit, of_formula: Option<&OfFormula>) -> Option<f64> {
    if is_curve_of_time(effect) {
        let curves = Curve::all(effect, fit);
        let relative = of_formula.map_or(0.0, |by| by.relative(effect));
        let is_slow = is_slow(&curves);
        return Some(if is_slow {
            changes(&curves, relative)
        } else {
            0.0
        });
    }
    let sizes = effect.info().parameters.iter();
    let free = sizes
        .filter(|parameter| parameter.role == Role::Size)
        .filter_map(|size| Some((size, fit.parameter(size.name)?)))
        .filter(|(_, size)| size.info.state == ParameterState::Free);
    // The recordings pull it beyond what is possible: it does the work of something else. A drift may do so in one of them.
    let is_pressed = !is_drift(effect)
        && free.clone().any(|(parameter, size)| {
            let mut values = size.values.iter();
            size.at_bound && values.any(|value| is_beyond(parameter, *value))
        });
    if is_pressed {
        return Some(0.0);
    }
    let over = free.flat_map(|(parameter, size)| {
        let each = size.values.iter().zip(&size.intervals);
        each.map(move |(&value, interval)| match *interval {
            // An end that stands at a bound is no end of the interval.
            Some(own) => {
                let own = match of_formula {
                    Some(by) => by.widened((effect, parameter), size, (value, own)),
                    None => own,
                };
                value.abs() / (own.upper - value).max(value - own.lower)
            }
            // At an end of what can be it is as large as that; at 0 it is absent.
            None if size.at_bound && !is_zero(value, size.info.bounds) => f64::INFINITY,
            None => 0.0,
        })
    });
    let over: Vec<f64> = over.collect();
    let largest = over.iter().copied().reduce(f64::max);
    largest.map(|largest| largest / widened(over.len()))
}

/// True if a size is 0 within its bounds, to rounding.
fn is_zero(value: f64, bounds: Bounds) -> bool {
    const ROUNDING: f64 = 1e-9;
    value.abs() <= ROUNDING * bounds.width()
}

/// Half of an interval that each of so many normal deviations keeps to with 95 % in all, over that of one: about, since those of
/// parameters are Student's.
fn widened(n: usize) -> f64 {
    let outside = |deviations: f64| libm::erfc(deviations * FRAC_1_SQRT_2);
    let each = outside(HALF_95) / n as f64;
    // No interval of numbers that a machine holds is wider.
    let (mut low, mut high) = (HALF_95, 40.0);
    while high - low > 1e-9 {
        let middle = 0.5 * (low + high);
        if outside(middle) > each {
            low = middle;
        } else {
            high = middle;
        }
    }
    low / HALF_95
}

#[cfg(test)]
mod tests {
    use super::{CameTrue, HALF_95, widened};
    use crate::EffectId;

    #[test]
    fn a_change_that_comes_true_as_it_is_tells_a_size() {
        let told = |share: [f64; 2]| {
            let there = CameTrue {
                share,
                explained: 1.0,
            };
            there.told(EffectId::SupplyLag.into(), None)
        };
        assert!((told([0.98, 0.05]) - 0.98 / (HALF_95 * 0.05)).abs() < 1e-12);
        assert!(told([0.98, 0.51]) < 1.0);
        // It makes them worse, or asks for another size.
        assert!(
            [0.45, 1.55]
                .map(|share| told([share, 0.01]))
                .iter()
                .all(|told| *told <= 0.0)
        );
    }

    #[test]
    fn intervals_of_several_sizes_are_wider() {
        assert!((widened(1) - 1.0).abs() < 1e-8);
        // Standard normal quantile of 1 - 0.025/8: 2.7344.
        assert!((widened(8) * 1.96 - 2.7344).abs() < 1e-3, "{}", widened(8));
    }
}
