//! Recordings of an actuator: CSV in, checked samples out.
//!
//! A lab records what drives a shape-memory-alloy actuator (current, PWM duty, voltage, power, or,
//! for static data, temperature) and what the actuator does (displacement, angle, force).
//! [`read_csv`] turns such a file into a [`Recording`]: finite numbers in known units, in rising
//! time, or a [`RecordingError`] that names file, line, column, value and what would be accepted.
//! This crate knows no model.
//!
//! # File format
//!
//! * UTF-8 text; a byte-order mark, blank lines and lines whose first visible character is `#` are
//!   skipped; lines end with `\n` or `\r\n`.
//! * **Delimiter:** tab, if the first line has one outside quotes; else semicolon; else comma; else
//!   runs of white space. Fields may stand in double quotes, except between white space. Numbers
//!   have a decimal point.
//! * **Header:** the first line is a header if none of its fields is a number. Without a header the
//!   columns are given by number ([`ColumnKey::Number`]).
//! * **Units** come from the end of the column name, `current_ma`, `Load (N)` or `Izadg [A]`, or
//!   from [`ColumnSpec::unit`], which wins. Known units, in either case: `s ms a ma v w mm um m
//!   degc c k deg n mpa pa ohm %`. Time, drive, temperatures and stress are converted to s, A, 1, V,
//!   W, °C, Pa (a column in K is an absolute temperature); one of them without a unit is an error,
//!   except for a duty, which is then a fraction. The output keeps its own unit.
//! * **Names** are matched without case, and `current_A`, `current [A]` and `current (A)` are the
//!   same name. [`Columns`] lists the defaults.
//! * Every row has as many fields as the first line (empty ones at the end do not count); columns
//!   that are not asked for may hold anything.
//!
//! This is what [`parse_csv`] takes from any reader. [`read_csv`] reads a file that is not so as loggers write it, unless
//! [`Columns::strict`] is set, and [`Recording::adaptations`] says what was done:
//!
//! | in the file | is read |
//! | --- | --- |
//! | UTF-16 with its mark, windows-1252, `\r` between lines | yes |
//! | lines before the table (LabVIEW, banners, `sep=`), a footer of up to 20 lines, a last line that was cut off | left out |
//! | a header in a comment, a row of units under it, `24.0 °C` or `I=0.5` in each field | yes |
//! | other names (`Zeit [s]`, `Wire Current (Amps)`) | if one column alone fits, and has a unit |
//! | decimal commas, thousands set apart, Fortran's exponents, `\|` between fields | yes; `1,234` alone needs `decimal` |
//! | stamps (`2024-05-02 10:00:00.1`, `10:00:00.1`), epochs, a counter that runs over | seconds from the first row |
//! | a row that stands twice; rows of one stamp; a row too late | left out; spread up to the next stamp; moved |
//! | up to five numbers in a row missing (empty, `--`, `NaN`), 5 % in all | a drive is held, all else interpolated |
//! | counts of a converter | with `full_scale` |
//! | two recordings in a file, JSON, workbooks and other binary files | no: the error says what to save |
//!
//! # Samples
//!
//! Row k holds the drive from t_k to t_(k+1); the output of row k is measured at t_k, before that
//! drive acts.
//!
//! # What is in a recording
//!
//! | question | answer |
//! | --- | --- |
//! | everything below at once, and what to do about it | [`inspect`], [`Inspection::warnings`] |
//! | what could each column be? | [`survey`] |
//! | is time uniform, are samples missing? | [`Recording::sampling`], [`Recording::gaps`] |
//! | in what steps does the converter count? | [`quantization_step`] |
//! | is a signal flat at its extreme? | [`clipping`] |
//! | which samples do not belong to the series, and a recording without them? | [`wild`], [`mended`] |
//! | where does the output slip? | [`slips`] |
//! | where does the logger repeat a value? | [`stuck`] |
//! | is the column of the drive noisy? | [`drive_noise`] |
//! | in what steps can the supply be set, and from where on? | [`drive_resolution`] |
//! | where is the drive constant? | [`holds`] |
//! | which are its whole cycles, which repeat? | [`cycles`], [`repeats`] |
//! | how far apart are runs of the same drive? | [`repeat_floor`] |
//! | how large is the noise, at least and at most? | [`noise_floor`] |
//! | parts of whole cycles | [`split_by_cycles`], [`Recording::slice`] |
//! | a longer, equal step | [`resample`] |
//! | a part of it, fewer rows, no drift from rest to rest | [`Recording::within`], [`Recording::excluding`], [`Recording::decimated`], [`Recording::detrended`] |
//!
//! # Examples
//!
//! ```
//! use recording::{Quantity, ReadOptions, Sampling, parse_csv};
//!
//! let text = "time_ms,duty [%],position_mm\n0,0,0.00\n100,35,0.00\n200,35,0.02\n";
//! let recording = parse_csv(text.as_bytes(), "run3.csv", &ReadOptions::new(Quantity::Duty))?;
//! recording.check_identifiable()?;
//!
//! assert_eq!(recording.drive(), [0.0, 0.35, 0.35]);
//! match recording.sampling() {
//!     Sampling::Uniform { dt_s } => assert!((dt_s - 0.1).abs() < 1e-12),
//!     other => unreachable!("{other:?}"),
//! }
//! # Ok::<(), recording::RecordingError>(())
//! ```

mod adapt;
mod check;
mod clipping;
mod columns;
mod cycles;
mod digits;
mod drive_noise;
mod error;
mod faults;
mod files;
mod holds;
mod inspect;
mod layout;
mod limited;
mod lines;
mod mended;
mod noise;
pub mod order;
mod ordered;
mod quantity;
mod quantization;
mod rates;
mod read;
mod recording;
mod repeated;
mod resample;
mod resistance;
mod resolution;
mod sampling;
mod slip;
mod stretches;
mod stuck;
mod survey;
mod unit;
mod used;
mod warning;
mod wild;
mod write;

pub use adapt::Adaptation;
pub use clipping::{Clipping, Side, clipping};
pub use columns::{ColumnKey, ColumnSpec, Columns, ResistanceSpec};
pub use cycles::{Cycle, Repeats, cycles, repeats, split_by_cycles};
pub use drive_noise::{DriveNoise, drive_noise};
pub use error::{Position, RecordingError};
pub use files::{open_regular, read_text};
pub use holds::{HOLD_TOLERANCE, Hold, holds};
pub use inspect::{Channel, Inspection, LONG_HOLD_S, SETTLE_S, inspect, inspect_as_recorded};
pub use mended::{mended, smoothed};
pub use noise::{DifferenceNoise, HoldNoise, NoiseConfig, NoiseFloor, RepeatNoise, noise_floor};
pub use quantity::Quantity;
pub use quantization::quantization_step;
pub use rates::has_one_rate;
pub use read::{ReadOptions, parse_csv, read_csv, read_drive_csv};
pub use recording::{Recording, RecordingParts};
pub use repeated::{Apart, Difference, Part, RepeatFloor, RepeatedDrive, repeat_floor};
pub use resample::resample;
pub use resistance::Resistance;
pub use resolution::{DriveResolution, drive_resolution};
pub use sampling::{GAP_FACTOR, Gap, Sampling};
pub use slip::{Slip, slips};
pub use stuck::{Stuck, stuck};
pub use survey::{Meaning, Survey, SurveyedColumn, survey};
pub use warning::Warning;
pub use wild::{Wild, wild};
pub use write::write_csv;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
