//! Conversion of the files of loggers into text that [`parse_csv`](crate::parse_csv) reads: line for line, so that errors
//! name the lines of the file. Every change is reported.
//!
//! ```text
//! bytes -> text (encoding, ends of lines) -> table (delimiter, header, units) -> numbers -> clock -> gaps -> text
//! ```

mod clock;
mod gaps;
pub(crate) mod guess;
mod number;
mod stamp;
mod table;
mod text;

use std::fmt;

use crate::columns::Columns;
use crate::error::RecordingError;
use crate::quantity::Quantity;
use table::Table;

/// Something that was done to a file so that it could be read, or to a recording so that it can be fitted; displays as what, how
/// often and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Adaptation {
    /// Description of the change.
    pub what: String,
    /// Lines that it was done to; 0 if it is about the whole file.
    pub n_lines: usize,
    /// The first of them, counted from 1.
    pub first_line: usize,
}

impl Adaptation {
    /// Of something that was done to what was read.
    pub(crate) fn of_recording(what: String) -> Self {
        Self {
            what,
            n_lines: 0,
            first_line: 0,
        }
    }
}

impl fmt::Display for Adaptation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.n_lines {
            0 => f.write_str(&self.what),
            1 => write!(f, "{} (line {})", self.what, self.first_line),
            n => write!(f, "{} ({n} lines, first {})", self.what, self.first_line),
        }
    }
}

/// Changes made so far.
#[derive(Debug, Default)]
pub(crate) struct Done(Vec<Adaptation>);

impl Done {
    fn of_file(&mut self, what: impl Into<String>) {
        self.0.push(Adaptation::of_recording(what.into()));
    }

    /// Counts one more line to which the change `what` was made.
    fn at_line(&mut self, what: &str, line: usize) {
        match self.0.iter_mut().find(|one| one.what == what) {
            Some(one) => one.n_lines += 1,
            None => self.0.push(Adaptation {
                what: what.to_owned(),
                n_lines: 1,
                first_line: line,
            }),
        }
    }
}

/// The table of a file whose columns nobody has named yet, and what was done to it; `None` if there is none.
///
/// # Errors
///
/// [`RecordingError::NotText`].
pub(crate) fn tabled(
    bytes: &[u8],
    file: &str,
) -> Result<Option<(Table, Vec<Adaptation>)>, RecordingError> {
    text::check(bytes, file)?;
    let mut done = Done::default();
    let lines = text::lines(bytes, &mut done);
    let table = Table::of(&lines, &Columns::default(), &mut done);
    Ok(table.map(|mut table| {
        table.take_units_from_values(&mut done);
        (table, done.0)
    }))
}

/// A file as text that the reader takes, and what was done to it; `None` if it holds no table of numbers.
///
/// # Errors
///
/// [`RecordingError::NotText`] for files of other programs, with what to save instead; [`RecordingError::MissingUnit`].
pub(crate) fn adapted(
    bytes: &[u8],
    file: &str,
    columns: &Columns,
    quantity: Quantity,
) -> Result<Option<(String, Vec<Adaptation>)>, RecordingError> {
    text::check(bytes, file)?;
    let mut done = Done::default();
    let lines = text::lines(bytes, &mut done);
    let Some(mut table) = Table::of(&lines, columns, &mut done) else {
        return Ok(None);
    };
    table.take_units_from_values(&mut done);
    let roles = guess::roles(&mut table, file, columns, quantity, &mut done)?;
    clock::set(&mut table, &roles, &mut done);
    gaps::fill(&mut table, &roles, &mut done);
    Ok(Some((table.text(lines.len()), done.0)))
}
