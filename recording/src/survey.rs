//! Possible meanings of the columns of a file, before anything is known of the rig.

use std::io::Read;
use std::path::Path;

use crate::adapt::{Adaptation, guess, tabled};
use crate::error::RecordingError;
use crate::files::open_regular;
use crate::quantity::Quantity;
use crate::unit::{Unit, split_name};

/// Different values that are counted, at most.
const MOST_LEVELS: usize = 1000;

/// Possible meaning of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Meaning {
    /// Time.
    Time,
    /// A drive.
    Drive(Quantity),
    /// Output of the actuator.
    Output,
    /// Temperature of the actuator.
    Temperature,
    /// Temperature of the surroundings.
    Ambient,
    /// Stress in the actuator.
    Stress,
    /// Resistance of the actuator.
    Resistance,
}

/// A column of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct SurveyedColumn {
    /// Its place, counted from 1.
    pub number: usize,
    /// Its name, if the file has a header.
    pub name: Option<String>,
    /// The unit in its name, in a row of units or behind its values.
    pub unit: Option<String>,
    /// Rows that hold a number.
    pub n_numbers: usize,
    /// Different numbers, at most 1000.
    pub n_levels: usize,
    /// The lowest number, in the unit of the column; NaN without numbers.
    pub lowest: f64,
    /// The highest.
    pub highest: f64,
    /// Largest difference of neighbors, in the unit of the column; 0 with fewer than two.
    pub largest_step: f64,
    /// True if each number is above the one before.
    pub rises: bool,
    /// True if all numbers are whole.
    pub is_whole: bool,
    /// True if the column counts rows: from 0, or from 1.
    pub counts: bool,
    /// True if the column holds dates or times of day.
    pub holds_stamps: bool,
    /// Meaning that its name, unit and values suggest.
    pub meaning: Option<Meaning>,
    /// True if its name or unit states the meaning; false if only its values suggest it.
    pub is_said: bool,
}

/// The columns of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Survey {
    /// The file.
    pub file: String,
    /// Rows of its table.
    pub n_rows: usize,
    /// Its columns, as they stand.
    pub columns: Vec<SurveyedColumn>,
    /// Adaptations that make the file readable.
    pub adaptations: Vec<Adaptation>,
}

impl Survey {
    /// The column that speaks for a meaning.
    #[must_use]
    pub fn column(&self, meaning: Meaning) -> Option<&SurveyedColumn> {
        let mut columns = self.columns.iter();
        columns.find(|column| column.meaning == Some(meaning))
    }

    /// The drive, and what it is.
    #[must_use]
    pub fn drive(&self) -> Option<(&SurveyedColumn, Quantity)> {
        self.columns.iter().find_map(|column| match column.meaning {
            Some(Meaning::Drive(quantity)) => Some((column, quantity)),
            _ => None,
        })
    }

    /// True if the output is a temperature.
    #[must_use]
    pub fn shows_temperature(&self) -> bool {
        self.column(Meaning::Output)
            .is_some_and(SurveyedColumn::is_temperature)
    }
}

/// Looks at the columns of a file, and says what each may be.
///
/// # Errors
///
/// [`RecordingError::Unreadable`], [`RecordingError::NotText`], and [`RecordingError::NoTable`] for a file without rows of numbers.
pub fn survey(path: impl AsRef<Path>) -> Result<Survey, RecordingError> {
    let file = path.as_ref().display().to_string();
    let read = || {
        let mut bytes = Vec::new();
        open_regular(path.as_ref())?.read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    let bytes = read().map_err(|source| RecordingError::Unreadable {
        file: file.clone(),
        source,
    })?;
    let Some((table, adaptations)) = tabled(&bytes, &file)? else {
        return Err(RecordingError::NoTable { file });
    };
    let n_columns = table.rows.first().map_or(0, |row| row.fields.len());
    let mut columns: Vec<SurveyedColumn> = (0..n_columns)
        .map(|k| {
            let values: Vec<f64> = table.rows.iter().filter_map(|row| row.value(k)).collect();
            let name = table.names.as_ref().and_then(|names| names.get(k)).cloned();
            let unit = name.as_deref().and_then(|name| split_name(name).1);
            let unit = unit.map(|unit| match Unit::parse(unit) {
                Some(known) => known.symbol().to_owned(),
                None => unit.to_owned(),
            });
            let mut levels: Vec<u64> = values.iter().map(|value| value.to_bits()).collect();
            levels.sort_unstable();
            levels.dedup();
            SurveyedColumn {
                number: k + 1,
                unit,
                n_numbers: values.len(),
                n_levels: levels.len().min(MOST_LEVELS),
                lowest: values.iter().copied().fold(f64::NAN, f64::min),
                highest: values.iter().copied().fold(f64::NAN, f64::max),
                largest_step: values
                    .windows(2)
                    .map(|pair| (pair[1] - pair[0]).abs())
                    .fold(0.0, f64::max),
                is_whole: values.iter().all(|value| value.fract() == 0.0),
                counts: counts_rows(&values),
                rises: values.len() > 1 && values.is_sorted_by(|a, b| a < b),
                holds_stamps: table.holds_stamps(k),
                meaning: None,
                is_said: true,
                name: name.filter(|name| !name.is_empty()),
            }
        })
        .collect();
    mean(&mut columns, table.rows.len());
    Ok(Survey {
        file,
        n_rows: table.rows.len(),
        columns,
        adaptations,
    })
}

/// True if each number is the number of its row, counted from 0 or from 1.
fn counts_rows(values: &[f64]) -> bool {
    let start = values.first().copied().unwrap_or(-1.0);
    let rows = values.iter().enumerate();
    [0.0, 1.0].contains(&start)
        && rows
            .into_iter()
            .all(|(k, value)| (value - start - k as f64).abs() <= 0.0)
}

/// Says what each column may be: by name and unit, then by its values.
fn mean(columns: &mut [SurveyedColumn], n_rows: usize) {
    let mut reading = Reading { columns, n_rows };
    reading.by_names();
    reading.by_values();
}

/// Units of times, and of what an actuator does.
const TIMES: &[Unit] = &[
    Unit::Second,
    Unit::Millisecond,
    Unit::Microsecond,
    Unit::Minute,
    Unit::Hour,
];
const SHOWN: &[Unit] = &[
    Unit::Millimeter,
    Unit::Micrometer,
    Unit::Meter,
    Unit::Centimeter,
    Unit::Inch,
    Unit::Degree,
    Unit::Newton,
];

/// Drives, the one that is believed first if several are recorded.
const DRIVES: [Quantity; 4] = [
    Quantity::Current,
    Quantity::Power,
    Quantity::Voltage,
    Quantity::Duty,
];

/// Whole numbers above are no amperes, but the counts of a converter: wires for actuators take a few.
const LARGEST_CURRENT_A: f64 = 20.0;

/// Columns that get their meanings.
struct Reading<'a> {
    columns: &'a mut [SurveyedColumn],
    n_rows: usize,
}

impl Reading<'_> {
    fn by_names(&mut self) {
        self.set(Meaning::Time, true, |column| column.holds_stamps);
        self.set(Meaning::Time, true, |column| column.is_called(&guess::TIME));
        self.set(Meaning::Time, true, |column| {
            column.rises && column.is_in(TIMES)
        });
        self.set(Meaning::Ambient, true, |column| {
            column.is_called(&guess::AMBIENT)
        });
        self.set(Meaning::Temperature, true, |column| column.is_temperature());
        self.set(Meaning::Resistance, true, |column| {
            column.is_in(&[Unit::Ohm])
        });
        self.set(Meaning::Stress, true, |column| {
            column.is_in(&[Unit::Megapascal, Unit::Pascal])
        });
        for quantity in DRIVES {
            self.set(Meaning::Drive(quantity), true, |column| {
                let is_so = column.is_called(guess::of_drive(quantity));
                column.n_levels > 1 && (is_so || column.is_in(units_of(quantity)))
            });
        }
        self.set_drive(|column| column.n_levels > 1 && column.is_called(&guess::ANY_DRIVE));
        for words in [&guess::OUTPUT, &guess::OTHER_OUTPUT] {
            self.set(Meaning::Output, true, |column| {
                column.n_levels > 1 && column.is_called(words)
            });
        }
        self.set(Meaning::Output, true, |column| {
            column.n_levels > 1 && column.is_in(SHOWN)
        });
    }

    /// Gives the remaining columns meanings by their values: time rises, an output has more values than anything else. A
    /// column in another unit gets none of these meanings.
    fn by_values(&mut self) {
        let is_free = |column: &SurveyedColumn| column.unit.is_none() && column.n_levels > 1;
        self.set(Meaning::Time, false, |column| {
            is_free(column) && column.rises && !column.counts
        });
        // Without names and time a loop over a temperature, where a column looks like one.
        let is_nameless = self.columns.iter().all(|column| column.name.is_none());
        let n_free = self.columns.iter().filter(|one| is_free(one)).count();
        let is_static = is_nameless && !self.has(Meaning::Time) && n_free >= 2;
        if is_static && !self.has(Meaning::Temperature) {
            let meaning = Meaning::Drive(Quantity::Temperature);
            self.set(meaning, false, |column| {
                is_free(column) && column.looks_like_a_temperature()
            });
        }
        let rest = self.columns.iter();
        let rest = rest.filter(|one| one.meaning.is_none() && is_free(one) && !one.rises);
        let most = rest.map(|one| one.n_levels).max();
        self.set(Meaning::Output, false, |column| {
            is_free(column) && !column.rises && Some(column.n_levels) == most
        });
        if self.has(Meaning::Temperature) {
            // A loop over a temperature, unless something heats.
            if !self.is_driven() {
                for column in self.columns.iter_mut() {
                    if column.meaning == Some(Meaning::Temperature) {
                        column.meaning = Some(Meaning::Drive(Quantity::Temperature));
                    }
                }
            } else if !self.has(Meaning::Output) {
                // Something heats, and nothing else is shown: the heat balance.
                for column in self.columns.iter_mut() {
                    if column.meaning == Some(Meaning::Temperature) {
                        column.meaning = Some(Meaning::Output);
                    }
                }
            }
        } else {
            self.set_drive(|column| is_free(column) && !column.rises);
        }
    }

    /// Gives the first column that fits a drive of which no name says what it is: counts of a converter, or a current.
    fn set_drive(&mut self, fits: impl Fn(&SurveyedColumn) -> bool) {
        self.set(Meaning::Drive(Quantity::Duty), false, |column| {
            column.is_whole && column.highest > LARGEST_CURRENT_A && fits(column)
        });
        self.set(Meaning::Drive(Quantity::Current), false, fits);
    }

    fn has(&self, meaning: Meaning) -> bool {
        let mut all = self.columns.iter();
        all.any(|column| column.meaning == Some(meaning))
    }

    fn is_driven(&self) -> bool {
        let mut all = self.columns.iter();
        all.any(|column| matches!(column.meaning, Some(Meaning::Drive(_))))
    }

    /// Gives the first column that is free and fits a meaning, unless another has it.
    fn set(&mut self, meaning: Meaning, is_said: bool, fits: impl Fn(&SurveyedColumn) -> bool) {
        let is_taken = match meaning {
            Meaning::Drive(_) => self.is_driven(),
            other => self.has(other),
        };
        if is_taken {
            return;
        }
        let n_rows = self.n_rows;
        let is_it = |column: &&mut SurveyedColumn| {
            let holds = column.holds_stamps || 5 * column.n_numbers >= 4 * n_rows;
            column.meaning.is_none() && holds && fits(column)
        };
        if let Some(column) = self.columns.iter_mut().find(is_it) {
            column.meaning = Some(meaning);
            column.is_said = is_said;
        }
    }
}

fn units_of(quantity: Quantity) -> &'static [Unit] {
    match quantity {
        Quantity::Current => &[Unit::Ampere, Unit::Milliampere],
        Quantity::Voltage => &[Unit::Volt, Unit::Millivolt],
        Quantity::Power => &[Unit::Watt, Unit::Milliwatt],
        // A percentage may be anything.
        Quantity::Duty => &[],
        Quantity::Temperature => &[Unit::DegreeCelsius, Unit::Kelvin, Unit::DegreeFahrenheit],
    }
}

impl SurveyedColumn {
    fn is_in(&self, units: &[Unit]) -> bool {
        let unit = self.unit.as_deref().and_then(Unit::parse);
        unit.is_some_and(|unit| units.contains(&unit))
    }

    /// True if unit or name state a temperature.
    fn is_temperature(&self) -> bool {
        self.is_in(units_of(Quantity::Temperature)) || self.is_called(&guess::TEMPERATURE)
    }

    /// True if its values could be the temperatures of a slow cycle, °C: within the range from a cold chamber to a furnace
    /// that alloys stand, over a wider span than in a room, and without jumps.
    fn looks_like_a_temperature(&self) -> bool {
        const LOWEST_DEGC: f64 = -200.0;
        const HIGHEST_DEGC: f64 = 600.0;
        const LEAST_SPAN_K: f64 = 20.0;
        /// Share of the span that no neighbors differ by.
        const JUMP: f64 = 0.25;
        let span_k = self.highest - self.lowest;
        self.lowest >= LOWEST_DEGC
            && self.highest <= HIGHEST_DEGC
            && span_k >= LEAST_SPAN_K
            && self.largest_step <= JUMP * span_k
    }

    fn is_called(&self, words: &[&str]) -> bool {
        self.name
            .as_deref()
            .is_some_and(|name| guess::is_called(name, words))
    }
}
