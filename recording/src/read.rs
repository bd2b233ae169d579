//! CSV to a checked recording, in one pass.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;

use crate::adapt::adapted;
use crate::check::{Place, check_duty, check_rising};
use crate::columns::Columns;
use crate::error::{Position, RecordingError};
use crate::faults::Faults;
use crate::files::open_regular;
use crate::layout::{Column, Header, Layout, ResistanceColumns, Wanted, shown};
use crate::lines::{Delimiter, Lines};
use crate::quantity::Quantity;
use crate::recording::{Recording, RecordingParts};
use crate::resistance::Resistance;
use crate::unit::Unit;

/// Columns to read from a file, their meaning, and limits.
///
/// # Examples
///
/// ```
/// use recording::{Quantity, ReadOptions};
///
/// let options = ReadOptions { max_samples: 100_000, ..ReadOptions::new(Quantity::Duty) };
/// # assert!(!options.allow_untimed);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ReadOptions {
    /// Which column is what.
    pub columns: Columns,
    /// Quantity that the drive column measures.
    pub drive_quantity: Quantity,
    /// True if the time column may be missing although the drive is not a temperature. For static data only, such as a loop
    /// measured point by point in steady state: the recording then has no time
    /// ([`Sampling::Untimed`](crate::Sampling::Untimed)).
    pub allow_untimed: bool,
    /// Magnitude beyond which the supply gives no more of the drive, in the unit of its quantity, > 0: what is above counts as
    /// it, see [`Recording::limited`]. `None` where the drive acts as it is.
    pub drive_limit: Option<f64>,
    /// Samples that a recording may have; 20 million by default, half a gigabyte in three columns.
    pub max_samples: usize,
}

impl ReadOptions {
    /// Default columns and limits for a drive of this quantity.
    #[must_use]
    pub fn new(drive_quantity: Quantity) -> Self {
        Self {
            columns: Columns::default(),
            drive_quantity,
            allow_untimed: false,
            drive_limit: None,
            max_samples: 20_000_000,
        }
    }
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self::new(Quantity::default())
    }
}

/// Reads a recording from a file; its name is `path` as given.
///
/// A file that [`parse_csv`] refuses is read as loggers write it, unless [`Columns::strict`] is set: text in UTF-16 or
/// windows-1252, lines before and behind the table, a row of units, units or labels in each field, decimal commas, stamps, clocks
/// that run over, a few numbers that are missing. [`Recording::adaptations`] says what was done.
///
/// # Errors
///
/// [`RecordingError`], naming file, line, column, value and what would be accepted.
pub fn read_csv(
    path: impl AsRef<Path>,
    options: &ReadOptions,
) -> Result<Recording, RecordingError> {
    read(path.as_ref(), options, Wanted::DriveAndOutput)
}

/// Reads a drive to simulate with from a file: time and ambient as they are there, but no output. That of
/// the result is 0 throughout, without a unit.
///
/// # Errors
///
/// As [`read_csv`].
pub fn read_drive_csv(
    path: impl AsRef<Path>,
    options: &ReadOptions,
) -> Result<Recording, RecordingError> {
    read(path.as_ref(), options, Wanted::Drive)
}

/// Largest file that is adapted, bytes: it is held in memory as a whole.
const LARGEST_ADAPTED: u64 = 1 << 27;

fn read(path: &Path, options: &ReadOptions, wanted: Wanted) -> Result<Recording, RecordingError> {
    let columns = &options.columns;
    let as_written = || {
        let (file, name) = open(path)?;
        parse(file, &name, options, wanted)
    };
    if columns.strict {
        return as_written();
    }
    let written = match columns.skip == 0 && columns.decimal != Some(',') {
        false => None,
        true => match as_written() {
            // Without its end the last line may have lost digits.
            Ok(recording) if ends_with_a_line(path) => return Ok(recording),
            Err(fault) if !fault.is_of_format() => return Err(fault),
            written => Some(written),
        },
    };
    let (mut file, name) = open(path)?;
    let unreadable = |source| RecordingError::Unreadable {
        file: name.clone(),
        source,
    };
    let length = file.metadata().map_err(unreadable)?.len();
    let mut bytes = Vec::new();
    if length <= LARGEST_ADAPTED {
        file.read_to_end(&mut bytes).map_err(unreadable)?;
    }
    match (
        adapted(&bytes, &name, columns, options.drive_quantity)?,
        written,
    ) {
        (Some((_, adaptations)), Some(Ok(recording))) if adaptations.is_empty() => Ok(recording),
        (Some((text, adaptations)), _) => {
            parse(text.as_bytes(), &name, options, wanted).map(|one| one.adapted_by(adaptations))
        }
        (None, written) => written.unwrap_or_else(as_written),
    }
}

/// True if the last byte of a file ends a line, or cannot be read.
fn ends_with_a_line(path: &Path) -> bool {
    let last = || {
        let mut file = File::open(path)?;
        file.seek(SeekFrom::End(-1))?;
        let mut last = [0];
        file.read_exact(&mut last)?;
        Ok::<u8, std::io::Error>(last[0])
    };
    last().map_or(true, |last| matches!(last, b'\n' | b'\r'))
}

fn open(path: &Path) -> Result<(File, String), RecordingError> {
    let name = path.display().to_string();
    match open_regular(path) {
        Ok(file) => Ok((file, name)),
        Err(source) => Err(RecordingError::Unreadable { file: name, source }),
    }
}

/// Reads a recording from any reader, which need not be buffered; `name` is what errors call it.
///
/// One pass: what is kept is the wanted columns, 8 bytes a value.
///
/// # Errors
///
/// [`RecordingError`], naming file, line, column, value and what would be accepted.
pub fn parse_csv(
    reader: impl Read,
    name: &str,
    options: &ReadOptions,
) -> Result<Recording, RecordingError> {
    parse(reader, name, options, Wanted::DriveAndOutput)
}

fn parse(
    reader: impl Read,
    name: &str,
    options: &ReadOptions,
    wanted: Wanted,
) -> Result<Recording, RecordingError> {
    let mut lines = Lines::new(reader, name);
    let Some((line, first)) = lines.advance()? else {
        return Err(RecordingError::Empty {
            file: name.to_owned(),
        });
    };
    let delimiter = Delimiter::detect(first);
    let mut fields = Vec::new();
    delimiter.split(first, &mut fields);
    let names = header_names(first, &fields);
    let n_columns = names.as_ref().map_or(fields.len(), Vec::len);
    let header = Header {
        file: name,
        line,
        names,
        n_columns,
    };
    let layouts = Layout::all(&header, options, wanted)?;
    let max_rows = options.max_samples / layouts.len();
    let mut ways: Vec<Rows<'_>> = layouts
        .into_iter()
        .map(|layout| Rows::new(name, layout, max_rows))
        .collect();
    let mut faults = Faults::default();
    let mut push = |line, row: &str, fields: &[Range<usize>]| {
        ways.iter_mut()
            .try_for_each(|rows| rows.push(line, row, fields, &mut faults))?;
        Ok(!faults.are_enough())
    };
    if header.names.is_none() {
        push(line, first, &fields)?;
    }
    while let Some((line, row)) = lines.advance()? {
        delimiter.split(row, &mut fields);
        if !push(line, row, &fields)? {
            break;
        }
    }
    faults.into_result(name)?;
    let whole = ways.into_iter().reduce(Rows::followed_by);
    let Some(rows) = whole else {
        unreachable!("[columns] itself is the first of the ways");
    };
    let recording = rows.finish(options.drive_quantity)?;
    match options.drive_limit {
        Some(limit) => recording.limited(limit),
        None => Ok(recording),
    }
}

/// The names in the first line, or `None` if it holds a number.
fn header_names(line: &str, fields: &[Range<usize>]) -> Option<Vec<String>> {
    if fields
        .iter()
        .any(|field| line[field.clone()].parse::<f64>().is_ok())
    {
        return None;
    }
    let n_names = fields
        .iter()
        .rposition(|field| !field.is_empty())
        .map_or(0, |last| last + 1);
    let name = |field: &Range<usize>| line[field.clone()].replace("\"\"", "\"");
    Some(fields[..n_names].iter().map(name).collect())
}

/// The samples read so far.
struct Rows<'a> {
    file: &'a str,
    layout: Layout,
    max_samples: usize,
    /// The last time as it stands in the file, for errors.
    last_time: f64,
    time_s: Vec<f64>,
    drive: Vec<f64>,
    antagonist_drive: Vec<f64>,
    output: Vec<f64>,
    temperature_degc: Vec<f64>,
    ambient_degc: Vec<f64>,
    stress_pa: Vec<f64>,
    /// Resistance, Ω, or the voltage over it, V.
    resistance: Vec<f64>,
    resistance_current_a: Vec<f64>,
}

impl<'a> Rows<'a> {
    fn new(file: &'a str, layout: Layout, max_samples: usize) -> Self {
        Self {
            file,
            layout,
            max_samples,
            last_time: f64::NEG_INFINITY,
            time_s: Vec::new(),
            drive: Vec::new(),
            antagonist_drive: Vec::new(),
            output: Vec::new(),
            temperature_degc: Vec::new(),
            ambient_degc: Vec::new(),
            stress_pa: Vec::new(),
            resistance: Vec::new(),
            resistance_current_a: Vec::new(),
        }
    }

    /// These rows and then others, of equal columns.
    fn followed_by(mut self, then: Self) -> Self {
        self.drive.extend(then.drive);
        self.antagonist_drive.extend(then.antagonist_drive);
        self.output.extend(then.output);
        self.temperature_degc.extend(then.temperature_degc);
        self.ambient_degc.extend(then.ambient_degc);
        self.stress_pa.extend(then.stress_pa);
        self.resistance.extend(then.resistance);
        self.resistance_current_a.extend(then.resistance_current_a);
        self
    }

    /// Checks one row and keeps its wanted columns; what is wrong with it is among the faults, and stops nothing.
    fn push(
        &mut self,
        line: u64,
        row: &str,
        fields: &[Range<usize>],
        faults: &mut Faults,
    ) -> Result<(), RecordingError> {
        if self.drive.len() >= self.max_samples {
            return Err(RecordingError::TooManySamples {
                file: self.file.to_owned(),
                line,
                max_samples: self.max_samples,
            });
        }
        let n_fields = self.check_count(line, fields);
        if n_fields.is_err() {
            faults.check(n_fields);
            return Ok(());
        }
        let row = Row {
            file: self.file,
            line,
            text: row,
            fields,
        };
        if let Some(column) = &self.layout.time {
            match row.number(column) {
                Err(fault) => faults.check(Err(fault)),
                Ok(raw) => {
                    let time_s = column.unit.to_base(raw);
                    if let Some(&previous_s) = self.time_s.last() {
                        // Compared as converted, shown as written.
                        let rises = time_s > previous_s;
                        faults.check(check_rising(rises, &row.place(column), raw, self.last_time));
                    }
                    self.last_time = raw;
                    self.time_s.push(time_s);
                }
            }
        }
        self.drive.push(row.drive(&self.layout.drive, faults));
        if let Some(column) = &self.layout.antagonist {
            self.antagonist_drive.push(row.drive(column, faults));
        }
        self.output.push(match &self.layout.output {
            Some(column) => faults.or_zero(row.number(column)),
            None => 0.0,
        });
        if let Some(column) = &self.layout.temperature {
            self.temperature_degc
                .push(column.unit.to_base(faults.or_zero(row.number(column))));
        }
        if let Some(column) = &self.layout.ambient {
            self.ambient_degc
                .push(column.unit.to_base(faults.or_zero(row.number(column))));
        }
        if let Some(column) = &self.layout.stress {
            self.stress_pa
                .push(column.unit.to_base(faults.or_zero(row.number(column))));
        }
        match &self.layout.resistance {
            None => {}
            Some(ResistanceColumns::Ohm(column)) => {
                self.resistance.push(faults.or_zero(row.number(column)))
            }
            Some(ResistanceColumns::VoltageOverCurrent { voltage, current }) => {
                self.resistance.push(faults.or_zero(row.number(voltage)));
                self.resistance_current_a
                    .push(current.unit.to_base(faults.or_zero(row.number(current))));
            }
        }
        Ok(())
    }

    /// A missing field is a line cut off, one too many often a decimal comma: neither may pass.
    fn check_count(&self, line: u64, fields: &[Range<usize>]) -> Result<(), RecordingError> {
        let n_columns = self.layout.n_columns;
        let n_filled = fields
            .iter()
            .rposition(|field| !field.is_empty())
            .map_or(0, |last| last + 1);
        if fields.len() >= n_columns && n_filled <= n_columns {
            return Ok(());
        }
        Err(RecordingError::FieldCount {
            file: self.file.to_owned(),
            line,
            n_fields: fields.len(),
            n_columns,
        })
    }

    fn finish(self, drive_quantity: Quantity) -> Result<Recording, RecordingError> {
        let Layout {
            time,
            drive,
            antagonist,
            output,
            temperature,
            ambient,
            stress,
            resistance,
            every_s,
            n_columns: _,
        } = self.layout;
        let counted_s = every_s.map(|every_s| {
            let samples = 0..self.drive.len();
            samples.map(|k| every_s * k as f64).collect()
        });
        Recording::from_checked(RecordingParts {
            name: self.file.to_owned(),
            time_s: time.map(|_| self.time_s).or(counted_s),
            drive_quantity,
            drive: self.drive,
            smoothed_noise: 0.0,
            antagonist_drive: antagonist.map(|_| self.antagonist_drive),
            drive_unit: match drive.unit {
                Unit::Own => drive.unit_text,
                _ => String::new(),
            },
            output_unit: output.map_or(String::new(), |column| column.unit_text),
            output: self.output,
            temperature_degc: temperature.map(|_| self.temperature_degc),
            ambient_degc: ambient.map(|_| self.ambient_degc),
            stress_pa: stress.map(|_| self.stress_pa),
            resistance: resistance.map(|columns| match columns {
                ResistanceColumns::Ohm(_) => Resistance::Ohm(self.resistance),
                ResistanceColumns::VoltageOverCurrent { .. } => Resistance::VoltageOverCurrent {
                    voltage_v: self.resistance,
                    current_a: self.resistance_current_a,
                },
            }),
        })
    }
}

/// One row, split.
struct Row<'a> {
    file: &'a str,
    line: u64,
    text: &'a str,
    fields: &'a [Range<usize>],
}

impl<'a> Row<'a> {
    fn place(&self, column: &'a Column) -> Place<'a> {
        Place {
            file: self.file,
            at: Position::Line(self.line),
            column: &column.label,
        }
    }

    /// The drive in `column`, in the unit of its quantity; what is wrong with it is among the faults.
    fn drive(&self, column: &Column, faults: &mut Faults) -> f64 {
        let raw = faults.or_zero(self.number(column));
        let full_scale = match column.unit {
            Unit::One => Some(1.0),
            Unit::Percent => Some(100.0),
            Unit::Counts => Some(column.full_scale),
            _ => None,
        };
        if let Some(full_scale) = full_scale {
            faults.check(check_duty(raw, full_scale, &self.place(column)));
        }
        match column.unit {
            Unit::Counts => raw / column.full_scale,
            unit => unit.to_base(raw),
        }
    }

    /// The finite number in `column`, as it stands there.
    fn number(&self, column: &Column) -> Result<f64, RecordingError> {
        let field = &self.text[self.fields[column.index].clone()];
        match field.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) => Err(self
                .place(column)
                .not_finite(shown(field), &column.unit_text)),
            Err(_) => Err(RecordingError::NotANumber {
                file: self.file.to_owned(),
                line: self.line,
                column: column.label.clone(),
                value: shown(field),
                unit: column.unit_text.clone(),
            }),
        }
    }
}
