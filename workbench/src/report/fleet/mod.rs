//! Report of `sma batch`: a row a rig, and which physics is in how many of them.

mod csv;
mod picture;
mod row;
#[cfg(test)]
mod tests;

use std::fmt::Write;

use comfy_table::Table;
use serde_json::{Value, json};

pub use picture::{InRigs, Spread};
pub use row::{Estimated, Found, Row, RowStatus, named};

use super::number::{behind, spoken};
use super::table::{folding, right, table, unpadded};

/// Rigs without a result that the text names; a table names all.
const MOST_NAMED: usize = 25;

/// Result of a fleet.
#[derive(Debug)]
pub struct FleetReport<'a> {
    /// Command that was run on each rig: `diagnose` or `identify`.
    pub command: &'a str,
    /// The seed.
    pub seed: u64,
    /// A row a rig.
    pub rows: Vec<Row>,
    /// Files that were left out.
    pub left_out: &'a [String],
}

impl FleetReport<'_> {
    /// Rigs of a status.
    pub fn of(&self, status: RowStatus) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(move |row| row.status == status)
    }

    /// The first sentence.
    #[must_use]
    pub fn head(&self) -> String {
        let count = |status| self.of(status).count();
        let n_open = count(RowStatus::Open);
        let open = if n_open > 0 {
            format!(", {n_open} not run yet")
        } else {
            String::new()
        };
        let n_done = count(RowStatus::Done);
        let n_unsound = n_done - self.sound().count();
        let unsound = if n_unsound > 0 {
            format!(" ({n_unsound} not to be used)")
        } else {
            String::new()
        };
        format!(
            "{} {}: {n_done} with a result{unsound}, {} failed{open}.",
            self.rows.len(),
            if self.rows.len() == 1 { "rig" } else { "rigs" },
            count(RowStatus::Failed),
        )
    }

    /// For people.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = self.head() + "\n";
        let verdicts = self.verdicts();
        if !verdicts.is_empty() {
            let _ = write!(text, "\n{}\n", self.verdict_table());
        }
        let physics = self.physics();
        if !physics.is_empty() {
            let _ = write!(text, "\n{}\n", self.physics_table());
        }
        let spreads = self.spreads();
        if !spreads.is_empty() {
            let _ = write!(text, "\n{}\n", self.spread_table());
        }
        let without: Vec<&Row> = self.without_result().collect();
        for row in without.iter().take(MOST_NAMED) {
            let _ = write!(text, "\n{}", row.said());
        }
        if without.len() > MOST_NAMED {
            let n_more = without.len() - MOST_NAMED;
            let _ = write!(text, "\nand {n_more} more; --csv names all");
        }
        if !without.is_empty() {
            text.push('\n');
        }
        unpadded(&text)
    }

    /// Rigs whose result is to be used.
    pub fn sound(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| row.is_sound())
    }

    /// Rigs that failed or were not run.
    pub fn without_result(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| row.status != RowStatus::Done)
    }

    /// Verdicts, in how many rigs.
    #[must_use]
    pub fn verdict_table(&self) -> Table {
        let mut verdicts = table(["verdict", "rigs", "of those with a result"]);
        let n_done = self.of(RowStatus::Done).count();
        for (verdict, n_rigs) in self.verdicts() {
            verdicts.add_row([
                comfy_table::Cell::new(verdict),
                right(n_rigs.to_string()),
                right(share(n_rigs, n_done)),
            ]);
        }
        verdicts
    }

    /// Physics that was found, in how many rigs, and how large.
    #[must_use]
    pub fn physics_table(&self) -> Table {
        let mut physics = table([
            "missing physics",
            "rigs",
            "of those to be used",
            "or another",
            "size: lowest … median … highest",
        ]);
        let n_sound = self.sound().count();
        for one in self.physics() {
            physics.add_row([
                comfy_table::Cell::new(&one.effect),
                right(one.named.to_string()),
                right(share(one.named, n_sound)),
                right(one.ambiguous.to_string()),
                comfy_table::Cell::new(one.size.as_ref().map_or(String::new(), Spread::said)),
            ]);
        }
        physics
    }

    /// Parameters over the fleet.
    #[must_use]
    pub fn spread_table(&self) -> Table {
        let mut parameters = table(["parameter", "rigs", "lowest", "median", "highest", "unit"]);
        for one in self.spreads() {
            parameters.add_row([
                comfy_table::Cell::new(&one.name),
                right(one.n_rigs.to_string()),
                right(super::number::significant(one.lowest)),
                right(super::number::significant(one.median)),
                right(super::number::significant(one.highest)),
                comfy_table::Cell::new(&one.unit),
            ]);
        }
        parameters
    }

    /// Rigs with a result, a row each.
    #[must_use]
    pub fn rig_table(&self) -> Table {
        let mut rigs = table([
            "rig",
            "verdict",
            "found",
            "error, training",
            "unseen",
            "with what was found: training",
            "unseen",
            "noise",
            "unit",
        ]);
        let cell = |value: Option<f64>| right(value.map_or(String::new(), spoken));
        for row in self.of(RowStatus::Done) {
            let found: Vec<String> = row.findings.iter().map(said).collect();
            rigs.add_row([
                comfy_table::Cell::new(&row.rig),
                comfy_table::Cell::new(row.verdict.as_deref().unwrap_or_default()),
                comfy_table::Cell::new(found.join("; ")),
                cell(row.train_rmse),
                cell(row.validate_rmse),
                cell(row.extended_train_rmse),
                cell(row.extended_validate_rmse),
                cell(row.noise_upper),
                comfy_table::Cell::new(row.output_unit.as_deref().unwrap_or_default()),
            ]);
        }
        rigs
    }

    /// Rigs without a result, and why.
    #[must_use]
    pub fn failure_table(&self) -> Table {
        let mut failures = folding(["rig", "reason"]);
        for row in self.without_result() {
            failures.add_row([row.rig.as_str(), row.sentence()]);
        }
        failures
    }

    /// For programs.
    #[must_use]
    pub fn json(&self) -> Value {
        let verdicts = self.verdicts().into_iter();
        let verdicts: Vec<Value> = verdicts
            .map(|(verdict, n_rigs)| json!({"verdict": verdict, "rigs": n_rigs}))
            .collect();
        json!({
            "schema_version": 1,
            "command": "batch",
            "version": env!("CARGO_PKG_VERSION"),
            "seed": self.seed,
            "do": self.command,
            "counts": {
                "done": self.of(RowStatus::Done).count(),
                "to_be_used": self.sound().count(),
                "failed": self.of(RowStatus::Failed).count(),
                "open": self.of(RowStatus::Open).count(),
            },
            "verdicts": verdicts,
            "physics": self.physics().iter().map(InRigs::json).collect::<Vec<_>>(),
            "parameters": self.spreads().iter().map(Spread::json).collect::<Vec<_>>(),
            "rigs": self.rows.iter().map(Row::json).collect::<Vec<_>>(),
            "left_out": self.left_out,
        })
    }
}

/// A finding in a few words.
fn said(found: &Found) -> String {
    let size = found.parameters.first();
    let size = size.map_or(String::new(), |size| {
        format!(" {}{}", spoken(size.value), behind(&size.unit))
    });
    let others: String = found
        .could_also_be
        .iter()
        .map(|other| format!(" or {other}"))
        .collect();
    format!("{}{size}{others}", found.effect)
}

fn share(n_rigs: usize, of: usize) -> String {
    super::number::spoken_percent(n_rigs as f64 / of.max(1) as f64)
}
