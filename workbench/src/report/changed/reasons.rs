//! Table of the changes that were considered, each with the reason why it is named or is not.

use comfy_table::{Cell, Table};
use missing_physics::{Change, LEAST_UNCHANGED, MOST_EXCESS, Standing};

use super::{half, name, probability};
use crate::report::number::{significant, spoken, spoken_percent};
use crate::report::table::{right, table};
use crate::report::words::capitalized;

/// All of them, the likeliest first.
pub(crate) fn reasons(change: &Change) -> Table {
    let header = [
        "change",
        "parameter",
        "by",
        "± 95 %",
        "unit",
        "evidence, nats",
        "probability",
        "named?",
    ];
    let mut table = table(header);
    for (one, standing) in change.considered.iter().zip(change.standings()) {
        table.add_row([
            Cell::new(capitalized(&name(one.what))),
            Cell::new(one.parameter),
            right(significant(one.change)),
            right(half(one).map_or("not fixed".to_owned(), significant)),
            Cell::new(&one.unit),
            right(format!("{:.1}", one.nats)),
            right(probability(one.probability)),
            Cell::new(reason(change, standing)),
        ]);
    }
    table
}

fn reason(change: &Change, standing: Standing) -> String {
    let unchanged = probability(change.unchanged);
    match standing {
        Standing::Named => format!(
            "named: no change keeps {unchanged} (needs < {})",
            spoken_percent(LEAST_UNCHANGED)
        ),
        Standing::CouldAlsoBe => "could also be: these runs do not exclude it".to_owned(),
        Standing::PartOfNamed => "named in another row".to_owned(),
        Standing::LessLikely => "no: likelier changes account for these runs".to_owned(),
        Standing::NoChangeIsLikely => format!(
            "no: no change keeps {unchanged} (a name needs < {})",
            spoken_percent(LEAST_UNCHANGED)
        ),
        Standing::LeavesTooMuch => format!(
            "no: with it these runs leave {} times what a run of the reference left at most (a name needs ≤ {}, or 80 % of the excess \
             explained)",
            spoken(change.excess[1]),
            spoken(MOST_EXCESS)
        ),
        Standing::ReferenceTooShort => "no: the reference is too short for a name".to_owned(),
    }
}
