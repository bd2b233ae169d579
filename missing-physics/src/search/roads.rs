//! The road from the baseline to models with effects: screen, refit, and again.

use std::collections::BTreeSet;
use std::sync::Arc;

use identify::{Fit, IdentifyError, in_order_of};
use recording::order::{falling, rising};

use crate::config::Part;
use crate::model::case::{Case, Node};
use crate::model::elsewhere::is_drift;
use crate::model::tangent::{Sensitivity, sensitivities};
use crate::screen::scores::{Score, as_one, sizes_of};
use crate::screen::screening::{Sifted, sift};
use crate::search::odds::{BEYOND_DOUBT_NATS, MISFIT};
use crate::search::refit::{led, refit};
use crate::search::settle::{fitted, settled};
use crate::{Candidate, CandidateSet};

/// Most effects of a model.
pub(crate) const MOST_EFFECTS: usize = 4;

/// Models of each number of effects that are followed further: so many by likelihood, and by error.
const BRANCHES: usize = 2;

/// Candidates that are refitted beside other effects: so many by the plain score, and so many by the whitened one.
/// Alone, all that could matter are.
const BY_PLAIN: usize = 9;
const BY_WHITENED: usize = 5;

/// Candidates that are refitted beside other effects where a simulation is costly: by the plain score, and by the
/// whitened one.
const COSTLY: [usize; 2] = [4, 3];

/// Mean square over that with an effect less from which, far from the noise, further effects lead nowhere either.
const STALLED: f64 = 0.9;

/// Swarms from which a chosen model is fitted, if it is still such a misfit: what is bent far leads nowhere from nearby.
const SWARMS: u64 = 1;

/// Share of the critical score from which a candidate could matter.
const COULD_MATTER: f64 = 0.7;

/// A model and what could be added to it.
#[derive(Debug, Clone)]
pub(crate) struct Visited {
    pub(crate) node: Node,
    pub(crate) sifted: Option<Arc<Sifted>>,
    /// True if its search went to its end.
    is_finished: bool,
    /// Its fit from many places, if it was made: the node stands where that ended.
    fit: Option<Arc<Fit>>,
}

impl From<Node> for Visited {
    fn from(node: Node) -> Self {
        Self {
            node,
            sifted: None,
            is_finished: false,
            fit: None,
        }
    }
}

/// All models that were looked at.
#[derive(Debug)]
pub(crate) struct Search<'a> {
    pub(crate) case: &'a Case<'a>,
    /// Candidates that may be found.
    catalogue: CandidateSet,
    /// Variance of the noise, at most.
    noise: f64,
    seed: u64,
    visited: Vec<Visited>,
    /// Models that more effects are yet to be tried beside.
    frontier: Vec<CandidateSet>,
    /// The baseline at its other minima, until effects have been tried there.
    other_baselines: Vec<Node>,
    /// True if a drift may stand beside other effects.
    pub(crate) beside_drifts: bool,
    /// Sets of effects that lead nowhere.
    dead: Vec<CandidateSet>,
    /// Models that were searched from where one with an effect more was fitted, after that one.
    lightened: Vec<(CandidateSet, CandidateSet)>,
    /// True if its models come from the ends of another search: they need not be fitted from many places.
    is_ended: bool,
}

impl<'a> Search<'a> {
    pub(crate) fn new(
        case: &'a Case<'a>,
        baseline: Node,
        catalogue: CandidateSet,
        noise: f64,
        seed: u64,
    ) -> Result<Self, IdentifyError> {
        Ok(Self {
            case,
            catalogue,
            noise,
            seed,
            other_baselines: case.other_baselines()?,
            visited: vec![baseline.into()],
            frontier: vec![CandidateSet::EMPTY],
            beside_drifts: false,
            dead: Vec::new(),
            lightened: Vec::new(),
            is_ended: false,
        })
    }

    /// A search of models that another has taken to their ends on fewer samples.
    pub(crate) fn ended(
        case: &'a Case<'a>,
        baseline: Node,
        other: &Search<'_>,
        noise: f64,
    ) -> Self {
        Self {
            case,
            catalogue: other.catalogue,
            noise,
            seed: other.seed,
            other_baselines: Vec::new(),
            visited: vec![baseline.into()],
            frontier: Vec::new(),
            beside_drifts: other.beside_drifts,
            dead: Vec::new(),
            lightened: Vec::new(),
            is_ended: true,
        }
    }

    /// Models in the order in which they were found, the baseline first.
    pub(crate) fn nodes(&self) -> impl Iterator<Item = &Node> {
        self.visited.iter().map(|visited| &visited.node)
    }

    pub(crate) fn baseline(&self) -> &Node {
        &self.visited[0].node
    }

    fn index(&self, effects: CandidateSet) -> Option<usize> {
        self.visited
            .iter()
            .position(|one| one.node.effects == effects)
    }

    /// Scores at a model that was visited.
    pub(crate) fn sifted(&mut self, effects: CandidateSet) -> Result<Arc<Sifted>, IdentifyError> {
        let Some(index) = self.index(effects) else {
            unreachable!("only models that were visited are sifted");
        };
        if let Some(sifted) = &self.visited[index].sifted {
            return Ok(Arc::clone(sifted));
        }
        let node = &self.visited[index].node;
        let sifted = Arc::new(sift(self.case, node, self.catalogue, self.seed)?);
        self.visited[index].sifted = Some(Arc::clone(&sifted));
        Ok(sifted)
    }

    /// Derivatives of a model that was visited by its free parameters: those of its scores, if it has them.
    pub(crate) fn sensitivities(&self, node: &Node) -> Result<Arc<[Sensitivity]>, IdentifyError> {
        let visited = self.index(node.effects).map(|index| &self.visited[index]);
        match visited.and_then(|visited| visited.sifted.as_ref()) {
            Some(sifted) => Ok(Arc::clone(&sifted.sensitivities)),
            None => Ok(sensitivities(self.case, node)?.into()),
        }
    }

    /// Goes to models with one effect more, beside those that the last ones led to.
    pub(crate) fn grow_by_one(&mut self) -> Result<(), IdentifyError> {
        let frontier = std::mem::take(&mut self.frontier);
        let mut grown: Vec<CandidateSet> = Vec::new();
        for (rank, &effects) in frontier.iter().enumerate() {
            // Where the best model leaves nothing, others are followed only if they are near.
            let is_closed = rank > 0 && grown.is_empty();
            if is_closed && self.behind(effects, frontier[0]) > BEYOND_DOUBT_NATS {
                continue;
            }
            for child in self.children(effects)? {
                if !grown.contains(&child) {
                    grown.push(child);
                }
            }
        }
        let before = self.least_error(&frontier);
        if frontier == [CandidateSet::EMPTY] {
            self.settle_pressed(&grown)?;
        }
        let best = self.best_of(grown);
        self.finish(&best)?;
        let is_stalled = self.is_misfit() && self.least_error(&best) > STALLED * before;
        let is_full = best.iter().all(|set| set.len() == MOST_EFFECTS);
        if !is_stalled && !is_full {
            self.frontier = best;
        }
        Ok(())
    }

    /// Fits the nearest of some models from many places if it stands against a bound and leaves more than noise all the same: it is in a
    /// wrong minimum then, and so is what grows from it.
    fn settle_pressed(&mut self, sets: &[CandidateSet]) -> Result<(), IdentifyError> {
        let nearest = sets
            .iter()
            .copied()
            .min_by(|&a, &b| self.error(a).total_cmp(&self.error(b)));
        let Some(nearest) = nearest.filter(|&set| !is_costly(set)) else {
            return Ok(());
        };
        let is_pressed = self.get(nearest).is_some_and(Node::is_held);
        if is_pressed && self.is_misfit() && !self.case.leaves_out(Part::OtherStarts) {
            self.settle(nearest)?;
        }
        Ok(())
    }

    /// True if a model may be chosen: none of its effects is pressed against a bound, and no flexible effect helps
    /// others to their names. Drifts may stand beside other effects once these have failed without a drift.
    pub(crate) fn admits(&self, node: &Node) -> bool {
        let may_stand = node.effects.len() == 1
            || node
                .effects
                .iter()
                .all(|one| !one.info().flexible || self.beside_drifts && is_drift(one));
        may_stand && !node.is_held()
    }

    /// Tries effects beside a drift, from now on admitted; whether there were any.
    pub(crate) fn grow_beside_drifts(&mut self) -> Result<bool, IdentifyError> {
        self.beside_drifts = true;
        let mut grown = Vec::new();
        for drift in self.catalogue.iter().filter(|&one| is_drift(one)) {
            let alone = CandidateSet::EMPTY.with(drift);
            // What presses it against a bound may be the other.
            if self.get(alone).is_some() {
                grown.extend(self.children(alone)?);
            }
        }
        let best = self.best_of(grown);
        self.finish(&best)?;
        Ok(!best.is_empty())
    }

    /// Takes searches that were cut short to their ends.
    pub(crate) fn finish(&mut self, sets: &[CandidateSet]) -> Result<(), IdentifyError> {
        let known = sets.iter().filter_map(|&set| self.index(set));
        let open: BTreeSet<usize> = known
            .filter(|&index| !self.visited[index].is_finished)
            .collect();
        let open: Vec<usize> = open.into_iter().collect();
        let cost = |&index: &usize| cost(self.visited[index].node.effects);
        let finished = in_order_of(&open, cost, |&index| {
            self.case.finished(&self.visited[index].node)
        });
        for (index, node) in open.into_iter().zip(finished) {
            self.visited[index] = Visited {
                is_finished: true,
                ..node?.into()
            };
        }
        Ok(())
    }

    /// Fits a model that was visited from many places, once.
    pub(crate) fn settle(&mut self, effects: CandidateSet) -> Result<Arc<Fit>, IdentifyError> {
        let Some(index) = self.index(effects) else {
            unreachable!("only models that were visited are settled");
        };
        let before = &self.visited[index];
        if let Some(fit) = &before.fit {
            return Ok(Arc::clone(fit));
        }
        let is_costly = is_costly(effects);
        let fit = if self.is_ended {
            fitted(self.case, &before.node, self.seed)?
        } else {
            let swarms = if self.error(effects) > MISFIT * self.noise && !is_costly {
                SWARMS
            } else {
                0
            };
            settled(self.case, &before.node, swarms, self.seed, is_costly)?
        };
        let fit = Arc::new(fit);
        let node = self.case.fitted(&before.node, &fit)?;
        let is_elsewhere = node.noise.nats() - before.node.noise.nats() > BEYOND_DOUBT_NATS;
        self.visited[index] = Visited {
            // Around the same end the scores are the same.
            sifted: before.sifted.clone().filter(|_| !is_elsewhere),
            is_finished: true,
            fit: Some(Arc::clone(&fit)),
            ..node.into()
        };
        Ok(fit)
    }

    /// The most credible of some models, the best first, then those of the lowest error.
    fn best_of(&self, mut sets: Vec<CandidateSet>) -> Vec<CandidateSet> {
        let admitted = |set: &CandidateSet| self.get(*set).is_some_and(|node| self.admits(node));
        if sets.iter().any(admitted) {
            sets.retain(admitted);
        }
        let mut by_error = sets.clone();
        rising(&mut by_error, |&one| self.error(one));
        falling(&mut sets, |&set| self.credit(set));
        let mut best: Vec<CandidateSet> = sets.into_iter().take(BRANCHES).collect();
        for set in by_error.into_iter().take(BRANCHES) {
            if !best.contains(&set) {
                best.push(set);
            }
        }
        best
    }

    /// Variance of the noise, at most.
    pub(crate) fn noise(&self) -> f64 {
        self.noise
    }

    /// Mean square of what a model leaves of the output.
    fn error(&self, effects: CandidateSet) -> f64 {
        self.get(effects).map_or(f64::INFINITY, Node::mean_square)
    }

    fn least_error(&self, sets: &[CandidateSet]) -> f64 {
        let errors = sets.iter().map(|&set| self.error(set));
        errors.fold(f64::INFINITY, f64::min)
    }

    /// The model with these effects, if it was visited.
    pub(crate) fn get(&self, effects: CandidateSet) -> Option<&Node> {
        self.index(effects).map(|index| &self.visited[index].node)
    }

    /// Models with one effect more that are significantly better.
    pub(crate) fn children(
        &mut self,
        effects: CandidateSet,
    ) -> Result<Vec<CandidateSet>, IdentifyError> {
        let sifted = self.sifted(effects)?;
        let critical = sifted.found.critical;
        let most = if effects.is_empty() {
            [usize::MAX; 2]
        } else {
            [BY_PLAIN, BY_WHITENED]
        };
        let least = if effects.is_empty() && self.error(effects) > MISFIT * self.noise {
            // Large effects hide in the memory that the residual seems to have: all are tried.
            f64::NEG_INFINITY
        } else {
            COULD_MATTER * critical
        };
        let mut list = shortlist(&sifted.found.scores, least, most);
        if !effects.is_empty() {
            let first = shortlist(&sifted.found.scores, least, COSTLY);
            let is_first = |score: &Score| first.iter().any(|one| one.effect == score.effect);
            list.retain(|score| is_first(score) || !is_costly(effects.with(score.effect)));
        }
        let mut added: Vec<Candidate> = list.iter().map(|score| score.effect).collect();
        let is_new = |score: &&Score| {
            let set = effects.with(score.effect);
            self.index(set).is_none() && !self.dead.contains(&set)
        };
        let list: Vec<&Score> = list.into_iter().filter(is_new).collect();
        let Some(parent) = self.get(effects) else {
            unreachable!("its scores were just taken");
        };
        let refitted = self.refitted(parent, &list)?;
        self.keep_all(refitted);
        if effects.is_empty() {
            for other in std::mem::take(&mut self.other_baselines) {
                let sifted = sift(self.case, &other, self.catalogue, self.seed)?;
                let list = shortlist(&sifted.found.scores, least, most);
                let refitted = self.refitted(&other, &list)?;
                self.keep_all(refitted);
                added.extend(list.iter().map(|score| score.effect));
            }
        }
        let Some(parent) = self.get(effects) else {
            unreachable!("nothing is ever taken away");
        };
        let mut children: Vec<CandidateSet> = Vec::new();
        for effect in added {
            let set = effects.with(effect);
            let child = self.get(set);
            let is_significant = |child: &Node| gained(parent, child, effect) > critical;
            if child.is_some_and(is_significant) && !children.contains(&set) {
                children.push(set);
            }
        }
        Ok(children)
    }

    /// A model with one effect more, each.
    fn refitted(
        &self,
        parent: &Node,
        list: &[&Score],
    ) -> Result<Vec<(CandidateSet, Option<Node>)>, IdentifyError> {
        let with = |score: &&Score| parent.effects.with(score.effect);
        let refitted = in_order_of(
            list,
            |score| cost(with(score)),
            |score| Ok((with(score), refit(self.case, parent, score, self.seed)?)),
        );
        refitted.into_iter().collect()
    }

    fn keep_all(&mut self, refitted: Vec<(CandidateSet, Option<Node>)>) {
        for (set, node) in refitted {
            self.keep(set, node);
        }
    }

    /// Takes in a refitted model, unless a lower end is known; one whose effect has vanished leads nowhere.
    pub(crate) fn keep(&mut self, set: CandidateSet, node: Option<Node>) {
        let found = node.filter(|node| set.iter().all(|effect| !node.has_vanished(effect)));
        match (self.index(set), found) {
            (None, None) if self.dead.contains(&set) => {}
            (None, None) => self.dead.push(set),
            (None, Some(found)) => {
                self.dead.retain(|dead| *dead != set);
                self.visited.push(found.into());
            }
            (Some(known), Some(found)) => {
                let known = &mut self.visited[known];
                if found.noise.deviance() < known.node.noise.deviance() {
                    *known = found.into();
                }
            }
            (Some(_), None) => {}
        }
    }

    /// A model without one of its effects, refitted if it was not visited; `None` if another effect vanishes then.
    pub(crate) fn without(
        &mut self,
        effects: CandidateSet,
        without: Candidate,
    ) -> Result<Option<CandidateSet>, IdentifyError> {
        let less = effects.without(without);
        if self.dead.contains(&less) {
            return Ok(None);
        }
        self.lighten(effects, less)?;
        Ok(self.index(less).map(|_| less))
    }

    /// The nearest model without one of the effects of another: with all others, or with those of them that do not vanish then.
    pub(crate) fn node_without(
        &mut self,
        effects: CandidateSet,
        without: Candidate,
    ) -> Result<&Node, IdentifyError> {
        let less = self.without(effects, without)?;
        let left = effects.without(without);
        let is_part = |node: &&Node| match less {
            Some(less) => node.effects == less,
            None => node.effects.iter().all(|one| left.contains(one)),
        };
        let parts = self.nodes().filter(is_part);
        let nearest = parts.min_by(|a, b| a.mean_square().total_cmp(&b.mean_square()));
        Ok(nearest.unwrap_or_else(|| self.baseline()))
    }

    /// Refits models in which one effect is replaced by that of a score, in parallel; those of which an effect vanishes are left out.
    pub(crate) fn exchanged(
        &mut self,
        effects: CandidateSet,
        exchanges: &[(Candidate, Score)],
    ) -> Result<Vec<CandidateSet>, IdentifyError> {
        let sets = exchanges.iter().map(|(without, score)| {
            let less = effects.without(*without);
            (less, less.with(score.effect), score)
        });
        let sets: Vec<(CandidateSet, CandidateSet, &Score)> = sets.collect();
        let is_new = |set: CandidateSet| self.index(set).is_none() && !self.dead.contains(&set);
        let new = sets.iter().filter(|(_, set, _)| is_new(*set));
        let new: Vec<(CandidateSet, &Node, &Score)> = new
            .filter_map(|&(less, set, score)| Some((set, self.get(less)?, score)))
            .collect();
        let refitted = in_order_of(
            &new,
            |&(set, ..)| cost(set),
            |&(set, parent, score)| Ok((set, refit(self.case, parent, score, self.seed)?)),
        );
        self.keep_all(refitted.into_iter().collect::<Result<_, IdentifyError>>()?);
        let known = sets.iter().map(|(_, set, _)| *set);
        Ok(known.filter(|&set| self.index(set).is_some()).collect())
    }

    /// Searches a model from where one with an effect more stands, if it was not searched yet, and once more when that
    /// one has been fitted from many places; the lower end counts.
    fn lighten(&mut self, effects: CandidateSet, less: CandidateSet) -> Result<(), IdentifyError> {
        let Some(from) = self.index(effects).map(|index| &self.visited[index]) else {
            return Ok(());
        };
        let is_fitted = from.fit.is_some();
        let is_needed = match self.index(less).map(|index| &self.visited[index]) {
            None => true,
            // What was fitted from many places may still have missed where the larger model stands.
            Some(_) => is_fitted && !less.is_empty() && !self.lightened.contains(&(effects, less)),
        };
        if !is_needed {
            return Ok(());
        }
        let model = self.case.model(less);
        let start = self.case.moved(&from.node, &model, |_, _| None);
        let found = led(self.case.refined(&from.node, less, &[start]))?;
        if is_fitted {
            self.lightened.push((effects, less));
        }
        self.keep(less, found);
        Ok(())
    }

    /// Takes in the model of a node of another search, with this loop, from where that one stands.
    pub(crate) fn moved_here(&mut self, other: &Node) -> Result<(), IdentifyError> {
        let model = self.case.model(other.effects);
        let start = self.case.moved(other, &model, |_, _| None);
        let found = led(self.case.refined(other, other.effects, &[start]))?;
        self.keep(other.effects, found);
        Ok(())
    }

    /// Simulations of the whole training set so far.
    pub(crate) fn simulations(&self) -> u64 {
        self.nodes().map(|node| node.simulations).sum()
    }
}

/// True if the rod has several zones: a simulation takes as long as ten of one zone.
pub(crate) fn is_costly(effects: CandidateSet) -> bool {
    effects.iter().any(|effect| effect.info().costly)
}

/// Rank of a model by the time that its search takes: costly effects count first, then their number.
pub(crate) fn cost(effects: CandidateSet) -> usize {
    let zones = if is_costly(effects) { MOST_EFFECTS } else { 0 };
    zones + effects.len()
}

/// By how much a refit is better, as the score that a size of one degree would have.
pub(crate) fn gained(parent: &Node, child: &Node, effect: Candidate) -> f64 {
    let ratio = 2.0 * (child.noise.nats() - parent.noise.nats());
    as_one(ratio.max(0.0), sizes_of(effect).count())
}

/// Candidates of at least some score: the first by the plain one, and the first by the whitened one.
fn shortlist(scores: &[Score], least: f64, most: [usize; 2]) -> Vec<&Score> {
    let first = |of: fn(&Score) -> f64, n: usize| {
        let mut sorted: Vec<&Score> = scores.iter().filter(|score| of(score) > least).collect();
        falling(&mut sorted, |one| of(one));
        sorted.truncate(n);
        sorted
    };
    let mut list = first(|score| score.plain, most[0]);
    for score in first(|score| score.whitened, most[1]) {
        if !list.iter().any(|other| other.effect == score.effect) {
            list.push(score);
        }
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::synthetic::{NOISE_MM, Synthetic};
    use crate::{EffectId, EffectSet, EffectValues};

    #[test]
    fn where_another_effect_vanishes_without_one_both_are_left_out() {
        let both = [EffectId::LatentHeat, EffectId::DeadTime];
        let [heat, late] = both.map(Candidate::from);
        let both: CandidateSet = both.into_iter().map(Candidate::from).collect();
        let values = EffectValues::typical(EffectId::LatentHeat, 1.0);
        let synthetic = Synthetic::of(EffectSet::of(EffectId::LatentHeat), values, 1);
        let case = synthetic.case();
        let noise = NOISE_MM.powi(2);
        let mut search = Search::new(&case, case.baseline().unwrap(), both, noise, 1).unwrap();
        search.grow_by_one().unwrap();
        let less = search.node_without(both, late).unwrap().effects;
        assert_eq!(less, both.without(late));
        // As if a dead time vanished where no heat is latent.
        let alone = both.without(heat);
        search.visited.retain(|one| one.node.effects != alone);
        search.dead.push(alone);
        let less = search.node_without(both, heat).unwrap().effects;
        assert!(less.is_empty());
    }
}
