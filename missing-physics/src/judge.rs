//! Which model, which names, and which verdict.

use std::cell::RefCell;
use std::ops::Range;

use identify::IdentifyError;

use crate::case::Node;
use crate::diagnosis::Verdict;
use crate::floor::Measured;
use crate::folds::{Fold, folds, held_out, mean_square};
use crate::local_terms::{local_terms, slow_terms};
use crate::projection::{Span, dot};
use crate::scores::Score;
use crate::search::{Search, UNIVERSAL};
use crate::tangent::sensitivities;
use crate::whiten::Whitener;
use crate::{EffectId, EffectSet};

/// Share of the explainable error that an effect must bring to have a name.
const OWN_SHARE: f64 = 0.05;

/// Share of the explainable error that the whole model must explain for its names to hold.
const GATE: f64 = 0.8;

/// Units of log-likelihood within which another model does as well: odds of e³, 20 to 1.
const AS_WELL: f64 = 3.0;

/// Probability of a lack of fit under noise alone, below which there is one.
const LACK_OF_FIT: f64 = 0.01;

/// Share of the explainable error below which a remainder is not worth a word.
const SMALL_REMAINDER: f64 = 0.02;

/// Cosine of two traces from which they could be one another's names.
const ALIKE: f64 = 0.5;

/// Accuracy to which holds and repeats tell the variance of the noise, as a factor.
const KNOWN: f64 = 1.1;

/// Residual of the plain model over noise, squared, that cannot be noise.
const LARGE: f64 = 1.5;

/// Residual over noise, squared, from which not every effect gets a name.
const FAR: f64 = 2.0;

/// Neighbors of a model that are tried.
const NEIGHBORS: usize = 4;

/// Rounds of exchanges.
const ROUNDS: usize = 3;

/// Recordings from which whole ones are left out in turn.
const FEWEST_RECORDINGS: usize = 3;

/// Parts of the training that are left out in turn, each with a refit.
const PARTS: usize = 4;

/// Gap between training and held-out samples, time constants.
const GAP: f64 = 5.0;

/// What the search comes to.
#[derive(Debug, Clone)]
pub(crate) struct Judged {
    pub(crate) verdict: Verdict,
    /// Effects of the chosen model.
    pub(crate) effects: EffectSet,
    pub(crate) named: Vec<Named>,
    /// Effects of the chosen model whose names do not hold.
    pub(crate) suspects: Vec<Named>,
    /// Share of the explainable error that the chosen model explains, held out; `None` where the baseline's
    /// error is the noise's.
    pub(crate) explained: Option<f64>,
}

/// An effect of the chosen model.
#[derive(Debug, Clone)]
pub(crate) struct Named {
    pub(crate) effect: EffectId,
    /// Others that would do as well in its place, with their share of the probability, the likeliest first.
    pub(crate) others: Vec<(EffectId, f64)>,
    pub(crate) probability: f64,
    pub(crate) contribution: f64,
}

/// What is left of a residual along local and slow terms of any shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lack {
    /// Whitened sum of squares beyond that of noise.
    pub(crate) beyond: f64,
    /// Probability that noise leaves as much.
    pub(crate) p_value: f64,
}

/// The held-out errors of models of one case.
struct Trial {
    folds: Vec<Fold>,
    /// Whether models are refitted without each part: what is far from the recordings is not linear.
    refits: bool,
    known: RefCell<Vec<(EffectSet, f64)>>,
    /// Mean square of the baseline's.
    baseline: f64,
    /// Standard error of it.
    error: f64,
    /// Variance of the noise.
    noise: f64,
}

/// Judges the models of a search.
pub(crate) fn judge(
    search: &mut Search<'_>,
    noise: &Measured,
    tau_s: f64,
) -> Result<Judged, IdentifyError> {
    let mut effects = chosen(search);
    if search.is_misfit() {
        effects = improved(search, effects)?;
    }
    let dispersion = search.dispersion();
    let trial = Trial::of(search, noise, tau_s, search.is_misfit())?;
    let contributions = loop {
        let contributions = contributions(search, &trial, effects)?;
        let weakest = contributions.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        match weakest {
            Some(&(effect, share)) if share < OWN_SHARE => {
                let less = search.exchanged(effects, effect, None);
                effects = less.unwrap_or(EffectSet::EMPTY);
            }
            _ => break contributions,
        }
    };
    let mut named = Vec::new();
    for (effect, contribution) in contributions {
        let (probability, others) = alternatives(search, effects, effect, dispersion)?;
        named.push(Named {
            effect,
            others,
            probability,
            contribution,
        });
    }
    let shared = shared(search, effects);
    let Some(best) = search.get(effects) else {
        unreachable!("a chosen model was visited");
    };
    // Far above the noise something else is going on, and whatever bends can help: then only what every rod has
    // gets a name, and only if no other road leads as far without it.
    let is_far = best.mean_square() > FAR * search.noise();
    let (mut licensed, mut suspects): (Vec<Named>, Vec<Named>) =
        named.into_iter().partition(|named| {
            let is_shared = shared.contains(named.effect) || !named.others.is_empty();
            is_shared && (!is_far || UNIVERSAL.contains(&named.effect))
        });
    let lack = lack(search, best)?;
    let explained = trial.explained(search, best)?;
    let gained = 2.0 * (best.noise.nats() - search.baseline().noise.nats());
    let by_lack = gained / (gained + lack.beyond);
    let share = explained.filter(|_| trial.tells(best, noise));
    let passes = share.unwrap_or(by_lack) >= GATE;
    let left = 1.0 - explained.unwrap_or(by_lack).min(by_lack);
    let is_left = lack.p_value < LACK_OF_FIT;
    let verdict = if effects.is_empty() {
        // Slow errors look like noise with a long memory: where the noise was measured, their size tells.
        let is_measured = noise.upper.is_some();
        let is_large = is_measured && search.baseline().mean_square() > LARGE * search.noise();
        if Trial::far_off(search.baseline(), noise) && (is_left || is_large) {
            Verdict::Unexplained
        } else {
            Verdict::Adequate
        }
    } else if !passes || licensed.is_empty() {
        Verdict::Unexplained
    } else if is_left && left > SMALL_REMAINDER && Trial::far_off(best, noise) {
        Verdict::ExplainedInPart
    } else if licensed.iter().any(|named| !named.others.is_empty()) {
        Verdict::Ambiguous
    } else {
        Verdict::Explained
    };
    if verdict == Verdict::Unexplained {
        suspects.append(&mut licensed);
    }
    Ok(Judged {
        verdict,
        effects,
        named: licensed,
        suspects,
        explained: explained.or((!effects.is_empty()).then_some(by_lack)),
    })
}

/// The most credible model.
fn chosen(search: &Search<'_>) -> EffectSet {
    let admitted = search.nodes().filter(|node| node.is_admitted());
    let best = admitted
        .map(|node| (search.credit(node.effects), node.effects))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or(EffectSet::EMPTY, |(_, effects)| effects)
}

/// The model with effects exchanged, added or left out for as long as that makes it more credible: roads that
/// lead to one place differ in their order.
fn improved(search: &mut Search<'_>, mut effects: EffectSet) -> Result<EffectSet, IdentifyError> {
    for _ in 0..ROUNDS {
        let mut neighbors: Vec<EffectSet> = search.children(effects)?;
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
        search.finish(&neighbors)?;
        let best = chosen(search);
        if best == effects {
            break;
        }
        effects = best;
    }
    Ok(effects)
}

/// Scores of what could stand in the place of an effect, with the cosines of their traces with its own.
fn rivals(
    search: &mut Search<'_>,
    effects: EffectSet,
    effect: EffectId,
) -> Result<Vec<(Score, f64)>, IdentifyError> {
    let Some(less) = search.exchanged(effects, effect, None) else {
        return Ok(Vec::new());
    };
    let sifted = search.sifted(less)?;
    let own = sifted
        .found
        .scores
        .iter()
        .find(|score| score.effect == effect);
    let direction = own.map(|own| own.direction.clone()).unwrap_or_default();
    Ok(sifted
        .found
        .scores
        .iter()
        .filter(|score| !effects.contains(score.effect))
        .map(|score| (score.clone(), dot(&score.direction, &direction).abs()))
        .collect())
}

/// Share of the explainable error that comes back without each effect.
fn contributions(
    search: &mut Search<'_>,
    trial: &Trial,
    effects: EffectSet,
) -> Result<Vec<(EffectId, f64)>, IdentifyError> {
    let mut shares = Vec::new();
    for effect in effects.iter() {
        let Some(less) = search.exchanged(effects, effect, None) else {
            // Nothing can be fitted without it.
            shares.push((effect, 1.0));
            continue;
        };
        let (Some(with), Some(without)) = (search.get(effects), search.get(less)) else {
            unreachable!("both were visited");
        };
        let share = if trial.is_resolved() {
            let lost = trial.held_out(search, without)? - trial.held_out(search, with)?;
            lost / (trial.baseline - trial.noise)
        } else {
            let all = with.noise.nats() - search.baseline().noise.nats();
            (with.noise.nats() - without.noise.nats()) / all
        };
        shares.push((effect, share));
    }
    Ok(shares)
}

/// Effects that all models share which are nearly as credible as a model, where all leave more than noise.
fn shared(search: &Search<'_>, effects: EffectSet) -> EffectSet {
    let least = search.credit(effects) - AS_WELL;
    let near = search
        .nodes()
        .filter(|node| search.is_misfit() && node.is_admitted())
        .filter(|node| search.credit(node.effects) > least);
    near.fold(effects, |shared, node| {
        shared
            .iter()
            .filter(|&effect| node.effects.contains(effect))
            .collect()
    })
}

/// Probability of an effect against those that would do as well in its place, and these.
fn alternatives(
    search: &mut Search<'_>,
    effects: EffectSet,
    effect: EffectId,
    dispersion: f64,
) -> Result<(f64, Vec<(EffectId, f64)>), IdentifyError> {
    let mut weights = Vec::new();
    for (rival, cosine) in rivals(search, effects, effect)? {
        if cosine < ALIKE {
            continue;
        }
        if let Some(set) = search.exchanged(effects, effect, Some(&rival)) {
            let behind = search.behind(set, effects) / dispersion;
            if behind < AS_WELL {
                weights.push((rival.effect, (-behind).exp()));
            }
        }
    }
    let total = 1.0 + weights.iter().map(|(_, weight)| weight).sum::<f64>();
    weights.iter_mut().for_each(|(_, weight)| *weight /= total);
    weights.sort_by(|a, b| b.1.total_cmp(&a.1));
    Ok((1.0 / total, weights))
}

/// How much of a node's residual lies along terms of any shape in the blocks of the cascade.
fn lack(search: &Search<'_>, node: &Node) -> Result<Lack, IdentifyError> {
    let case = search.case;
    let sensitivities = sensitivities(case, node)?;
    let whitener = Whitener::new(&case.layout, &node.noise);
    let white = |column: &Vec<f64>| whitener.whiten(column);
    let fitted: Vec<Vec<f64>> = sensitivities.iter().map(|one| white(&one.column)).collect();
    let mut span = Span::of(&fitted);
    let residual = span.outside(&white(&node.residual));
    let own = span.dimension();
    let terms = local_terms(case, node, &sensitivities)?;
    for column in terms
        .iter()
        .map(|term| &term.column)
        .chain(&slow_terms(case))
    {
        span.widen(&white(column));
    }
    let added = &span.basis()[own..];
    let along: f64 = added.iter().map(|one| dot(one, &residual).powi(2)).sum();
    let degrees = added.len() as f64;
    // What noise leaves in 95 % of cases is no lack.
    let usual = degrees + 1.645 * (2.0 * degrees).sqrt();
    Ok(Lack {
        beyond: (along - usual).max(0.0),
        p_value: chi_squared_tail(along, degrees),
    })
}

/// Probability of a χ² above a value (Wilson and Hilferty's cube root).
fn chi_squared_tail(value: f64, degrees: f64) -> f64 {
    if degrees <= 0.0 {
        return 1.0;
    }
    let spread = 2.0 / (9.0 * degrees);
    let normal = ((value / degrees).cbrt() - (1.0 - spread)) / spread.sqrt();
    0.5 * libm::erfc(normal / std::f64::consts::SQRT_2)
}

impl Trial {
    fn of(
        search: &Search<'_>,
        noise: &Measured,
        tau_s: f64,
        refits: bool,
    ) -> Result<Self, IdentifyError> {
        let mut trial = Self {
            folds: folds(search.case, GAP * tau_s),
            refits,
            known: RefCell::default(),
            baseline: 0.0,
            error: 0.0,
            noise: noise.gate,
        };
        let baseline = search.baseline();
        trial.baseline = trial.held_out(search, baseline)?;
        let spread = (2.0 / baseline.noise.output.n_effective).sqrt();
        trial.error = trial.baseline * spread;
        Ok(trial)
    }

    /// Mean square error of a model on what it has not seen of the training.
    fn held_out(&self, search: &Search<'_>, node: &Node) -> Result<f64, IdentifyError> {
        let known = self.known.borrow();
        if let Some((_, error)) = known.iter().find(|(set, _)| *set == node.effects) {
            return Ok(*error);
        }
        drop(known);
        let error = if self.refits && search.case.training.len() >= FEWEST_RECORDINGS {
            // Another rate or amplitude is the harder test.
            search.case.without_recordings(node)?
        } else if self.refits {
            let parts: Vec<Vec<Range<usize>>> = (0..PARTS)
                .map(|part| {
                    let own = self.folds.iter().skip(part).step_by(PARTS);
                    own.map(|fold| fold.scored.clone()).collect()
                })
                .collect();
            search.case.without_parts(node, &parts)?
        } else {
            let sensitivities = sensitivities(search.case, node)?;
            mean_square(&held_out(node, &sensitivities, &self.folds), &self.folds)
        };
        self.known.borrow_mut().push((node.effects, error));
        Ok(error)
    }

    /// Whether the baseline leaves more than noise beyond doubt.
    fn is_resolved(&self) -> bool {
        self.baseline - self.noise > 2.0 * self.error
    }

    /// Share of the explainable error that a model explains where it was not fitted.
    fn explained(&self, search: &Search<'_>, node: &Node) -> Result<Option<f64>, IdentifyError> {
        if !self.is_resolved() || node.effects.is_empty() {
            return Ok(None);
        }
        let left = self.held_out(search, node)?;
        Ok(Some((self.baseline - left) / (self.baseline - self.noise)))
    }

    /// Whether a model leaves more than the noise that was measured.
    fn far_off(node: &Node, noise: &Measured) -> bool {
        let highest = noise.upper.unwrap_or(noise.lower).max(noise.gate.sqrt());
        let spread = 1.0 + 2.0 * (2.0 / node.noise.output.n_effective).sqrt();
        node.mean_square() > KNOWN * highest * highest * spread
    }

    /// Whether the share by the noise floor says more than that by the lack of fit: the baseline leaves much more
    /// than noise, and the model does, too.
    fn tells(&self, node: &Node, noise: &Measured) -> bool {
        self.is_resolved() && Self::far_off(node, noise)
    }
}
