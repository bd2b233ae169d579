//! Report of a blind trial: text for people, JSON for programs.

use blind_trial::Proportion;
use blind_trial::scores::{Became, FOLLOWED, Figure, Score, Scores, VISIBLE_T};
use comfy_table::{Cell, Table};
use serde_json::{Value, json};

use super::number::percent;
use super::table::{folding, right, table, unpadded};

/// A trial whose seals were opened.
#[derive(Debug)]
pub struct Tried<'a> {
    /// The seed.
    pub seed: &'a str,
    /// Cases that were diagnosed.
    pub n_cases: usize,
    /// True if the cases were drawn around a user's rig.
    pub is_own: bool,
    /// Scores of the cases.
    pub scores: Scores,
}

impl Tried<'_> {
    /// Quantities and their targets.
    #[must_use]
    pub fn table(&self) -> Table {
        let mut scores = table(["quantity", "figure", "target", ""]);
        for score in &self.scores.table {
            scores.add_row(vec![
                score.quantity.clone(),
                score.figure.to_string(),
                score.target_text(),
                mark(score).to_owned(),
            ]);
        }
        scores
    }

    /// Outcome for each effect, by its size over the usual one.
    #[must_use]
    pub fn reach(&self) -> Table {
        let mut reach = table([
            "concealed",
            "half its usual size",
            "usual size",
            "twice that",
        ]);
        for row in &self.scores.reach.rows {
            let at = |size: f64| {
                let of_size = row
                    .sizes
                    .iter()
                    .filter(|(one, _)| (one - size).abs() < 1e-9);
                let words: Vec<&str> = of_size.map(|(_, became)| became.as_str()).collect();
                words.join(", ")
            };
            reach.add_row([row.addition.clone(), at(0.5), at(1.0), at(2.0)]);
        }
        reach
    }

    /// The result for people.
    #[must_use]
    pub fn text(&self) -> String {
        if self.is_own {
            return unpadded(&format!("{}\n\n{}\n", self.head(), self.reach()));
        }
        let mut power = table(["oracle score from", "in the stated set", "top-1"]);
        for bin in &self.scores.power.bins {
            power.add_row(vec![
                right(format!("{}", bin.from_t)),
                right(bin.stated.to_string()),
                right(bin.top.to_string()),
            ]);
        }
        let mut text = format!(
            "{}\n\n{}\n\nSingle effects, over how visible they were:\n\n{power}\n",
            self.head(),
            self.table()
        );
        if let Some(margins) = self.margins() {
            text += &format!(
                "\nThe same with the threshold of one rule times a factor; of a share or a probability above a half, what it lacks of 1 \
                 is multiplied. Equal shares are left out:\n\n{margins}\n"
            );
        }
        if let Some(audits) = self.audits() {
            text += &format!(
                "\nPart of what is left that a curve without physics predicts on blocks it has not seen: median share of the square, \
                 and cases in which chance does as much in at most 1 %:\n\n{audits}\n"
            );
        }
        if let Some(others) = self.others() {
            text += &format!("\nOther methods on the same files:\n\n{others}\n");
        }
        unpadded(&text)
    }

    /// Figures with the threshold of a rule moved, if the diagnoses noted them.
    #[must_use]
    pub fn margins(&self) -> Option<Table> {
        let margins = self.scores.margins.as_ref()?;
        let head = ["rule", "factor", "cases changed"].into_iter();
        let mut table = folding(head.chain(FOLLOWED).collect::<Vec<_>>());
        let decided = margins.decided.map(|share| right(counted(share)));
        table.add_row(
            ["as decided", "", ""]
                .map(Cell::new)
                .into_iter()
                .chain(decided),
        );
        for row in &margins.rows {
            let pairs = row.shares.iter().zip(&margins.decided);
            let moved = pairs.map(|(moved, decided)| {
                let is_equal = moved == decided;
                right(if is_equal {
                    String::new()
                } else {
                    counted(*moved)
                })
            });
            let first = [
                Cell::new(row.rule),
                right(row.factor.to_string()),
                right(row.n_changed.to_string()),
            ];
            table.add_row(first.into_iter().chain(moved));
        }
        Some(table)
    }

    /// Predictions of residuals by a curve, if the diagnoses noted them.
    #[must_use]
    pub fn audits(&self) -> Option<Table> {
        if self.scores.audits.is_empty() {
            return None;
        }
        let mut table = folding([
            "concealed",
            "of the baseline model",
            "beyond chance",
            "of the model with what was found",
            "beyond chance",
        ]);
        for audited in &self.scores.audits {
            let cells = [&audited.baseline, &audited.extended]
                .into_iter()
                .flat_map(|one| {
                    let share = one.share.map_or_else(|| "–".to_owned(), percent);
                    [right(share), right(counted(one.beyond_chance))]
                });
            table.add_row(std::iter::once(Cell::new(&audited.kind)).chain(cells));
        }
        Some(table)
    }

    /// Other methods on the same files, if any was asked.
    #[must_use]
    pub fn others(&self) -> Option<Table> {
        let methods = &self.scores.others.methods;
        if methods.is_empty() {
            return None;
        }
        let mut others = folding([
            "method",
            "finds something: clean",
            "with a visible effect",
            "names it first",
            "explains of the unseen error",
        ]);
        for method in methods {
            let or_nothing = |text: Option<String>| text.unwrap_or_else(|| "–".to_owned());
            others.add_row(vec![
                method.name.to_owned(),
                method.false_alarms.to_string(),
                method.alarms.to_string(),
                or_nothing(method.named.map(|share| share.to_string())),
                or_nothing(method.explained.map(|figure| figure.to_string())),
            ]);
        }
        Some(others)
    }

    /// The first sentence.
    pub fn head(&self) -> String {
        if self.is_own {
            return self.revealed();
        }
        let with_target = self.scores.table.iter().filter_map(Score::holds);
        let (held, all) = with_target.fold((0, 0), |(held, all), holds| {
            (held + usize::from(holds), all + 1)
        });
        format!(
            "{} cases of seed {}: {held} of {all} targets are met. Every answer was sealed before its case was \
             diagnosed, and every seal holds.\nEffects count as visible from an oracle score of {VISIBLE_T}; intervals \
             are exact 95 % intervals.",
            self.n_cases, self.seed
        )
    }

    /// Effects that an experiment like the user's can reveal, in words.
    fn revealed(&self) -> String {
        let usual = self.scores.reach.rows.iter().flat_map(|row| &row.sizes);
        let usual = usual.filter(|(size, _)| (size - 1.0).abs() < 1e-9);
        let count = |wanted: &[Became]| {
            let of_kind = usual.clone().filter(|(_, became)| wanted.contains(became));
            of_kind.count()
        };
        format!(
            "Of {} effects of their usual size this experiment would name {}, leave {} among several, and miss {}; {} nobody could \
             see in it.\nRigs like yours: what the rod file says is so, the rest is drawn from seed {}. Every answer was sealed \
             before its case was diagnosed, and every seal holds.",
            usual.clone().count(),
            count(&[Became::Named]),
            count(&[Became::InSet, Became::Suspected]),
            count(&[Became::Missed]),
            count(&[Became::Hidden]),
            self.seed
        )
    }

    /// The result for programs.
    pub fn json(&self) -> Value {
        let confusion = &self.scores.confusion;
        let share = |of: Proportion| json!({"hits": of.hits, "n": of.n});
        json!({
            "schema_version": 1,
            "command": "trial",
            "version": env!("CARGO_PKG_VERSION"),
            "seed": self.seed,
            "cases": self.n_cases,
            "table": self.scores.table.iter().map(row).collect::<Vec<_>>(),
            "power": self.scores.power.bins.iter().map(|bin| json!({
                "oracle_score_from": bin.from_t,
                "in_set": share(bin.stated),
                "top_1": share(bin.top),
            })).collect::<Vec<_>>(),
            "reach": self.scores.reach.rows.iter().map(|row| json!({
                "concealed": row.addition,
                "effect": row.effect,
                "sizes": row.sizes.iter().map(|(size, became)| json!({
                    "size": size,
                    "became": became.as_str(),
                })).collect::<Vec<_>>(),
            })).collect::<Vec<_>>(),
            "confusion": {
                "concealed": confusion.rows,
                "named": confusion.columns,
                "cases": confusion.counts,
            },
            "margins": self.scores.margins.as_ref().map(|margins| json!({
                "followed": FOLLOWED,
                "decided": margins.decided.map(share),
                "rows": margins.rows.iter().map(|row| json!({
                    "rule": row.rule,
                    "factor": row.factor,
                    "changed": row.n_changed,
                    "shares": row.shares.map(share),
                })).collect::<Vec<_>>(),
            })),
            "audits": self.scores.audits.iter().map(|audited| json!({
                "concealed": audited.kind,
                "baseline": {"share": audited.baseline.share, "beyond_chance": share(audited.baseline.beyond_chance)},
                "extended": {"share": audited.extended.share, "beyond_chance": share(audited.extended.beyond_chance)},
            })).collect::<Vec<_>>(),
            "methods": self.scores.others.methods.iter().map(|method| json!({
                "method": method.name,
                "false_alarms": share(method.false_alarms),
                "alarms": share(method.alarms),
                "named_first": method.named.map(share),
                "explained_fraction": method.explained.and_then(|figure| figure.value()),
            })).collect::<Vec<_>>(),
            "calibration": self.scores.calibration.bins.iter().map(|bin| json!({
                "stated": bin.stated, "right": bin.right, "n": bin.n,
            })).collect::<Vec<_>>(),
        })
    }
}

/// So many of so many, without the interval.
fn counted(share: Proportion) -> String {
    format!("{} of {}", share.hits, share.n)
}

/// Mark of a score: target met or not; empty without a target or a case.
fn mark(score: &Score) -> &'static str {
    match score.holds() {
        Some(true) => "met",
        Some(false) => "not met",
        None => "",
    }
}

fn row(score: &Score) -> Value {
    let (hits, n, interval) = match score.figure {
        Figure::Share(share) => {
            let interval = (share.n > 0).then(|| share.interval());
            (Some(share.hits), share.n, interval)
        }
        Figure::Number { n, .. } => (None, n, None),
    };
    json!({
        "quantity": score.quantity.trim(),
        "value": score.figure.value(),
        "hits": hits,
        "n": n,
        "interval_95": interval,
        "target": score.target_text(),
        "met": score.holds(),
    })
}
