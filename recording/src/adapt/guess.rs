//! Which column is what, by the words in its name.

use crate::adapt::Done;
use crate::adapt::table::Table;
use crate::columns::{ColumnKey, ColumnSpec, Columns};
use crate::error::RecordingError;
use crate::layout::Role;
use crate::quantity::Quantity;
use crate::unit::{normalized, split_name};

/// The columns that matter here, counted from 0.
#[derive(Debug)]
pub(super) struct Roles {
    pub(super) time: Option<usize>,
    pub(super) drive: Option<usize>,
}

pub(crate) const TIME: [&str; 8] = [
    "time",
    "t",
    "zeit",
    "timestamp",
    "datetime",
    "elapsed",
    "temps",
    "tiempo",
];
pub(crate) const OUTPUT: [&str; 8] = [
    "displacement",
    "position",
    "weg",
    "x",
    "stroke",
    "hub",
    "deflection",
    "lvdt",
];

/// Words for outputs that are no displacement.
pub(crate) const OTHER_OUTPUT: [&str; 8] = [
    "angle",
    "winkel",
    "force",
    "kraft",
    "load",
    "strain",
    "dehnung",
    "extension",
];
pub(crate) const TEMPERATURE: [&str; 5] =
    ["temperature", "temperatur", "temp", "thermocouple", "tc"];
pub(crate) const AMBIENT: [&str; 7] = [
    "ambient",
    "ambiente",
    "room",
    "air",
    "surroundings",
    "umgebung",
    "raum",
];
/// Words for a drive of whatever kind.
pub(crate) const ANY_DRIVE: [&str; 4] = ["drive", "input", "command", "control"];

/// True if a column's name, without its unit, holds one of some words. A single letter counts only if it is the whole name.
pub(crate) fn is_called(name: &str, words: &[&str]) -> bool {
    let stem = split_name(name).0.to_lowercase();
    let mut own = stem.split(|c: char| !c.is_alphanumeric());
    own.any(|word| words.contains(&word) && (word.len() > 1 || word == stem))
}

/// Words for a drive of a quantity.
pub(crate) fn of_drive(quantity: Quantity) -> &'static [&'static str] {
    match quantity {
        Quantity::Current => &["current", "strom", "i", "courant", "corriente"],
        Quantity::Duty => &["duty", "pwm"],
        Quantity::Voltage => &["voltage", "spannung", "u", "v", "tension"],
        Quantity::Power => &["power", "leistung", "p"],
        Quantity::Temperature => &["temperature", "temperatur", "temp"],
    }
}

/// Finds the columns; one that no default name fits is called by the default name if its words leave no doubt.
///
/// # Errors
///
/// [`RecordingError::MissingUnit`] for one of these that has no unit and needs one.
pub(super) fn roles(
    table: &mut Table,
    file: &str,
    columns: &Columns,
    quantity: Quantity,
    done: &mut Done,
) -> Result<Roles, RecordingError> {
    let drive = split_name(quantity.column()).0;
    let mut find = |role: &Role, spec: Option<&ColumnSpec>, words: &[&str], name: &str| match spec {
        Some(spec) => Ok(placed(spec, table.names.as_deref())),
        None => taken(table, file, role, words, name, done),
    };
    let time = find(&Role::TIME, columns.time.as_ref(), &TIME, "time")?;
    let own = columns.drive.as_ref();
    let drive = find(&Role::drive(quantity), own, of_drive(quantity), drive)?;
    find(
        &Role::OUTPUT,
        columns.output.as_ref(),
        &OUTPUT,
        "displacement",
    )?;
    Ok(Roles { time, drive })
}

/// Where a column that was asked for stands.
fn placed(spec: &ColumnSpec, names: Option<&[String]>) -> Option<usize> {
    match &spec.key {
        ColumnKey::Number(number) => number.checked_sub(1),
        ColumnKey::EveryS(_) => None,
        ColumnKey::Name(name) => {
            let is_it = |present: &String| {
                normalized(present) == normalized(name)
                    || split_name(present).0.eq_ignore_ascii_case(name.trim())
            };
            names?.iter().position(is_it)
        }
    }
}

/// The column of a default name, or else the one whose words fit, from now on of that name.
fn taken(
    table: &mut Table,
    file: &str,
    role: &Role,
    words: &[&str],
    name: &str,
    done: &mut Done,
) -> Result<Option<usize>, RecordingError> {
    let names = table.names.as_deref().unwrap_or_default();
    if let Some(index) = role.default_in(names) {
        return Ok(Some(index));
    }
    let mut fitting = (0..names.len()).filter(|&k| is_called(&names[k], words));
    let (Some(index), None) = (fitting.next(), fitting.next()) else {
        return Ok(None);
    };
    let present = names[index].clone();
    let called = match split_name(&present).1 {
        Some(unit) => format!("{name} [{unit}]"),
        None if role.needs_unit() && !table.holds_stamps(index) => {
            return Err(RecordingError::MissingUnit {
                file: file.to_owned(),
                line: table.header_line as u64,
                role: role.key,
                column: present,
                accepted: role.units_text,
            });
        }
        None => name.to_owned(),
    };
    done.of_file(format!(
        "\"{present}\" is taken for the {}, as \"{called}\"",
        role.key
    ));
    if let Some(names) = &mut table.names {
        names[index] = called;
    }
    Ok(Some(index))
}
