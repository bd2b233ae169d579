//! Numbers that are not there.

use crate::adapt::Done;
use crate::adapt::guess::Roles;
use crate::adapt::table::Table;

/// Rows one after another that may lack a number.
const LONGEST: usize = 5;

/// Share of the rows that may.
const MOST: f64 = 0.05;

/// Fills in the few numbers that a column lacks: a drive is held, all else goes straight from one neighbor to the next. Where more
/// are missing, the reader refuses the first.
pub(super) fn fill(table: &mut Table, roles: &Roles, done: &mut Done) {
    let n_columns = table
        .rows
        .iter()
        .map(|row| row.fields.len())
        .max()
        .unwrap_or(0);
    for column in (0..n_columns).filter(|column| Some(*column) != roles.time) {
        let lacking: Vec<usize> = (0..table.rows.len())
            .filter(|&k| table.rows[k].lacks(column))
            .collect();
        if lacking.is_empty() || lacking.len() as f64 > MOST * table.rows.len() as f64 {
            continue;
        }
        let is_held = Some(column) == roles.drive;
        fill_column(table, column, &lacking, is_held, done);
    }
}

fn fill_column(
    table: &mut Table,
    column: usize,
    lacking: &[usize],
    is_held: bool,
    done: &mut Done,
) {
    let name = table.names.as_ref().and_then(|names| names.get(column));
    let name = name.map_or_else(
        || format!("column {}", column + 1),
        |name| format!("\"{name}\""),
    );
    let how = if is_held {
        "the one before holds"
    } else {
        "taken from its neighbors"
    };
    let what = format!("{name} has no number: {how}");
    let value = |table: &Table, k: usize| table.rows.get(k).and_then(|row| row.value(column));
    for &k in lacking {
        let before = (1..=LONGEST).find_map(|far| {
            let place = k.checked_sub(far)?;
            Some((far, value(table, place)?))
        });
        let after = (1..=LONGEST).find_map(|far| Some((far, value(table, k + far)?)));
        let filled = match (before, after) {
            (Some((_, before)), _) if is_held => before,
            (Some((back, before)), Some((ahead, after))) if back + ahead <= LONGEST + 1 => {
                before + (after - before) * back as f64 / (back + ahead) as f64
            }
            _ => return,
        };
        done.at_line(&what, table.rows[k].line);
        table.rows[k].fields[column] = filled.to_string();
    }
}
