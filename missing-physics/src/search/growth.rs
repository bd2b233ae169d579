//! From models with one effect to those with more: loop by loop, effect by effect.

use identify::IdentifyError;

use crate::config::Part;
use crate::evidence::{Model, Population};
use crate::model::case::Node;
use crate::search::complete::Completing;
use crate::search::families::IN_VAIN;
use crate::search::roads::{MOST_EFFECTS, Search};

/// Goes on, effect by effect, with the paper's loop, the first, and with each other that does not stay further from the recordings than
/// another's does.
///
/// Each of these goes on to pairs, and from there until a loop with an effect fewer outdoes it, or its models are worth no more than those with
/// fewer effects.
pub(crate) fn grow(
    searches: &mut [Search<'_>],
    completing: &mut Completing<'_>,
) -> Result<(), IdentifyError> {
    let left = |search: &Search<'_>| search.nearest().mean_square();
    let nearest = searches.iter().map(left).fold(f64::INFINITY, f64::min);
    let may_be_nearest = |(place, search): (usize, &Search<'_>)| {
        place == 0 || !search.is_misfit() || left(search) <= IN_VAIN * nearest
    };
    let mut goes_on: Vec<bool> = searches.iter().enumerate().map(may_be_nearest).collect();
    for n_effects in 2..=MOST_EFFECTS {
        if !goes_on.contains(&true) || searches[0].case.leaves_out(Part::MoreEffects) {
            break;
        }
        for (search, goes_on) in searches.iter_mut().zip(&goes_on) {
            if *goes_on {
                search.grow_by_one()?;
            }
        }
        let population = completing.audited(searches)?;
        for (place, goes_on) in goes_on.iter_mut().enumerate() {
            *goes_on &= !is_outdone(searches, place, n_effects)
                && predicts_more(&population, &searches[place], n_effects);
        }
    }
    Ok(())
}

/// Least mean square that a search leaves with so many effects at most.
fn least(search: &Search<'_>, n_effects: usize) -> f64 {
    let simple = search
        .nodes()
        .filter(|node| node.effects.len() <= n_effects);
    simple.map(Node::mean_square).fold(f64::INFINITY, f64::min)
}

/// True if another loop leaves less than half of the mean square that a search leaves with so many effects, and with an effect fewer.
fn is_outdone(searches: &[Search<'_>], place: usize, n_effects: usize) -> bool {
    let others = searches
        .iter()
        .enumerate()
        .filter(|(other, _)| *other != place);
    let simpler = others.map(|(_, other)| least(other, n_effects - 1));
    let simpler = simpler.fold(f64::INFINITY, f64::min);
    IN_VAIN * simpler < least(&searches[place], n_effects)
}

/// True if a model of a search with so many effects is worth more, by its prior and the blocks that are left out, than all with fewer that may be chosen.
fn predicts_more(population: &Population, search: &Search<'_>, n_effects: usize) -> bool {
    let worth = |is_asked: &dyn Fn(&Model) -> bool| {
        let family = search.case.setting.loop_family;
        let own = population
            .models
            .iter()
            .filter(|model| model.family == family);
        let asked = own.filter(|model| is_asked(model));
        asked
            .map(|model| model.worth())
            .fold(f64::NEG_INFINITY, f64::max)
    };
    let fewer = |model: &Model| model.effects.len() < n_effects && model.is_admissible();
    worth(&|model| model.effects.len() == n_effects) > worth(&fewer)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::blocks;
    use crate::model::synthetic::Synthetic;
    use crate::search::families::{Near, beside, cases, formulas, shaped};
    use crate::{CandidateSet, EffectId, EffectSet, EffectValues, Effort, LoopFamily};

    #[test]
    fn a_loop_that_another_outdoes_with_less_is_tried_with_pairs_and_no_more() {
        let (nothing, values) = (EffectSet::EMPTY, EffectValues::default());
        let synthetic = Synthetic::with_loop(LoopFamily::Relays, nothing, values, 1);
        let case = synthetic.case();
        let formulas = formulas(&case, 1).unwrap();
        let mut fits = shaped(&case, formulas, Near::Nearer, (Effort::Normal, 1)).unwrap();
        fits.truncate(1);
        let others = cases(&case, &fits);
        let blocks = blocks(&case);
        let few = [
            EffectId::LatentHeat,
            EffectId::DeadTime,
            EffectId::OutputLag,
            EffectId::Radiation,
        ];
        let few: CandidateSet = few.into_iter().map(Into::into).collect();
        let all = std::iter::once(&case).chain(&others);
        let with_one = all.map(|one| {
            let catalogue = beside(one.setting.loop_family, few);
            let (baseline, noise) = (one.baseline().unwrap(), case.fit.noise.variance);
            let mut search = Search::new(one, baseline, catalogue, noise, 1).unwrap();
            search.grow_by_one().unwrap();
            search
        });
        let mut searches: Vec<Search<'_>> = with_one.collect();
        grow(&mut searches, &mut Completing::new(&blocks, 1)).unwrap();
        assert!(is_outdone(&searches, 0, 2) && !is_outdone(&searches, 1, 2));
        let papers = searches[0].nodes().map(|node| node.effects.len());
        assert_eq!(papers.max(), Some(2));
    }
}
