//! Table of the runs that were compared.

use comfy_table::{Cell, Table};
use recording::Recording;

use super::SinceReference;
use crate::report::number::{count, significant, spoken};
use crate::report::table::{right, table};
use crate::sanity::duration_s;

/// All runs, those of the reference first: length, drive, and how well they are met.
pub(crate) fn runs_used(
    since: &SinceReference<'_>,
    [reference, today]: [&[Recording]; 2],
) -> Table {
    let change = since.change;
    let error = format!("error of the reference's laws, {}", change.output_unit);
    let with = format!("with the likeliest change, {}", change.output_unit);
    let mut table = table([
        "recording",
        "part",
        "samples",
        "lasts, s",
        "largest drive",
        &error,
        &with,
    ]);
    let mut row = |run: &Recording, part: &str, errors: [Option<f64>; 2]| {
        let [error, with] = errors.map(|error| right(error.map_or("-".to_owned(), significant)));
        let drive = match run.drive_unit() {
            "1" => spoken(run.largest_drive()),
            unit => format!("{} {unit}", spoken(run.largest_drive())),
        };
        table.add_row([
            Cell::new(since.label(run.name())),
            Cell::new(part),
            right(count(run.len())),
            right(spoken(duration_s(run))),
            right(drive),
            error,
            with,
        ]);
    };
    for run in reference {
        let own = change.left_out.iter().find(|one| one.name == run.name());
        row(run, "reference", [own.map(|own| own.rmse), None]);
    }
    for run in today {
        let own = change.runs.iter().find(|(name, _)| name == run.name());
        let errors = own.map(|(_, errors)| *errors);
        let each = |k: usize| errors.map(|errors| errors[k]);
        row(run, "since", [each(0), each(1)]);
    }
    table
}
