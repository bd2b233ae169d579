//! A drive behind a supply that saturates.

use crate::adapt::Adaptation;
use crate::{Recording, RecordingError};

impl Recording {
    /// The recording with the drive that acts behind a supply that saturates.
    ///
    /// ```text
    /// drive' = sign(drive) min(|drive|, limit)
    /// ```
    ///
    /// `limit` is in the unit of the drive, > 0. Where it cuts anything off, [`Recording::adaptations`] says so.
    ///
    /// # Errors
    ///
    /// [`RecordingError::DriveLimit`].
    pub fn limited(mut self, limit: f64) -> Result<Self, RecordingError> {
        if !(limit > 0.0 && limit.is_finite()) {
            return Err(RecordingError::DriveLimit {
                file: self.name().to_owned(),
                limit,
                unit: self.drive_unit().to_owned(),
            });
        }
        let is_beyond = |drive: &f64| drive.abs() > limit;
        let firsts = self
            .drives()
            .filter_map(|drive| drive.iter().position(is_beyond));
        let Some(first) = firsts.min() else {
            return Ok(self);
        };
        let n_beyond = self
            .drives()
            .flatten()
            .filter(|drive| is_beyond(drive))
            .count();
        let unit = match self.drive_unit() {
            "1" => String::new(),
            unit => format!(" {unit}"),
        };
        let since = self.time_s().get(first);
        let since = since.map_or_else(|| format!("sample {first}"), |time_s| format!("{time_s} s"));
        let largest = self.largest_drive();
        let what = format!(
            "the supply gives at most {limit}{unit}: {n_beyond} samples of the drive, up to {largest}{unit} and the first at {since}, \
             count as that"
        );
        for drive in self.drives_mut().flatten() {
            *drive = drive.abs().min(limit).copysign(*drive);
        }
        Ok(self.also_adapted_by(Adaptation::of_recording(what)))
    }
}
