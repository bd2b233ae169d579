//! Worth of the models of searches: on blocks that were left out, and with a curve on top.

use std::collections::BTreeMap;

use identify::{IdentifyError, in_parallel, try_in_parallel};

use crate::decide::leading;
use crate::evidence::{Anonymous, Block, Evidence, Memory, Model, Population, audited, weighed};
use crate::model::case::Node;
use crate::model::elsewhere::is_drift;
use crate::search::roads::Search;
use crate::{Candidate, CandidateSet, LoopFamily, Role};

/// Worth of a node where it stood.
#[derive(Debug)]
struct Kept {
    coordinates: Vec<f64>,
    /// True if it has a drift, an effect that moves slowly and on its own.
    drifts: bool,
    evidence: Evidence,
    anonymous: Option<Anonymous>,
}

/// Number of a search, and a model's effects.
type Key = (usize, String);

/// Weighs the models of searches.
#[derive(Debug)]
pub(crate) struct Weighing<'a> {
    blocks: &'a [Block],
    seed: u64,
    kept: BTreeMap<Key, Kept>,
    memory: Option<Memory>,
}

impl<'a> Weighing<'a> {
    pub(crate) fn new(blocks: &'a [Block], seed: u64) -> Self {
        Self {
            blocks,
            seed,
            kept: BTreeMap::new(),
            memory: None,
        }
    }

    /// All models, weighed, and with a curve on top of the best, the leading one and its parts.
    pub(crate) fn audited(&mut self, searches: &[Search<'_>]) -> Result<Population, IdentifyError> {
        self.weigh(searches)?;
        let mut population = self.population(searches);
        // What leads depends on whether a curve finds more than the best has.
        let best = population.best().names;
        self.audit(searches, &population, |names| {
            names == best || names.is_empty()
        })?;
        population = self.population(searches);
        // And on whether one finds more than a part of it.
        loop {
            let first = leading(&population).names;
            self.audit(searches, &population, |names| {
                names.iter().all(|name| first.contains(name))
            })?;
            population = self.population(searches);
            if leading(&population).names == first {
                return Ok(population);
            }
        }
    }

    /// Weighs the models that were not, where they stand now.
    fn weigh(&mut self, searches: &[Search<'_>]) -> Result<(), IdentifyError> {
        let is_new = |(place, node): &(usize, &Node)| {
            let kept = self.kept.get(&key(*place, node.effects));
            kept.is_none_or(|kept| kept.coordinates != node.coordinates)
        };
        let new: Vec<(usize, &Node)> = nodes(searches).filter(is_new).collect();
        let weighed = try_in_parallel(&new, |&(place, node)| {
            let search = &searches[place];
            let sensitivities = search.sensitivities(node)?;
            let kept = Kept {
                coordinates: node.coordinates.clone(),
                drifts: node.effects.iter().any(is_drift),
                evidence: weighed(search.case, node, &sensitivities, self.blocks),
                anonymous: None,
            };
            Ok((key(place, node.effects), kept))
        })?;
        self.kept.extend(weighed);
        self.remember(searches);
        Ok(())
    }

    /// Gives the densities of all by what the noise remembers: that of the least residual without a drift, which holds least besides
    /// noise.
    fn remember(&mut self, searches: &[Search<'_>]) {
        let layout = &searches[0].case.layout;
        let all = || {
            let kept = self.kept.values().filter(|kept| !kept.drifts);
            kept.flat_map(|kept| {
                let with_curve = kept.anonymous.as_ref().map(|one| &one.evidence);
                std::iter::once(&kept.evidence).chain(with_curve)
            })
        };
        let least = |channel: usize| {
            let square = |one: &&Evidence| one.squares()[channel];
            all().min_by(|a, b| square(a).total_cmp(&square(b)))
        };
        let (Some(output), Some(temperature)) = (least(0), least(1)) else {
            return;
        };
        let memory = Memory::of(layout, [&output.residual, &temperature.residual]);
        let is_known = self.memory.as_ref() == Some(&memory);
        let blocks = self.blocks;
        let mut asked: Vec<&mut Evidence> = self
            .kept
            .values_mut()
            .flat_map(|kept| {
                let with_curve = kept.anonymous.as_mut().map(|one| &mut one.evidence);
                std::iter::once(&mut kept.evidence).chain(with_curve)
            })
            .filter(|one| !is_known || one.nats.is_empty())
            .collect();
        let nats = in_parallel(&asked, |one| memory.by_block(layout, &one.residual, blocks));
        for (one, nats) in asked.iter_mut().zip(nats) {
            one.nats = nats;
        }
        self.memory = Some(memory);
    }

    /// Puts a curve on top of some models.
    fn audit(
        &mut self,
        searches: &[Search<'_>],
        population: &Population,
        wanted: impl Fn(CandidateSet) -> bool,
    ) -> Result<(), IdentifyError> {
        let models = population.models.iter();
        let asked: Vec<&Model> = models
            .filter(|model| wanted(model.names) && model.anonymous.is_none())
            .collect();
        let found = try_in_parallel(&asked, |model| {
            let (place, effects) = at(searches, model);
            let search = &searches[place];
            let Some(node) = search.get(effects) else {
                unreachable!("the population is of visited models");
            };
            let sensitivities = search.sensitivities(node)?;
            let anonymous = audited(
                search.case,
                node,
                &model.evidence,
                &sensitivities,
                self.blocks,
                self.seed,
            )?;
            Ok((key(place, effects), anonymous))
        })?;
        for (key, anonymous) in found {
            if let Some(kept) = self.kept.get_mut(&key) {
                kept.anonymous = Some(anonymous);
            }
        }
        self.remember(searches);
        Ok(())
    }

    fn population(&self, searches: &[Search<'_>]) -> Population {
        let models = nodes(searches).map(|(place, node)| {
            let kept = &self.kept[&key(place, node.effects)];
            let family = node.model.loop_family();
            let shape = CandidateSet::of(Candidate::other_loop());
            let names = match family {
                LoopFamily::Proximity => node.effects,
                _ => node.effects.iter().chain(shape.iter()).collect(),
            };
            let those = |is: fn(&Node, Candidate) -> bool| {
                let effects = node.effects.iter();
                effects.filter(|&one| is(node, one)).collect()
            };
            Model {
                family,
                effects: node.effects,
                names,
                ln_prior: ln_prior(&searches[place], node, names),
                pressed: those(Node::is_pressed),
                slight: those(Node::is_slight),
                evidence: kept.evidence.clone(),
                anonymous: kept.anonymous.clone(),
            }
        });
        Population {
            models: models.collect(),
        }
    }
}

/// The models of all searches, each with the number of its search.
fn nodes<'a>(searches: &'a [Search<'_>]) -> impl Iterator<Item = (usize, &'a Node)> {
    let numbered = searches.iter().enumerate();
    numbered.flat_map(|(place, search)| search.nodes().map(move |node| (place, node)))
}

fn key(place: usize, effects: CandidateSet) -> Key {
    (place, format!("{effects:?}"))
}

/// Where a model of the population stands: the number of its search, and its effects.
pub(crate) fn at(searches: &[Search<'_>], model: &Model) -> (usize, CandidateSet) {
    let mut families = searches.iter();
    let place = families.position(|search| search.case.setting.loop_family == model.family);
    (place.unwrap_or(0), model.effects)
}

/// Logarithm of a prior: whether these effects are there, and of such sizes.
fn ln_prior(search: &Search<'_>, node: &Node, names: CandidateSet) -> f64 {
    let present: f64 = names
        .iter()
        .map(|name| name.info().presence.ln_odds())
        .sum();
    let setting = &search.case.setting;
    let knows_temperature = search.case.base.knows_temperature();
    let sizes = node.effects.iter().map(|effect| {
        let info = effect.info();
        let values = node.values(effect).unwrap_or(&[]);
        let priors = info.parameters.iter().zip(values).filter(|(parameter, _)| {
            // On an assumed scale a number of kelvins says nothing.
            parameter.role == Role::Size && (knows_temperature || !parameter.unit.contains('K'))
        });
        let each = priors.map(|(parameter, value)| setting.prior_of(parameter).ln_relative(*value));
        if info.flexible {
            // Knots of one curve are large together.
            each.fold(0.0, f64::min)
        } else {
            each.sum()
        }
    });
    present + sizes.sum::<f64>()
}
