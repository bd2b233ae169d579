//! Which explanations the next run is to tell apart.

use identify::{IdentifyError, Limits};

use recording::order::falling;

use crate::decide::Verdict;
use crate::decide::{Decided, Named};
use crate::model::case::Node;
use crate::next::advice::record_surroundings;
use crate::next::experiment::{Rival, next_experiment};
use crate::next::run::NextExperiment;
use crate::search::roads::Search;
use crate::{Candidate, CandidateSet};

/// Most explanations that a run is sought for.
const RIVALS: usize = 3;

/// Factor by which a run must part models that are all far off more than the recordings at hand do.
const FURTHER: f64 = 2.0;

/// The run that would tell apart a name that is not sure and what else it could be; where nothing accounts for the
/// mismatch, the models that come nearest.
pub(crate) fn next(
    search: &Search<'_>,
    decided: &Decided,
    effects: CandidateSet,
    limits: &Limits,
) -> Result<Option<NextExperiment>, IdentifyError> {
    let unsure = decided
        .named
        .iter()
        .filter(|named| !named.others.is_empty());
    let strongest = unsure.max_by(|a, b| a.contribution.total_cmp(&b.contribution));
    if let Some(named) = strongest.filter(|named| drift_is_guessed(search, effects, named)) {
        let others = named.others.iter().map(|(other, _)| *other);
        let separates = std::iter::once(named.effect).chain(others).collect();
        return Ok(Some(record_surroundings(separates)));
    }
    let mut rivals = match strongest {
        Some(named) => in_its_place(search, effects, named),
        None if decided.verdict == Verdict::Unexplained => nearest(search, effects),
        None => Vec::new(),
    };
    rivals.truncate(RIVALS);
    let Some(best) = rivals.first() else {
        return Ok(None);
    };
    let next = next_experiment(search.case, &rivals, limits, &best.node.noise)?;
    // Between models that are all far off, a run counts that parts them further than these recordings do.
    let tells_more = |next: &NextExperiment| {
        let run = next.run.as_ref();
        strongest.is_some() || run.is_some_and(|run| run.separation > FURTHER * run.separation_now)
    };
    Ok(next.filter(tells_more))
}

/// True if nobody recorded the temperature of the surroundings, and a drift of the surroundings is in the model or may
/// be in the place of the name.
fn drift_is_guessed(search: &Search<'_>, effects: CandidateSet, named: &Named) -> bool {
    let others = named.others.iter().map(|(other, _)| *other);
    let may_drift = |effect: Candidate| effect.info().settled_by_ambient_record;
    let mut training = search.case.training.iter();
    effects.iter().chain(others).any(may_drift)
        && training.all(|recording| recording.ambient_degc().is_none())
}

/// A model with a name, and those with what else it could be.
fn in_its_place<'a>(
    search: &'a Search<'_>,
    effects: CandidateSet,
    named: &Named,
) -> Vec<Rival<'a>> {
    let less = effects.without(named.effect);
    // A finer form of a loop that is there is no candidate.
    let others = named.others.iter().map(|(effect, _)| *effect);
    let others = others.filter(|&other| !effects.contains(other));
    std::iter::once(named.effect)
        .chain(others)
        .filter_map(|effect| {
            let node = search.get(less.with(effect))?;
            Some(Rival { effect, node })
        })
        .collect()
}

/// The chosen model, or the most credible with effects, and the most credible others, each by an effect that the
/// first does not have.
fn nearest<'a>(search: &'a Search<'_>, chosen: CandidateSet) -> Vec<Rival<'a>> {
    let with_effects = |node: &&Node| search.admits(node) && !node.effects.is_empty();
    let mut nodes: Vec<&Node> = search.nodes().filter(with_effects).collect();
    falling(&mut nodes, |node| match node.effects == chosen {
        true => f64::INFINITY,
        false => search.credit(node.effects),
    });
    let own = |node: &Node, other: &Node| {
        let mut own = node.effects.iter();
        own.find(|&effect| !other.effects.contains(effect))
    };
    let Some((best, others)) = nodes.split_first() else {
        return Vec::new();
    };
    let mut rivals: Vec<Rival<'_>> = Vec::new();
    for &node in others {
        let (Some(of_best), Some(effect)) = (own(best, node), own(node, best)) else {
            continue;
        };
        if rivals.is_empty() {
            rivals.push(Rival {
                effect: of_best,
                node: best,
            });
        }
        if rivals.iter().all(|rival| rival.effect != effect) {
            rivals.push(Rival { effect, node });
        }
    }
    rivals
}
