//! Findings and suspects: what they are, how sure they are, and why.

use comfy_table::{Cell, Table};
use missing_physics::{Candidate, Comparison, Diagnosis, Finding, Rule, RuleId, Trace};
use sma_effects::{Belongs, Role};

use super::headline::{names, names_of_others};
use super::traces::of_effect;
use crate::report::number::{probability, significant, spoken, spoken_percent};
use crate::report::table::{right, table};
use crate::report::words::{capitalized, full_stop, listed};

/// Distance to a bound, as a share of the range, at which a value stands on it.
const NEAR_BOUND: f64 = 1e-6;

/// Instructions for reading findings.
const HOW_TO_READ: &str = "± is half of a 95 % interval. Explainable: the squared error of the baseline model less the least that any model \
     leaves, with or without a free curve on top. Chance: noise like the residual.";

/// A paragraph for each finding, and one for the reasons behind it.
pub(super) fn findings(diagnosis: &Diagnosis) -> Vec<String> {
    let mut lines = Vec::new();
    for (k, finding) in diagnosis.findings.iter().enumerate() {
        lines.push(format!("{}. {}", k + 1, named(diagnosis, finding)));
        lines.push(format!("   Why: {}.", why(diagnosis, finding)));
    }
    lines.extend(at_bounds(&diagnosis.findings));
    if !diagnosis.findings.is_empty() {
        lines.push(HOW_TO_READ.to_owned());
    }
    lines
}

/// A paragraph for each suspect, with the rules that keep it from being a finding.
pub(super) fn suspects(diagnosis: &Diagnosis) -> Vec<String> {
    let suspects = diagnosis.suspects.iter();
    suspects
        .map(|suspect| {
            format!(
                "Suspected, not a finding: {}. It reduces the error, but {}.",
                suspect.effect.info().name,
                listed(&against(diagnosis, suspect), "and")
            )
        })
        .collect()
}

/// A finding under all its names, with its probability and what it does.
fn named(diagnosis: &Diagnosis, finding: &Finding) -> String {
    let first = finding.effect.info().name;
    if finding.could_also_be.is_empty() {
        return format!(
            "{} (probability {}): {}",
            capitalized(first),
            probability(finding.probability),
            full_stop(what(finding))
        );
    }
    let set = of_effect(diagnosis, RuleId::Set, finding.effect.id());
    let together = set.map_or(String::new(), |set| {
        format!("probability {} together, ", probability(set.value))
    });
    format!(
        "{} ({together}{} for {first} alone). If it is {first}: {}",
        capitalized(&names(finding, &diagnosis.findings)),
        probability(finding.probability),
        full_stop(what(finding))
    )
}

/// Description of an effect, without the claim that it is missing.
#[must_use]
pub fn what(finding: &Finding) -> &str {
    let sentence = finding.sentence.as_str();
    sentence.split_once(": ").map_or(sentence, |(_, what)| what)
}

/// Answers of the rules for a finding, each with what it requires.
fn why(diagnosis: &Diagnosis, finding: &Finding) -> String {
    let id = finding.effect.id();
    let required = |trace: &Trace| required(trace, spoken_percent);
    let mut reasons = vec![format!(
        "without it {} of the explainable error comes back",
        spoken_percent(finding.contribution)
    )];
    if let Some(own) = of_effect(diagnosis, RuleId::Own, id) {
        reasons.push(format!(
            "chance does as much in {} of draws{}",
            spoken_percent(own.value),
            required(own)
        ));
    }
    if let Some(gain) = of_effect(diagnosis, RuleId::UnseenGain, id) {
        reasons.push(format!(
            "in unseen data {} of the change that it predicts is there{}",
            spoken_percent(gain.value),
            required(gain)
        ));
    }
    match comparison(finding) {
        Compared::Outside => {
            reasons.push("BUT its size is outside of the literature's range".to_owned())
        }
        Compared::Not => reasons.push("its size was not compared with the literature".to_owned()),
        Compared::Within | Compared::Nothing => {}
    }
    reasons.join("; ")
}

/// Rules that keep a suspect from being a finding; if they are not on record, the one that always does.
fn against(diagnosis: &Diagnosis, suspect: &Finding) -> Vec<String> {
    let id = suspect.effect.id();
    let failed = |rule: RuleId| of_effect(diagnosis, rule, id).filter(|trace| !trace.passed);
    let mut reasons = Vec::new();
    if let Some(set) = failed(RuleId::Set) {
        reasons.push(format!(
            "the probability of it or an alternative is {}{}",
            probability(set.value),
            required(set, spoken_percent)
        ));
    }
    if let Some(own) = failed(RuleId::Own) {
        reasons.push(format!(
            "chance does as much in {} of draws{}",
            spoken_percent(own.value),
            required(own, spoken_percent)
        ));
    }
    if let Some(matters) = failed(RuleId::Matters) {
        reasons.push(format!(
            "what it does is {} times the least that matters{}",
            spoken(matters.value),
            required(matters, spoken)
        ));
    }
    if let Some(told) = failed(RuleId::Told) {
        reasons.push(
            if told.value.abs() <= 0.0 && is_drift_through_values(suspect) {
                "it turns back again and again, or comes within an eighth of a recording: that is no slow drift".to_owned()
            } else if told.value.abs() <= 0.0 {
                "its size ends at a bound of what is possible: it does the work of something else, or it has none".to_owned()
            } else {
                format!(
                    "its size is {} times half of its interval{}",
                    spoken(told.value),
                    required(told, spoken)
                )
            },
        );
    }
    if let Some(gain) = failed(RuleId::UnseenGain) {
        reasons.push(format!(
            "in unseen data {} of the change that it predicts is there{}",
            spoken_percent(gain.value),
            required(gain, spoken_percent)
        ));
    }
    if reasons.is_empty() {
        reasons.push("it does not account for enough of it".to_owned());
    }
    reasons
}

/// True for a drift that is a curve through values along a recording.
fn is_drift_through_values(finding: &Finding) -> bool {
    let info = finding.effect.info();
    info.flexible && info.belongs_to == Belongs::Recording
}

/// Threshold of a rule behind its statistic.
fn required(trace: &Trace, shown: fn(f64) -> String) -> String {
    let Rule {
        comparison,
        threshold,
        ..
    } = *trace.rule;
    match comparison {
        Comparison::AtLeast | Comparison::AtMost => {
            format!(" (needs {} {})", comparison.sign(), shown(threshold))
        }
        Comparison::NearOne => {
            let [from, to] = [1.0 - threshold, 1.0 + threshold].map(shown);
            format!(" (needs {}-{to})", from.trim_end_matches(" %"))
        }
    }
}

/// Sizes that would be larger still if they could: a sign that another effect is meant.
fn at_bounds(findings: &[Finding]) -> Option<String> {
    let estimates = findings.iter().flat_map(|finding| {
        let infos = finding.effect.info().parameters.iter();
        infos.zip(&finding.parameters)
    });
    let on_bound: Vec<&str> = estimates
        .filter(|(info, estimate)| {
            let near = NEAR_BOUND * (info.bounds[1] - info.bounds[0]);
            let is_whole = info.name.ends_with("_share") && info.bounds[1] >= 1.0;
            let is_on = |bound: f64| bound != 0.0 && (estimate.value - bound).abs() <= near;
            !is_whole && info.bounds.into_iter().any(is_on)
        })
        .map(|(info, _)| info.name)
        .collect();
    (!on_bound.is_empty()).then(|| {
        format!(
            "DOUBTFUL, on a bound of what is possible: {}. The data pull further: something else may be meant.",
            listed(&on_bound, "and")
        )
    })
}

/// Result of a comparison of sizes with the literature.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Compared {
    /// The literature has no range for any of them.
    Nothing,
    /// It has, in a unit that the size does not have.
    Not,
    /// All that it has are within.
    Within,
    /// One is not.
    Outside,
}

fn comparison(finding: &Finding) -> Compared {
    let infos = finding.effect.info().parameters.iter();
    let has_range = infos
        .filter(|info| info.literature.is_some_and(|literature| literature.checked))
        .any(|info| {
            let mut estimates = finding.parameters.iter();
            estimates.any(|estimate| estimate.name == info.name)
        });
    let mut estimates = finding.parameters.iter();
    let is_compared = estimates.any(|estimate| estimate.literature.is_some());
    match (has_range, is_compared, finding.plausible) {
        (_, true, false) => Compared::Outside,
        (_, true, true) => Compared::Within,
        (true, false, _) => Compared::Not,
        (false, false, _) => Compared::Nothing,
    }
}

/// Findings and suspects, as far as there are any: title, effects, table of their parameters.
pub fn found(diagnosis: &Diagnosis) -> impl Iterator<Item = (&str, &[Finding], Table)> {
    [
        ("Findings", &diagnosis.findings, true),
        // No probability: it is against the rest of the catalogue, which does not account for the error.
        (
            "Suspects: they reduce the error, and are no findings",
            &diagnosis.suspects,
            false,
        ),
    ]
    .into_iter()
    .filter(|(_, findings, _)| !findings.is_empty())
    .map(|(title, findings, sure)| (title, &findings[..], estimates(findings, sure)))
}

/// Effects with their parameters, a row a parameter.
fn estimates(findings: &[Finding], with_probability: bool) -> Table {
    let mut header = vec![
        "effect",
        "probability",
        "parameter",
        "value",
        "95 % interval",
        "unit",
        "literature",
        "within it",
    ];
    if !with_probability {
        header.remove(1);
    }
    let mut table = table(header);
    for finding in findings {
        for (k, one) in finding.parameters.iter().enumerate() {
            let [effect, likely, within] = if k == 0 {
                let within = match comparison(finding) {
                    Compared::Within => "yes",
                    Compared::Outside => "NO",
                    Compared::Not | Compared::Nothing => "not compared",
                };
                [
                    finding.effect.id(),
                    &probability(finding.probability),
                    within,
                ]
                .map(ToOwned::to_owned)
            } else {
                ["", "", ""].map(ToOwned::to_owned)
            };
            let range = |ends: Option<[f64; 2]>, none: &str, shown: fn(f64) -> String| {
                ends.map_or(none.to_owned(), |ends| ends.map(shown).join(" … "))
            };
            let mut row = vec![
                Cell::new(effect),
                right(likely),
                Cell::new(one.name),
                right(significant(one.value)),
                Cell::new(range(one.ci95, "not fixed", significant)),
                Cell::new(one.unit),
                Cell::new(range(one.literature, "", spoken)),
                Cell::new(within),
            ];
            if !with_probability {
                row.remove(1);
            }
            table.add_row(row);
        }
    }
    table
}

/// Range in the literature of the first size that has one.
#[must_use]
pub fn literature(finding: &Finding) -> Option<[f64; 2]> {
    let parameters = finding
        .effect
        .info()
        .parameters
        .iter()
        .zip(&finding.parameters);
    parameters
        .filter(|(info, _)| info.role == Role::Size)
        .find_map(|(_, estimate)| estimate.literature)
}

/// Alternatives to a finding; empty if there are none.
pub(super) fn or_else(findings: &[Finding], effect: Candidate) -> String {
    let found = findings.iter().find(|one| one.effect == effect);
    match found.map(|one| names_of_others(one, findings)) {
        Some(names) if !names.is_empty() => format!("or {}", listed(&names, "or")),
        _ => String::new(),
    }
}
