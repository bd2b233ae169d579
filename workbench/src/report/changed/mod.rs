//! Report of `sma diagnose --reference`: text for people, JSON for programs.

use std::fmt::Write;

use comfy_table::{Cell, Table};
use missing_physics::{
    Change, ChangeVerdict, Changed, Changing, Considered, FEWEST_COOLINGS, FEWEST_RUNS,
    LEAST_UNCHANGED,
};
use serde_json::{Value, json};

use super::label::label;
use super::number::{behind, percent, significant, spoken};
use super::table::{right, table, unpadded};
use super::words::{capitalized, wrapped};

mod advice;
mod reasons;
mod runs_used;
mod spread;

pub(crate) use advice::advice;
pub(crate) use reasons::{how_to_read, reasons};
pub(crate) use runs_used::runs_used;
pub(crate) use spread::{HOW_TO_READ_SPREAD, spread};

/// Changes that a person reads; JSON has all.
const ROWS: usize = 6;

/// Probability that is not told from certainty.
const CERTAIN: f64 = 0.995;

/// Share of the samples that is not told from all.
const ALL: f64 = 0.995;

/// Probability that a page does not tell from 0.
const NOT_ZERO: f64 = 0.001;

/// The result of `sma diagnose --reference`.
#[derive(Debug)]
pub struct SinceReference<'a> {
    /// Change since the reference.
    pub change: &'a Change,
    /// The seed.
    pub seed: u64,
    /// Notes beside the result.
    pub notes: Vec<String>,
}

impl SinceReference<'_> {
    /// For people.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = wrapped(&self.headline()) + "\n" + &wrapped(&self.errors()) + "\n";
        if self.change.verdict != ChangeVerdict::ReferenceTooShort {
            let _ = write!(
                text,
                "\nChanges that were considered, the likeliest first (probability against no change and all others)\n{}\n",
                self.considered()
            );
        }
        let _ = write!(
            text,
            "\nRuns of the reference, each met by laws from the others\n{}\n",
            self.left_out()
        );
        let _ = write!(text, "\nRuns since\n{}\n", self.runs());
        unpadded(&text)
    }

    /// Verdict in capitals, and its sentence.
    pub(crate) fn headline(&self) -> String {
        let class = self.change.verdict.id().replace('_', " ").to_uppercase();
        format!("{class}: {}", self.verdict())
    }

    fn verdict(&self) -> String {
        let change = self.change;
        match (change.verdict, &change.finding) {
            (ChangeVerdict::Unchanged, _) if change.unchanged < LEAST_UNCHANGED => format!(
                "nothing has changed since the reference that these runs could show: they leave {} times what a run of it that was left out does.",
                spoken(change.excess[0])
            ),
            (ChangeVerdict::Unchanged, _) => {
                let likeliest = change.considered.first();
                let likeliest = likeliest.map(|one| {
                    let share = probability(one.probability);
                    format!(", and the likeliest change, {}, to {share}", name(one.what))
                });
                format!(
                    "nothing has changed since the reference that these runs could show: no change is probable to {}{}.",
                    probability(change.unchanged),
                    likeliest.unwrap_or_default()
                )
            }
            (ChangeVerdict::ReferenceTooShort, _) => format!(
                "no name can be given. The reference has {} of at least {FEWEST_RUNS} runs, and cools {} of at least {FEWEST_COOLINGS} \
                 times through the loop. Record more runs of the rig as it should be, each with a slow cooling.",
                change.left_out.len().max(1),
                change.coolings
            ),
            (ChangeVerdict::Changed, Some(finding)) => {
                let mut said = said(&finding.leading);
                if !finding.could_also_be.is_empty() {
                    let others = finding.could_also_be.iter().map(|other| name(*other));
                    let others: Vec<String> = others.collect();
                    let _ = write!(
                        said,
                        " It could also be: {}. These runs do not tell them apart.",
                        others.join(", ")
                    );
                }
                said
            }
            _ => format!(
                "something has changed since the reference, and no single effect or law accounts for it: these runs leave {} times \
                 what a run of the reference left at most. Or they go where the reference did not: record runs of the same drive.",
                spoken(change.excess[0])
            ),
        }
    }

    /// How well the laws do.
    pub(crate) fn errors(&self) -> String {
        let change = self.change;
        let unit = behind(&change.output_unit);
        let rms = |squares: &mut dyn Iterator<Item = f64>| {
            let (n, sum) = squares.fold((0, 0.0), |(n, sum), one| (n + 1, sum + one * one));
            (sum / f64::from(n.max(1))).sqrt()
        };
        let of_runs = |k: usize| rms(&mut change.runs.iter().map(|(_, errors)| errors[k]));
        let reference = rms(&mut change.left_out.iter().map(|one| one.rmse));
        let mut said = String::new();
        if !change.left_out.is_empty() {
            let _ = write!(
                said,
                "Laws of the reference leave {}{unit} of a run of it that they do not know, and ",
                spoken(reference)
            );
        }
        let _ = write!(said, "{}{unit} of the runs since", spoken(of_runs(0)));
        if change.finding.is_some() {
            let _ = write!(said, ", {}{unit} with the change", spoken(of_runs(1)));
        }
        said += "; surroundings, heat loss and stroke of each run are its own.";
        if change.share_compared < ALL {
            let _ = write!(
                said,
                " {} of the samples since lie in partial loops that the reference does not make, and were not compared.",
                percent(1.0 - change.share_compared)
            );
        }
        said
    }

    fn considered(&self) -> Table {
        let mut table = table(["change", "parameter", "by", "± 95 %", "unit", "probability"]);
        for one in self.change.considered.iter().take(ROWS) {
            table.add_row([
                Cell::new(name(one.what)),
                Cell::new(one.parameter),
                right(significant(one.change)),
                right(half(one).map_or("not fixed".to_owned(), significant)),
                Cell::new(&one.unit),
                right(probability(one.probability)),
            ]);
        }
        table
    }

    /// The finding and its alternatives, a row each.
    pub(crate) fn found(&self, finding: &Changed) -> Table {
        let mut table = table([
            "change",
            "parameter",
            "by",
            "95 % interval",
            "unit",
            "probability",
        ]);
        let leading = finding.leading.what;
        let others = finding.could_also_be.iter().copied();
        let rows = std::iter::once(leading).chain(others).filter_map(|what| {
            let mut all = self.change.considered.iter();
            all.find(|one| one.what == what)
        });
        for (k, one) in rows.enumerate() {
            let interval = one.ci95.map_or("not fixed".to_owned(), |ends| {
                let [lower, upper] = ends.map(significant);
                format!("{lower} … {upper}")
            });
            let what = name(one.what);
            table.add_row([
                Cell::new(match k {
                    0 => capitalized(&what),
                    _ => format!("or {what}"),
                }),
                Cell::new(one.parameter),
                right(significant(one.change)),
                right(interval),
                Cell::new(&one.unit),
                right(probability(one.probability)),
            ]);
        }
        table
    }

    /// Probability that nothing has changed.
    pub(crate) fn unchanged(&self) -> String {
        likelihood(self.change.unchanged)
    }

    /// A recording's name for people.
    pub(crate) fn label<'n>(&self, name: &'n str) -> &'n str {
        label(name, self.names())
    }

    fn names(&self) -> impl Iterator<Item = &str> {
        let reference = self.change.left_out.iter().map(|one| one.name.as_str());
        reference.chain(self.change.runs.iter().map(|(name, _)| name.as_str()))
    }

    fn left_out(&self) -> Table {
        let error = format!("error, {}", self.change.output_unit);
        let mut table = table(["recording", &error]);
        for one in &self.change.left_out {
            table.add_row([
                Cell::new(label(&one.name, self.names())),
                right(significant(one.rmse)),
            ]);
        }
        table
    }

    fn runs(&self) -> Table {
        let unit = &self.change.output_unit;
        let errors = [
            format!("error unchanged, {unit}"),
            format!("with the likeliest change, {unit}"),
        ];
        let mut table = table(["recording", &errors[0], &errors[1]]);
        for (name, [before, after]) in &self.change.runs {
            table.add_row([
                Cell::new(label(name, self.names())),
                right(significant(*before)),
                right(significant(*after)),
            ]);
        }
        table
    }

    /// For programs.
    #[must_use]
    pub fn json(&self) -> Value {
        let change = self.change;
        let what = |what: Changing| {
            let kind = match what {
                Changing::Appeared(_) => "appeared",
                Changing::Grown(_) => "grown",
                Changing::Law(_) => "law",
            };
            json!({"id": what.id(), "kind": kind})
        };
        let considered = |one: &Considered| {
            let mut row = what(one.what);
            row["parameter"] = json!(one.parameter);
            row["unit"] = json!(one.unit);
            row["change"] = json!(one.change);
            row["ci95"] = json!(one.ci95);
            row["probability"] = json!(one.probability);
            row["nats"] = json!(one.nats);
            row
        };
        let finding = change.finding.as_ref().map(|finding| {
            let mut found = considered(&finding.leading);
            let others = finding.could_also_be.iter();
            found["could_also_be"] = others.map(|other| what(*other)).collect();
            found["sentence"] = json!(capitalized(&said(&finding.leading)));
            found
        });
        let left_out = change.left_out.iter();
        let left_out =
            left_out.map(|one| json!({"recording": one.name, "rmse": one.rmse, "nats": one.nats}));
        let runs = change.runs.iter();
        let runs = runs.map(|(name, [before, after])| json!({"recording": name, "rmse": before, "rmse_changed": after}));
        json!({
            "command": "diagnose",
            "verdict": change.verdict.id(),
            "finding": finding,
            "probability_unchanged": change.unchanged,
            "considered": change.considered.iter().map(considered).collect::<Value>(),
            "reference": {
                "coolings": change.coolings,
                "effects": change.laws.iter().map(|effect| effect.id()).collect::<Vec<_>>(),
                "left_out": left_out.collect::<Value>(),
            },
            "runs": runs.collect::<Value>(),
            "excess": change.excess,
            "share_compared": change.share_compared,
            "output_unit": change.output_unit,
            "seed": self.seed,
        })
    }
}

/// A change in a sentence.
fn said(one: &Considered) -> String {
    let size = match half(one) {
        Some(half) => format!("{} ± {}", spoken(one.change), spoken(half)),
        None => spoken(one.change),
    };
    let unit = match one.unit.as_str() {
        "1" => String::new(),
        unit => behind(unit),
    };
    let verb = match one.what {
        Changing::Appeared(_) => "has appeared",
        Changing::Grown(_) => "is of another size",
        Changing::Law(_) => "is another",
    };
    format!(
        "since the reference, {} {verb}: {} by {size}{unit} (probability {}).",
        name(one.what),
        one.parameter,
        probability(one.probability)
    )
}

fn name(what: Changing) -> String {
    match what {
        Changing::Appeared(effect) | Changing::Grown(effect) => effect.info().name.to_owned(),
        Changing::Law(parameter) => format!("the parameter {parameter}"),
    }
}

/// Half of the interval.
fn half(one: &Considered) -> Option<f64> {
    one.ci95.map(|[lower, upper]| 0.5 * (upper - lower))
}

/// A probability on a page, never 0 nor 100 %.
fn likelihood(value: f64) -> String {
    if value < NOT_ZERO {
        "< 0.1 %".to_owned()
    } else {
        probability(value)
    }
}

fn probability(value: f64) -> String {
    if value > CERTAIN {
        "> 99 %".to_owned()
    } else {
        percent(value)
    }
}
