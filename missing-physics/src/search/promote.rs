//! From models on recordings with few samples to the same models on those that are judged.

use identify::{IdentifyError, in_order_of};
use recording::order::falling;

use crate::config::Part;
use crate::decide::leading;
use crate::evidence::{Block, Model, Population};
use crate::model::case::{Case, Node};
use crate::search::complete::parts;
use crate::search::roads::{Search, cost, is_costly};
use crate::search::survey::Survey;
use crate::search::weighing::{Weighing, at};
use crate::{CandidateSet, LoopFamily};

/// Nats behind the best model from which another can have no share of the belief on the judged samples: odds of e¹².
const HOPELESS: f64 = 12.0;

/// Rounds until the leading model stays: each takes one to its end, or searches around it.
const ROUNDS: usize = 12;

/// Models that are judged: at least, and at most, of those that may be chosen; and of those that may not.
const FEWEST: usize = 6;
const MOST: usize = 24;
const FEW_PRESSED: usize = 2;

/// The population of some models on the judged samples: those that the searches at few samples leave in question, at the ends that they have there.
///
/// `cases` are those of the searches, with the judged samples, and `blocks` those on which they are weighed; `noise` is its largest
/// variance.
pub(crate) fn promoted<'c>(
    cases: &[&'c Case<'c>],
    survey: &mut Survey<'_>,
    blocks: &[Block],
    noise: f64,
) -> Result<(Vec<Search<'c>>, Population), IdentifyError> {
    let Survey {
        searches: coarse,
        completing,
        config,
        ..
    } = survey;
    let mut weighing = Weighing::new(blocks, config.seed);
    let mut fine = cases
        .iter()
        .zip(coarse.iter())
        .map(|(case, coarse)| begun(case, coarse, noise))
        .collect::<Result<Vec<_>, IdentifyError>>()?;
    let mut settled: Vec<(usize, CandidateSet)> = Vec::new();
    for _ in 0..ROUNDS {
        let population = completing.audited(coarse)?;
        let wanted = contenders(coarse, &population, leading(&population));
        promote(&mut fine, coarse, &wanted)?;
        let judged = weighing.audited(&fine)?;
        let best = at(&fine, judged.best());
        let (place, effects) = at(&fine, leading(&judged));
        let is_open = !cases[0].leaves_out(Part::MoreEffects);
        if is_open && best != (place, effects) && completing.taken_apart(coarse, best)? {
            let of_both = parts(best.1).into_iter();
            let of_both = of_both.flat_map(|part| [(best.0, part), (0, part)]);
            promote(&mut fine, coarse, &of_both.collect::<Vec<_>>())?;
        } else if is_open && completing.completed_around(coarse, (place, effects))? {
            let parts = parts(effects).into_iter().map(|part| (place, part));
            promote(&mut fine, coarse, &parts.collect::<Vec<_>>())?;
        } else if !effects.is_empty() && !settled.contains(&(place, effects)) {
            settled.push((place, effects));
            fine[place].settle(effects)?;
        } else {
            return Ok((fine, judged));
        }
    }
    let judged = weighing.audited(&fine)?;
    Ok((fine, judged))
}

/// A search on the judged samples that begins with the baseline model of another's loop.
fn begun<'c>(
    case: &'c Case<'c>,
    coarse: &Search<'_>,
    noise: f64,
) -> Result<Search<'c>, IdentifyError> {
    let baseline = match coarse.case.setting.loop_family {
        LoopFamily::Proximity => case.baseline()?,
        _ => on_judged(case, coarse.baseline())?,
    };
    Ok(Search::ended(case, baseline, coarse, noise))
}

/// The end of a coarse search's model on the judged samples; its simulations are those on them.
fn on_judged(case: &Case<'_>, coarse: &Node) -> Result<Node, IdentifyError> {
    let mut node = case.finished_by_means(coarse)?;
    node.simulations -= coarse.simulations;
    Ok(node)
}

/// Takes models of coarse searches to their ends on the judged samples, unless they are there.
fn promote(
    fine: &mut [Search<'_>],
    coarse: &[Search<'_>],
    wanted: &[(usize, CandidateSet)],
) -> Result<(), IdentifyError> {
    let mut new: Vec<(usize, &Node)> = Vec::new();
    for &(place, set) in wanted {
        let is_there = fine[place].get(set).is_some();
        let is_asked = new
            .iter()
            .any(|(at, node)| *at == place && node.effects == set);
        if !is_there && !is_asked {
            new.extend(coarse[place].get(set).map(|node| (place, node)));
        }
    }
    let found = in_order_of(
        &new,
        |(_, node)| cost(node.effects),
        |&(place, node)| on_judged(fine[place].case, node),
    );
    for ((place, _), node) in new.into_iter().zip(found) {
        let node = node?;
        fine[place].keep(node.effects, Some(node));
    }
    Ok(())
}

/// Models of a population that must be judged: those that could be the best, those of the least error,
/// and the parts of the leading and of the best one; each as the number of its search and its effects.
fn contenders(
    searches: &[Search<'_>],
    population: &Population,
    leading: &Model,
) -> Vec<(usize, CandidateSet)> {
    let best = population.best();
    let mut models: Vec<&Model> = population.models.iter().collect();
    falling(&mut models, |model| model.worth());
    let could = |(rank, model): &(usize, &&Model)| {
        *rank < FEWEST && !is_costly(model.effects) || model.worth() > best.worth() - HOPELESS
    };
    // What stands against a bound now may be free of it then, and the other way round.
    let admissible = models.iter().filter(|model| model.is_admissible());
    let pressed = models
        .iter()
        .filter(|model| !model.is_admissible() && !is_costly(model.effects));
    let mut wanted: Vec<(usize, CandidateSet)> = admissible
        .enumerate()
        .filter(could)
        .take(MOST)
        .map(|(_, model)| model)
        .chain(pressed.take(FEW_PRESSED))
        .map(|model| at(searches, model))
        .collect();
    for channel in [0, 1] {
        let least = models.iter().min_by(|a, b| {
            let [a, b] = [a, b].map(|one| one.evidence.squares()[channel]);
            a.total_cmp(&b)
        });
        wanted.extend(least.map(|model| at(searches, model)));
    }
    for model in [leading, best] {
        let (place, effects) = at(searches, model);
        wanted.extend(parts(effects).into_iter().map(|part| (place, part)));
        if place > 0 {
            // The same beside the paper's loop.
            wanted.extend(parts(effects).into_iter().map(|part| (0, part)));
        }
    }
    wanted
}
