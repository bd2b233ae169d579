//! Effects that may be named, and their alternatives.

use recording::order::falling;

use crate::decide::known::Known;
use crate::decide::rules::RuleId;
use crate::decide::trace::Traces;
use crate::evidence::UNLISTED;
use crate::evidence::{Model, Population, by_chance, centered, masses, not_above_zero};
use crate::model::elsewhere::is_drift;
use crate::noise::wander::by_wander;
use crate::{Candidate, CandidateSet, LoopFamily};

/// An effect of the chosen model.
#[derive(Debug, Clone)]
pub(crate) struct Named {
    pub(crate) effect: Candidate,
    /// Others that would do as well in its place, with their share of the probability, the likeliest first.
    pub(crate) others: Vec<(Candidate, f64)>,
    pub(crate) probability: f64,
    pub(crate) contribution: f64,
}

/// The belief in each of some models: in all that may be chosen, and in the leading one, whole and without some of its names, with an
/// anonymous curve on top.
///
/// A curve beside all names speaks against none of them: a name with the curve is weighed against its absence with the curve.
pub(crate) struct Belief {
    /// Names of each model, and what it is believed.
    masses: Vec<(CandidateSet, f64)>,
}

impl Belief {
    pub(crate) fn of(population: &Population, leading: &Model, seed: u64) -> Self {
        let admissible = population
            .models
            .iter()
            .filter(|model| model.is_admissible());
        let named = admissible.map(|model| (model.names, model.ln_prior, &model.evidence.nats));
        let is_part = |model: &&Model| {
            let mut names = model.names.iter();
            names.all(|name| leading.names.contains(name))
        };
        let unlisted = population
            .models
            .iter()
            .filter(is_part)
            .filter_map(|model| {
                let anonymous = model.anonymous.as_ref()?;
                Some((
                    model.names,
                    model.ln_prior + UNLISTED,
                    &anonymous.evidence.nats,
                ))
            });
        let (names, asked): (Vec<CandidateSet>, Vec<(f64, &[f64])>) = named
            .chain(unlisted)
            .map(|(names, prior, nats)| (names, (prior, nats.as_slice())))
            .unzip();
        Self {
            masses: names.into_iter().zip(masses(&asked, seed)).collect(),
        }
    }

    /// Probability that one of some names is there.
    pub(crate) fn any(&self, of: CandidateSet) -> f64 {
        let has = |names: &CandidateSet| of.iter().any(|name| names.contains(name));
        let with = self.masses.iter().filter(|(names, _)| has(names));
        with.map(|(_, mass)| mass).sum()
    }

    /// Probability of one model alone, by its names: of the plain one without a curve, the first.
    pub(crate) fn plain(&self) -> f64 {
        self.masses.first().map_or(0.0, |(_, mass)| *mass)
    }
}

/// The names of the leading model: those that hold, and those that do not.
pub(crate) fn names(
    population: &Population,
    leading: &Model,
    belief: &Belief,
    known: &Known,
    traces: &mut Traces,
) -> [Vec<Named>; 2] {
    let mut sorted = [Vec::new(), Vec::new()];
    let plain = population.plain();
    let beats_curve_alone = beats_curve([plain, plain, leading], known.seed);
    for effect in leading.names.iter() {
        let id = effect.id();
        let less = population.without(leading, effect);
        let [lost, of_temperatures] = [0, 1]
            .map(|channel| less.evidence.squares()[channel] - leading.evidence.squares()[channel]);
        let lost = lost / leading.evidence.n_outputs as f64;
        let (mut named, covered) = alternatives(leading, (belief, known), effect, traces);
        if may_be_the_loop((population, leading), known, effect) {
            named.shares_with(Candidate::other_loop());
        }
        let in_its_place = beats_curve([plain, less, leading], known.seed);
        let beats_curves = beats_curve_alone.min(in_its_place);
        named.scale_probability(beats_curves);
        let is_covered = traces.ask(RuleId::Set, id, covered * beats_curves);
        named.contribution = population.share(leading.evidence.squares(), less.evidence.squares());
        let added = known.segments.iter().map(|range| {
            let without = centered(&less.evidence.residual[range.clone()]);
            let with = centered(&leading.evidence.residual[range.clone()]);
            let pairs = without.iter().zip(&with);
            let added = pairs.map(|(without, with)| without - with).collect();
            (without, added)
        });
        let added: Vec<(Vec<f64>, Vec<f64>)> = added.collect();
        let alone = by_chance(&added, SHIFTS, known.seed);
        // It is the best of all that were tried in its place.
        let mut p_value = (alone * known.tried_beside(less.names) as f64).min(1.0);
        if is_drift(effect) {
            // Fitted to what is slow it goes along with that, and noise may be slow.
            let pairs = added.iter().zip(&known.segments);
            let pairs = pairs.map(|((_, drift), range)| {
                (drift.as_slice(), &leading.evidence.residual[range.clone()])
            });
            p_value = p_value.max(by_wander(pairs, effect.info().parameters.len(), known.seed));
        }
        let is_own = traces.ask(RuleId::Own, id, p_value);
        let shown = (known.explained(effect, lost), of_temperatures);
        let is_material = known.is_material(traces, id, shown, leading.evidence.n_outputs);
        sorted[usize::from(!(is_covered && is_own && is_material))].push(named);
    }
    sorted
}

/// Probability that the leading model leaves no more of the blocks left out than a part of it with an anonymous curve: that a name
/// helps beside a curve does not make it what is missing. Formulas may be off by a share of what the curve explains of the baseline model's
/// error (rule `form`).
fn beats_curve([plain, part, leading]: [&Model; 3], seed: u64) -> f64 {
    let Some(curve) = &part.anonymous else {
        return 1.0;
    };
    let [named, plain, curve] = [&leading.evidence, &plain.evidence, &curve.evidence].map(|one| {
        let of_both = one.squares.iter().map(|channels| channels.iter().sum());
        of_both.collect::<Vec<f64>>()
    });
    let explained = plain.iter().sum::<f64>() - curve.iter().sum::<f64>();
    // Block by block as much as it leaves there.
    let tolerance = RuleId::Form.rule().threshold * explained / curve.iter().sum::<f64>();
    let behind = named.iter().zip(&curve);
    let behind = behind.map(|(named, curve)| named - (1.0 + tolerance.max(0.0)) * curve);
    not_above_zero(&behind.collect::<Vec<f64>>(), seed)
}

impl Named {
    /// Multiplies its probability, and those of its alternatives.
    fn scale_probability(&mut self, factor: f64) {
        self.probability *= factor;
        self.others.iter_mut().for_each(|(_, mass)| *mass *= factor);
    }

    /// Takes in what could be in the place of all of them just as likely.
    fn shares_with(&mut self, other: Candidate) {
        let whole = self.probability + self.others.iter().map(|(_, mass)| mass).sum::<f64>();
        self.probability *= 0.5;
        self.others.iter_mut().for_each(|(_, mass)| *mass *= 0.5);
        self.others.push((other, 0.5 * whole));
        falling(&mut self.others, |other| other.1);
    }
}

/// True if what a name explains may be the error of the loop's formula, beside a loop that is not the baseline's: by no more than formulas of
/// loops differ by it changes nothing but how the output follows the temperature and its past, or is a curve of time, which takes up a part
/// of any error.
fn may_be_the_loop(
    (population, leading): (&Population, &Model),
    known: &Known,
    effect: Candidate,
) -> bool {
    let n_outputs = leading.evidence.n_outputs;
    // Of the model that is nearest without it: some are likelier whose errors are larger, and known from one sample to the next.
    let lost = population.least_without(leading, effect) - leading.evidence.squares()[0];
    let of_formulas = most_of_formula(leading.family) * known.output_deviation(n_outputs);
    leading.names.contains(Candidate::other_loop())
        && effect != Candidate::other_loop()
        && (effect.info().like_loop || effect.info().flexible)
        && lost < n_outputs as f64 * of_formulas.powi(2)
}

/// The smallest set of names with this one that is as probable as it must be, and that probability.
fn alternatives(
    leading: &Model,
    (belief, known): (&Belief, &Known),
    effect: Candidate,
    traces: &Traces,
) -> (Named, f64) {
    let mut set = CandidateSet::of(effect);
    let own = belief.any(set);
    let mut covered = own;
    let mut others = Vec::new();
    let rivals: Vec<Candidate> = known
        .catalogue
        .iter()
        .filter(|&other| !leading.names.contains(other))
        .collect();
    while covered < traces.threshold(RuleId::Set) {
        let wider = rivals.iter().filter(|&&other| !set.contains(other));
        let best = wider
            .map(|&other| (belief.any(set.with(other)) - covered, other))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((added, other)) = best.filter(|(added, _)| *added > LEAST) else {
            break;
        };
        set = set.with(other);
        covered += added;
        others.push((other, added));
    }
    // What acts like it in every rig and could not be tried, for want of what it needs, is as likely.
    let untried: Vec<Candidate> = effect
        .info()
        .acts_like
        .iter()
        .map(|&other| Candidate::from(other))
        .filter(|&other| known.untried.contains(other) && !leading.names.contains(other))
        .collect();
    let share = 1.0 / (1 + untried.len()) as f64;
    others.iter_mut().for_each(|(_, mass)| *mass *= share);
    // A sum of shares may pass the whole by rounding.
    let own = (own * share).min(1.0);
    others.extend(untried.into_iter().map(|other| (other, own)));
    falling(&mut others, |other| other.1);
    let named = Named {
        effect,
        others,
        probability: own,
        contribution: 0.0,
    };
    (named, covered)
}

/// Root mean square by which a loop of one family misses one of another at the least, though its shape is free, over the standard
/// deviation of the output: as much may any of them miss a real loop. Relays of two populations miss one by less, and it stays.
pub(crate) const OF_FORMULAS: f64 = 0.02;

/// Root mean square of that kind at the most: an effect that explains less beside a loop may be the error of its formula. The paper's
/// loop with a shape of its own is no further from others than relays are.
pub(crate) fn most_of_formula(family: LoopFamily) -> f64 {
    match family {
        LoopFamily::Kinetics => 0.05,
        LoopFamily::Relays | LoopFamily::Proximity => 0.03,
    }
}

/// Shifts by which it is found whether a name goes with the recordings: so many that the best of a catalogue can pass.
const SHIFTS: usize = 9_999;

/// Probability below which another name is not worth a word.
const LEAST: f64 = 0.005;

#[cfg(test)]
mod tests {
    use super::super::tests::{N, known, model};
    use super::*;
    use crate::EffectId::{
        self, AmbientDrift, Backlash, DeadTime, EndStop, FunctionalFatigue, OutputLag,
    };

    fn leaving_as_much(names: &[EffectId]) -> Model {
        model(names, vec![1.0; N], vec![1.0; N])
    }

    /// Models with nothing but their priors against each other, and with a curve on top as credible as without.
    fn by_priors(names: &[(&[EffectId], f64)]) -> Population {
        let models = names.iter().map(|(names, prior)| {
            let mut one = leaving_as_much(names);
            one.ln_prior = prior.ln();
            one.evidence.nats.fill(0.0);
            one.anonymous.as_mut().unwrap().evidence.nats.fill(0.0);
            one
        });
        Population {
            models: models.collect(),
        }
    }

    fn set(names: &[EffectId]) -> CandidateSet {
        names.iter().map(|&name| name.into()).collect()
    }

    fn is_near(found: f64, expected: f64) -> bool {
        (found - expected).abs() < 1e-9
    }

    #[test]
    fn all_that_may_be_chosen_is_believed_and_the_leading_model_and_its_parts_with_a_curve() {
        let mut population = by_priors(&[
            (&[], 1.0),
            (&[OutputLag], 0.5),
            (&[OutputLag, Backlash], 0.25),
            (&[DeadTime], 0.125),
            (&[EndStop], 8.0),
        ]);
        population.models[4].pressed = set(&[EndStop]);
        let belief = Belief::of(&population, &population.models[2], 1);
        // The baseline, the lag alone, and lag and backlash are parts of the last.
        let unlisted = UNLISTED.exp();
        let all = 1.0 + 0.5 + 0.25 + 0.125 + unlisted * (1.0 + 0.5 + 0.25);
        assert!(is_near(belief.plain(), 1.0 / all));
        let with_lag = 0.5 + 0.25 + unlisted * (0.5 + 0.25);
        assert!(is_near(belief.any(set(&[OutputLag])), with_lag / all));
        let any = belief.any(set(&[OutputLag, DeadTime]));
        assert!(is_near(any, (with_lag + 0.125) / all));
        assert!(is_near(belief.any(set(&[EndStop])), 0.0));
    }

    /// The set around the first name of a leading model, where so much is believed of each of some names, and its probability.
    fn around(leading: &[EffectId], masses: &[(&[EffectId], f64)], known: &Known) -> (Named, f64) {
        let masses = masses.iter().map(|&(names, mass)| (set(names), mass));
        let belief = Belief {
            masses: masses.collect(),
        };
        let model = leaving_as_much(leading);
        let asked = (&belief, known);
        alternatives(&model, asked, leading[0].into(), &Traces::default())
    }

    /// The set around the lag, where these shares are believed of it and of others, and its probability.
    fn around_the_lag(of_lag: f64, others: &[(EffectId, f64)]) -> (Named, f64) {
        let lag = [OutputLag];
        let mut masses: Vec<(&[EffectId], f64)> = vec![(&lag, of_lag)];
        masses.extend(
            others
                .iter()
                .map(|(name, mass)| (std::slice::from_ref(name), *mass)),
        );
        around(&lag, &masses, &known())
    }

    #[test]
    fn a_set_takes_in_the_likeliest_until_it_is_probable_enough() {
        let (named, covered) =
            around_the_lag(0.5, &[(Backlash, 0.06), (DeadTime, 0.4), (EndStop, 0.04)]);
        assert!(
            is_near(named.probability, 0.5) && is_near(covered, 0.96),
            "{covered}"
        );
        let others: Vec<&str> = named.others.iter().map(|(other, _)| other.id()).collect();
        assert_eq!(others, ["dead-time", "backlash"]);
        assert!(is_near(named.others[0].1, 0.4) && is_near(named.others[1].1, 0.06));
        // What is hardly believed at all is no alternative.
        let (named, covered) = around_the_lag(0.94, &[(Backlash, 0.004)]);
        assert!(
            named.others.is_empty() && is_near(covered, 0.94),
            "{named:?}"
        );
        let (named, covered) = around_the_lag(0.94, &[(Backlash, 0.006)]);
        assert!(
            named.others.len() == 1 && is_near(covered, 0.946),
            "{named:?}"
        );
    }

    #[test]
    fn what_acts_alike_and_could_not_be_tried_has_half_of_the_probability() {
        let known = Known {
            untried: set(&[FunctionalFatigue, EndStop]),
            ..known()
        };
        let masses: [(&[EffectId], f64); 2] = [(&[AmbientDrift], 0.9), (&[DeadTime], 0.08)];
        let of = |leading: &[EffectId]| around(leading, &masses, &known);
        let (named, covered) = of(&[AmbientDrift]);
        assert!(
            is_near(named.probability, 0.45) && is_near(covered, 0.98),
            "{named:?}"
        );
        let others: Vec<&str> = named.others.iter().map(|(other, _)| other.id()).collect();
        assert_eq!(others, ["functional-fatigue", "dead-time"]);
        assert!(is_near(named.others[0].1, 0.45) && is_near(named.others[1].1, 0.04));
        // Beside both it is no alternative to either.
        let (named, _) = of(&[AmbientDrift, FunctionalFatigue]);
        assert!(is_near(named.probability, 0.9), "{named:?}");
    }

    #[test]
    fn probabilities_are_multiplied_and_shared_together() {
        let mut named = Named {
            effect: OutputLag.into(),
            others: vec![(DeadTime.into(), 0.3)],
            probability: 0.6,
            contribution: 0.0,
        };
        named.scale_probability(0.5);
        assert!(is_near(named.probability, 0.3) && is_near(named.others[0].1, 0.15));
        named.shares_with(Candidate::other_loop());
        assert!(is_near(named.probability, 0.15));
        // The likeliest first.
        assert_eq!(named.others[0].0, Candidate::other_loop());
        assert!(is_near(named.others[0].1, 0.225) && is_near(named.others[1].1, 0.075));
    }
}
