//! Measured quantities of recordings, and the check that they agree.

use recording::{Quantity, Recording};

use crate::IdentifyError;

/// Recordings that are looked at together measure one thing in one unit, under one kind of drive.
pub(crate) fn one_unit(recordings: &[Recording]) -> Result<(), IdentifyError> {
    let Some(first) = recordings.first() else {
        return Ok(());
    };
    let expected = Quantities::of(first);
    recordings
        .iter()
        .try_for_each(|recording| same_quantities(recording, first.name(), &expected))
}

/// Measured quantities of a recording, with their units.
pub(crate) struct Quantities<'a> {
    pub(crate) output_unit: &'a str,
    pub(crate) drive: Quantity,
    pub(crate) drive_unit: &'a str,
}

impl<'a> Quantities<'a> {
    fn of(recording: &'a Recording) -> Self {
        Self {
            output_unit: recording.output_unit(),
            drive: recording.drive_quantity(),
            drive_unit: recording.drive_unit(),
        }
    }

    fn drive(&self) -> String {
        if self.drive_unit == self.drive.unit() {
            self.drive.name().to_owned()
        } else {
            format!("an input in {}", self.drive_unit)
        }
    }
}

/// Refuses a recording that does not measure what `first` does.
pub(crate) fn same_quantities(
    recording: &Recording,
    first: &str,
    expected: &Quantities<'_>,
) -> Result<(), IdentifyError> {
    if recording.output_unit() != expected.output_unit {
        return Err(IdentifyError::Units {
            recording: recording.name().to_owned(),
            found: recording.output_unit().to_owned(),
            first: first.to_owned(),
            expected: expected.output_unit.to_owned(),
        });
    }
    let found = Quantities::of(recording);
    if (found.drive, found.drive_unit) != (expected.drive, expected.drive_unit) {
        return Err(IdentifyError::Drives {
            recording: recording.name().to_owned(),
            found: found.drive(),
            first: first.to_owned(),
            expected: expected.drive(),
        });
    }
    Ok(())
}
