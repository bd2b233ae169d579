//! The checked value.

use std::ops::Range;
use std::path::Path;

use crate::adapt::Adaptation;
use crate::check::{Place, check_duty, check_rising};
use crate::error::{Position, RecordingError};
use crate::layout::shown;
use crate::quantity::Quantity;
use crate::resistance::Resistance;
use crate::sampling::{Gap, Sampling, gaps};
use crate::unit::output_symbol;
use crate::warning::WithUnit;

/// A recording of an actuator: samples of drive and output, checked and in known units.
///
/// All columns have the same length, at least 2; all numbers are finite; time rises; a duty is in
/// 0..1. Row k holds the drive from t_k to t_(k+1); the output of row k is measured at t_k, before
/// that drive acts.
///
/// # Examples
///
/// ```
/// use recording::{Quantity, Recording, RecordingParts, Sampling};
///
/// let recording = Recording::new(RecordingParts {
///     name: "generated".to_owned(),
///     time_s: Some((0..100).map(|k| 0.287 * f64::from(k)).collect()),
///     drive_quantity: Quantity::Current,
///     drive: (0..100).map(|k| if k < 50 { 0.0 } else { 1.8 }).collect(),
///     output_unit: "mm".to_owned(),
///     output: vec![0.0; 100],
///     ..RecordingParts::default()
/// })?;
/// assert!(matches!(recording.sampling(), Sampling::Uniform { .. }));
///
/// // A sound recording, but nothing to identify a model from.
/// let fault = recording.check_identifiable();
/// assert!(fault.is_err_and(|fault| fault.to_string().starts_with("generated: output is 0 mm")));
/// # Ok::<(), recording::RecordingError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    pub(crate) parts: RecordingParts,
    sampling: Sampling,
    pub(crate) adaptations: Vec<Adaptation>,
}

/// Parts of a [`Recording`]; all slices of one length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RecordingParts {
    /// Name in errors and reports.
    pub name: String,
    /// Time, s; rising. `None` for static data, which have no time.
    pub time_s: Option<Vec<f64>>,
    /// Quantity of `drive`.
    pub drive_quantity: Quantity,
    /// Drive in the unit of its quantity: A, 0..1, V, W or °C.
    pub drive: Vec<f64>,
    /// Drive of a second actuator that pulls the other way, in the unit of `drive`. `None` beside a drive that is a temperature.
    pub antagonist_drive: Option<Vec<f64>>,
    /// Standard deviation of the noise that was taken out of `drive`, in its unit: what is left of it in levels and ramps no column
    /// shows. 0 where none was.
    pub smoothed_noise: f64,
    /// Unit of `drive` where a [`Quantity::Temperature`] stands for another input of a static loop, a
    /// stress or the voltage of a source; empty otherwise.
    pub drive_unit: String,
    /// Unit of `output`: mm, deg, N, ...; `1` or nothing where it has none.
    pub output_unit: String,
    /// Output, in `output_unit`.
    pub output: Vec<f64>,
    /// Measured temperature of the actuator, °C. `None` beside a drive that is a temperature.
    pub temperature_degc: Option<Vec<f64>>,
    /// Measured temperature of the surroundings, °C.
    pub ambient_degc: Option<Vec<f64>>,
    /// Measured stress in the actuator, Pa.
    pub stress_pa: Option<Vec<f64>>,
    /// Measured resistance of the actuator.
    pub resistance: Option<Resistance>,
}

impl Recording {
    /// Adaptations that made the file readable, and changes to the recording after reading. Empty if the file is as the
    /// format says, and for a [`Self::slice`] of a recording.
    #[must_use]
    pub fn adaptations(&self) -> &[Adaptation] {
        &self.adaptations
    }

    /// This recording, with the adaptations of its file before its own.
    pub(crate) fn adapted_by(self, mut adaptations: Vec<Adaptation>) -> Self {
        adaptations.extend(self.adaptations);
        Self {
            adaptations,
            ..self
        }
    }

    /// This recording, with one more adaptation.
    pub(crate) fn also_adapted_by(mut self, done: Adaptation) -> Self {
        self.adaptations.push(done);
        self
    }

    /// Name of its file, without the folders of the path: as rod files name it.
    pub(crate) fn file_name(&self) -> String {
        let name = Path::new(self.name()).file_name();
        name.map_or_else(String::new, |name| name.to_string_lossy().into_owned())
    }

    /// This recording under another name.
    pub(crate) fn named(mut self, name: String) -> Self {
        self.parts.name = name;
        self
    }

    /// This recording, in surroundings of one temperature, °C.
    pub(crate) fn with_ambient(&self, ambient_degc: f64) -> Result<Self, RecordingError> {
        let parts = RecordingParts {
            ambient_degc: Some(vec![ambient_degc; self.len()]),
            ..self.parts.clone()
        };
        Ok(Self::new(parts)?.adapted_by(self.adaptations.clone()))
    }

    /// This recording with another output in the same unit, such as the residual of a model.
    ///
    /// # Errors
    ///
    /// Errors of [`Recording::new`]: another number of samples, numbers that are not finite.
    pub fn with_output(&self, output: Vec<f64>) -> Result<Self, RecordingError> {
        let parts = RecordingParts {
            output,
            ..self.parts.clone()
        };
        Ok(Self::new(parts)?.adapted_by(self.adaptations.clone()))
    }

    /// This recording with another drive in the same unit.
    ///
    /// # Errors
    ///
    /// Errors of [`Recording::new`]: another number of samples, numbers that are not finite.
    pub fn driven_by(&self, drive: Vec<f64>) -> Result<Self, RecordingError> {
        let parts = RecordingParts {
            drive,
            ..self.parts.clone()
        };
        Ok(Self::new(parts)?.adapted_by(self.adaptations.clone()))
    }

    /// Standard deviation of the noise that was taken out of the drive, in its unit; 0 where none was.
    #[must_use]
    pub fn smoothed_noise(&self) -> f64 {
        self.parts.smoothed_noise
    }

    /// Puts the times right.
    pub(crate) fn change_time(&mut self, change: impl FnOnce(&mut [f64])) {
        if let Some(time_s) = &mut self.parts.time_s {
            change(time_s);
            self.sampling = Sampling::of(time_s);
        }
    }

    /// The drive, to be put right.
    pub(crate) fn drive_mut(&mut self) -> &mut [f64] {
        &mut self.parts.drive
    }

    /// The drives of all actuators, to be put right.
    pub(crate) fn drives_mut(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        let antagonist = self.parts.antagonist_drive.as_mut();
        std::iter::once(&mut self.parts.drive).chain(antagonist)
    }

    /// The output, to be put right.
    pub(crate) fn output_mut(&mut self) -> &mut [f64] {
        &mut self.parts.output
    }

    /// Checks samples in memory, as the reader checks those of a file.
    ///
    /// # Errors
    ///
    /// [`RecordingError`], naming column, sample (counted from 0) and value: slices of unequal
    /// length or of fewer than two samples, a number that is not finite, time that does not rise, a
    /// duty outside 0..1, an output unit that cannot be written, two temperatures.
    pub fn new(parts: RecordingParts) -> Result<Self, RecordingError> {
        let time = ("time_s", "s", parts.time_s.as_deref());
        let drive = (
            parts.drive_quantity.column(),
            match parts.drive_unit.as_str() {
                "" => parts.drive_quantity.unit(),
                unit => unit,
            },
        );
        let antagonist = (
            "antagonist_drive",
            drive.1,
            parts.antagonist_drive.as_deref(),
        );
        let mut rest = vec![
            antagonist,
            (
                "output",
                parts.output_unit.as_str(),
                Some(parts.output.as_slice()),
            ),
            (
                "temperature_degc",
                "degC",
                parts.temperature_degc.as_deref(),
            ),
            ("ambient_degc", "degC", parts.ambient_degc.as_deref()),
            ("stress_pa", "Pa", parts.stress_pa.as_deref()),
        ];
        let resistance = parts.resistance.iter().flat_map(Resistance::columns);
        rest.extend(resistance.map(|(column, unit, values)| (column, unit, Some(values))));
        for (column, _, values) in std::iter::once(&time).chain(&rest) {
            match values {
                Some(values) if values.len() != parts.drive.len() => {
                    return Err(RecordingError::UnequalLengths {
                        file: parts.name.clone(),
                        column,
                        n_samples: values.len(),
                        expected: parts.drive.len(),
                    });
                }
                _ => {}
            }
        }
        let drive = (drive.0, drive.1, Some(parts.drive.as_slice()));
        for (column, unit, values) in [time, drive].iter().chain(&rest) {
            check_finite(&parts.name, column, unit, values.unwrap_or(&[]))?;
        }
        check_time(&parts.name, parts.time_s.as_deref().unwrap_or(&[]))?;
        if parts.drive_quantity == Quantity::Duty {
            for (column, _, duties) in [drive, antagonist] {
                for (sample, &duty) in duties.unwrap_or(&[]).iter().enumerate() {
                    check_duty(duty, 1.0, &place(&parts.name, column, sample))?;
                }
            }
        }
        Self::from_checked(parts)
    }

    /// The recording of samples that are checked one by one; checks what concerns them together.
    pub(crate) fn from_checked(mut parts: RecordingParts) -> Result<Self, RecordingError> {
        let n_samples = parts.drive.len();
        if n_samples < 2 {
            return Err(RecordingError::TooFewSamples {
                file: parts.name,
                n_samples,
            });
        }
        if parts.drive_quantity == Quantity::Temperature && parts.temperature_degc.is_some() {
            return Err(RecordingError::TwoTemperatures { file: parts.name });
        }
        if parts.drive_quantity == Quantity::Temperature && parts.antagonist_drive.is_some() {
            return Err(RecordingError::StaticAntagonist { file: parts.name });
        }
        if parts.drive_quantity != Quantity::Temperature && !parts.drive_unit.is_empty() {
            return Err(RecordingError::DriveUnit {
                file: parts.name,
                unit: shown(&parts.drive_unit),
                quantity: parts.drive_quantity.name(),
                expected: parts.drive_quantity.unit(),
            });
        }
        let unwritable = |c: char| c.is_control() || matches!(c, '[' | ']' | '"');
        for unit in [&parts.drive_unit, &parts.output_unit] {
            if unit.contains(unwritable) {
                return Err(RecordingError::InvalidUnit {
                    file: parts.name,
                    unit: shown(unit),
                });
            }
        }
        parts.output_unit = output_symbol(&parts.output_unit);
        parts.drive.shrink_to_fit();
        parts.output.shrink_to_fit();
        let optional = [
            &mut parts.time_s,
            &mut parts.antagonist_drive,
            &mut parts.temperature_degc,
            &mut parts.ambient_degc,
            &mut parts.stress_pa,
        ];
        optional.into_iter().flatten().for_each(Vec::shrink_to_fit);
        let sampling = Sampling::of(parts.time_s.as_deref().unwrap_or(&[]));
        Ok(Self {
            parts,
            sampling,
            adaptations: Vec::new(),
        })
    }

    /// Name in errors and reports: the path of a file, as it was given.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.parts.name
    }

    /// Time, s; rising. Empty if [`Self::sampling`] is [`Sampling::Untimed`].
    #[must_use]
    pub fn time_s(&self) -> &[f64] {
        self.parts.time_s.as_deref().unwrap_or(&[])
    }

    /// Drive in the unit of its quantity: A, 0..1, V, W or °C.
    #[must_use]
    pub fn drive(&self) -> &[f64] {
        &self.parts.drive
    }

    /// Drive of a second actuator that pulls the other way, in the unit of [`Self::drive`].
    #[must_use]
    pub fn antagonist_drive(&self) -> Option<&[f64]> {
        self.parts.antagonist_drive.as_deref()
    }

    /// The drives of all actuators, one or two, that of the first one first.
    pub fn drives(&self) -> impl Iterator<Item = &[f64]> + Clone {
        std::iter::once(self.drive()).chain(self.antagonist_drive())
    }

    /// Unit of the drive: that of its quantity, but for a static loop with an input of its own.
    #[must_use]
    pub fn drive_unit(&self) -> &str {
        match self.parts.drive_unit.as_str() {
            "" => self.parts.drive_quantity.unit(),
            unit => unit,
        }
    }

    /// Unit of the drive as it stands in [`RecordingParts`]: empty if it is that of the quantity.
    pub(crate) fn own_drive_unit(&self) -> String {
        self.parts.drive_unit.clone()
    }

    /// Largest magnitude of the drives, in their unit.
    #[must_use]
    pub fn largest_drive(&self) -> f64 {
        let drives = self.drives().flatten();
        drives.fold(0.0, |largest, drive| largest.max(drive.abs()))
    }

    /// The drive at `n_samples` even times, `dt_s` seconds apart from the first time stamp on: held between samples, and
    /// after the last. Empty for static data.
    ///
    /// Unlike [`resample`](crate::resample) it averages nothing: for set points, and steps no longer than its own.
    #[must_use]
    pub fn held_drive(&self, dt_s: f64, n_samples: usize) -> Vec<f64> {
        /// Share of a step by which time stamps are rounded.
        const ROUNDED: f64 = 1e-6;
        let (time_s, drive) = (self.time_s(), self.drive());
        let Some(first_s) = time_s.first() else {
            return Vec::new();
        };
        let mut at = 0;
        (0..n_samples)
            .map(|k| {
                let now_s = first_s + (k as f64 + ROUNDED) * dt_s;
                while at + 1 < time_s.len() && time_s[at + 1] <= now_s {
                    at += 1;
                }
                drive[at]
            })
            .collect()
    }

    /// Quantity of the drive.
    #[must_use]
    pub fn drive_quantity(&self) -> Quantity {
        self.parts.drive_quantity
    }

    /// Output, in [`Self::output_unit`].
    #[must_use]
    pub fn output(&self) -> &[f64] {
        &self.parts.output
    }

    /// Unit of the output: `mm`, `deg`, `N`, ...; `1` where it has none or none is stated.
    #[must_use]
    pub fn output_unit(&self) -> &str {
        &self.parts.output_unit
    }

    /// Measured temperature of the actuator, °C.
    #[must_use]
    pub fn temperature_degc(&self) -> Option<&[f64]> {
        self.parts.temperature_degc.as_deref()
    }

    /// Measured temperature of the surroundings, °C.
    #[must_use]
    pub fn ambient_degc(&self) -> Option<&[f64]> {
        self.parts.ambient_degc.as_deref()
    }

    /// Measured stress in the actuator, Pa.
    #[must_use]
    pub fn stress_pa(&self) -> Option<&[f64]> {
        self.parts.stress_pa.as_deref()
    }

    /// Measured resistance of the actuator.
    #[must_use]
    pub fn resistance(&self) -> Option<&Resistance> {
        self.parts.resistance.as_ref()
    }

    /// Number of samples, at least 2.
    #[must_use]
    pub fn len(&self) -> usize {
        self.parts.drive.len()
    }

    /// Never: a recording has at least two samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.parts.drive.is_empty()
    }

    /// Sampling of the recording: equal steps of time, unequal ones, or no time.
    #[must_use]
    pub fn sampling(&self) -> Sampling {
        self.sampling
    }

    /// Steps longer than [`GAP_FACTOR`](crate::GAP_FACTOR) times the median step, in order.
    #[must_use]
    pub fn gaps(&self) -> Vec<Gap> {
        gaps(self.time_s(), self.sampling)
    }

    /// The samples in `range` as a recording of their own: same name, time as recorded, sampling
    /// judged anew.
    ///
    /// # Errors
    ///
    /// [`RecordingError::RangeOutside`] unless `range` lies in 0..[`Self::len`] and holds at least
    /// two samples.
    pub fn slice(&self, range: Range<usize>) -> Result<Self, RecordingError> {
        let (start, end, n_samples) = (range.start, range.end, self.len());
        if end > n_samples || start > end || end - start < 2 {
            return Err(RecordingError::RangeOutside {
                file: self.parts.name.clone(),
                start,
                end,
                n_samples,
            });
        }
        let part = |values: &Vec<f64>| values[start..end].to_vec();
        Self::from_checked(RecordingParts {
            name: self.parts.name.clone(),
            time_s: self.parts.time_s.as_ref().map(part),
            drive_quantity: self.parts.drive_quantity,
            drive: part(&self.parts.drive),
            smoothed_noise: self.parts.smoothed_noise,
            antagonist_drive: self.parts.antagonist_drive.as_ref().map(part),
            drive_unit: self.parts.drive_unit.clone(),
            output_unit: self.parts.output_unit.clone(),
            output: part(&self.parts.output),
            temperature_degc: self.parts.temperature_degc.as_ref().map(part),
            ambient_degc: self.parts.ambient_degc.as_ref().map(part),
            stress_pa: self.parts.stress_pa.as_ref().map(part),
            resistance: self.parts.resistance.as_ref().map(|whole| whole.map(part)),
        })
    }

    /// This recording with drives that act `by_s` seconds earlier than recorded, held after the last sample. Unchanged for
    /// static data.
    ///
    /// The drive of a sample is the mean of the shifted drive over its span, so that no step is rounded to a sample.
    #[must_use]
    pub fn driven_earlier(&self, by_s: f64) -> Self {
        let time_s = self.time_s();
        let mut moved = self.clone();
        if time_s.is_empty() {
            return moved;
        }
        for (moved, drive) in moved.drives_mut().zip(self.drives()) {
            // Of the drive from the first sample on.
            let mut integral = vec![0.0; time_s.len()];
            for k in 1..time_s.len() {
                integral[k] = integral[k - 1] + drive[k - 1] * (time_s[k] - time_s[k - 1]);
            }
            let up_to = |at_s: f64| {
                let k = time_s.partition_point(|time_s| *time_s <= at_s).max(1) - 1;
                integral[k] + drive[k] * (at_s - time_s[k])
            };
            for k in 0..time_s.len() - 1 {
                let (from_s, to_s) = (time_s[k] + by_s, time_s[k + 1] + by_s);
                moved[k] = (up_to(to_s) - up_to(from_s)) / (to_s - from_s);
            }
        }
        moved
    }

    /// This recording with another drive in one sample, counted from 0, which says so among its [`Recording::adaptations`].
    ///
    /// # Panics
    ///
    /// Panics if there is no such sample.
    #[must_use]
    pub fn driven_in(&self, sample: usize, drive: f64) -> Self {
        let with_unit = |value| WithUnit(value, self.drive_unit()).to_string();
        let place = match self.time_s().get(sample) {
            Some(time_s) => format!("at {time_s} s"),
            None => format!("in sample {sample}"),
        };
        let recorded = with_unit(self.drive()[sample]);
        let done = format!(
            "the drive of {recorded} {place} does not fit the output: {} is taken, as beside it",
            with_unit(drive)
        );
        let mut changed = self.clone();
        changed.drive_mut()[sample] = drive;
        changed.also_adapted_by(Adaptation::of_recording(done))
    }

    /// The samples from one time to another, s, both included, as a recording of their own, which says so among its
    /// [`Recording::adaptations`].
    ///
    /// # Errors
    ///
    /// [`RecordingError::NoTime`] for static data, [`RecordingError::RangeOutside`] for fewer than two samples.
    pub fn within(&self, start_s: f64, end_s: f64) -> Result<Self, RecordingError> {
        let time_s = self.time_s();
        if time_s.is_empty() {
            return Err(RecordingError::NoTime {
                file: self.parts.name.clone(),
            });
        }
        let start = time_s.partition_point(|time_s| *time_s < start_s);
        let end = time_s.partition_point(|time_s| *time_s <= end_s);
        let used = Adaptation::of_recording(format!("{start_s} to {end_s} s of it are used"));
        let slice = self.slice(start..end.max(start))?;
        Ok(slice
            .adapted_by(self.adaptations.clone())
            .also_adapted_by(used))
    }

    /// Checks that there is anything to identify: both drive and output change.
    ///
    /// Not part of reading, so that a recording of nothing can still be inspected.
    ///
    /// # Errors
    ///
    /// [`RecordingError::NeverChanges`], for the drive first.
    pub fn check_identifiable(&self) -> Result<(), RecordingError> {
        let drive = ("drive", self.drive(), self.drive_unit());
        let antagonist = self.antagonist_drive();
        let antagonist = antagonist.map(|drive| ("antagonist drive", drive, self.drive_unit()));
        let output = ("output", self.output(), self.output_unit());
        for (role, values, unit) in [Some(drive), antagonist, Some(output)]
            .into_iter()
            .flatten()
        {
            let lowest = values.iter().copied().fold(f64::INFINITY, f64::min);
            let highest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            if highest > lowest {
                continue;
            }
            return Err(RecordingError::NeverChanges {
                file: self.parts.name.clone(),
                role,
                value: lowest,
                unit: unit.to_owned(),
                n_samples: values.len(),
            });
        }
        Ok(())
    }
}

fn place<'a>(file: &'a str, column: &'a str, sample: usize) -> Place<'a> {
    Place {
        file,
        at: Position::Sample(sample),
        column,
    }
}

fn check_finite(
    file: &str,
    column: &str,
    unit: &str,
    values: &[f64],
) -> Result<(), RecordingError> {
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(k) => Err(place(file, column, k).not_finite(values[k].to_string(), unit)),
    }
}

fn check_time(file: &str, time_s: &[f64]) -> Result<(), RecordingError> {
    for (k, pair) in time_s.windows(2).enumerate() {
        check_rising(
            pair[1] > pair[0],
            &place(file, "time_s", k + 1),
            pair[1],
            pair[0],
        )?;
    }
    Ok(())
}
