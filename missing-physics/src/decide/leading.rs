//! The model that is judged: the most credible one, without what may be only the error of another effect's formula.

use crate::Candidate;
use crate::decide::rules::RuleId;
use crate::evidence::{Model, Population};
use crate::model::elsewhere::is_drift;

/// The most credible model that may be chosen, without effects that are too small to be told from how inexact the others'
/// formulas are.
///
/// Beside an effect with a form of its own even a small one is told if with it nothing predictable is left: what a formula
/// leaves wrong a curve would find. Beside a loop of another family it is told if no such loop could act like it; and beside any others if it
/// takes nearly all of what they leave. An effect that does nearly all of a drift's work without the drift is told as well: a drift is a curve of
/// time, which takes what it can of any law.
pub(crate) fn leading(population: &Population) -> &Model {
    let mut model = population.best();
    let is_whole = model.is_whole();
    loop {
        let idle = model.names.iter().filter_map(|name| {
            let less = population.without(model, name);
            let of_both = [model, less].map(|one| one.evidence.squares());
            let share = match is_of_time(model, name) {
                true => population.share(of_both[0], of_both[1]),
                false => population.share_beside_drifts(model, of_both[0], of_both[1]),
            };
            let is_small = !RuleId::Form.rule().passes(share);
            let is_told = is_whole && has_form_of_its_own(model, name)
                || does_without_a_drift(population, model, name)
                || takes_what_is_left(population, model, name);
            (is_small && !is_told).then_some((share, less))
        });
        match idle.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((_, less)) => model = less,
            None => return model,
        }
    }
}

/// True if a name could be what a drift's values miss: it is a drift, or acts like one of the model's.
fn is_of_time(model: &Model, name: Candidate) -> bool {
    let mut drifts = model.names.iter().filter(|&one| is_drift(one));
    is_drift(name) || drifts.any(|drift| drift.acts_like(name))
}

/// True if a name could not be an error of the formulas beside it: all have a form of their own; or a loop of another family alone has
/// none, and the name is not of how the output follows the temperature, as a loop is.
fn has_form_of_its_own(model: &Model, name: Candidate) -> bool {
    let other_loop = Candidate::other_loop();
    let mut others = model.names.iter().filter(|&one| one != other_loop);
    model.is_rigid()
        || name != other_loop && !name.info().like_loop && others.all(|one| !one.info().flexible)
}

/// Share of what could be explained that an effect which explains nearly all of it may leave.
const NEARLY_ALL: f64 = 0.1;

/// True if, without some drift of the model, an effect still explains nearly all that the two explain together.
fn does_without_a_drift(population: &Population, model: &Model, name: Candidate) -> bool {
    let mut drifts = model.names.iter().filter(|&one| is_drift(one));
    !is_drift(name)
        && drifts.any(|drift| {
            let without_drift = population.without(model, drift);
            let without_both = population.without(without_drift, name);
            let [all, alone, none] =
                [model, without_drift, without_both].map(|one| one.evidence.squares());
            let lost = population.share(all, alone);
            without_drift.names.contains(name) && lost < NEARLY_ALL * population.share(all, none)
        })
}

/// True if an effect with a form of its own takes nearly all of what the rest of the model leaves to explain, and more than a curve of any
/// shape does in its place, and nothing in that rest acts like it: beside a loop of another family no effect that acts like a loop.
///
/// The error of a formula may have any shape: that of an effect with one or two sizes it has by a rare chance alone, and that of
/// several together by a lesser one.
fn takes_what_is_left(population: &Population, model: &Model, name: Candidate) -> bool {
    let less = population.without(model, name);
    let Some(curve) = &less.anonymous else {
        return false;
    };
    let [left, all, by_curve] =
        [&model.evidence, &less.evidence, &curve.evidence].map(|one| one.squares());
    let least = population.ceiling();
    // In the channel in which it shows.
    let explained = [0, 1].map(|channel| all[channel] - left[channel]);
    let shows = usize::from(explained[1] > explained[0]);
    !name.info().flexible
        && stands_alone(less, name)
        && left[shows] <= by_curve[shows]
        && left[shows] - least[shows] <= NEARLY_ALL * (all[shows] - least[shows])
}

/// True if nothing in a model acts like an effect that is added to it, or could take any shape but a loop.
fn stands_alone(less: &Model, name: Candidate) -> bool {
    let other_loop = Candidate::other_loop();
    let has_other_loop = less.names.contains(other_loop);
    let mut others = less.names.iter().filter(|&one| one != other_loop);
    !less.names.is_empty()
        && name != other_loop
        && others.all(|one| {
            let info = one.info();
            let is_of_loop = has_other_loop && info.like_loop;
            !(info.flexible || is_of_loop || one.acts_like(name) || name.acts_like(one))
        })
}
