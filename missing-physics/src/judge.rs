//! Which model, which names, and which verdict.

use identify::IdentifyError;

use crate::case::Node;
use crate::diagnosis::Verdict;
use crate::elsewhere::is_rigid;
use crate::floor::Measured;
use crate::lack::{BEYOND_DOUBT, LACK_OF_FIT, lack};
use crate::projection::dot;
use crate::scores::Score;
use crate::search::{MOST_EFFECTS, Search, is_universal};
use crate::series::Channel;
use crate::tone::has_tone;
use crate::trial::{KNOWN, Trial};
use crate::{Candidate, CandidateSet, EffectBlock, EffectId, LoopFamily};

/// Share of the explainable error that an effect must bring to have a name.
pub(crate) const OWN_SHARE: f64 = 0.05;

/// Mean square of a model over that of the noise from which an effect may be for what is left; the share of it that it must
/// take; and units of log-likelihood that it must bring.
const MUCH_LEFT: f64 = 1.5;
const THE_REST: f64 = 0.5;
const BEYOND: f64 = 6.0;

/// Share of the explainable error that the whole model must explain for its names to hold.
pub(crate) const GATE: f64 = 0.8;

/// The same where more than noise is left, of models with effects that not every rod has: beside the paper's loop.
const GATE_IN_PART: f64 = 0.93;

/// The same from which two effects hold one another's names up: what is wrong comes to nine tenths.
const NEARLY_ALL: f64 = 0.95;

/// Units of log-likelihood within which another model does as well: odds of e³, 20 to 1.
const AS_WELL: f64 = 3.0;

/// Share of the explainable error below which a remainder is not worth a word.
const SMALL_REMAINDER: f64 = 0.02;

/// Cosine of two traces from which they could be one another's names.
const ALIKE: f64 = 0.5;

/// Residual of the plain model over noise, squared, that cannot be noise.
pub(crate) const LARGE: f64 = 1.5;

/// Probability of an effect where nothing of the catalogue does as well: something that nobody has listed may. Of such names
/// 190 of 195 were right in concealed cases with one effect (blind-trial, seed e78453f0).
const OF_CATALOGUE: f64 = 0.97;

/// The same of a flexible one, 22 of 24: a spline takes the place of whatever drifts.
pub(crate) const OF_FLEXIBLE: f64 = 0.9;

/// Mean square over that of the noise at rest of a model with a drift that accounts for all.
const NEAR: f64 = 2.0;

/// Mean square without a drift over that with it, from which others may stand beside it.
const DRIFTED: f64 = 3.0;

/// Mean square of a drift alone over that with others, from which these are not its own remainder.
const HALVED: f64 = 2.0;

/// Share of the likelihood that an effect must bring to have a name beside what drifts through the run, and what drifts
/// itself: what a smooth law leaves of a real drift is noise with a memory, of which others take in up to 4 and 8 %.
const BESIDE: [f64; 2] = [0.05, 0.1];

/// Losses that grow faster than the temperature.
const ACT_ALIKE: [[EffectId; 2]; 1] = [[EffectId::Radiation, EffectId::NaturalConvection]];

/// Most rigid effects with a name that not every rod has.
const MOST_ODD: usize = 2;

/// Neighbors of a model that are tried.
const NEIGHBORS: usize = 4;

/// Rounds of exchanges.
const ROUNDS: usize = 3;

/// What the search comes to.
#[derive(Debug, Clone)]
pub(crate) struct Judged {
    pub(crate) verdict: Verdict,
    /// Effects of the chosen model.
    pub(crate) effects: CandidateSet,
    pub(crate) named: Vec<Named>,
    /// Effects of the chosen model whose names do not hold.
    pub(crate) suspects: Vec<Named>,
    /// Share of the explainable error that the chosen model explains, held out; `None` where the baseline's
    /// error is the noise's.
    pub(crate) explained: Option<f64>,
}

/// An effect of the chosen model.
#[derive(Debug, Clone)]
pub(crate) struct Named {
    pub(crate) effect: Candidate,
    /// Others that would do as well in its place, with their share of the probability, the likeliest first.
    pub(crate) others: Vec<(Candidate, f64)>,
    pub(crate) probability: f64,
    pub(crate) contribution: f64,
}

impl Judged {
    /// Whether something is left to be explained.
    fn is_open(&self) -> bool {
        matches!(
            self.verdict,
            Verdict::Unexplained | Verdict::ExplainedInPart
        )
    }

    /// Whether a loop of another family may do instead: something is left, or a name is of the loop.
    pub(crate) fn may_be_the_loop(&self) -> bool {
        let blocks = self.named.iter().map(|named| named.effect.info().block);
        self.is_open()
            || blocks
                .into_iter()
                .any(|block| block == EffectBlock::Transformation)
    }

    /// All names become suspects.
    pub(crate) fn demoted(self, verdict: Verdict) -> Self {
        let Self {
            mut named,
            mut suspects,
            ..
        } = self;
        named.append(&mut suspects);
        Self {
            verdict,
            named: Vec::new(),
            suspects: named,
            ..self
        }
    }
}

/// Judges the models of a search; where nothing accounts for the mismatch, with a drift beside the effects: what it
/// helps to a name must leave nothing but noise, and most of what is left without it must be its own.
pub(crate) fn judge(
    search: &mut Search<'_>,
    noise: &Measured,
    tau_s: f64,
) -> Result<Judged, IdentifyError> {
    let without = judged(search, noise, tau_s)?;
    let best = visited(search, without.effects);
    // A drift that is found alone may hide what stands beside it.
    let is_drift = best.effects.iter().any(|one| one.info().flexible);
    let hides = is_drift
        && (best.mean_square() > NEAR * noise.gate || lack(search, best)?.p_value < BEYOND_DOUBT);
    let is_settled = without.verdict != Verdict::Unexplained && !hides;
    if is_settled || !search.grow_beside_drifts()? {
        search.part_from_drifts();
        return Ok(without);
    }
    let beside = judged(search, noise, tau_s)?;
    if !beside.named.is_empty() && drifts(search, noise, &beside)? {
        return Ok(beside);
    }
    search.part_from_drifts();
    Ok(without)
}

/// Whether a model with a drift leaves nothing but noise, or nearly accounts for all with what stands beside the drift taking
/// most of what that leaves, or its share of the likelihood: no smooth curve follows a drift all the way. Without the drift
/// it must leave far more.
fn drifts(
    search: &mut Search<'_>,
    noise: &Measured,
    beside: &Judged,
) -> Result<bool, IdentifyError> {
    let effects = beside.effects;
    let is_nearly_all = beside.explained.is_some_and(|share| share >= NEARLY_ALL);
    for drift in effects.iter().filter(|effect| effect.info().flexible) {
        let Some(less) = search.exchanged(effects, drift, None) else {
            continue;
        };
        let [with, without] = [effects, less].map(|set| visited(search, set));
        // Cycles that drift apart make the noise of repeats look large: that at rest tells, too.
        let is_near = with.mean_square() < NEAR * noise.gate;
        let is_noise = !Trial::far_off(with, noise) && (is_near || leaves_noise(search, effects)?);
        let alone = search.get(CandidateSet::EMPTY.with(drift));
        let is_own = alone.is_some_and(|alone| {
            HALVED * with.mean_square() < alone.mean_square()
                || share_of_likelihood(search, with, alone) > BESIDE[0]
        });
        let accounts = is_noise || is_nearly_all && is_own;
        if !accounts || without.mean_square() < DRIFTED * with.mean_square() {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Judges the models that are admitted.
fn judged(search: &mut Search<'_>, noise: &Measured, tau_s: f64) -> Result<Judged, IdentifyError> {
    let mut effects = settled(search)?;
    let trial = Trial::of(search, noise, tau_s)?;
    let mut contributions = pruned(search, &trial, &mut effects)?;
    if !search.get(effects).is_some_and(|node| search.admits(node)) {
        // What is left of a larger model stands on a bound: another of its size may do.
        effects = chosen(search, effects.len());
        contributions = pruned(search, &trial, &mut effects)?;
    }
    let mut named = names(search, &trial, effects, contributions)?;
    for _ in 0..ROUNDS {
        // What was refitted in a name's place may have come out ahead.
        let Some(better) = ahead(search, effects) else {
            break;
        };
        effects = better;
        let contributions = pruned(search, &trial, &mut effects)?;
        named = names(search, &trial, effects, contributions)?;
    }
    let upheld = upheld(search, &trial, noise, effects)?;
    let shared = shared(search, effects);
    let (mut licensed, mut suspects): (Vec<Named>, Vec<Named>) =
        named.into_iter().partition(|named| {
            let is_shared = shared.contains(named.effect) || !named.others.is_empty();
            let fits =
                |node: &Node| !node.is_pressed(named.effect) && !node.is_slight(named.effect);
            let has_size = search.get(effects).is_some_and(fits);
            is_shared && upheld.contains(named.effect) && has_size
        });
    let best = visited(search, effects);
    let explained = trial.explained(search, best)?;
    let lack = lack(search, best)?;
    let gained = 2.0 * (best.noise.nats() - search.baseline().noise.nats());
    let by_lack = gained / (gained + lack.beyond);
    // A flexible shape must hold where it was not fitted, whatever it leaves; and what explains nearly all there does.
    let is_flexible = effects.iter().any(|effect| effect.info().flexible);
    let share = explained
        .filter(|share| is_flexible || share.lower >= NEARLY_ALL || trial.tells(best, noise));
    let share = share.map_or(by_lack, |share| share.lower);
    let explained = explained.map(|share| share.value);
    let left = 1.0 - explained.unwrap_or(by_lack).min(by_lack);
    let is_left = lack.p_value < LACK_OF_FIT;
    let is_in_part = is_left && left > SMALL_REMAINDER && Trial::far_off(best, noise);
    // What a wrong name bends to the recordings comes to nine tenths, seldom further.
    let is_wanting = is_in_part
        && explained.is_some_and(|share| share < GATE_IN_PART)
        && effects.iter().any(|effect| !is_universal(effect))
        && search.case.setting.loop_family == LoopFamily::Proximity;
    let verdict = if effects.is_empty() {
        without_effects(search, noise, lack.p_value)
    } else if licensed.is_empty() || share < GATE || is_wanting {
        Verdict::Unexplained
    } else if is_in_part {
        Verdict::ExplainedInPart
    } else if licensed.iter().any(|named| !named.others.is_empty()) {
        Verdict::Ambiguous
    } else {
        Verdict::Explained
    };
    if verdict == Verdict::Unexplained {
        suspects.append(&mut licensed);
    }
    Ok(Judged {
        verdict,
        effects,
        named: licensed,
        suspects,
        explained: explained.or((!effects.is_empty()).then_some(by_lack)),
    })
}

/// The effects of a model with what else they could be.
fn names(
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

/// A model of as many effects, none of which acts like another, that is far more credible.
fn ahead(search: &Search<'_>, effects: CandidateSet) -> Option<CandidateSet> {
    let least = search.credit(effects) + AS_WELL;
    let has_twins = |set: CandidateSet| set.iter().any(|one| has_twin(one, set));
    let is_one = |node: &Node| node.effects.len() == effects.len() && !has_twins(node.effects);
    let best = most_credible(search, is_one)?;
    (search.credit(best) > least).then_some(best)
}

/// The most credible of some models.
fn most_credible(search: &Search<'_>, is_one: impl Fn(&Node) -> bool) -> Option<CandidateSet> {
    let credible = search
        .nodes()
        .filter(|node| is_one(node) && search.admits(node) && !search.is_outdone(node));
    credible
        .map(|node| (search.credit(node.effects), node.effects))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, effects)| effects)
}

/// A model that was visited.
pub(crate) fn visited<'a>(search: &'a Search<'_>, effects: CandidateSet) -> &'a Node {
    let Some(node) = search.get(effects) else {
        unreachable!("only models that were visited are judged");
    };
    node
}

/// The verdict where no effect helps, with the probability that noise alone leaves as much.
pub(crate) fn without_effects(search: &Search<'_>, noise: &Measured, p_value: f64) -> Verdict {
    let plain = search.baseline();
    let is_left = p_value < LACK_OF_FIT;
    // The noise of a thermometer is not measured: there only what is beyond doubt counts.
    let has_thermometer = plain.noise.temperature.n_samples > 0;
    if has_thermometer && p_value < BEYOND_DOUBT {
        return Verdict::Unexplained;
    }
    // Slow errors look like noise with a long memory: where the noise was measured, their size tells.
    let is_large = noise.upper.is_some() && plain.mean_square() > LARGE * search.noise();
    let is_far = Trial::far_off(plain, noise) && (is_left || is_large);
    let is_unsteady = noise.is_unsteady(plain.mean_square());
    let mut segments = search.case.layout.segments.iter();
    let has_tone = !noise.is_coarse(plain.mean_square())
        && segments.any(|segment| {
            segment.channel == Channel::Output && has_tone(&plain.residual[segment.range.clone()])
        });
    if is_far || is_unsteady || has_tone {
        Verdict::Unexplained
    } else {
        Verdict::Adequate
    }
}

/// The most credible model of so many effects at most.
fn chosen(search: &Search<'_>, most: usize) -> CandidateSet {
    let best = most_credible(search, |node| node.effects.len() <= most);
    best.unwrap_or(CandidateSet::EMPTY)
}

/// The most credible model, fitted from many places; where much is left, or was until then, or the fit ends on a
/// bound, with effects exchanged, added or left out for as long as that makes it more credible: roads that lead to
/// one place differ in their order.
fn settled(search: &mut Search<'_>) -> Result<CandidateSet, IdentifyError> {
    let mut effects = chosen(search, usize::MAX);
    for _ in 0..ROUNDS {
        let is_elsewhere = !effects.is_empty() && search.settle(effects)?.is_elsewhere;
        let is_admitted = search.get(effects).is_some_and(|node| search.admits(node));
        if !is_elsewhere && is_admitted && !search.is_misfit() {
            break;
        }
        look_around(search, effects)?;
        let best = chosen(search, usize::MAX);
        if best == effects {
            break;
        }
        effects = best;
    }
    Ok(effects)
}

/// Visits models with one effect more, less or exchanged.
fn look_around(search: &mut Search<'_>, effects: CandidateSet) -> Result<(), IdentifyError> {
    let mut neighbors: Vec<CandidateSet> = if effects.len() < MOST_EFFECTS {
        search.children(effects)?
    } else {
        Vec::new()
    };
    for effect in effects.iter() {
        neighbors.extend(search.exchanged(effects, effect, None));
        for (rival, cosine) in rivals(search, effects, effect)? {
            if cosine > ALIKE {
                neighbors.extend(search.exchanged(effects, effect, Some(&rival)));
            }
        }
    }
    neighbors.sort_by(|&a, &b| search.credit(b).total_cmp(&search.credit(a)));
    neighbors.truncate(NEIGHBORS);
    search.finish(&neighbors)
}

/// Scores of what could stand in the place of an effect, with the cosines of their traces with its own.
fn rivals(
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

/// Leaves out effects that hardly bring anything, or are too small for their names; the others with what they bring.
fn pruned(
    search: &mut Search<'_>,
    trial: &Trial,
    effects: &mut CandidateSet,
) -> Result<Vec<(Candidate, f64)>, IdentifyError> {
    // What a larger model needs stays when what acts like another leaves it, and some of the other's form is left.
    let mut needed = CandidateSet::EMPTY;
    loop {
        if let Some(less) = without_slight(search, *effects) {
            *effects = less;
            continue;
        }
        let contributions = contributions(search, trial, *effects)?;
        let weak = contributions.iter().filter(|(_, share)| *share < OWN_SHARE);
        let weak: Vec<(Candidate, f64)> = weak.copied().collect();
        let mut idle = Vec::new();
        for (effect, share) in weak {
            // What acts like another of the model takes in what is only the other's form.
            if !has_twin(effect, *effects) {
                let Some(less) = search.exchanged(*effects, effect, None) else {
                    // Nothing can be fitted without it.
                    continue;
                };
                let [with, without] = [*effects, less].map(|set| visited(search, set));
                if !is_crowd(with.effects.iter())
                    && lack(search, with)?.is_mended(&lack(search, without)?)
                {
                    needed = needed.with(effect);
                }
                if needed.contains(effect)
                    || takes_the_rest(with, without, trial.noise)
                    || stands_beside_drifts(search, with, without, effect)
                {
                    continue;
                }
            }
            idle.push((effect, share));
        }
        match idle.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((effect, _)) => {
                let less = search.exchanged(*effects, effect, None);
                *effects = less.unwrap_or(CandidateSet::EMPTY);
            }
            None if search.settle(*effects)?.is_elsewhere => {}
            None => return Ok(contributions),
        }
    }
}

/// Whether a set has more rigid effects that not every rod has than may have a name: more of them together bend to whatever
/// is there.
pub(crate) fn is_crowd(effects: impl IntoIterator<Item = Candidate>) -> bool {
    let is_odd = |one: &Candidate| !is_universal(*one) && !one.info().flexible;
    effects.into_iter().filter(is_odd).count() > MOST_ODD
}

/// A model of several effects without one that is too small for its name.
fn without_slight(search: &mut Search<'_>, effects: CandidateSet) -> Option<CandidateSet> {
    let node = visited(search, effects);
    let slight = effects.iter().find(|&effect| node.is_slight(effect))?;
    let less = search.exchanged(effects, slight, None)?;
    (!less.is_empty()).then_some(less)
}

/// Whether a model takes most of what another leaves beyond the noise: beside a large effect a small one is a small share of
/// all.
fn takes_the_rest(with: &Node, without: &Node, noise: f64) -> bool {
    let gained = with.noise.nats() - without.noise.nats();
    let [with, without] = [with, without].map(Node::mean_square);
    let is_left = without > MUCH_LEFT * noise;
    is_left && gained > BEYOND && without - with > THE_REST * (without - noise)
}

/// Whether an effect is told beside what drifts through the run.
fn stands_beside_drifts(
    search: &Search<'_>,
    with: &Node,
    without: &Node,
    effect: Candidate,
) -> bool {
    let drifts = |one: Candidate| !is_rigid(one);
    let least = BESIDE[usize::from(drifts(effect))];
    without.effects.iter().any(drifts) && share_of_likelihood(search, with, without) > least
}

/// What a model has beyond another of the likelihood that it has beyond the plain one.
fn share_of_likelihood(search: &Search<'_>, with: &Node, without: &Node) -> f64 {
    let [with, without, plain] = [with, without, search.baseline()].map(|node| node.noise.nats());
    (with - without) / (with - plain)
}

/// Whether a model that was visited leaves noise alone.
fn leaves_noise(search: &Search<'_>, effects: CandidateSet) -> Result<bool, IdentifyError> {
    Ok(lack(search, visited(search, effects))?.p_value > LACK_OF_FIT)
}

/// Share of the explainable error that comes back without each effect.
fn contributions(
    search: &mut Search<'_>,
    trial: &Trial,
    effects: CandidateSet,
) -> Result<Vec<(Candidate, f64)>, IdentifyError> {
    let mut shares = Vec::new();
    for effect in effects.iter() {
        let Some(less) = search.exchanged(effects, effect, None) else {
            // Nothing can be fitted without it.
            shares.push((effect, 1.0));
            continue;
        };
        let [with, without] = [effects, less].map(|set| visited(search, set));
        let share = if trial.is_resolved() {
            let lost = trial.left(search, without)? - trial.left(search, with)?;
            let of_output = lost / (trial.left(search, search.baseline())? - trial.noise);
            of_output.max(of_temperature(search, with, without))
        } else {
            let all = with.noise.nats() - search.baseline().noise.nats();
            (with.noise.nats() - without.noise.nats()) / all
        };
        shares.push((effect, share));
    }
    Ok(shares)
}

/// What an effect brings to a recorded temperature, as a share of what there is to be explained.
fn of_temperature(search: &Search<'_>, with: &Node, without: &Node) -> f64 {
    let left = |node: &Node| node.noise.temperature.variance;
    let least = search.nodes().map(left).fold(f64::INFINITY, f64::min);
    let plain = left(search.baseline());
    if plain > KNOWN * least {
        (left(without) - left(with)) / (plain - least)
    } else {
        0.0
    }
}

/// Effects that all models share which are nearly as credible as a model, where all leave more than noise.
fn shared(search: &Search<'_>, effects: CandidateSet) -> CandidateSet {
    let least = search.credit(effects) - AS_WELL;
    let near = search
        .nodes()
        .filter(|node| search.is_misfit() && search.admits(node))
        .filter(|node| search.credit(node.effects) > least);
    near.fold(effects, |shared, node| {
        shared
            .iter()
            .filter(|&effect| node.effects.contains(effect))
            .collect()
    })
}

/// Effects of a model whose names the others do not carry. Where a model does not reach the noise something else is
/// going on, to which several effects can bend together: there a name is for what passes the gate without the
/// others, beside what every rod has, or for two that account for nearly all. A loop of any shape bends to anything.
fn upheld(
    search: &mut Search<'_>,
    trial: &Trial,
    noise: &Measured,
    effects: CandidateSet,
) -> Result<CandidateSet, IdentifyError> {
    let is_far = |node: &Node| Trial::far_off(node, noise);
    if !search.get(effects).is_some_and(is_far) {
        return Ok(effects);
    }
    let share = trial.explained(search, visited(search, effects))?;
    let is_nearly_all = share.is_some_and(|share| share.lower >= NEARLY_ALL);
    if is_nearly_all && effects.len() <= 2 && !effects.contains(EffectId::LoopShape) {
        return Ok(effects);
    }
    let universal: CandidateSet = effects.iter().filter(|&one| is_universal(one)).collect();
    let mut upheld = CandidateSet::EMPTY;
    let odd = effects.iter().filter(|&effect| !universal.contains(effect));
    for set in std::iter::once(universal).chain(odd.map(|effect| universal.with(effect))) {
        if passes(search, trial, effects, set)? {
            upheld = upheld.iter().chain(set.iter()).collect();
        }
    }
    Ok(upheld)
}

/// Whether a part of the effects of a model passes the gate alone.
fn passes(
    search: &mut Search<'_>,
    trial: &Trial,
    effects: CandidateSet,
    part: CandidateSet,
) -> Result<bool, IdentifyError> {
    let mut set = effects;
    for other in effects.iter().filter(|&effect| !part.contains(effect)) {
        let Some(less) = search.exchanged(set, other, None) else {
            return Ok(false);
        };
        set = less;
    }
    let share = trial.explained(search, visited(search, set))?;
    Ok(share.is_some_and(|share| share.lower >= GATE))
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
fn has_twin(effect: Candidate, effects: CandidateSet) -> bool {
    acts_like(effect).any(|other| effects.contains(other))
}

/// What acts like an effect in every rig, and could not be tried for want of what it needs: as likely.
fn untried(search: &Search<'_>, effect: Candidate) -> impl Iterator<Item = Candidate> {
    acts_like(effect).filter(|&other| search.may_be(other) && search.case.missing(other).is_some())
}

/// Rates of fading, 1/cycle, and losses of stroke over their usual share of the shift, below which a fatigue has neither.
const UNFADING: f64 = 0.01;
const STROKE_KEPT: f64 = 0.1;

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

/// The model in which an effect is compared with others: with what acts like another of its effects beside that, if it takes in
/// what is only the other's form, which would speak for whatever mends that.
fn formed(search: &Search<'_>, effects: CandidateSet, effect: Candidate) -> CandidateSet {
    let others = effects.iter().filter(|&other| other != effect);
    let with_twin = others.flat_map(acts_like).map(|twin| effects.with(twin));
    let far_better = with_twin.filter(|&set| {
        let is_admitted = search.get(set).is_some_and(|node| search.admits(node));
        is_admitted && !has_twin(effect, set) && search.behind(effects, set) > BEYOND
    });
    far_better.last().unwrap_or(effects)
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
