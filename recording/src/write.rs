//! A recording to CSV.

use std::io::{self, Write};
use std::num::FpCategory;

use crate::recording::Recording;
use crate::sampling::Sampling;
use crate::unit::is_suffix;

/// Writes a recording as CSV that [`parse_csv`](crate::parse_csv) reads back exactly, with default
/// columns and the same drive quantity (the column of an input in a unit of its own must be named; and
/// [`allow_untimed`](crate::ReadOptions::allow_untimed) is needed if it has no time).
///
/// Columns: `time_s`, the drive ([`Quantity::column`](crate::Quantity::column)), that of an antagonist (`antagonist_` and the
/// same, to be named when read), the output as `displacement_mm` (in its unit, whatever it is), `temperature_degc`, `ambient_degc`, `stress_pa`,
/// `resistance_ohm`; those that the recording has. Voltage and current of a resistance are written as
/// `resistance_voltage_v` and `resistance_current_a`, to be named when read. Numbers are the shortest that read back as the same; they are written line
/// by line, so give a buffered writer.
///
/// # Errors
///
/// Those of the writer.
pub fn write_csv(recording: &Recording, mut writer: impl Write) -> io::Result<()> {
    let time = match recording.sampling() {
        Sampling::Untimed => None,
        _ => Some(recording.time_s()),
    };
    let mut columns = vec![
        ("time_s".to_owned(), time),
        (drive_column(recording), Some(recording.drive())),
        (
            format!("antagonist_{}", recording.drive_quantity().column()),
            recording.antagonist_drive(),
        ),
        (
            output_column(recording.output_unit()),
            Some(recording.output()),
        ),
        ("temperature_degc".to_owned(), recording.temperature_degc()),
        ("ambient_degc".to_owned(), recording.ambient_degc()),
        ("stress_pa".to_owned(), recording.stress_pa()),
    ];
    if let Some(resistance) = recording.resistance() {
        let parts = resistance.columns().into_iter();
        columns.extend(parts.map(|(name, _, values)| (name.to_owned(), Some(values))));
    }
    let (names, values): (Vec<String>, Vec<&[f64]>) = columns
        .into_iter()
        .filter_map(|(name, values)| Some((name, values?)))
        .unzip();
    writeln!(writer, "{}", names.join(","))?;
    for k in 0..recording.len() {
        for (j, column) in values.iter().enumerate() {
            if j > 0 {
                writer.write_all(b",")?;
            }
            write_number(&mut writer, column[k])?;
        }
        writer.write_all(b"\n")?;
    }
    Ok(())
}

/// Name of the drive column; an input of a static loop that is no temperature is called `input`.
fn drive_column(recording: &Recording) -> String {
    let quantity = recording.drive_quantity();
    match recording.drive_unit() {
        unit if unit == quantity.unit() => quantity.column().to_owned(),
        unit => quoted(format!("input [{unit}]")),
    }
}

/// Name of an output column in this unit.
fn output_column(unit: &str) -> String {
    if is_suffix(unit) && unit.chars().all(char::is_alphabetic) {
        return format!("displacement_{}", unit.to_lowercase());
    }
    quoted(format!("displacement [{unit}]"))
}

/// A name in quotes, if a reader would take part of it for a delimiter.
fn quoted(name: String) -> String {
    if name.contains(['\t', ';', ',']) {
        format!("\"{name}\"")
    } else {
        name
    }
}

/// The shortest digits that read back as `value`; an extreme one in scientific notation.
fn write_number(writer: &mut impl Write, value: f64) -> io::Result<()> {
    let is_zero = value.classify() == FpCategory::Zero;
    // Within these bounds plain notation needs the digits of the number and a few zeros.
    if is_zero || (1e-5..1e16).contains(&value.abs()) {
        write!(writer, "{value}")
    } else {
        write!(writer, "{value:e}")
    }
}
