//! The most credible of the models that were visited, and what is visited around it.

use identify::IdentifyError;

use crate::CandidateSet;
use crate::case::Node;
use crate::names::{ALIKE, has_twin, rivals};
use crate::search::{MOST_EFFECTS, Search};

/// Units of log-likelihood within which another model does as well: odds of e³, 20 to 1.
pub(crate) const AS_WELL: f64 = 3.0;

/// Neighbors of a model that are tried.
const NEIGHBORS: usize = 4;

/// Rounds of exchanges.
pub(crate) const ROUNDS: usize = 3;

/// A model that was visited.
pub(crate) fn visited<'a>(search: &'a Search<'_>, effects: CandidateSet) -> &'a Node {
    let Some(node) = search.get(effects) else {
        unreachable!("only models that were visited are judged");
    };
    node
}

/// The most credible model, fitted from many places; where much is left, or was until then, or the fit ends on a
/// bound, with effects exchanged, added or left out for as long as that makes it more credible: roads that lead to
/// one place differ in their order.
pub(crate) fn settled(search: &mut Search<'_>) -> Result<CandidateSet, IdentifyError> {
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

/// The most credible model of so many effects at most.
pub(crate) fn chosen(search: &Search<'_>, most: usize) -> CandidateSet {
    let best = most_credible(search, |node| node.effects.len() <= most);
    best.unwrap_or(CandidateSet::EMPTY)
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

/// A model of as many effects, none of which acts like another, that is far more credible.
pub(crate) fn ahead(search: &Search<'_>, effects: CandidateSet) -> Option<CandidateSet> {
    let least = search.credit(effects) + AS_WELL;
    let has_twins = |set: CandidateSet| set.iter().any(|one| has_twin(one, set));
    let is_one = |node: &Node| node.effects.len() == effects.len() && !has_twins(node.effects);
    let best = most_credible(search, is_one)?;
    (search.credit(best) > least).then_some(best)
}
