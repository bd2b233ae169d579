//! Which effects of a model stay: what each of them brings.

use identify::IdentifyError;

use crate::case::Node;
use crate::choice::visited;
use crate::credit::{BEYOND_DOUBT_NATS, is_universal};
use crate::elsewhere::is_rigid;
use crate::lack::lack;
use crate::names::has_twin;
use crate::search::Search;
use crate::trial::{KNOWN, Trial};
use crate::{Candidate, CandidateSet};

/// Share of the explainable error that an effect must bring to have a name.
pub(crate) const OWN_SHARE: f64 = 0.05;

/// Mean square of a model over that of the noise from which an effect may be for what is left.
const MUCH_LEFT: f64 = 1.5;

/// Share of what is left that it must take.
const THE_REST: f64 = 0.5;

/// Share of the likelihood that an effect must bring to have a name beside what drifts through the run, and what drifts
/// itself: what a smooth law leaves of a real drift is noise with a memory, of which others take in up to 4 and 8 %.
pub(crate) const BESIDE: [f64; 2] = [0.05, 0.1];

/// Most rigid effects with a name that not every rod has.
const MOST_ODD: usize = 2;

/// Leaves out effects that hardly bring anything, or are too small for their names; the others with what they bring.
pub(crate) fn pruned(
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
    is_left && gained > BEYOND_DOUBT_NATS && without - with > THE_REST * (without - noise)
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
pub(crate) fn share_of_likelihood(search: &Search<'_>, with: &Node, without: &Node) -> f64 {
    let [with, without, plain] = [with, without, search.baseline()].map(|node| node.noise.nats());
    (with - without) / (with - plain)
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
