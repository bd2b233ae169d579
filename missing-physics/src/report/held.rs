//! The chosen model at its end, and what was decided, held to the recordings that were not used.

use std::sync::Arc;

use identify::{Fit, IdentifyError, Validated};
use recording::Recording;

use crate::decide::{Decided, RuleId, Verdict};
use crate::model::case::{Case, Node};
use crate::model::coarse::{NEARLY_ALL, coarse_at};
use crate::model::elsewhere::{predicted, spread};
use crate::model::unseen::{Unseen, validated_by};
use crate::noise::of_drive::of_drive;
use crate::report::diagnosis::{ExtendedStage, Stage};
use crate::report::errors::Errors;
use crate::report::explained::share;
use crate::report::told::CameTrue;
use crate::search::roads::Search;
use crate::search::settle::fitted;
use crate::{Candidate, CandidateSet, ExtendedModel, LoopFamily};

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

/// How much of what an effect of the extended model changes on recordings that were not used comes true; `None` where it changes nothing.
pub(crate) fn came_true(
    effect: Candidate,
    search: &mut Search<'_>,
    (extended, with): (&ExtendedStage, &Unseen),
    errors: &mut Errors<'_>,
) -> Result<Option<CameTrue>, IdentifyError> {
    let effects: CandidateSet = extended.effects.iter().copied().collect();
    if !effects.contains(effect) {
        return Ok(None);
    }
    let weight = temperature_weight(search, effects);
    let without = errors.of(search.node_without(effects, effect)?)?;
    let share = with.comes_true(without, weight);
    let [all, left] = [without, with].map(Unseen::mean_square);
    Ok(share
        .zip(all.zip(left))
        .map(|(share, (all, left))| CameTrue {
            share,
            explained: all - left,
        }))
}

/// Decision, held to the recordings that were not used: a name that makes them worse becomes a suspect, and an error
/// that the names alone do not explain there, or that is more than twice what they leave of the training and the uncertainty of the parameters
/// makes, does not count as explained. `ceiling` is the mean square that there is no way below.
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
    let mut fallen = CandidateSet::EMPTY;
    for named in &decided.named {
        let there = came_true(named.effect, search, (extended, with), errors)?;
        // What is not exercised there, or lost in the noise, says nothing.
        let told = there.filter(|there| there.share[1] < TOLD);
        let Some([share, _]) = told.map(|there| there.share) else {
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
            let made = match alone.mean_square() {
                Some(error) => {
                    let ExtendedStage { model, stage, .. } = extended;
                    share_made(error, left, (model, stage), errors.recordings)?
                }
                None => 1.0,
            };
            let value = by_names.unwrap_or(1.0).min(made);
            decided.traces.ask(RuleId::UnseenShare, "", value)
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
    let left = plain.fit.train_rmse.powi(2);
    let made = share_made(error, left, (model, plain), unseen)?;
    if !decided.traces.ask(RuleId::UnseenShare, "", made) {
        decided.verdict = Verdict::Unexplained;
    }
    Ok(decided)
}

/// Share of a model's mean square on unseen recordings that is made by twice what it leaves of the training, `left`, by twice the uncertainty
/// of its parameters, and by noise of the drive.
fn share_made(
    error: f64,
    left: f64,
    (model, stage): (&ExtendedModel, &Stage),
    unseen: &[Recording],
) -> Result<f64, IdentifyError> {
    let noise = TWICE.powi(2) * left;
    // An error that is no number is none that is made.
    if error <= noise {
        return Ok(1.0);
    }
    let spread = spread(model, &stage.fit, &stage.validated, unseen)?;
    let points = stage.validated.iter().map(|one| one.point.as_slice());
    let of_drive = of_drive(model, unseen.iter().zip(points), 1)?;
    Ok((noise + TWICE.powi(2) * spread + of_drive) / error)
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
