//! Status of each effect by the recordings, and the findings.

use identify::{Bounds, FittedParameter, IdentifyError, ParameterState};

use crate::decide::{Decided, Named, Verdict, leading};
use crate::evidence::{Model, Population};
use crate::report::diagnosis::{Entry, Estimate, ExtendedStage, Finding, Status};
use crate::report::formula::{HALF_95, certainly_shown, error_of_formula};
use crate::report::sentence;
use crate::screen::scores::Score;
use crate::screen::screening::{POWER, at_their_sizes};
use crate::search::roads::Search;
use crate::{Candidate, CandidateSet, EffectParameter, LoopFamily, Role, Setting};

/// An effect of the chosen model with its numbers.
pub(crate) fn finding(
    named: &Named,
    setting: &Setting,
    extended: Option<&ExtendedStage>,
) -> Finding {
    let info = named.effect.info();
    let family = setting.loop_family;
    if named.effect == Candidate::other_loop() && family != LoopFamily::Proximity {
        return Finding {
            effect: named.effect,
            could_also_be: Vec::new(),
            probability: named.probability,
            plausible: true,
            contribution: named.contribution,
            sentence: sentence::of_family(info, family),
            parameters: Vec::new(),
        };
    }
    let fitted = |name: &str| extended.and_then(|one| one.stage.fit.parameter(name));
    let is_held = |name: &str| {
        let held = |one: &FittedParameter| one.info.state != ParameterState::Free;
        fitted(name).is_some_and(held)
    };
    let r = largest_in(info.parameters, extended);
    let parameters: Vec<Estimate> = info
        .parameters
        .iter()
        .filter(|parameter| !is_held(parameter.name))
        .map(|parameter| {
            let fitted = fitted(parameter.name);
            let unit = setting.unit_of(parameter);
            // What is compared is in one unit.
            let literature = parameter.literature.filter(|_| unit == parameter.unit);
            let literature = literature.filter(|literature| literature.checked);
            Estimate {
                name: parameter.name,
                unit,
                value: fitted.map_or(parameter.neutral(), |fitted| fitted.values[r]),
                ci95: fitted
                    .and_then(|fitted| fitted.intervals[r])
                    .map(|interval| within(interval, fitted.map(|one| one.info.bounds))),
                literature: literature.map(|literature| literature.range),
            }
        })
        .collect();
    Finding {
        effect: named.effect,
        could_also_be: named.others.iter().map(|(effect, _)| *effect).collect(),
        probability: named.probability,
        plausible: parameters.iter().all(is_plausible),
        contribution: named.contribution,
        sentence: sentence::finding(info, &parameters),
        parameters,
    }
}

/// Both ends of an interval, as far as they are possible.
fn within(interval: Bounds, possible: Option<Bounds>) -> [f64; 2] {
    let ends = [interval.lower, interval.upper];
    possible.map_or(ends, |one| ends.map(|end| end.clamp(one.lower, one.upper)))
}

/// Index of the recording in which a drift is largest; 0 of an effect that all recordings share.
fn largest_in(parameters: &[EffectParameter], extended: Option<&ExtendedStage>) -> usize {
    let mut largest = (0, 0.0);
    for size in parameters.iter().filter(|one| one.role == Role::Size) {
        let fitted = extended.and_then(|one| one.stage.fit.parameter(size.name));
        for (r, value) in fitted.iter().flat_map(|one| one.values.iter().enumerate()) {
            let share = value.abs() / size.typical;
            if share > largest.1 {
                largest = (r, share);
            }
        }
    }
    largest.0
}

/// True if the interval of an estimate meets the literature's, or the literature has none; magnitudes count.
fn is_plausible(estimate: &Estimate) -> bool {
    let Some([lower, upper]) = estimate.literature else {
        return true;
    };
    let ends = estimate.ci95.unwrap_or([estimate.value; 2]);
    let sign = estimate.value.signum();
    let mut ends = ends.map(|end| sign * end);
    ends.sort_by(f64::total_cmp);
    ends[0] <= upper && ends[1] >= lower
}

/// An entry for each effect; `effects` are those of the leading model of the population, and `least_rms` is the root mean square in
/// the output's unit that one must show to matter, and to be told from what is left.
pub(crate) fn catalogue(
    search: &mut Search<'_>,
    (population, decided): (&Population, &Decided),
    effects: CandidateSet,
    least_rms: f64,
    seed: u64,
) -> Result<Vec<Entry>, IdentifyError> {
    let plain = search.sifted(CandidateSet::EMPTY)?;
    let last = search.sifted(effects)?;
    let Some(node) = search.get(effects) else {
        unreachable!("its scores were just taken");
    };
    let family = search.case.setting.loop_family;
    let credible: Vec<&Model> = population
        .as_credible_as(leading(population))
        .filter(|model| model.family == family)
        .collect();
    let critical = last.found.critical;
    let left = at_their_sizes(search.case, node, &last, seed)?;
    let is_open = matches!(
        decided.verdict,
        Verdict::Unexplained | Verdict::ExplainedInPart
    );
    let is_suspect = |effect: Candidate| decided.suspects.iter().any(|one| one.effect == effect);
    let entry = |effect: Candidate| {
        let unit = search.case.setting.unit_of(&effect.info().parameters[0]);
        let score = plain
            .found
            .scores
            .iter()
            .find(|score| score.effect == effect);
        let left = left.iter().find(|score| score.effect == effect);
        let error = |score: &Score| {
            score.errors[0].hypot(error_of_formula(search.case, effect, score.shown_per_unit))
        };
        let detectable = left
            .or(score)
            .map(|score| ((critical + POWER) * error(score)).max(least_rms / score.shown_per_unit));
        let is_other = |named: &Named| named.others.iter().any(|(other, _)| *other == effect);
        let status = if let Some(need) = search.case.missing(effect) {
            Status::Unknown { need }
        } else if decided.named.iter().any(|named| named.effect == effect) {
            Status::Detected
        } else if effects.contains(effect)
            || decided.named.iter().any(is_other)
            || is_suspect(effect)
        {
            Status::Ambiguous
        } else {
            let (largest, signed) = largest(effect);
            let upper = |left: &Score| {
                let size = left.sizes[0];
                let size = if signed { size.abs() } else { size.max(0.0) };
                // A smaller one would be passed over, and one that a model as credible has is not out of the question.
                let shown = (size + HALF_95 * error(left)).max(least_rms / left.shown_per_unit);
                // Over nothing, any size may be there.
                let hidden = shown / certainly_shown(left.absorbed).max(0.0);
                hidden.max(held_possible(search, &credible, effect))
            };
            match left {
                // While something unknown is left, no limit is tighter than that allows.
                _ if is_open => Status::NotTestable,
                Some(left)
                    if (critical + POWER) * error(left) <= largest && upper(left) < largest =>
                {
                    Status::Excluded { upper: upper(left) }
                }
                _ => Status::NotTestable,
            }
        };
        Entry {
            effect,
            status,
            t: score.map(|score| score.whitened),
            absorption: score.map(|score| score.absorbed),
            minimum_detectable: detectable.filter(|size| size.is_finite()),
            unit,
        }
    };
    Ok(Candidate::all(search.case.setting.hypotheses)
        .map(entry)
        .collect())
}

/// Largest size of an effect, in magnitude, in some models of a search; 0 where none has it.
fn held_possible(search: &Search<'_>, credible: &[&Model], effect: Candidate) -> f64 {
    let nodes = credible
        .iter()
        .filter_map(|model| search.get(model.effects));
    nodes
        .filter_map(|node| {
            let place = node.model.first_parameter(effect)?;
            let sizes = node.points.iter().map(|point| point[place].abs());
            sizes.reduce(f64::max)
        })
        .fold(0.0, f64::max)
}

/// Largest plausible size of an effect's first parameter, in magnitude, and whether it may be negative.
fn largest(effect: Candidate) -> (f64, bool) {
    let first = effect
        .info()
        .parameters
        .iter()
        .find(|parameter| parameter.role == Role::Size);
    first.map_or((0.0, false), |parameter| {
        (parameter.largest(), parameter.bounds[0] < 0.0)
    })
}
