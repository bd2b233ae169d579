//! Report of `sma diagnose` on recordings without time: text for people, JSON for programs.

use std::fmt::Write;

use comfy_table::{Cell, Table};
use identify::{Estimate, NotTestable, StaticEffect, StaticEffects, StaticScore};
use missing_physics::Verdict;
use serde_json::{Value, json};
use sma_effects::EffectId;

use super::number::{percent, significant, spoken};
use super::table::{folding, right, table, unpadded};
use super::words::listed;

/// Reason why static recordings cannot test any other effect.
const NEEDS_TIME: &str = "needs time";

/// The result of `sma diagnose` on static recordings.
#[derive(Debug)]
pub struct StaticDiagnosed<'a> {
    /// Result of the diagnosis.
    pub effects: &'a StaticEffects,
    /// Unit of the output.
    pub output_unit: &'a str,
    /// The seed.
    pub seed: u64,
    /// Rule of the hysteresis' memory, as the flag names it.
    pub memory: &'static str,
    /// Notes beside the result.
    pub notes: Vec<String>,
}

type Tested = Result<StaticEffect, NotTestable>;

impl StaticDiagnosed<'_> {
    fn all(&self) -> [(EffectId, &Tested); 3] {
        [
            (EffectId::StressCoupling, &self.effects.stress_coupling),
            (
                EffectId::PhaseDependentResistance,
                &self.effects.phase_dependent_resistance,
            ),
            (
                EffectId::FunctionalFatigue,
                &self.effects.functional_fatigue,
            ),
        ]
    }

    fn tested(&self) -> impl Iterator<Item = &StaticEffect> {
        self.all()
            .into_iter()
            .filter_map(|(_, tested)| tested.as_ref().ok())
    }

    /// `None` if nothing could be tested. What is found explains in part at best: without a noise floor nobody
    /// knows how much there was to explain.
    pub fn verdict(&self) -> Option<Verdict> {
        self.tested().next()?;
        let converged = |one: &StaticEffect| one.without.converged && one.with.converged;
        Some(if !self.tested().all(converged) {
            Verdict::NotConverged
        } else if self.tested().any(StaticEffect::is_found) {
            Verdict::ExplainedInPart
        } else {
            Verdict::Adequate
        })
    }

    /// For people.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = match self.verdict() {
            None => "UNTESTED: these static recordings test no effect, and nothing can be said of what the loop leaves out.\n".to_owned(),
            Some(Verdict::NotConverged) => {
                "NOT CONVERGED: the loop is not fitted, and nothing can be said of what it leaves out. Try another --seed.\n".to_owned()
            }
            Some(Verdict::Adequate) => {
                "ADEQUATE: nothing is missing that these static recordings could show.\n".to_owned()
            }
            Some(_) => {
                let found: Vec<&StaticEffect> =
                    self.tested().filter(|one| one.is_found()).collect();
                let names: Vec<String> = found.iter().map(|one| one.effect.replace('-', " ")).collect();
                let verb = if names.len() == 1 { "is" } else { "are" };
                let said: String = found.into_iter().map(|one| sentence(one) + "\n").collect();
                format!(
                    "EXPLAINED IN PART: {} {verb} missing from the loop.\n{said}Without time nothing tells the noise: these recordings \
                     cannot say if something else is left.\n",
                    listed(&names, "and")
                )
            }
        };
        if self.tested().next().is_some() {
            let _ = write!(text, "\n{}\n\n{}\n", self.ladder(), self.estimates());
        }
        let mut catalogue = folding(["effect", "", "what these recordings say"]);
        for (effect, tested) in self.all() {
            let (group, said) = match tested {
                Err(why) => ("not testable", why.to_string()),
                Ok(one) if one.is_found() => ("detected", String::new()),
                Ok(one) => (
                    "not found",
                    upper(one).map_or("not fixed by these recordings".to_owned(), |upper| {
                        format!("at most {} {}", spoken(upper), one.estimates[0].unit)
                    }),
                ),
            };
            catalogue.add_row([effect.id(), group, &said]);
        }
        catalogue.add_row(["all others", "not testable", NEEDS_TIME]);
        let _ = write!(text, "\nThe catalogue\n{catalogue}\n");
        unpadded(&text)
    }

    fn ladder(&self) -> Table {
        let mut table = table(["effect", "RMSE without", "with", "unit"]);
        for one in self.tested() {
            table.add_row([
                Cell::new(one.effect),
                right(significant(one.without.rmse)),
                right(significant(one.with.rmse)),
                Cell::new(&one.with.unit),
            ]);
        }
        table
    }

    fn estimates(&self) -> Table {
        let mut table = table(["effect", "parameter", "value", "95 % interval", "unit"]);
        for one in self.tested() {
            for (k, estimate) in one.estimates.iter().enumerate() {
                table.add_row([
                    Cell::new(if k == 0 { one.effect } else { "" }),
                    Cell::new(estimate.name),
                    right(significant(estimate.value)),
                    Cell::new(
                        estimate
                            .interval
                            .map_or("not fixed".to_owned(), |interval| {
                                [interval.lower, interval.upper]
                                    .map(significant)
                                    .join(" … ")
                            }),
                    ),
                    Cell::new(&estimate.unit),
                ]);
            }
        }
        table
    }

    /// For programs: DESIGN's document, as far as it goes without time.
    pub fn json(&self) -> Value {
        // The effects of the loop itself; the cycles are tested where the stress is not.
        let of_loop = self.effects.stress_coupling.as_ref().ok();
        let of_loop = of_loop.or(self.effects.functional_fatigue.as_ref().ok());
        let stage = |rmse: Option<f64>| json!({"train_rmse": rmse, "predicted_rmse": null, "validate_rmse": null, "temperature_rmse_k": null, "parameters": []});
        let found: Vec<&StaticEffect> = self.tested().filter(|one| one.is_found()).collect();
        let extended = of_loop.filter(|one| one.is_found()).map(|one| {
            let mut stage = stage(Some(one.with.rmse));
            stage["effects"] = json!([one.effect]);
            stage["parameters"] = parameters(one);
            stage
        });
        json!({
            "schema_version": 1,
            "command": "diagnose",
            "version": env!("CARGO_PKG_VERSION"),
            "seed": self.seed,
            "verdict": self.verdict().map(Verdict::id),
            // The loop by itself is for `sma identify`.
            "implausible": null,
            "output_unit": self.output_unit,
            "noise_floor": {"lower": null, "upper": null, "class": null},
            "repeats": null,
            "runs": null,
            "baseline": stage(of_loop.map(|one| one.without.rmse)),
            "extended": extended,
            "explained_fraction": {"train": null, "validate": null, "validate_interval": null, "by_findings": null},
            "mismatch": {
                "block": null, "block_probability": null, "blocks": [], "cells": [], "spans": [], "bands": [],
            },
            "findings": found.into_iter().map(finding).collect::<Vec<_>>(),
            "suspects": [],
            "remainder": null,
            "catalogue": EffectId::ALL.map(|effect| self.entry(effect)),
            "next_experiment": null,
            "predictable": null,
            "trace": [],
            "otherwise": [],
            "memory": self.memory,
            "notes": self.notes,
        })
    }

    fn entry(&self, effect: EffectId) -> Value {
        let own = self.all().into_iter().find(|(id, ..)| *id == effect);
        let entry = |verdict: &str, unit: &str, upper: Option<f64>, reason: Option<String>| {
            json!({
                "effect": effect.id(),
                "verdict": verdict,
                "t": null,
                "absorption": null,
                "minimum_detectable": null,
                "unit": unit,
                "upper_limit": upper,
                "reason": reason,
            })
        };
        let unit = effect.info().parameters[0].unit;
        match own {
            None => entry("not_testable", unit, None, Some(NEEDS_TIME.to_owned())),
            Some((_, Err(why))) => entry("not_testable", unit, None, Some(why.to_string())),
            Some((_, Ok(one))) if one.is_found() => {
                entry("detected", &one.estimates[0].unit, None, None)
            }
            Some((_, Ok(one))) => {
                let upper = upper(one);
                let verdict = if upper.is_some() {
                    "excluded"
                } else {
                    "not_testable"
                };
                entry(verdict, &one.estimates[0].unit, upper, None)
            }
        }
    }
}

/// The largest first size that the recordings allow.
fn upper(one: &StaticEffect) -> Option<f64> {
    let interval = one.estimates[0].interval?;
    Some(interval.lower.abs().max(interval.upper.abs()))
}

fn sentence(one: &StaticEffect) -> String {
    if let Some(coefficient) = one.estimate("stress_coupling_mpa_per_k") {
        return format!(
            "Stress coupling is missing: the loop shifts with the stress, {} MPa/K{}.",
            spoken(coefficient.value),
            bracketed(coefficient, spoken)
        );
    }
    if let [shift, loss, lasting, ..] = one.sizes() {
        return fatigue(one, [shift, loss, lasting]);
    }
    let change = &one.estimates[0];
    format!(
        "Phase-dependent resistance is missing: the resistance changes by {}{} of its cold value while transforming.",
        percent(change.value),
        bracketed(change, percent)
    )
}

/// Sentence on functional fatigue; names each size whose interval excludes 0.
fn fatigue(one: &StaticEffect, [shift, loss, lasting]: [&Estimate; 3]) -> String {
    let of = |estimate: &Estimate, said: String| estimate.excludes_zero().then_some(said);
    let shift_said = format!(
        "the loop shifts by {} {}{}",
        spoken(shift.value),
        shift.unit,
        bracketed(shift, spoken)
    );
    let loss_said = format!(
        "the stroke changes by {}{} of it",
        percent(-loss.value),
        loss.interval.map_or(String::new(), |interval| {
            let ends = [-interval.upper, -interval.lower].map(percent);
            format!(" [{}]", ends.join(", "))
        })
    );
    let way = if lasting.value < 0.0 {
        "against"
    } else {
        "along"
    };
    let size = |end: f64| percent(end * lasting.value.signum());
    let lasting_said = format!(
        "the rest moves by {}{} of the stroke {way} it",
        size(lasting.value),
        lasting.interval.map_or(String::new(), |interval| {
            let mut ends = [interval.lower, interval.upper];
            ends.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
            format!(" [{}]", ends.map(size).join(", "))
        })
    );
    let said: Vec<String> = [
        of(shift, shift_said),
        of(loss, loss_said),
        of(lasting, lasting_said),
    ]
    .into_iter()
    .flatten()
    .collect();
    let cycles = one.estimate("cycles").map_or(0.0, |cycles| cycles.value);
    format!(
        "Functional fatigue is missing: the loop and its stroke drift with the number of cycles; after {cycles:.0} over the whole range {}. Without \
         time a sensor that drifts would look the same.",
        said.join(", ")
    )
}

fn bracketed(estimate: &Estimate, shown: fn(f64) -> String) -> String {
    estimate.interval.map_or(String::new(), |interval| {
        format!(
            " [{}]",
            [interval.lower, interval.upper].map(shown).join(", ")
        )
    })
}

fn parameters(one: &StaticEffect) -> Value {
    let parameters: Vec<Value> = one
        .estimates
        .iter()
        .map(|estimate| {
            json!({
                "name": estimate.name,
                "value": estimate.value,
                "ci95": estimate.interval.map(|interval| [interval.lower, interval.upper]),
                "unit": estimate.unit,
                "literature": null,
            })
        })
        .collect();
    json!(parameters)
}

fn finding(one: &StaticEffect) -> Value {
    let score =
        |score: &StaticScore| json!({"rmse": score.rmse, "unit": score.unit, "bic": score.bic});
    json!({
        "effect": one.effect,
        "could_also_be": [],
        "probability": null,
        "parameters": parameters(one),
        "literature": null,
        "plausible": null,
        "contribution": null,
        "sentence": sentence(one),
        "without": score(&one.without),
        "with": score(&one.with),
    })
}
