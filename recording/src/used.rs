//! Parts and corrections of a recording that its user asks for.

use std::ops::Range;

use crate::adapt::Adaptation;
use crate::error::RecordingError;
use crate::holds::{HOLD_TOLERANCE, range};
use crate::quantity::Quantity;
use crate::recording::{Recording, RecordingParts};

/// Fewest samples at rest from which a level is read.
const FEWEST_AT_REST: usize = 10;

/// The output has settled at the end of a rest if it moves less than this share of its range from the third quarter of it to the
/// fourth, beside the line itself.
const SETTLED: f64 = 0.01;

impl Recording {
    /// The parts that spans leave of the recording, s, both ends of a span left out, too; each says so among its
    /// [`Recording::adaptations`].
    ///
    /// A span at the start or the end leaves one part, with the name of the recording. One in the middle leaves two. The state in which
    /// the second begins is not that in which the first ends, so they are recordings of their own, named by their first and last time
    /// stamp as a window of the recording is: `run3.csv:0..32.9` and `run3.csv:41.1..60`.
    ///
    /// # Errors
    ///
    /// [`RecordingError::NoTime`] for static data, [`RecordingError::RangeOutside`] if nothing is left, if fewer than two samples are
    /// between two spans, or if the end of a span is not behind its start.
    pub fn excluding(&self, spans_s: &[[f64; 2]]) -> Result<Vec<Self>, RecordingError> {
        let time_s = self.time_s();
        if time_s.is_empty() {
            return Err(RecordingError::NoTime {
                file: self.name().to_owned(),
            });
        }
        if !spans_s.iter().all(|[start_s, end_s]| start_s <= end_s) {
            // No span: nothing would be left.
            return self.slice(0..0).map(|none| vec![none]);
        }
        let is_left = |time_s: &f64| {
            let mut spans = spans_s.iter();
            !spans.any(|[start_s, end_s]| start_s <= time_s && time_s <= end_s)
        };
        let is_left: Vec<bool> = time_s.iter().map(is_left).collect();
        let mut parts: Vec<Range<usize>> = Vec::new();
        for (k, _) in is_left.iter().enumerate().filter(|(_, is_left)| **is_left) {
            match parts.last_mut() {
                Some(last) if last.end == k => last.end = k + 1,
                _ => parts.push(k..k + 1),
            }
        }
        if parts.is_empty() {
            parts.push(0..0);
        }
        let n_parts = parts.len();
        let part = |range: Range<usize>| {
            let mut part = self.slice(range)?.adapted_by(self.adaptations().to_vec());
            for [start_s, end_s] in spans_s {
                let what = format!("{start_s} to {end_s} s of it are left out");
                part = part.also_adapted_by(Adaptation::of_recording(what));
            }
            if n_parts > 1 {
                let [first_s, last_s] = [part.time_s()[0], part.time_s()[part.len() - 1]]
                    .map(|time_s| (1e3 * time_s).round() / 1e3);
                let what = "the parts are recordings of their own, each with its start and offset";
                part = part
                    .named(format!("{}:{first_s}..{last_s}", self.name()))
                    .also_adapted_by(Adaptation::of_recording(what.to_owned()));
            }
            Ok(part)
        };
        parts.into_iter().map(part).collect()
    }

    /// The recording in surroundings of one temperature, °C; says so among its [`Recording::adaptations`].
    ///
    /// # Errors
    ///
    /// [`RecordingError::AmbientTwice`] if the surroundings are recorded, and what [`Recording::new`] refuses: no finite number.
    pub fn surrounded_by(&self, ambient_degc: f64) -> Result<Self, RecordingError> {
        if self.ambient_degc().is_some() {
            return Err(RecordingError::AmbientTwice {
                file: self.name().to_owned(),
                ambient_degc,
            });
        }
        let done = Adaptation::of_recording(format!(
            "its surroundings have {ambient_degc} °C, as is stated"
        ));
        Ok(self.with_ambient(ambient_degc)?.also_adapted_by(done))
    }

    /// Every `n`-th row, with the mean of the `n` measured values around it (`n` − 1 of an even `n`), so that nothing is shifted in
    /// time; fewer at the ends. Time stamps are as they are. The drive until the next row is the mean in what it heats by, as in
    /// [`resample`](crate::resample); a held one stays as it is. Of static data the drive is a measured value, too.
    ///
    /// # Errors
    ///
    /// [`RecordingError::DecimationOutOfRange`] unless `n` ≥ 2 and at least two rows are left.
    pub fn decimated(&self, n: usize) -> Result<Self, RecordingError> {
        let most = self.len() / 2;
        if !(2..=most).contains(&n) {
            return Err(RecordingError::DecimationOutOfRange {
                file: self.name().to_owned(),
                n,
                most,
            });
        }
        let rows = || (0..self.len()).step_by(n);
        let mean = |values: &[f64]| -> Vec<f64> {
            let around = |k: usize| {
                let reach = ((n - 1) / 2).min(k).min(values.len() - 1 - k);
                let part = &values[k - reach..=k + reach];
                // From the middle one, so that equal values have themselves as their mean.
                let off: f64 = part.iter().map(|value| value - values[k]).sum();
                values[k] + off / part.len() as f64
            };
            rows().map(around).collect()
        };
        let heating = |drive: &[f64]| -> Vec<f64> {
            let until_next = rows().map(|k| k..(k + n).min(self.len()));
            until_next
                .map(|samples| self.heating_drive(drive, samples))
                .collect()
        };
        let time_s = self.time_s();
        let decimated = Self::new(RecordingParts {
            name: self.name().to_owned(),
            time_s: (!time_s.is_empty()).then(|| rows().map(|k| time_s[k]).collect()),
            drive_quantity: self.drive_quantity(),
            drive: match self.drive_quantity() {
                Quantity::Temperature => mean(self.drive()),
                _ => heating(self.drive()),
            },
            antagonist_drive: self.antagonist_drive().map(heating),
            smoothed_noise: self.smoothed_noise() / (n as f64).sqrt(),
            drive_unit: self.own_drive_unit(),
            output_unit: self.output_unit().to_owned(),
            output: mean(self.output()),
            temperature_degc: self.temperature_degc().map(mean),
            ambient_degc: self.ambient_degc().map(mean),
            stress_pa: self.stress_pa().map(mean),
            resistance: self
                .resistance()
                .map(|whole| whole.map(|values| mean(values))),
        })?;
        let what = format!("one row in {n} is used, with the mean of those around it");
        Ok(decimated
            .adapted_by(self.adaptations().to_vec())
            .also_adapted_by(Adaptation::of_recording(what)))
    }

    /// The one drive that heats as those of some samples of one of its drives do.
    fn heating_drive(&self, drive: &[f64], samples: Range<usize>) -> f64 {
        let (time_s, drive) = (self.time_s(), &drive[samples.clone()]);
        let first = drive[0];
        if drive.iter().all(|other| other.to_bits() == first.to_bits()) {
            return first;
        }
        let lasts_s = |k: usize| match (time_s.get(k), time_s.get(k + 1)) {
            (Some(now_s), Some(next_s)) => next_s - now_s,
            // The last row lasts as long as the one before it.
            (Some(now_s), None) => now_s - time_s[k - 1],
            _ => 1.0,
        };
        let (mut total_s, mut sum, mut squares) = (0.0, 0.0, 0.0);
        for (k, drive) in samples.zip(drive) {
            total_s += lasts_s(k);
            sum += lasts_s(k) * drive;
            squares += lasts_s(k) * drive * drive;
        }
        match self.drive_quantity() {
            Quantity::Current | Quantity::Voltage => (squares / total_s).sqrt().copysign(sum),
            _ => sum / total_s,
        }
    }

    /// The recording without the straight line that its output follows from the rest at its start to the rest at its end; says so
    /// among its [`Recording::adaptations`]. At the start nothing is taken off.
    ///
    /// # Errors
    ///
    /// [`RecordingError::NoRestAtBothEnds`] unless there are ten samples at rest at the start, and as many at the end in which the
    /// output has settled; [`RecordingError::NoTime`] for static data.
    pub fn detrended(&self) -> Result<Self, RecordingError> {
        let time_s = self.time_s();
        if time_s.is_empty() {
            return Err(RecordingError::NoTime {
                file: self.name().to_owned(),
            });
        }
        let levels = || self.drive().iter().map(|d| self.drive_quantity().level(*d));
        let (lowest, highest) = range(levels());
        let low = lowest + HOLD_TOLERANCE * (highest - lowest);
        let at_rest = levels().take_while(|level| *level <= low).count();
        let at_end = levels().rev().take_while(|level| *level <= low).count();
        let n = self.len();
        // The last quarter of the rest at the end, the one before it, and the rest at the start.
        let quarter = at_end / 4;
        let [start, before, end] = [0..at_rest, n - 2 * quarter..n - quarter, n - quarter..n]
            .map(|samples| self.mean(samples));
        let (bottom, top) = range(self.output().iter().copied());
        let is_whole = at_rest == n || quarter == 0;
        let slope = (end.output - start.output) / (end.time_s - start.time_s);
        let by_drift = slope * (end.time_s - before.time_s);
        let moves = (end.output - before.output - by_drift).abs() / (top - bottom);
        let enough = at_rest >= FEWEST_AT_REST && quarter >= FEWEST_AT_REST;
        let has_settled = moves < SETTLED;
        if is_whole || !enough || !has_settled {
            return Err(RecordingError::NoRestAtBothEnds {
                file: self.name().to_owned(),
                at_start: at_rest,
                at_end,
                moves: if moves.is_finite() {
                    100.0 * moves
                } else {
                    0.0
                },
            });
        }
        let mut detrended = self.clone();
        for (y, time_s) in detrended.output_mut().iter_mut().zip(time_s) {
            *y -= slope * (time_s - start.time_s);
        }
        let what = format!(
            "a straight line of {} {} from rest to rest is taken off the output",
            crate::warning::Short(end.output - start.output),
            self.output_unit()
        );
        Ok(detrended.also_adapted_by(Adaptation::of_recording(what)))
    }

    /// Mean time and output of some samples.
    fn mean(&self, samples: Range<usize>) -> Mean {
        let of = |values: &[f64]| {
            let part = &values[samples.clone()];
            part.iter().sum::<f64>() / part.len() as f64
        };
        Mean {
            time_s: of(self.time_s()),
            output: of(self.output()),
        }
    }
}

struct Mean {
    time_s: f64,
    output: f64,
}
