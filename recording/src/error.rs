//! Faults of a recording.

use std::fmt;

/// Where in a recording a fault lies; displays as the part behind the name, `:118` or `, sample 7`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Position {
    /// Line of a file, counted from 1.
    Line(u64),
    /// Index into the slices given to [`Recording::new`](crate::Recording::new), counted from 0.
    Sample(usize),
}

impl fmt::Display for Position {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, ":{line}"),
            Self::Sample(index) => write!(f, ", sample {index}"),
        }
    }
}

/// A fault of a recording.
///
/// `file` is the path or name that the caller gave. `role` is the key of the `[columns]` table
/// (`time`, `drive`, `antagonist`, `output`, `temperature`, `ambient`), `column` the column's name in the file, or
/// `column 3` where it has none.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// The file cannot be opened, or reading it fails half way.
    #[error("{file}: cannot be read")]
    Unreadable {
        /// The file.
        file: String,
        /// Error of the operating system.
        source: std::io::Error,
    },

    /// There is nothing but blank lines and comments.
    #[error("{file}: empty; expected a header line and at least 2 rows")]
    Empty {
        /// The file.
        file: String,
    },

    /// There are fewer than two samples.
    #[error("{file}: rows of data: {n_samples}; expected at least 2")]
    TooFewSamples {
        /// The file.
        file: String,
        /// Samples found.
        n_samples: usize,
    },

    /// There are more samples than the caller allows.
    #[error(
        "{file}:{line}: more than {max_samples} samples; expected a shorter recording, or a higher \
         max_samples"
    )]
    TooManySamples {
        /// The file.
        file: String,
        /// Line of the first sample too many.
        line: u64,
        /// Samples allowed.
        max_samples: usize,
    },

    /// A line is so long that this cannot be a recording.
    #[error("{file}:{line}: line of more than {max_bytes} bytes; expected CSV text")]
    LineTooLong {
        /// The file.
        file: String,
        /// The line.
        line: u64,
        /// Bytes allowed in a line.
        max_bytes: usize,
    },

    /// A file of another program.
    #[error("{file}: {what}; expected {expected}")]
    NotText {
        /// The file.
        file: String,
        /// Kind of file that it is.
        what: &'static str,
        /// Form to save instead.
        expected: &'static str,
    },

    /// A file without rows of numbers.
    #[error(
        "{file}: no table; expected rows of at least two numbers; where commas stand in numbers, save with semicolons or tabs between fields"
    )]
    NoTable {
        /// The file.
        file: String,
    },

    /// A duty in counts without its full scale.
    #[error(
        "{file}:{line}: drive = {column}: in counts; expected full_scale beside unit under [columns]: drive = {{ name = \"{column}\", \
         unit = \"counts\", full_scale = 255 }}"
    )]
    MissingFullScale {
        /// The file.
        file: String,
        /// Line of the header.
        line: u64,
        /// The column.
        column: String,
    },

    /// A line is not UTF-8.
    #[error("{file}:{line}: byte {byte} of the line is not UTF-8; expected text in UTF-8")]
    NotUtf8 {
        /// The file.
        file: String,
        /// The line.
        line: u64,
        /// First wrong byte, counted from 1 within the line.
        byte: usize,
    },

    /// A column is looked for by name, and the file starts with numbers.
    #[error(
        "{file}:{line}: {role} = \"{wanted}\": the file has no header; expected a header line, or \
         the number of the column under [columns], such as {role} = 1"
    )]
    NoHeader {
        /// The file.
        file: String,
        /// Its first line.
        line: u64,
        /// Key of the column.
        role: &'static str,
        /// Name looked for.
        wanted: String,
    },

    /// A column is not there.
    #[error(
        "{file}:{line}: {role} = {wanted}: no such column; expected {role} under [columns] to be \
         one of the {n_columns} present: {present}"
    )]
    MissingColumn {
        /// The file.
        file: String,
        /// Line of the header.
        line: u64,
        /// Key of the column.
        role: &'static str,
        /// Name in quotes, or number, looked for.
        wanted: String,
        /// Number of columns in the file.
        n_columns: usize,
        /// Their names.
        present: String,
    },

    /// Several columns fit.
    #[error(
        "{file}:{line}: {role} = \"{wanted}\": several columns fit, {fitting}; expected one, give \
         its name or number under [columns]"
    )]
    DoubledColumn {
        /// The file.
        file: String,
        /// Line of the header.
        line: u64,
        /// Key of the column.
        role: &'static str,
        /// Name looked for.
        wanted: String,
        /// The columns that fit, with their numbers.
        fitting: String,
    },

    /// One column is given two meanings.
    #[error("{file}:{line}: {column} is both {first} and {second}; expected different columns")]
    SharedColumn {
        /// The file.
        file: String,
        /// Line of the header.
        line: u64,
        /// The column.
        column: String,
        /// Key that takes the column.
        first: &'static str,
        /// Another key that takes it.
        second: &'static str,
    },

    /// Columns whose rows follow those of others are not the same ones.
    #[error(
        "{file}:{line}: [columns.then] and [columns] differ in {what}; expected the same columns in the same \
         units, and no time"
    )]
    UnequalColumns {
        /// The file.
        file: String,
        /// Line of the header.
        line: u64,
        /// Key of the first that differs.
        what: &'static str,
    },

    /// A column has no unit and needs one.
    #[error(
        "{file}:{line}: {role} = {column}: no unit; expected {accepted} at the end of its name, \
         or as unit under [columns]"
    )]
    MissingUnit {
        /// The file.
        file: String,
        /// Line of the header.
        line: u64,
        /// Key of the column.
        role: &'static str,
        /// The column.
        column: String,
        /// Units that would do.
        accepted: &'static str,
    },

    /// A column has a unit that is unknown or does not suit it.
    #[error(
        "{file}:{line}: {role} = {column}: unit \"{unit}\"; expected {accepted} at the end of its \
         name, or as unit under [columns]"
    )]
    WrongUnit {
        /// The file.
        file: String,
        /// Line of the header.
        line: u64,
        /// Key of the column.
        role: &'static str,
        /// The column.
        column: String,
        /// Its unit.
        unit: String,
        /// Units that would do.
        accepted: &'static str,
    },

    /// A unit cannot be written behind a column name.
    #[error(
        "{file}: unit \"{unit}\"; expected text such as mm, deg or N, without square \
         brackets, quotes or control characters"
    )]
    InvalidUnit {
        /// The recording.
        file: String,
        /// The unit.
        unit: String,
    },

    /// A drive that heats has a unit of its own.
    #[error(
        "{file}: drive in \"{unit}\"; expected a {quantity} in {expected}: only the input of a static \
         loop has a unit of its own"
    )]
    DriveUnit {
        /// The recording.
        file: String,
        /// The unit.
        unit: String,
        /// Quantity of the drive.
        quantity: &'static str,
        /// Its unit.
        expected: &'static str,
    },

    /// A drive that is a temperature has a measured temperature beside it.
    #[error("{file}: both drive and temperature are temperatures; expected one of them")]
    TwoTemperatures {
        /// The recording.
        file: String,
    },

    /// A static loop has the drive of an antagonist.
    #[error(
        "{file}: a drive that is a temperature has no antagonist; expected a current, a duty, a voltage or a power"
    )]
    StaticAntagonist {
        /// The recording.
        file: String,
    },

    /// A row has another number of fields than the first line.
    #[error("{file}:{line}: fields: {n_fields}; expected {n_columns}, as in the first line{}", too_many(*n_fields, *n_columns))]
    FieldCount {
        /// The file.
        file: String,
        /// Line of the row.
        line: u64,
        /// Its fields.
        n_fields: usize,
        /// Fields of the first line.
        n_columns: usize,
    },

    /// A field is not a number.
    #[error(
        "{file}:{line}: {column} = \"{value}\": not a number; expected a finite number in {unit}{}{}",
        decimal_comma(value),
        header_again(value, column)
    )]
    NotANumber {
        /// The file.
        file: String,
        /// Line of the row.
        line: u64,
        /// The column.
        column: String,
        /// The field.
        value: String,
        /// Unit of the column.
        unit: String,
    },

    /// A number is infinite or NaN.
    #[error("{file}{at}: {column} = {value}: not finite; expected a finite number in {unit}")]
    NotFinite {
        /// The recording.
        file: String,
        /// Where in it.
        at: Position,
        /// The column.
        column: String,
        /// The number, as it stands there.
        value: String,
        /// Unit of the column.
        unit: String,
    },

    /// Time falls or stands still.
    #[error(
        "{file}{at}: {column} = {value} after {previous} in the row before; expected time to rise{}",
        starts_anew(*value, *previous)
    )]
    TimeNotRising {
        /// The recording.
        file: String,
        /// Where in it.
        at: Position,
        /// The column.
        column: String,
        /// The time, in the unit of the column.
        value: f64,
        /// The time in the row before.
        previous: f64,
    },

    /// A duty is outside 0..1.
    #[error(
        "{file}{at}: {column} = {value}: outside 0..{full_scale}; expected a duty of 0..1, of 0..100 in a column \
         with unit %, or counts: unit = \"counts\", full_scale = 255"
    )]
    DutyOutOfRange {
        /// The recording.
        file: String,
        /// Where in it.
        at: Position,
        /// The column.
        column: String,
        /// The duty, in the unit of the column.
        value: f64,
        /// Duty of a bridge that is always on, in the unit of the column: 1 or 100.
        full_scale: f64,
    },

    /// Several fields or rows are wrong.
    #[error("{}", by_kind(file, kinds))]
    Several {
        /// The file.
        file: String,
        /// The first fault of each kind, and how many there are of it.
        kinds: Vec<(RecordingError, usize)>,
    },

    /// Slices of one recording differ in length.
    #[error("{file}: {column} has {n_samples} samples; expected {expected}, as many as the drive")]
    UnequalLengths {
        /// The recording.
        file: String,
        /// The column.
        column: &'static str,
        /// Its samples.
        n_samples: usize,
        /// Samples of the drive.
        expected: usize,
    },

    /// A drive or an output is the same throughout: there is nothing to identify.
    #[error(
        "{file}: {role} is {value} {unit} in all {n_samples} samples; expected it to change, there \
         is nothing to identify"
    )]
    NeverChanges {
        /// The recording.
        file: String,
        /// `drive` or `output`.
        role: &'static str,
        /// Its value.
        value: f64,
        /// Unit of the value.
        unit: String,
        /// Samples.
        n_samples: usize,
    },

    /// A range of samples is not in the recording, or holds fewer than two.
    #[error(
        "{file}: samples {start}..{end}; expected a range of at least 2 samples within \
         0..{n_samples}"
    )]
    RangeOutside {
        /// The recording.
        file: String,
        /// First sample wanted.
        start: usize,
        /// Sample after the last wanted.
        end: usize,
        /// Samples of the recording.
        n_samples: usize,
    },

    /// The surroundings are recorded, and stated besides.
    #[error(
        "{file}: ambient_degc = {ambient_degc} °C is stated of it under [recordings], and it has a column of that; expected one of the two"
    )]
    AmbientTwice {
        /// The file.
        file: String,
        /// Stated temperature, °C.
        ambient_degc: f64,
    },

    /// So few rows cannot be left.
    #[error("{file}: one row in {n}; expected one in 2 to {most}, half of the rows")]
    DecimationOutOfRange {
        /// The file.
        file: String,
        /// Rows of which one is wanted.
        n: usize,
        /// Half of the rows.
        most: usize,
    },

    /// No rest tells how far the output has drifted.
    #[error(
        "{file}: at rest: {at_start} samples at the start, {at_end} at the end, where the output still moves by {moves:.1} % of its \
         range; expected at least 10 at the start, and 40 at the end that move by less than 1 %, to take a straight line off"
    )]
    NoRestAtBothEnds {
        /// The file.
        file: String,
        /// Samples at rest before the drive rises.
        at_start: usize,
        /// Samples at rest at the end.
        at_end: usize,
        /// Change of the output from the third to the last quarter of these, % of its range; 0 where there is none.
        moves: f64,
    },

    /// A recording cannot be split into so many parts of whole cycles.
    #[error("{file}: parts: {n_parts}; expected 1 to {most}, each of at least one whole cycle")]
    PartsOutOfRange {
        /// The recording.
        file: String,
        /// Parts wanted.
        n_parts: usize,
        /// Whole cycles of the drive, or 1.
        most: usize,
    },

    /// Static data cannot be resampled in time.
    #[error("{file}: no time; expected a recording with a time column")]
    NoTime {
        /// The recording.
        file: String,
    },

    /// A recording with missing samples cannot be resampled.
    #[error(
        "{file}: gap of {dt_s} s after time_s = {start_s}; expected no gap, slice the recording at \
         samples 0..{end} and {end}..{n_samples}"
    )]
    GapInside {
        /// The recording.
        file: String,
        /// Time before the gap, s.
        start_s: f64,
        /// Length of the gap, s.
        dt_s: f64,
        /// First sample after the gap.
        end: usize,
        /// Samples of the recording.
        n_samples: usize,
    },

    /// The limit of a supply is no magnitude.
    #[error("{file}: drive limit = {limit} {unit}: must be finite and > 0")]
    DriveLimit {
        /// The recording.
        file: String,
        /// Limit wanted.
        limit: f64,
        /// Unit of the drive.
        unit: String,
    },

    /// A recording cannot be resampled to this step.
    #[error(
        "{file}: dt_s = {dt_s} s; expected {min_dt_s} s, its own step, to {max_dt_s} s, its duration"
    )]
    StepOutOfRange {
        /// The recording.
        file: String,
        /// Step wanted, s.
        dt_s: f64,
        /// Step of the recording, s.
        min_dt_s: f64,
        /// Duration of the recording, s.
        max_dt_s: f64,
    },
}

impl RecordingError {
    /// True if the fault may lie in how the file is written rather than in what it says.
    pub(crate) fn is_of_format(&self) -> bool {
        !matches!(
            self,
            Self::Unreadable { .. }
                | Self::TooManySamples { .. }
                | Self::TwoTemperatures { .. }
                | Self::StaticAntagonist { .. }
                | Self::UnequalColumns { .. }
                | Self::MissingFullScale { .. }
                | Self::WrongUnit { .. }
                | Self::DriveLimit { .. }
        )
    }
}

/// How often there is each kind of fault, and the first of it.
fn by_kind(file: &str, kinds: &[(RecordingError, usize)]) -> String {
    if let [(first, n)] = kinds {
        return format!("{first}; {n} such faults in all");
    }
    let n: usize = kinds.iter().map(|(_, n)| n).sum();
    let mut text = format!("{file}: {n} faults; of each kind how many, and the first:");
    for (first, n) in kinds {
        text += &format!("\n  {n} x {first}");
    }
    text
}

/// Hint for a clock that falls far.
fn starts_anew(value: f64, previous: f64) -> &'static str {
    if value < 0.5 * previous {
        "; a clock that starts anew begins another recording: save its rows as a file of their own"
    } else {
        ""
    }
}

/// Hint for a row with too many fields.
fn too_many(n_fields: usize, n_columns: usize) -> &'static str {
    if n_fields > n_columns {
        "; if commas stand both between fields and in numbers, save with semicolons or tabs between fields"
    } else {
        ""
    }
}

/// Hint for a header among the rows.
fn header_again(value: &str, column: &str) -> &'static str {
    if value == column {
        "; a second header begins another recording: save its rows as a file of their own"
    } else {
        ""
    }
}

/// Hint for a number with a decimal comma.
fn decimal_comma(value: &str) -> &'static str {
    let is_number =
        value.matches(',').count() == 1 && value.replace(',', ".").parse::<f64>().is_ok();
    if is_number {
        ", with a decimal point instead of a comma, or decimal = \",\" under [columns]"
    } else {
        ""
    }
}
