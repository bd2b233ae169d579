//! What an effect may be called: what else would do as well in its place, and how likely it is.

use identify::IdentifyError;

use crate::case::Node;
use crate::choice::{AS_WELL, visited};
use crate::credit::BEYOND_DOUBT_NATS;
use crate::elsewhere::is_rigid;
use crate::projection::dot;
use crate::scores::Score;
use crate::search::Search;
use crate::trial::Trial;
use crate::{Candidate, CandidateSet, EffectId};

/// Probability of an effect where nothing of the catalogue does as well: something that nobody has listed may. Of such names
/// 190 of 195 were right in concealed cases with one effect (blind-trial, seed e78453f0).
const OF_CATALOGUE: f64 = 0.97;

/// The same of a flexible one, 22 of 24: a spline takes the place of whatever drifts.
pub(crate) const OF_FLEXIBLE: f64 = 0.9;

/// Cosine of two traces from which they could be one another's names.
pub(crate) const ALIKE: f64 = 0.5;

/// Losses that grow faster than the temperature.
const ACT_ALIKE: [[EffectId; 2]; 1] = [[EffectId::Radiation, EffectId::NaturalConvection]];

/// Rate of fading, 1/cycle, below which a fatigue does not fade.
const UNFADING: f64 = 0.01;

/// Loss of stroke over its usual share of the shift, below which a fatigue keeps its stroke.
const STROKE_KEPT: f64 = 0.1;

/// An effect of the chosen model.
#[derive(Debug, Clone)]
pub(crate) struct Named {
    pub(crate) effect: Candidate,
    /// Others that would do as well in its place, with their share of the probability, the likeliest first.
    pub(crate) others: Vec<(Candidate, f64)>,
    pub(crate) probability: f64,
    pub(crate) contribution: f64,
}

/// The effects of a model with what else they could be.
pub(crate) fn names(
    search: &mut Search<'_>,
    trial: &Trial,
    effects: CandidateSet,
    contributions: Vec<(Candidate, f64)>,
) -> Result<Vec<Named>, IdentifyError> {
    let mut named = Vec::new();
    for (effect, contribution) in contributions {
        let (probability, others) = alternatives(search, trial, effects, effect)?;
        named.push(Named {
            effect,
            others,
            probability,
            contribution,
        });
    }
    Ok(named)
}

/// Probability of an effect against those that would do as well in its place, and these.
fn alternatives(
    search: &mut Search<'_>,
    trial: &Trial,
    effects: CandidateSet,
    effect: Candidate,
) -> Result<(f64, Vec<(Candidate, f64)>), IdentifyError> {
    // What a smooth law leaves of a real drift is no noise: likelihoods tell the less the more of it there is.
    let beside_drifts = effects.iter().any(|one| !is_rigid(one));
    let left = visited(search, effects).mean_square() / trial.noise;
    let tempered = if beside_drifts { left.max(1.0) } else { 1.0 };
    let effects = formed(search, effects, effect);
    let mut weights = Vec::new();
    for (rival, cosine) in rivals(search, effects, effect)? {
        if cosine < ALIKE {
            continue;
        }
        if let Some(set) = search.exchanged(effects, effect, Some(&rival)) {
            search.finish(&[set])?;
            let behind = search.behind(set, effects) / tempered;
            let is_credible = |node: &Node| search.admits(node) && !search.is_outdone(node);
            if behind < AS_WELL && search.get(set).is_some_and(is_credible) {
                weights.push((rival.effect, (-behind).exp()));
            }
        }
    }
    let node = visited(search, effects);
    let untold = drift_by_another_name(node, effect).filter(|&other| search.may_be(other));
    weights.extend(
        untried(search, effect)
            .chain(untold)
            .map(|other| (other, 1.0)),
    );
    let total = 1.0 + weights.iter().map(|(_, weight)| weight).sum::<f64>();
    let listed = if effect.info().flexible {
        OF_FLEXIBLE
    } else {
        OF_CATALOGUE
    };
    weights
        .iter_mut()
        .for_each(|(_, weight)| *weight *= listed / total);
    weights.sort_by(|a, b| b.1.total_cmp(&a.1));
    Ok((listed / total, weights))
}

/// The model in which an effect is compared with others: with what acts like another of its effects beside that, if it takes in
/// what is only the other's form, which would speak for whatever mends that.
fn formed(search: &Search<'_>, effects: CandidateSet, effect: Candidate) -> CandidateSet {
    let others = effects.iter().filter(|&other| other != effect);
    let with_twin = others.flat_map(acts_like).map(|twin| effects.with(twin));
    let far_better = with_twin.filter(|&set| {
        let is_admitted = search.get(set).is_some_and(|node| search.admits(node));
        is_admitted && !has_twin(effect, set) && search.behind(effects, set) > BEYOND_DOUBT_NATS
    });
    far_better.last().unwrap_or(effects)
}

/// Scores of what could stand in the place of an effect, with the cosines of their traces with its own.
pub(crate) fn rivals(
    search: &mut Search<'_>,
    effects: CandidateSet,
    effect: Candidate,
) -> Result<Vec<(Score, f64)>, IdentifyError> {
    let Some(less) = search.exchanged(effects, effect, None) else {
        return Ok(Vec::new());
    };
    let sifted = search.sifted(less)?;
    let own = sifted
        .found
        .scores
        .iter()
        .find(|score| score.effect == effect);
    let direction = own.map(|own| own.direction.clone()).unwrap_or_default();
    Ok(sifted
        .found
        .scores
        .iter()
        .filter(|score| !effects.contains(score.effect))
        .map(|score| (score.clone(), dot(&score.direction, &direction).abs()))
        .collect())
}

/// What acts like an effect in every rig.
fn acts_like(effect: Candidate) -> impl Iterator<Item = Candidate> {
    ACT_ALIKE.into_iter().filter_map(move |[one, other]| {
        if effect == one {
            Some(other.into())
        } else if effect == other {
            Some(one.into())
        } else {
            None
        }
    })
}

/// Whether a set has what acts like an effect in every rig.
pub(crate) fn has_twin(effect: Candidate, effects: CandidateSet) -> bool {
    acts_like(effect).any(|other| effects.contains(other))
}

/// What acts like an effect in every rig, and could not be tried for want of what it needs: as likely.
fn untried(search: &Search<'_>, effect: Candidate) -> impl Iterator<Item = Candidate> {
    acts_like(effect).filter(|&other| search.may_be(other) && search.case.missing(other).is_some())
}

/// A drift of the surroundings, for a fatigue that neither fades nor takes stroke: as likely.
fn drift_by_another_name(node: &Node, effect: Candidate) -> Option<Candidate> {
    let values = node
        .values(effect)
        .filter(|_| effect == EffectId::FunctionalFatigue)?;
    let &[shift_k, loss, fading] = values else {
        return None;
    };
    let [shift, stroke, _] = [0, 1, 2].map(|k| effect.info().parameters[k].typical);
    let keeps_stroke = (loss / stroke).abs() < STROKE_KEPT * (shift_k / shift).abs();
    (keeps_stroke && fading < UNFADING).then_some(EffectId::AmbientDrift.into())
}
