//! Loops of other families beside the paper's.

use std::ops::ControlFlow;

use identify::{
    Fit, FitConfig, ForwardModel, IdentifyError, ONSET_SHARPNESS, ParameterVector, WienerModel,
    try_in_parallel,
};
use recording::order::rising;

use crate::agreed::agreed;
use crate::config::Part;
use crate::decide::{RuleId, leading};
use crate::evidence::Population;
use crate::model::case::{Case, Node};
use crate::model::extended_model::{ExtendedModel, LoopFreedom};
use crate::search::roads::Search;
use crate::{Candidate, CandidateSet, EffectBlock, Effort, LoopFamily};

/// Families beside the paper's, and how sharply their transformations set in if that is held.
///
/// Where kinetics set in decides which excursions leave a trace, so that a fit hardly comes from a smooth onset to a sharp one, nor from
/// one between to either.
const OTHERS: [(LoopFamily, Option<f64>); 4] = [
    (LoopFamily::Relays, None),
    (LoopFamily::Kinetics, None),
    (LoopFamily::Kinetics, Some(0.0)),
    (LoopFamily::Kinetics, Some(1.0)),
];

/// Starts of the fit of a baseline model of another family, beside the place where the paper's ended.
const STARTS: u64 = 4;

/// Error of a baseline model over that of the nearest family's up to which a family is tried, too.
const NEARLY: f64 = 4.0;

/// Mean square of what is left over that of another loop from which a search with the first is in vain.
pub(super) const IN_VAIN: f64 = 2.0;

/// Error over that of the nearest fit of a family from which another one ended in another minimum.
const APART: f64 = 1.001;

/// A baseline model with a loop of another family than the paper's.
#[derive(Debug, Clone)]
pub(crate) struct OtherBaseline {
    pub(crate) family: LoopFamily,
    /// With the start of recordings open that may begin warm.
    pub(crate) base: WienerModel,
    pub(crate) freedom: LoopFreedom,
    pub(crate) fit: Fit,
}

impl OtherBaseline {
    /// The fit from where this one ended, with the shape of the loop free and another baseline model.
    pub(super) fn shaped(
        &self,
        case: &Case<'_>,
        base: WienerModel,
        seed: u64,
    ) -> Result<Self, IdentifyError> {
        let freedom = LoopFreedom::Shape;
        let of_family = case.of_family(self.family, &base, case.fit, freedom);
        let model = of_family.model(CandidateSet::EMPTY);
        let with = fit_from(case, &model, &self.fit, 0, seed)?;
        Ok(self.followed_by(base, freedom, with))
    }

    /// The fit from where this one ended, with the shape of the loop free, and how recordings began that may begin warm.
    fn opened(&self, case: &Case<'_>, seed: u64) -> Result<Self, IdentifyError> {
        let warm = case.base.with_open_starts(case.training);
        let mut opened = self.shaped(case, warm, seed)?;
        let turned = case.base.with_open_reversals();
        // Where the paper's loop asks for no warm start, none of its reversals is missed.
        if turned.parameters() != case.base.parameters() {
            // At once, and from where it ended without: either may miss the lower minimum.
            for from in [self, &opened.clone()] {
                let with = from.shaped(case, turned.clone(), seed)?;
                if is_told(&opened.fit, &with.fit, case.training.len()) {
                    opened = with;
                }
            }
        }
        Ok(opened)
    }

    /// The baseline model of a fit that began where this one ended: the starts are those of this one, and the simulations those of both.
    pub(super) fn followed_by(&self, base: WienerModel, freedom: LoopFreedom, with: Fit) -> Self {
        Self {
            family: self.family,
            base,
            freedom,
            fit: Fit {
                agreeing_starts: self.fit.agreeing_starts,
                starts: self.fit.starts,
                simulations: self.fit.simulations + with.simulations,
                ..with
            },
        }
    }
}

/// Fit of the baseline model with a loop, from where another fit ended and from so many starts.
fn fit_from(
    case: &Case<'_>,
    model: &ExtendedModel,
    from: &Fit,
    starts: u64,
    seed: u64,
) -> Result<Fit, IdentifyError> {
    let vector = ParameterVector::new(model.parameters(), case.training.len());
    let config = FitConfig {
        from: vec![from.coordinates(&vector)],
        starts,
        ..case.fit_config(&case.fit.noise, seed)
    };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    agreed(&case.watched(model), case.training, &config, go_on)
}

/// Baseline models of all other families, each fitted from so many starts beside the place where the paper's ended, the nearest
/// first. One that sets in sharply and one that does so smoothly are two.
pub(crate) fn plain_fits(
    case: &Case<'_>,
    starts: u64,
    seed: u64,
) -> Result<Vec<OtherBaseline>, IdentifyError> {
    let freedom = LoopFreedom::Formula;
    let mut fits = try_in_parallel(&OTHERS, |&(family, sharpness)| {
        let of_family = case.of_family(family, case.base, case.fit, freedom);
        let mut model = of_family.model(CandidateSet::EMPTY);
        if let Some(held) = sharpness {
            model = model.holding(ONSET_SHARPNESS, held);
        }
        Ok(OtherBaseline {
            family,
            base: case.base.clone(),
            freedom,
            fit: fit_from(case, &model, case.fit, starts, seed)?,
        })
    })?;
    rising(&mut fits, |other| other.fit.train_rmse);
    Ok(fits)
}

/// Share of the mean square by which the formula of a loop misses one of another family that an effect takes up that does not act like a loop, on
/// average.
pub(crate) const TAKEN_UP: f64 = 1.0 / 30.0;

/// How near a loop of another family must come to be searched, by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Near {
    /// Nearer than the paper's.
    Nearer,
    /// About as near: where something else that is missing shows more than any loop does, none shows by itself which is the rig's.
    About,
}

/// Those of the fits of formulas that come as near as they must, each with the shape of its loop free, relays of two populations where the
/// search is thorough and the recordings tell of them, and the start of recordings that may begin warm.
///
/// The curves of each family are formulas of no real material, and what is missing may hide until they are bent: their
/// shape is always free. How a recording began decides which of its loops are inner ones, which are the most that families
/// differ by: it is free, too.
pub(crate) fn shaped(
    case: &Case<'_>,
    mut formulas: Vec<OtherBaseline>,
    near: Near,
    (effort, seed): (Effort, u64),
) -> Result<Vec<OtherBaseline>, IdentifyError> {
    retain_near(&mut formulas, case, near);
    let mut fits = try_in_parallel(&formulas, |formula| formula.opened(case, seed))?;
    rising(&mut fits, |other| other.fit.train_rmse);
    retain_near(&mut fits, case, near);
    retain_one_of_each(&mut fits);
    // Not before: relays of two populations take in more of what is missing than loops of another family can.
    if effort == Effort::Thorough {
        fits = try_in_parallel(&fits, |other| other.populated(case, seed))?;
        rising(&mut fits, |other| other.fit.train_rmse);
    }
    Ok(fits)
}

/// Baseline models of all other families with the formulas of their loops, to choose from by [`shaped`].
pub(crate) fn formulas(case: &Case<'_>, seed: u64) -> Result<Vec<OtherBaseline>, IdentifyError> {
    plain_fits(case, STARTS, seed)
}

/// True if what is left falls by more than so many parameters cost by Schwarz's criterion, counted in the independent residuals of the fit
/// with them.
pub(super) fn is_told(without: &Fit, with: &Fit, n_parameters: usize) -> bool {
    let n = with.noise.n_effective;
    let gain = n * (without.noise.variance / with.noise.variance).ln();
    gain > n_parameters as f64 * n.ln()
}

/// Keeps those that come as near to the recordings as they must beside the paper's loop, and not much less near than the nearest.
fn retain_near(fits: &mut Vec<OtherBaseline>, case: &Case<'_>, near: Near) {
    let papers = case.fit.train_rmse;
    let nearest = fits.first().map_or(0.0, |other| other.fit.train_rmse);
    let most = match near {
        Near::Nearer => (NEARLY * nearest).min(papers),
        Near::About => NEARLY * nearest.min(papers),
    };
    fits.retain(|other| other.fit.train_rmse < most);
}

/// Keeps the nearest of each family. Where others of it ended apart are other minima, from which effects are tried as well.
pub(crate) fn retain_one_of_each(fits: &mut Vec<OtherBaseline>) {
    let mut nearest: Vec<OtherBaseline> = Vec::new();
    for other in fits.drain(..) {
        let Some(kept) = nearest.iter_mut().find(|one| one.family == other.family) else {
            nearest.push(other);
            continue;
        };
        if other.fit.train_rmse > APART * kept.fit.train_rmse {
            kept.fit.other_minima.push(other.fit.points());
        }
    }
    *fits = nearest;
}

/// Families that may stand in for the paper's loop, the starts of which end apart. There are none where another loop is no candidate,
/// where not even the best start describes the output (then another loop is not what is missing), or where no other loop has one
/// minimum.
pub(crate) fn instead(
    case: &Case<'_>,
    among: CandidateSet,
    searched: (Effort, u64),
) -> Result<Vec<OtherBaseline>, IdentifyError> {
    if !among.contains(Candidate::other_loop()) {
        return Ok(Vec::new());
    }
    let squares = case.fit.train_rmse.powi(2) * case.layout.n_outputs() as f64;
    let described = 1.0 - squares / case.output_squares();
    if !RuleId::Describes.rule().passes(described) || case.leaves_out(Part::OtherLoops) {
        return Ok(Vec::new());
    }
    let formulas = formulas(case, searched.1)?;
    let fits = shaped(case, formulas, Near::Nearer, searched)?;
    Ok(if has_another(&fits, case.fit) {
        fits
    } else {
        Vec::new()
    })
}

/// True if a loop of another family has one minimum, with less than half of the mean square, where the paper's has many.
fn has_another(fits: &[OtherBaseline], papers: &Fit) -> bool {
    let square = |fit: &Fit| fit.train_rmse.powi(2);
    let nearest = fits.first();
    nearest
        .is_some_and(|other| other.fit.converged() && IN_VAIN * square(&other.fit) < square(papers))
}

/// True if the rig's loop is of another family: by itself it leaves less than half of the mean square that the paper's
/// loop leaves with any one effect that has a form of its own.
pub(crate) fn is_another(fits: &[OtherBaseline], papers: &Search<'_>) -> bool {
    let has_form = |node: &&Node| node.effects.iter().all(|one| !one.info().flexible);
    let with_one = papers.nodes().filter(has_form).map(Node::mean_square);
    let least = with_one.fold(f64::INFINITY, f64::min);
    let nearest = fits.first();
    nearest.is_some_and(|other| IN_VAIN * other.fit.train_rmse.powi(2) < least)
}

/// How many of the loops, the first, come about as near with nothing missing as a model of the paper's loop does with what it names: what
/// another loop shows by itself is a rival of every name, since each is but a formula.
pub(crate) fn rivals(fits: &[OtherBaseline], named: Option<&Node>) -> usize {
    let most = named.map_or(0.0, |node| IN_VAIN * node.mean_square());
    let is_rival = |other: &&OtherBaseline| other.fit.train_rmse.powi(2) <= most;
    fits.iter().take_while(is_rival).count()
}

/// True if a loop of another family leaves less than half of the mean square that the paper's, the first, leaves with whatever was tried
/// beside it. Then it is the rig's, though no curve finds what the paper's loop leaves.
pub(crate) fn is_far_nearer(searches: &[Search<'_>]) -> bool {
    let least = |search: &Search<'_>| search.nearest().mean_square();
    let others = searches[1..].iter().map(least);
    IN_VAIN * others.fold(f64::INFINITY, f64::min) < least(&searches[0])
}

/// The rig with each of these loops.
pub(crate) fn cases<'a>(case: &Case<'a>, fits: &'a [OtherBaseline]) -> Vec<Case<'a>> {
    fits.iter()
        .map(|other| case.of_family(other.family, &other.base, &other.fit, other.freedom))
        .collect()
}

/// Those of the candidates that a loop of this family does not already have in it.
pub(crate) fn beside(family: LoopFamily, catalogue: CandidateSet) -> CandidateSet {
    let is_beside =
        |one: &Candidate| family == LoopFamily::Proximity || !one.info().names_loop_families;
    catalogue.iter().filter(is_beside).collect()
}

/// True if there is anything to explain: something has a name, or a curve finds more than the baseline model has.
pub(crate) fn is_anything(population: &Population) -> bool {
    let model = leading(population);
    !model.names.is_empty() || !model.is_whole()
}

/// True if a model, with a curve on top or without, predicts as much of the output as a model must that describes a recording.
/// `output_squares` are those of the outputs about their means.
pub(crate) fn is_described(population: &Population, output_squares: f64) -> bool {
    let predicted = 1.0 - population.ceiling()[0] / output_squares;
    RuleId::Describes.rule().passes(predicted)
}

/// True if a loop of another family may do instead: a curve finds more than the leading model has, or a name is of the loop.
pub(crate) fn may_be_the_loop(population: &Population) -> bool {
    let model = leading(population);
    let is_of_loop = |name: Candidate| name.info().block == EffectBlock::Transformation;
    !model.is_whole() || model.names.iter().any(is_of_loop)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decide::{OF_FORMULAS, most_of_formula};
    use crate::model::synthetic::{NOISE_MM, Synthetic};
    use crate::{EffectSet, EffectValues};

    /// The nearest loop of each other family with its shape free, however near.
    fn one_of_each(case: &Case<'_>) -> Vec<OtherBaseline> {
        let plain = plain_fits(case, STARTS, 1).unwrap();
        let shaped = plain
            .iter()
            .map(|other| other.shaped(case, case.base.clone(), 1).unwrap());
        let mut shaped: Vec<OtherBaseline> = shaped.collect();
        rising(&mut shaped, |other| other.fit.train_rmse);
        retain_one_of_each(&mut shaped);
        shaped
    }

    /// The values of [`OF_FORMULAS`] and [`most_of_formula`] rest on this test.
    #[test]
    fn loops_of_two_families_miss_one_another_by_more_than_a_fiftieth_unless_relays_are_two_populations()
     {
        // Families, their onset, and what relays of two populations may miss them by.
        let truths = [
            (LoopFamily::Relays, 0.0, 0.4),
            (LoopFamily::Kinetics, 0.0, 0.4),
            (LoopFamily::Kinetics, 0.7, 0.6),
        ];
        for (truth, onset, of_two) in truths {
            for bends in [[0.0; 3], [0.1, 0.0, 0.05], [-0.1, 0.1, 0.0]] {
                let mut values = EffectValues::default();
                (values.family.bends, values.family.onset) = (bends, onset);
                let synthetic = Synthetic::with_loop(truth, EffectSet::EMPTY, values, 1);
                let case = synthetic.case();
                let deviation = case.output_deviation();
                let share = |other: &OtherBaseline| {
                    let error = (other.fit.train_rmse.powi(2) - NOISE_MM.powi(2)).max(0.0);
                    error.sqrt() / deviation / OF_FORMULAS
                };
                for other in one_of_each(&case) {
                    let is_same = other.family == truth;
                    let missed = share(&other);
                    let what = format!("{truth:?} {onset} {bends:?} {missed}");
                    let most = most_of_formula(other.family) / OF_FORMULAS;
                    let range = if is_same { 0.0..0.1 } else { 1.0..most };
                    assert!(range.contains(&missed), "{what}");
                    if other.family == LoopFamily::Relays {
                        let populated = share(&other.populated(&case, 1).unwrap());
                        assert!(populated < of_two, "{what} {populated}");
                    }
                }
            }
        }
    }

    /// The value of [`TAKEN_UP`] rests on this test.
    #[test]
    fn what_does_not_act_like_a_loop_takes_up_a_thirtieth_of_what_is_wrong_with_its_formula() {
        let truths = [
            (LoopFamily::Relays, 0.0),
            (LoopFamily::Kinetics, 0.0),
            (LoopFamily::Kinetics, 0.7),
        ];
        let mut shares = Vec::new();
        for (truth, onset) in truths {
            let mut values = EffectValues::default();
            values.family.onset = onset;
            let synthetic = Synthetic::with_loop(truth, EffectSet::EMPTY, values, 1);
            let case = synthetic.case();
            let mut shaped = one_of_each(&case);
            shaped.retain(|other| other.family != truth);
            for other in cases(&case, &shaped) {
                let all = CandidateSet::all(EffectSet::all(), &[]);
                let is_other = |one: &Candidate| !one.info().like_loop && !one.info().flexible;
                let beside = beside(other.setting.loop_family, all);
                let catalogue = beside.iter().filter(is_other).collect();
                let baseline = other.baseline().unwrap();
                let noise = NOISE_MM.powi(2);
                let wrong = baseline.mean_square() - noise;
                let mut search = Search::new(&other, baseline, catalogue, noise, 1).unwrap();
                search.grow_by_one().unwrap();
                let of_one = search.nodes().filter(|node| node.effects.len() == 1);
                shares.extend(of_one.map(|node| (wrong + noise - node.mean_square()) / wrong));
            }
        }
        let mean = shares.iter().sum::<f64>() / shares.len() as f64;
        assert!((0.5 * TAKEN_UP..1.5 * TAKEN_UP).contains(&mean), "{mean}");
    }

    #[test]
    fn a_loop_of_another_family_has_its_shape_in_it_and_no_effect() {
        let all = CandidateSet::all(EffectSet::all(), &[]);
        assert_eq!(beside(LoopFamily::Proximity, all), all);
        for (family, _) in OTHERS {
            let beside = beside(family, all);
            assert!(!beside.contains(Candidate::other_loop()));
            assert_eq!(beside.len() + 1, all.len());
        }
    }

    #[test]
    fn another_loop_stands_in_where_it_has_one_minimum_and_half_of_the_error() {
        let synthetic = Synthetic::of(EffectSet::EMPTY, EffectValues::default(), 1);
        let case = synthetic.case();
        let papers = case.fit;
        let with = |share: f64, agreeing_starts: u64| OtherBaseline {
            family: LoopFamily::Relays,
            base: case.base.clone(),
            freedom: LoopFreedom::Formula,
            fit: Fit {
                train_rmse: share * papers.train_rmse,
                agreeing_starts,
                starts: 5,
                ..papers.clone()
            },
        };
        assert!(papers.termination.is_minimum());
        assert!(has_another(&[with(0.7, 2)], papers));
        assert!(!has_another(&[with(0.72, 2)], papers));
        assert!(!has_another(&[with(0.7, 1)], papers));
        assert!(!has_another(&[], papers));
    }
}
