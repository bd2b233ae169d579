//! Columns of the recordings of a rig, by their own names and in their own units.

use std::borrow::Cow;

use identify::Rod;
use recording::{ColumnKey, ColumnSpec};

/// A column of a file.
#[derive(Debug)]
pub(crate) struct Column {
    /// Its name, in quotes if it holds a delimiter.
    pub(crate) name: String,
    /// Values in its unit over those in the base unit.
    pub(crate) factor: f64,
}

impl Column {
    /// The column that a rod file describes; one in the base unit where it has no name.
    pub(crate) fn of(spec: Option<&ColumnSpec>, default: &str) -> Self {
        let name = match spec.map(|spec| &spec.key) {
            Some(ColumnKey::Name(name)) => name.as_str(),
            Some(ColumnKey::Number(_) | ColumnKey::EveryS(_)) | None => default,
        };
        let at_end = name
            .trim_end_matches([')', ']'])
            .rsplit(['_', '(', '['])
            .next();
        let unit = spec.and_then(|spec| spec.unit.as_deref()).or(at_end);
        let counts = spec.and_then(|spec| spec.full_scale);
        let factor = match unit.unwrap_or("").trim().to_lowercase().as_str() {
            "counts" => Some(counts.unwrap_or(1.0)),
            "us" | "µs" => Some(1e6),
            "ms" | "ma" | "mv" | "mw" => Some(1e3),
            "%" | "percent" => Some(1e2),
            "min" => Some(1.0 / 60.0),
            "h" => Some(1.0 / 3600.0),
            "s" | "a" | "v" | "w" | "1" | "duty" | "degc" | "" => Some(1.0),
            // A name without a unit, which the base unit has.
            _ if spec.is_none_or(|spec| spec.unit.is_none()) => Some(1.0),
            // Written in the base unit, in the column of that.
            _ => None,
        };
        let has_name = matches!(spec.map(|spec| &spec.key), Some(ColumnKey::Name(_)));
        let (name, factor) = match factor {
            Some(factor) if has_name => (name, factor),
            _ => (default, 1.0),
        };
        Self {
            name: if name.contains([',', ';', '\t']) {
                format!("\"{name}\"")
            } else {
                name.to_owned()
            },
            factor,
        }
    }
}

/// A recording as [`write_csv`](recording::write_csv) writes it, with time, drive and output in the columns and units that a rod file
/// names, so that it is read by that rod file as its own recordings are.
#[must_use]
pub fn in_columns_of(rod: &Rod, csv: &str) -> String {
    let (header, rows) = csv.split_once('\n').unwrap_or((csv, ""));
    let columns: Vec<Option<Column>> = header
        .split(',')
        .map(|name| {
            let drive = rod.drive_kind.column();
            let spec = match name {
                "time_s" => rod.columns.time.as_ref(),
                name if name == drive => rod.columns.drive.as_ref(),
                name if name.trim_matches('"').starts_with("displacement") => {
                    rod.columns.output.as_ref()
                }
                _ => None,
            };
            spec.map(|spec| Column {
                // The output is kept in the unit that it was recorded in.
                factor: if name.trim_matches('"').starts_with("displacement") {
                    1.0
                } else {
                    Column::of(Some(spec), name).factor
                },
                ..Column::of(Some(spec), name)
            })
        })
        .collect();
    let names = header.split(',').zip(&columns);
    let names: Vec<&str> = names
        .map(|(name, column)| column.as_ref().map_or(name, |column| &column.name))
        .collect();
    let mut text = names.join(",") + "\n";
    for row in rows.lines() {
        let cells = row.split(',').zip(&columns).map(|(cell, column)| {
            let factor = column.as_ref().map_or(1.0, |column| column.factor);
            match cell.parse::<f64>() {
                // As it is, to the last digit.
                Ok(value) if factor.to_bits() != 1.0_f64.to_bits() => {
                    Cow::Owned((factor * value).to_string())
                }
                _ => Cow::Borrowed(cell),
            }
        });
        text += &cells.collect::<Vec<_>>().join(",");
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use rig_files::rod_file;

    use super::in_columns_of;

    #[test]
    fn a_recording_goes_back_into_the_columns_of_its_rig() {
        let rod = "[drive]\nkind = \"duty\"\nsupply_v = 24.0\n\
                   [columns]\ntime = \"t_ms\"\ndrive = { name = \"PWM\", unit = \"%\" }\noutput = \"position_mm\"\n";
        let rod = rod_file::parse("rod.toml", rod).unwrap();
        let csv = "time_s,duty,displacement_mm,temperature_degc\n0.1,0.25,1.3,40\n";
        assert_eq!(
            in_columns_of(&rod, csv),
            "t_ms,PWM,position_mm,temperature_degc\n100,25,1.3,40\n"
        );
        let rod = rod_file::parse("rod.toml", "").unwrap();
        let csv = "time_s,current_a,displacement_mm\n0.1,1,1.3\n";
        assert_eq!(in_columns_of(&rod, csv), csv);
    }
}
