//! The population: every model that a judgement needs, searched before anything is judged.

use identify::IdentifyError;

use recording::order::falling;

use crate::config::Part;
use crate::decide::leading;
use crate::evidence::{Block, Population};
use crate::model::elsewhere::is_drift;
use crate::search::exchange::{ALIKE, rivals};
use crate::search::roads::{MOST_EFFECTS, Search};
use crate::search::weighing::{Weighing, at};
use crate::{Candidate, CandidateSet};

/// Rounds of fits, exchanges and subsets around the leading model, until it stays.
const ROUNDS: usize = 8;

/// Completes the models of searches around the leading one.
#[derive(Debug)]
pub(crate) struct Completing<'a> {
    weighing: Weighing<'a>,
    /// Models that the population is complete around.
    around: Vec<(usize, CandidateSet)>,
    /// Models of which every one that lacks one name was searched.
    apart: Vec<(usize, CandidateSet)>,
    /// Models that were fitted from many places.
    settled: Vec<(usize, CandidateSet)>,
}

impl<'a> Completing<'a> {
    pub(crate) fn new(blocks: &'a [Block], seed: u64) -> Self {
        Self {
            weighing: Weighing::new(blocks, seed),
            around: Vec::new(),
            apart: Vec::new(),
            settled: Vec::new(),
        }
    }

    /// The population of some searches, the paper's loop first, with every model that a judgement needs.
    pub(crate) fn completed(
        &mut self,
        searches: &mut [Search<'_>],
    ) -> Result<Population, IdentifyError> {
        let mut beside_drifts = searches[0].beside_drifts;
        for _ in 0..ROUNDS {
            let case = searches[0].case;
            if case.leaves_out(Part::MoreEffects) {
                break;
            }
            let population = self.weighing.audited(searches)?;
            let model = leading(&population);
            let (place, effects) = at(searches, model);
            if self.completed_around(searches, (place, effects))? {
                continue;
            }
            // The foremost may lead only from where a search from many places ends.
            let foremost = (!model.is_whole()).then(|| foremost(searches, &population));
            let mut unsettled = std::iter::once((place, effects))
                .chain(foremost.into_iter().flatten())
                .chain(nearest_misfit(searches))
                .filter(|one| !one.1.is_empty() && !self.settled.contains(one));
            if let Some((place, effects)) = unsettled.next()
                && !case.leaves_out(Part::OtherStarts)
            {
                self.settled.push((place, effects));
                searches[place].settle(effects)?;
            } else if !beside_drifts && !model.is_whole() && has_drift(&population) {
                // A drift may hide what stands beside it.
                beside_drifts = true;
                searches[0].grow_beside_drifts()?;
            } else {
                break;
            }
        }
        self.weighing.audited(searches)
    }

    /// Completes the population around a model; whether that was left to do.
    pub(crate) fn completed_around(
        &mut self,
        searches: &mut [Search<'_>],
        model: (usize, CandidateSet),
    ) -> Result<bool, IdentifyError> {
        if self.around.contains(&model) {
            return Ok(false);
        }
        self.around.push(model);
        complete(searches, model.0, model.1)?;
        Ok(true)
    }

    /// Searches what a model is without each of its names, the loop among them: only that tells what it owes to them. Returns whether
    /// that was left to do.
    pub(crate) fn taken_apart(
        &mut self,
        searches: &mut [Search<'_>],
        model: (usize, CandidateSet),
    ) -> Result<bool, IdentifyError> {
        if self.around.contains(&model) || self.apart.contains(&model) {
            return Ok(false);
        }
        self.apart.push(model);
        let (place, effects) = model;
        for effect in effects.iter() {
            searches[place].without(effects, effect)?;
        }
        if place > 0
            && let Some(node) = searches[place].get(effects).cloned()
        {
            searches[0].moved_here(&node)?;
        }
        Ok(true)
    }

    /// The population as it is.
    pub(crate) fn audited(&mut self, searches: &[Search<'_>]) -> Result<Population, IdentifyError> {
        self.weighing.audited(searches)
    }
}

/// The model of each search that is worth most of those with an effect.
fn foremost(searches: &[Search<'_>], population: &Population) -> Vec<(usize, CandidateSet)> {
    let of = |place: usize| {
        let own = population.models.iter().filter(|model| {
            model.is_admissible() && !model.effects.is_empty() && at(searches, model).0 == place
        });
        let best = own.max_by(|a, b| a.worth().total_cmp(&b.worth()));
        best.map(|model| (place, model.effects))
    };
    (0..searches.len()).filter_map(of).collect()
}

/// The model with an effect that leaves the least of the output, of those that may be chosen, where even that leaves far more than noise.
///
/// Noise with a memory takes up what is left there, so that a model in a wrong minimum is worth as much as one in the right one.
fn nearest_misfit(searches: &[Search<'_>]) -> Option<(usize, CandidateSet)> {
    let of = |(place, search): (usize, &Search<'_>)| {
        let with_effects = search.nodes().filter(|node| !node.effects.is_empty());
        let admitted = with_effects.filter(|node| search.admits(node));
        let errors = admitted.map(|node| (node.mean_square(), (place, node.effects)));
        errors.min_by(|a, b| a.0.total_cmp(&b.0))
    };
    if !searches.iter().all(Search::is_misfit) {
        return None;
    }
    let nearest = searches.iter().enumerate().filter_map(of);
    let nearest = nearest.min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map(|(_, model)| model)
}

/// Share of what could be explained that a drift alone explains, from which others are tried beside it.
const MUCH: f64 = 0.5;

/// True if a drift alone explains more than the share `MUCH` of what could be explained.
fn has_drift(population: &Population) -> bool {
    let plain = population.plain().evidence.squares();
    let alone = population
        .models
        .iter()
        .filter(|model| model.effects.len() == 1 && model.names.iter().all(is_drift));
    alone
        .map(|model| population.share(model.evidence.squares(), plain))
        .any(|share| share > MUCH)
}

/// Searches what could stand beside a model, its parts, and what else could be in the place of each of its effects.
fn complete(
    searches: &mut [Search<'_>],
    place: usize,
    effects: CandidateSet,
) -> Result<(), IdentifyError> {
    let (papers, others) = searches.split_at_mut(1);
    let papers = &mut papers[0];
    let search = match place {
        0 => &mut *papers,
        _ => &mut others[place - 1],
    };
    let mut wanted = if effects.len() < MOST_EFFECTS {
        search.children(effects)?
    } else {
        Vec::new()
    };
    wanted.truncate(NEIGHBORS);
    let mut exchanges = Vec::new();
    for effect in effects.iter() {
        let rivals = rivals(search, effects, effect)?.into_iter();
        let alike = rivals.filter(|(_, cosine)| *cosine > ALIKE);
        exchanges.extend(alike.map(|(rival, _)| (effect, rival)));
    }
    wanted.extend(search.exchanged(effects, &exchanges)?);
    for part in parts(effects) {
        for effect in part.iter() {
            wanted.extend(search.without(part, effect)?);
        }
    }
    search.finish(&wanted)?;
    if place > 0 {
        // The paper's loop beside the same effects, from where this one stands.
        for part in parts(effects) {
            let node = others[place - 1].get(part).cloned();
            if let Some(node) = node {
                papers.moved_here(&node)?;
            }
        }
    }
    Ok(())
}

/// All sets of some of these effects, the largest first.
pub(crate) fn parts(effects: CandidateSet) -> Vec<CandidateSet> {
    let all: Vec<Candidate> = effects.iter().collect();
    let mut parts: Vec<CandidateSet> = (0..1_usize << all.len())
        .map(|bits| {
            let own = all.iter().enumerate().filter(|(k, _)| bits >> k & 1 == 1);
            own.map(|(_, effect)| *effect).collect()
        })
        .collect();
    falling(&mut parts, |part| part.len() as f64);
    parts
}

/// Models with one effect more that are tried around the leading one.
const NEIGHBORS: usize = 4;
