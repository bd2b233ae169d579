//! The checks of one sample, the same for files and for slices.

use crate::error::{Position, RecordingError};

/// Where a checked value stands.
pub(crate) struct Place<'a> {
    pub(crate) file: &'a str,
    pub(crate) at: Position,
    pub(crate) column: &'a str,
}

impl Place<'_> {
    pub(crate) fn not_finite(&self, value: String, unit: &str) -> RecordingError {
        RecordingError::NotFinite {
            file: self.file.to_owned(),
            at: self.at,
            column: self.column.to_owned(),
            value,
            unit: unit.to_owned(),
        }
    }
}

/// Checks that time `rises`, from `previous` to `value` as an error shows them.
pub(crate) fn check_rising(
    rises: bool,
    place: &Place<'_>,
    value: f64,
    previous: f64,
) -> Result<(), RecordingError> {
    if rises {
        return Ok(());
    }
    Err(RecordingError::TimeNotRising {
        file: place.file.to_owned(),
        at: place.at,
        column: place.column.to_owned(),
        value,
        previous,
    })
}

/// Checks that a duty is in 0..`full_scale`.
pub(crate) fn check_duty(
    duty: f64,
    full_scale: f64,
    place: &Place<'_>,
) -> Result<(), RecordingError> {
    if (0.0..=full_scale).contains(&duty) {
        return Ok(());
    }
    Err(RecordingError::DutyOutOfRange {
        file: place.file.to_owned(),
        at: place.at,
        column: place.column.to_owned(),
        value: duty,
        full_scale,
    })
}
