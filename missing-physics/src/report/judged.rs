//! The decision on a finished search, and what it would be by other thresholds.

use identify::IdentifyError;

use crate::decide::{Decided, Known, RULES, Rule, RuleId, Traces, Verdict, decide};
use crate::evidence::Population;
use crate::model::elsewhere::is_drift;
use crate::model::unseen::Unseen;
use crate::report::diagnosis::{ExtendedStage, Stage};
use crate::report::errors::Errors;
use crate::report::formula::OfFormula;
use crate::report::held::{came_true, held_plainly, held_to};
use crate::report::told::told;
use crate::search::roads::Search;
use crate::{Candidate, CandidateSet, ExtendedModel};

/// Factors of a threshold that are tried: a quarter less, and a quarter more.
const QUARTER: [f64; 2] = [0.75, 1.25];

/// The case before the judge: everything that was searched.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Judging<'a> {
    pub(crate) population: &'a Population,
    pub(crate) known: &'a Known,
    pub(crate) extended: Option<&'a ExtendedStage>,
    /// Errors of its sizes by the formula of its loop.
    pub(crate) of_formula: &'a OfFormula,
    /// The baseline model and its fit.
    pub(crate) plain: (&'a ExtendedModel, &'a Stage),
    /// Errors of the baseline model and of the extended one on the recordings that were not used, if there is an extended one.
    pub(crate) errors: Option<[&'a Unseen; 2]>,
    /// Mean square that there is no way below.
    pub(crate) ceiling: f64,
}

/// A decision.
#[derive(Debug, Clone)]
pub(crate) struct Judged {
    pub(crate) decided: Decided,
    /// Share of the unseen recordings' explainable error that the names alone explain.
    pub(crate) by_names: Option<f64>,
}

impl Judging<'_> {
    /// The decision. What it still needs is looked up in the search, and fitted where it is not there.
    pub(crate) fn judged(
        &self,
        search: &mut Search<'_>,
        errors: &mut Errors<'_>,
        traces: Traces,
    ) -> Result<Judged, IdentifyError> {
        let mut decided = decide(self.population, self.known, traces.begun_again());
        let mut by_names = None;
        if let (Some(extended), Some([before, after])) = (self.extended, self.errors) {
            let elsewhere = gained(&decided, search, extended, after, errors)?;
            if !elsewhere.is_empty() {
                let known = Known {
                    elsewhere,
                    ..self.known.clone()
                };
                decided = decide(self.population, &known, traces);
            }
            let of_both = ([before, after], self.ceiling);
            let comes_true = |effect| came_true(effect, search, (extended, after), errors);
            decided = told(decided, extended, self.of_formula, comes_true)?;
            (decided, by_names) = held_to(decided, search, extended, of_both, errors)?;
        }
        let decided = held_plainly(decided, self.plain, errors.recordings)?;
        Ok(Judged { decided, by_names })
    }

    /// Decisions with the threshold of one rule a quarter less or more, where they say something else than the one that was made.
    pub(crate) fn otherwise(
        &self,
        search: &mut Search<'_>,
        errors: &mut Errors<'_>,
        made: &Decided,
    ) -> Result<Vec<(&'static Rule, f64, Decided)>, IdentifyError> {
        let mut others = Vec::new();
        for rule in &RULES {
            for factor in QUARTER {
                // Without another answer there is no other decision.
                if made.traces.hang_on(rule, factor) {
                    let by = Traces::with_threshold_times(rule, factor);
                    let decided = self.judged(search, errors, by)?.decided;
                    if says(&decided) != says(made) {
                        others.push((rule, factor, decided));
                    }
                }
            }
        }
        Ok(others)
    }
}

/// Mean squares of the recordings that were not used which suspects explain that only are too small to matter in the training: there the same
/// physics may have more to do. Drifts are not asked: each is fitted to every recording.
fn gained(
    decided: &Decided,
    search: &mut Search<'_>,
    extended: &ExtendedStage,
    with: &Unseen,
    errors: &mut Errors<'_>,
) -> Result<Vec<(Candidate, f64)>, IdentifyError> {
    let effects: CandidateSet = extended.effects.iter().copied().collect();
    let mut gained = Vec::new();
    for suspect in &decided.suspects {
        let effect = suspect.effect;
        let refuses = |rule: RuleId| decided.traces.has(rule, effect.id(), false);
        let is_only_small =
            refuses(RuleId::Matters) && !refuses(RuleId::Set) && !refuses(RuleId::Own);
        if is_drift(effect) || !is_only_small {
            continue;
        }
        let node = search.node_without(effects, effect)?;
        let [without, with] = [errors.of(node)?, with].map(Unseen::mean_square);
        gained.extend(without.zip(with).map(|(a, b)| (effect, a - b)));
    }
    Ok(gained)
}

/// The verdict and the names with their alternatives.
fn says(decided: &Decided) -> (Verdict, Vec<(Candidate, Vec<Candidate>)>) {
    let names = decided.named.iter().map(|named| {
        let others = named.others.iter().map(|(other, _)| *other);
        (named.effect, others.collect())
    });
    (decided.verdict, names.collect())
}
