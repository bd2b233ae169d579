//! The population: every model that a judgement needs, searched before anything is judged.

use std::collections::BTreeMap;

use identify::IdentifyError;
use rayon::prelude::*;

use crate::decide::leading;
use crate::evidence::{Block, Evidence, Model, Population, audited, weighed};
use crate::model::case::Node;
use crate::model::elsewhere::is_drift;
use crate::search::exchange::{ALIKE, rivals};
use crate::search::roads::Search;
use crate::{Candidate, CandidateSet, LoopFamily, Role};

/// Rounds of fits, exchanges and subsets around the leading model, until it stays.
const ROUNDS: usize = 8;

/// What a node was worth where it stood.
#[derive(Debug)]
struct Kept {
    coordinates: Vec<f64>,
    evidence: Evidence,
    anonymous: Option<crate::evidence::Anonymous>,
}

/// Weighs the models of searches and completes them around the leading one.
#[derive(Debug)]
pub(crate) struct Weighing<'a> {
    pub(crate) blocks: &'a [Block],
    pub(crate) seed: u64,
    kept: BTreeMap<(usize, String), Kept>,
}

impl<'a> Weighing<'a> {
    pub(crate) fn new(blocks: &'a [Block], seed: u64) -> Self {
        Self {
            blocks,
            seed,
            kept: BTreeMap::new(),
        }
    }

    /// The population of some searches, the paper's loop first, with every model that a judgement needs.
    pub(crate) fn completed(
        &mut self,
        searches: &mut [Search<'_>],
    ) -> Result<Population, IdentifyError> {
        let mut tried: Vec<(usize, CandidateSet)> = Vec::new();
        let mut settled: Vec<(usize, CandidateSet)> = Vec::new();
        let mut beside_drifts = searches[0].beside_drifts;
        for _ in 0..ROUNDS {
            let population = self.audited(searches)?;
            let model = leading(&population);
            let (place, effects) = at(searches, model);
            // A model behind the plain one with a curve has no names: it need not be fitted from many places.
            let is_ahead = population.plain().worth_with_curve() < Some(model.worth());
            if !tried.contains(&(place, effects)) {
                tried.push((place, effects));
                complete(searches, place, effects)?;
            } else if is_ahead && !effects.is_empty() && !settled.contains(&(place, effects)) {
                settled.push((place, effects));
                searches[place].settle(effects)?;
            } else if !beside_drifts && !model.is_whole() && has_drift(&population) {
                // A drift may hide what stands beside it.
                beside_drifts = true;
                searches[0].grow_beside_drifts()?;
            } else {
                break;
            }
        }
        self.audited(searches)
    }

    /// All models, weighed, and with a curve on top of the best, the leading one and its parts.
    fn audited(&mut self, searches: &[Search<'_>]) -> Result<Population, IdentifyError> {
        let mut population = self.weighed(searches)?;
        // What leads depends on whether a curve finds more than the best has.
        let best = population.best().names;
        self.audit(searches, &mut population, |names| {
            names == best || names.is_empty()
        })?;
        let first = leading(&population).names;
        self.audit(searches, &mut population, |names| {
            names.iter().all(|name| first.contains(name))
        })?;
        Ok(population)
    }

    fn weighed(&mut self, searches: &[Search<'_>]) -> Result<Population, IdentifyError> {
        let nodes: Vec<(usize, &Node)> = (searches.iter().enumerate())
            .flat_map(|(place, search)| search.nodes().map(move |node| (place, node)))
            .collect();
        let new: Vec<&(usize, &Node)> = nodes
            .iter()
            .filter(|(place, node)| {
                let kept = self.kept.get(&key(*place, node));
                kept.is_none_or(|kept| kept.coordinates != node.coordinates)
            })
            .collect();
        let weighed = new
            .par_iter()
            .map(|(place, node)| {
                let search = &searches[*place];
                let sensitivities = search.sensitivities(node)?;
                let evidence = weighed(search.case, node, &sensitivities, self.blocks);
                Ok((*place, *node, evidence))
            })
            .collect::<Result<Vec<_>, IdentifyError>>()?;
        for (place, node, evidence) in weighed {
            let kept = Kept {
                coordinates: node.coordinates.clone(),
                evidence,
                anonymous: None,
            };
            self.kept.insert(key(place, node), kept);
        }
        let models = nodes.into_iter().map(|(place, node)| {
            let kept = &self.kept[&key(place, node)];
            let family = node.model.loop_family();
            let shape = CandidateSet::of(Candidate::other_loop());
            let names = match family {
                LoopFamily::Proximity => node.effects,
                _ => node.effects.iter().chain(shape.iter()).collect(),
            };
            Model {
                family,
                effects: node.effects,
                names,
                ln_prior: ln_prior(&searches[place], node, names),
                pressed: node
                    .effects
                    .iter()
                    .filter(|&one| node.is_pressed(one))
                    .collect(),
                slight: node
                    .effects
                    .iter()
                    .filter(|&one| node.is_slight(one))
                    .collect(),
                evidence: kept.evidence.clone(),
                anonymous: kept.anonymous.clone(),
            }
        });
        Ok(Population {
            models: models.collect(),
        })
    }

    /// Puts a curve on top of some models.
    fn audit(
        &mut self,
        searches: &[Search<'_>],
        population: &mut Population,
        wanted: impl Fn(CandidateSet) -> bool,
    ) -> Result<(), IdentifyError> {
        let asked = population
            .models
            .iter_mut()
            .filter(|model| wanted(model.names));
        let mut asked: Vec<&mut Model> = asked.filter(|model| model.anonymous.is_none()).collect();
        let found = asked
            .par_iter()
            .map(|model| {
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
                Ok((key(place, node), anonymous))
            })
            .collect::<Result<Vec<_>, IdentifyError>>()?;
        for (model, (key, anonymous)) in asked.iter_mut().zip(found) {
            if let Some(kept) = self.kept.get_mut(&key) {
                kept.anonymous = Some(anonymous.clone());
            }
            model.anonymous = Some(anonymous);
        }
        Ok(())
    }
}

/// Share of what could be explained that a drift alone explains, from which others are tried beside it.
const MUCH: f64 = 0.5;

/// Whether a drift alone explains much.
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

fn key(place: usize, node: &Node) -> (usize, String) {
    (place, format!("{:?}", node.effects))
}

/// Where a model of the population stands: the number of its search, and its effects.
pub(crate) fn at(searches: &[Search<'_>], model: &Model) -> (usize, CandidateSet) {
    let mut families = searches.iter();
    let place = families.position(|search| search.case.setting.loop_family == model.family);
    (place.unwrap_or(0), model.effects)
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
    let mut wanted = search.children(effects)?;
    wanted.truncate(NEIGHBORS);
    for effect in effects.iter() {
        for (rival, cosine) in rivals(search, effects, effect)? {
            if cosine > ALIKE {
                wanted.extend(search.exchanged(effects, effect, Some(&rival)));
            }
        }
    }
    for part in parts(effects) {
        for effect in part.iter() {
            wanted.extend(search.exchanged(part, effect, None));
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
fn parts(effects: CandidateSet) -> Vec<CandidateSet> {
    let all: Vec<Candidate> = effects.iter().collect();
    let mut parts: Vec<CandidateSet> = (0..1_usize << all.len())
        .map(|bits| {
            let own = all.iter().enumerate().filter(|(k, _)| bits >> k & 1 == 1);
            own.map(|(_, effect)| *effect).collect()
        })
        .collect();
    parts.sort_by_key(|part| std::cmp::Reverse(part.len()));
    parts
}

/// Models with one effect more that are tried around the leading one.
const NEIGHBORS: usize = 4;

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
