//! The chosen model at its end, and what was decided, held to the recordings that were not used.

use std::f64::consts::FRAC_1_SQRT_2;
use std::sync::Arc;

use identify::{Bounds, Fit, FittedParameter, IdentifyError, ParameterState, Validated};
use recording::Recording;

use crate::decide::{Decided, Named, RuleId, Traces, Verdict};
use crate::model::case::{Case, Node, is_beyond};
use crate::model::coarse::{NEARLY_ALL, coarse_at};
use crate::model::elsewhere::{is_drift, predicted, spread};
use crate::model::unseen::{Unseen, validated_by};
use crate::noise::of_drive::of_drive;
use crate::report::diagnosis::{ExtendedStage, Stage};
use crate::report::errors::Errors;
use crate::report::explained::share;
use crate::report::formula::{HALF_95, OfFormula};
use crate::search::roads::Search;
use crate::search::settle::fitted;
use crate::{Candidate, CandidateSet, ExtendedModel, LoopFamily, Role};

/// Standard deviations up to which an error may be the parameters' uncertainty.
const TWICE: f64 = 2.0;

/// Error on unseen recordings up to which a model does as well there, over that on the training's, and over the baseline model's.
const AS_NEAR: f64 = 1.2;

/// Share of the explainable error on unseen recordings that a model explains, up to which they do not bear it out.
const HALF: f64 = 0.5;

/// Standard error of the share of a change that comes true, from which it says nothing.
const TOLD: f64 = 0.5;

/// The chosen model of a search where it is fitted from many places; `None` of the baseline model.
pub(crate) fn chosen(
    search: &mut Search<'_>,
    effects: CandidateSet,
) -> Result<Option<Arc<Fit>>, IdentifyError> {
    if effects.is_empty() && search.case.setting.loop_family == LoopFamily::Proximity {
        return Ok(None);
    }
    search.settle(effects).map(Some)
}

/// The chosen model from where it is fitted to the end on all samples of the training, and validated; and its error on the recordings that were not
/// used, of which the second are judged.
pub(crate) fn extended(
    (search, effects): (&Search<'_>, CandidateSet),
    chosen: Arc<Fit>,
    training: &[Recording],
    unseen: [&[Recording]; 2],
) -> Result<(ExtendedStage, Unseen), IdentifyError> {
    let fit = match search.get(effects) {
        Some(node) => fitted_to_all((search.case, node), chosen, training)?,
        None => Arc::unwrap_or_clone(chosen),
    };
    let model = search.case.model(effects);
    let point = fit.point(0);
    let at = (&point[..], temperature_weight(search, effects));
    let (validated, error) = validated_by(&model, at, unseen)?;
    let stage = Stage {
        validated,
        predicted_rmse: predicted(&model, &point, unseen[0])?,
        fit,
    };
    let extended = ExtendedStage {
        effects: effects.iter().collect(),
        model,
        stage,
    };
    Ok((extended, error))
}

/// The fit of a node's model to all samples of the training, from where it stands on those of its case, `there`; of very many by way of some.
fn fitted_to_all(
    (case, node): (&Case<'_>, &Node),
    there: Arc<Fit>,
    training: &[Recording],
) -> Result<Fit, IdentifyError> {
    let Some(whole) = case.whole(training) else {
        return Ok(Arc::unwrap_or_clone(there));
    };
    let at = (&node.points[..], case.fit.tau_s());
    let some = coarse_at(NEARLY_ALL, &node.model, at, training)?;
    if !NEARLY_ALL.are_few(&some, training) {
        return fitted(&whole, node, there.seed);
    }
    let of_some = case.on(&some);
    let nearer = fitted(&of_some, node, there.seed)?;
    fitted(&whole, &of_some.fitted(node, &nearer)?, there.seed)
}

/// Weight of temperatures as a model of a search meets them, (output unit/K)²; 0 where none are recorded.
fn temperature_weight(search: &Search<'_>, effects: CandidateSet) -> f64 {
    let weight = search
        .get(effects)
        .and_then(|node| search.case.temperature_weight(node));
    weight.unwrap_or(0.0)
}

/// Turns within a recording from which a curve of time is no slow one.
const RESTLESS: usize = 3;

/// Share of a drift's range from one of its values to the next from which that is an event, or a level: what approaches its end with a time
/// constant as long as values are apart goes that far in the time, 1 - 1/e, and what is slower less far.
const AT_ONCE: f64 = 0.632;

/// Decision without names whose sizes may be zero, without drifts that are not slow, and without other names that end at a bound which is no end
/// of what can be; such names become suspects.
///
/// A size may be the error of the formula of the loop beside it, unless that is an alternative to the name, and to no other: then it is what it is
/// if the name is right. Several such names together may well be one error of the formula.
pub(crate) fn told(
    mut decided: Decided,
    extended: &ExtendedStage,
    of_formula: &OfFormula,
) -> Decided {
    let fit = &extended.stage.fit;
    let is_shared = |named: &Named| {
        let mut others = named.others.iter();
        others.any(|(other, _)| *other == Candidate::other_loop())
    };
    let is_one_shared = decided.named.iter().filter(|one| is_shared(one)).count() == 1;
    let is_told = |named: &Named, traces: &mut Traces| {
        let effect = named.effect;
        let may_be_formula = !(is_one_shared && is_shared(named));
        let sizes = effect.info().parameters.iter();
        let free = sizes
            .filter(|parameter| parameter.role == Role::Size)
            .filter_map(|size| Some((size, fit.parameter(size.name)?)))
            .filter(|(_, size)| size.info.state == ParameterState::Free);
        let over = free.clone().flat_map(|(parameter, size)| {
            let each = size.values.iter().zip(&size.intervals);
            each.map(move |(&value, interval)| match *interval {
                // An end that stands at a bound is no end of the interval.
                Some(own) => {
                    let own = match may_be_formula {
                        true => of_formula.widened((effect, parameter), size, (value, own)),
                        false => own,
                    };
                    value.abs() / (own.upper - value).max(value - own.lower)
                }
                // At an end of what can be it is as large as that; at 0 it is absent.
                None if size.at_bound && !is_zero(value, size.info.bounds) => f64::INFINITY,
                None => 0.0,
            })
        });
        let over: Vec<f64> = over.collect();
        // The recordings pull it beyond what is possible: it does the work of something else. A drift may do so in one of them.
        let is_pressed = !is_drift(effect)
            && free.clone().any(|(parameter, size)| {
                let mut values = size.values.iter();
                size.at_bound && values.any(|value| is_beyond(parameter, *value))
            });
        // A loop of another family has no size.
        let largest = over.iter().copied().reduce(f64::max);
        let largest = largest.map(|largest| match is_slow(effect, fit) && !is_pressed {
            true => largest / widened(over.len()),
            false => 0.0,
        });
        largest.is_none_or(|largest| traces.ask(RuleId::Told, effect.id(), largest))
    };
    let fallen = decided
        .named
        .iter()
        .filter(|one| !is_told(one, &mut decided.traces));
    let fallen: CandidateSet = fallen.map(|one| one.effect).collect();
    decided.fall(fallen);
    decided
}

/// False of a drift that turns back again and again within a recording, or of which one of its values has most where it has the largest
/// range; both by more than the uncertainty of its values. What is no curve of time is not asked.
fn is_slow(effect: Candidate, fit: &Fit) -> bool {
    // A law of time of one's own has no values along the recording.
    if !(is_drift(effect) && effect.info().flexible) {
        return true;
    }
    let knots = effect.info().parameters.iter();
    let knots: Vec<&FittedParameter> = knots.filter_map(|one| fit.parameter(one.name)).collect();
    let n_recordings = knots.first().map_or(0, |knot| knot.values.len());
    let curves = (0..n_recordings).map(|r| {
        let values = knots.iter().map(|knot| {
            let half = knot.intervals[r].map_or(0.0, |own| 0.5 * own.width());
            [knot.values[r], half]
        });
        values.collect::<Vec<[f64; 2]>>()
    });
    let curves: Vec<Vec<[f64; 2]>> = curves.collect();
    let largest = curves.iter().max_by(|a, b| range(a).total_cmp(&range(b)));
    curves
        .iter()
        .all(|curve| turns(curve.iter().copied()) < RESTLESS)
        && largest.is_none_or(|curve| longest_step(curve) <= AT_ONCE * range(curve))
}

/// Range of a curve from 0 through values with half intervals.
fn range(curve: &[[f64; 2]]) -> f64 {
    let values = curve.iter().map(|[value, _]| *value);
    let (low, high) = values.fold((0.0_f64, 0.0_f64), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    high - low
}

/// Longest way of such a curve from one value to the next, beyond what their intervals make.
fn longest_step(curve: &[[f64; 2]]) -> f64 {
    let before = std::iter::once(&[0.0; 2]).chain(curve);
    let steps = before
        .zip(curve)
        .map(|([from, half], [to, half_to])| (to - from).abs() - half.hypot(*half_to));
    steps.fold(0.0, f64::max)
}

/// How often a curve from 0 through values with half intervals turns back by more than these.
fn turns(values: impl Iterator<Item = [f64; 2]>) -> usize {
    let (mut turns, mut direction, mut extreme) = (0, 0.0, [0.0; 2]);
    for [value, half] in values {
        let change = value - extreme[0];
        if change * direction > 0.0 {
            extreme = [value, half];
        } else if change.abs() > half.hypot(extreme[1]) {
            turns += usize::from(direction != 0.0);
            (direction, extreme) = (change.signum(), [value, half]);
        }
    }
    turns
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

/// Decision, held to the recordings that were not used: a name that makes them worse becomes a suspect, and an error
/// that the names alone do not explain there does not count as explained. `ceiling` is the mean square that there is no way below.
/// It is returned with the share that the names alone explain.
pub(crate) fn held_to(
    mut decided: Decided,
    search: &mut Search<'_>,
    extended: &ExtendedStage,
    ([before, with], ceiling): ([&Unseen; 2], f64),
    errors: &mut Errors<'_>,
) -> Result<(Decided, Option<f64>), IdentifyError> {
    if errors.recordings.is_empty() || decided.named.is_empty() {
        return Ok((decided, None));
    }
    let effects: CandidateSet = extended.effects.iter().copied().collect();
    let weight = temperature_weight(search, effects);
    let mut fallen = CandidateSet::EMPTY;
    for named in &decided.named {
        if !effects.contains(named.effect) {
            continue;
        }
        let node = search.node_without(effects, named.effect)?;
        // What is not exercised there, or lost in the noise, says nothing.
        let told = with
            .comes_true(errors.of(node)?, weight)
            .filter(|[_, error]| *error < TOLD);
        let Some([share, _]) = told else {
            continue;
        };
        let id = named.effect.id();
        if !decided.traces.ask(RuleId::UnseenGain, id, share) {
            fallen = fallen.with(named.effect);
        }
    }
    decided.fall(fallen);
    if decided.named.is_empty() {
        // They made these recordings worse: what is left to say is what the baseline model leaves.
        return Ok((decided, None));
    }
    let names: CandidateSet = decided.named.iter().map(|named| named.effect).collect();
    let suspected = effects.iter().any(|effect| !names.contains(effect));
    let own = match names_alone(search, effects, names)? {
        Some(node) if suspected => Some(errors.of(node)?.clone()),
        _ => None,
    };
    // Of the samples on which the unseen recordings are judged, too.
    let left = search.get(effects).map_or(f64::NAN, Node::mean_square);
    // Without a fit of the names alone nothing is known of what they explain.
    let alone = own.as_ref().or((!suspected).then_some(with));
    let by_names = alone.and_then(|alone| share([before, alone], ceiling));
    let is_explained = match alone {
        None => false,
        Some(alone) => {
            decided
                .traces
                .ask(RuleId::UnseenShare, "", by_names.unwrap_or(1.0))
                || alone.squares() < AS_NEAR.powi(2) * before.squares()
                    && is_as_near([alone, with], extended, (left, errors.recordings))?
        }
    };
    // What suspects explain beside the names does not speak against these; that they make it worse by themselves does.
    let is_borne_out = share([before, with], ceiling).is_none_or(|whole| whole > HALF)
        && by_names.is_none_or(|alone| alone > 0.0);
    if !is_explained && is_borne_out {
        decided.verdict = Verdict::ExplainedInPart;
    } else if !is_explained {
        decided.verdict = Verdict::Unexplained;
        decided.suspects.append(&mut decided.named);
    }
    Ok((decided, by_names))
}

/// Decision that nothing is missing, held to the recordings that were not used: what misses these by more than twice what it does the
/// training, and than the uncertainty of its parameters makes, does not hold there. `plain` is the baseline model.
pub(crate) fn held_plainly(
    mut decided: Decided,
    (model, plain): (&ExtendedModel, &Stage),
    unseen: &[Recording],
) -> Result<Decided, IdentifyError> {
    let error = Validated::rmse_of_all(&plain.validated).map(|rmse| rmse.powi(2));
    let Some(error) = error.filter(|_| decided.verdict == Verdict::Adequate) else {
        return Ok(decided);
    };
    let noise = (TWICE * plain.fit.train_rmse).powi(2);
    // An error that is no number is none that is made.
    let made = if error <= noise {
        1.0
    } else {
        let spread = spread(model, &plain.fit, &plain.validated, unseen)?;
        let points = plain.validated.iter().map(|one| one.point.as_slice());
        let of_drive = of_drive(model, unseen.iter().zip(points), 1)?;
        (noise + TWICE.powi(2) * spread + of_drive) / error
    };
    if !decided.traces.ask(RuleId::UnseenShare, "", made) {
        decided.verdict = Verdict::Unexplained;
    }
    Ok(decided)
}

/// The model with names and without what is only suspected; `None` where no fit of it stands.
fn names_alone<'s>(
    search: &'s mut Search<'_>,
    effects: CandidateSet,
    names: CandidateSet,
) -> Result<Option<&'s Node>, IdentifyError> {
    let mut set = effects;
    for effect in effects.iter().filter(|&effect| !names.contains(effect)) {
        let Some(less) = search.without(set, effect)? else {
            return Ok(None);
        };
        set = less;
    }
    Ok(search.get(set))
}

/// True if the error of the names alone on the unseen recordings is no larger than two sources together make it: the error of the
/// extended model on the training, where the noise is larger than it was measured, and the uncertainty of its parameters, where the
/// training did not go. That is at most what the extended model itself leaves there.
fn is_as_near(
    [alone, with]: [&Unseen; 2],
    extended: &ExtendedStage,
    (left_of_training, unseen): (f64, &[Recording]),
) -> Result<bool, IdentifyError> {
    let (Some(error), Some(left)) = (alone.mean_square(), with.mean_square()) else {
        return Ok(false);
    };
    let ExtendedStage { model, stage, .. } = extended;
    let spread = spread(model, &stage.fit, &stage.validated, unseen)?;
    let uncertain = (TWICE.powi(2) * spread).min(left);
    Ok(error < AS_NEAR.powi(2) * left_of_training + uncertain)
}

#[cfg(test)]
mod tests {
    use super::{AT_ONCE, longest_step, range, turns, widened};

    #[test]
    fn a_curve_turns_where_it_comes_back_by_more_than_its_intervals() {
        let of = |values: &[f64], half: f64| turns(values.iter().map(|&value| [value, half]));
        assert_eq!(of(&[1.0, 2.0, 3.0, 2.5, 1.0, 0.5], 0.1), 1);
        assert_eq!(of(&[1.0, -1.0, 1.0, -1.0, 1.0], 0.1), 4);
        assert_eq!(of(&[1.0, -1.0, 1.0, -1.0, 1.0], 2.0), 0);
        assert_eq!(of(&[0.3, 1.0, 0.9, 1.1, 1.0, 1.2], 0.2), 0);
    }

    #[test]
    fn a_level_and_an_event_go_most_of_their_way_at_once_and_a_drift_does_not() {
        let share = |values: [f64; 8], half: f64| {
            let curve = values.map(|value| [value, half]);
            longest_step(&curve) / range(&curve)
        };
        let level = [1.0, 1.1, 0.9, 1.0, 1.0, 1.1, 1.0, 1.0];
        assert!(share(level, 0.1) > AT_ONCE);
        // As far as the intervals tell.
        assert!(share(level, 0.4) < AT_ONCE);
        let event = [0.1, 0.0, -0.1, 0.1, 0.0, 0.1, 0.0, 2.0];
        assert!(share(event, 0.1) > AT_ONCE);
        let approach =
            |knots: f64| std::array::from_fn(|k| 1.0 - (-((k + 1) as f64) / knots).exp());
        assert!((share(approach(1.0), 0.0) - AT_ONCE).abs() < 1e-3);
        assert!(share(approach(2.0), 0.0) < 0.5);
    }

    #[test]
    fn intervals_of_several_sizes_are_wider() {
        assert!((widened(1) - 1.0).abs() < 1e-8);
        // Standard normal quantile of 1 - 0.025/8: 2.7344.
        assert!((widened(8) * 1.96 - 2.7344).abs() < 1e-3, "{}", widened(8));
    }
}
