//! Table of the changes that were considered, each with the reason why it is named or is not.

use comfy_table::{Cell, Table};
use missing_physics::{
    Change, Considered, LEAST_EXPLAINED, LEAST_UNCHANGED, MOST_EXCESS, Standing,
};

use super::{half, likelihood, name};
use crate::report::number::{significant, spoken, spoken_percent};
use crate::report::table::{right, table};
use crate::report::words::capitalized;

/// Changes that are shown at once.
const FIRST: usize = 8;

/// How to read the table, with what a name needs.
pub(crate) fn how_to_read(change: &Change) -> String {
    format!(
        "Evidence: logarithm of how much likelier these runs are with the change than without, its size integrated out. Probability: against no \
         change, which has half before the runs are seen, and all others. A unit of 1: of the parameter's logarithm, or a share. The \
         likeliest change is named if no change keeps less than {} (here {}), the runs leave more without a change than a run of the reference \
         that was left out (here {} times as much), and they leave at most {} times what a run of the \
         reference left (here {}) or, of an effect with a form of its own, {} of the excess is explained. \"Could also be\" are those that are needed to hold 95 % of the probability that something has changed, and those within a \
         hundredth of its evidence.",
        spoken_percent(LEAST_UNCHANGED),
        likelihood(change.unchanged),
        spoken(change.excess[0]),
        spoken(MOST_EXCESS),
        spoken(change.excess[1]),
        spoken_percent(LEAST_EXPLAINED),
    )
}

/// All of them, the likeliest first, in two tables: those to be read, and the others.
pub(crate) fn reasons(change: &Change) -> [Table; 2] {
    let standings = change.standings();
    let rows = change.considered.iter().zip(standings).enumerate();
    let mut tables = [(); 2].map(|()| {
        table([
            "change",
            "parameter",
            "by",
            "± 95 %",
            "unit",
            "evidence, nats",
            "probability",
            "named?",
        ])
    });
    for (place, (one, standing)) in rows {
        add(
            &mut tables[usize::from(place >= FIRST)],
            one,
            reason(change, one, standing),
        );
    }
    tables
}

fn add(table: &mut Table, one: &Considered, reason: String) {
    table.add_row([
        Cell::new(capitalized(&name(one.what))),
        Cell::new(one.parameter),
        right(significant(one.change)),
        right(half(one).map_or("not fixed".to_owned(), significant)),
        Cell::new(&one.unit),
        right(format!("{:.1}", one.nats)),
        right(likelihood(one.probability)),
        Cell::new(reason),
    ]);
}

fn reason(change: &Change, one: &Considered, standing: Standing) -> String {
    let effect = one.what.effect();
    match standing {
        Standing::Named => "named".to_owned(),
        Standing::CouldAlsoBe => "could also be".to_owned(),
        Standing::PartOfNamed => "named in another row".to_owned(),
        Standing::LessLikely => "no: less likely".to_owned(),
        Standing::NoChangeIsLikely => "no: no change is likely".to_owned(),
        Standing::WithinReference => "no: runs of the reference differ as much".to_owned(),
        Standing::LeavesTooMuch if effect.is_some_and(|effect| effect.info().flexible) => format!(
            "no: leaves {} × the reference; what can take any shape needs ≤ {}",
            spoken(change.excess[1]),
            spoken(MOST_EXCESS)
        ),
        Standing::LeavesTooMuch => {
            format!("no: leaves {} × the reference", spoken(change.excess[1]))
        }
        Standing::ReferenceTooShort => "no: reference too short".to_owned(),
    }
}
