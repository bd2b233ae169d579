//! The model that is judged: the most credible one, without what may be only the error of another effect's formula.

use crate::decide::rules::{RuleId, rule};
use crate::evidence::{Model, Population};
use crate::model::elsewhere::is_drift;

/// The most credible model that may be chosen, without effects that are too small to be told from how inexact the others'
/// formulas are.
///
/// Beside an effect with a form of its own even a small one is told if with it nothing predictable is left: what a formula
/// leaves wrong a curve would find. Nor is there such an error where all other names are drifts: these are curves of time, which
/// take what they can of any law, and not a law that is off.
pub(crate) fn leading(population: &Population) -> &Model {
    let mut model = population.best();
    let is_whole = model.is_whole();
    loop {
        let idle = model.names.iter().filter_map(|name| {
            let less = population.without(model, name);
            let share = population.share(model.evidence.squares(), less.evidence.squares());
            let is_small = !rule(RuleId::Form).passes(share);
            let mut others = model.names.without(name).iter();
            let is_beside_drifts = model.names.len() > 1 && others.all(is_drift);
            let is_told = is_whole && model.is_rigid() || is_beside_drifts && !is_drift(name);
            (is_small && !is_told).then_some((share, less))
        });
        match idle.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((_, less)) => model = less,
            None => return model,
        }
    }
}
