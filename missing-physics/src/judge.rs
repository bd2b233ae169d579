//! Which verdict: whether what was chosen accounts for the mismatch, and whose names hold.

use identify::IdentifyError;

use crate::case::Node;
use crate::choice::{AS_WELL, ROUNDS, ahead, chosen, settled, visited};
use crate::credit::{BEYOND_DOUBT_NATS, OUTDONE, is_universal};
use crate::diagnosis::Verdict;
use crate::elsewhere::is_drift;
use crate::floor::Measured;
use crate::lack::{BEYOND_DOUBT_P, LACK_OF_FIT, lack};
use crate::names::{Named, names};
use crate::prune::{BESIDE, pruned, share_of_likelihood};
use crate::search::Search;
use crate::series::Channel;
use crate::tone::has_tone;
use crate::trial::Trial;
use crate::{Candidate, CandidateSet, EffectBlock, EffectId, LoopFamily};

/// Share of the explainable error that the whole model must explain for its names to hold.
pub(crate) const GATE: f64 = 0.8;

/// The same where more than noise is left, of models with effects that not every rod has: beside the paper's loop.
const GATE_IN_PART: f64 = 0.93;

/// The same from which two effects hold one another's names up: what is wrong comes to nine tenths.
const NEARLY_ALL: f64 = 0.95;

/// Share of the explainable error below which a remainder is not worth a word.
const SMALL_REMAINDER: f64 = 0.02;

/// Residual of the plain model over noise, squared, that cannot be noise.
pub(crate) const LARGE: f64 = 1.5;

/// Mean square over that of the noise at rest of a model with a drift that accounts for all.
const NEAR: f64 = 2.0;

/// Mean square without a drift over that with it, from which others may stand beside it.
const DRIFTED: f64 = 3.0;

/// Mean square of a drift alone over that with others, from which these are not its own remainder.
const HALVED: f64 = 2.0;

/// Variance among repeated cycles beyond the noise over what a drift explains, below which that is no drift: of concealed ones
/// it was 1 to 4, of other effects under a drift's name 0.01 at most (blind-trial, seed 66f801e5).
const AMONG_REPEATS: f64 = 0.1;

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
    // A drift that is found alone may hide what stands beside it, and several effects may stand for a drift and another.
    let is_flexible = best.effects.iter().any(|one| one.info().flexible);
    let hides = is_flexible
        && (best.mean_square() > NEAR * noise.gate || lack(search, best)?.p_value < BEYOND_DOUBT_P);
    let is_settled =
        without.verdict != Verdict::Unexplained && !hides && !is_drift_and_another(search, best);
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

/// Whether a drift with others, no more effects than a model has, leaves less than half of what that leaves, and is far more
/// credible.
fn is_drift_and_another(search: &Search<'_>, best: &Node) -> bool {
    let drifting = search.nodes().filter(|node| {
        node.effects.iter().any(is_drift)
            && node.effects.len() <= best.effects.len()
            && !node.is_held()
    });
    drifting
        .filter(|node| OUTDONE * node.mean_square() < best.mean_square())
        .any(|node| search.behind(best.effects, node.effects) > BEYOND_DOUBT_NATS)
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
    if !unseen_among_repeats(search, noise, effects).is_empty() {
        return Ok(false);
    }
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

/// Drifts of a model that repeated cycles do not show: what drifts through the run moves them apart.
fn unseen_among_repeats(
    search: &mut Search<'_>,
    noise: &Measured,
    effects: CandidateSet,
) -> CandidateSet {
    let Some(repeats) = noise.repeats else {
        return CandidateSet::EMPTY;
    };
    let mut is_unseen = |drift: Candidate| {
        let less = search.exchanged(effects, drift, None)?;
        let [with, without] = [effects, less].map(|set| visited(search, set).mean_square());
        Some(repeats - noise.gate < AMONG_REPEATS * (without - with))
    };
    let drifts = effects.iter().filter(|&effect| is_drift(effect));
    drifts
        .filter(|&drift| is_unseen(drift).unwrap_or(false))
        .collect()
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
    let unseen = unseen_among_repeats(search, noise, effects);
    let (mut licensed, mut suspects): (Vec<Named>, Vec<Named>) =
        named.into_iter().partition(|named| {
            let is_shared = shared.contains(named.effect) || !named.others.is_empty();
            let fits =
                |node: &Node| !node.is_pressed(named.effect) && !node.is_slight(named.effect);
            let has_size = search.get(effects).is_some_and(fits);
            is_shared && upheld.contains(named.effect) && has_size && !unseen.contains(named.effect)
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

/// The verdict where no effect helps, with the probability that noise alone leaves as much.
pub(crate) fn without_effects(search: &Search<'_>, noise: &Measured, p_value: f64) -> Verdict {
    let plain = search.baseline();
    let is_left = p_value < LACK_OF_FIT;
    // The noise of a thermometer is not measured: there only what is beyond doubt counts.
    let has_thermometer = plain.noise.temperature.n_samples > 0;
    if has_thermometer && p_value < BEYOND_DOUBT_P {
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

/// Whether a model that was visited leaves noise alone.
fn leaves_noise(search: &Search<'_>, effects: CandidateSet) -> Result<bool, IdentifyError> {
    Ok(lack(search, visited(search, effects))?.p_value > LACK_OF_FIT)
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
