//! Stretches of constant drive.

use std::ops::Range;

use crate::recording::Recording;
use crate::sampling::{GAP_FACTOR, Sampling};

/// A drive counts as constant while it stays within this share of its range over the whole
/// recording: below what any lab would call a step, above the ripple of a supply. Our choice.
pub const HOLD_TOLERANCE: f64 = 0.01;

/// Fewest samples of a hold: two of them are a slow ramp as well.
const FEWEST_SAMPLES: usize = 3;

/// A stretch of constant drive.
#[derive(Debug, Clone, PartialEq)]
pub struct Hold {
    /// Its samples: the drive is held from the time of the first to that of the one after the last,
    /// or of the last where the recording ends.
    pub samples: Range<usize>,
    /// The drive, in its unit; the middle of its range in the hold.
    pub drive: f64,
    /// How long it is held, s.
    pub duration_s: f64,
}

/// The holds of a recording that last longer than `longer_than_s` seconds, in order.
///
/// A hold starts where the last one ended and goes on while highest minus lowest drive stays within
/// [`HOLD_TOLERANCE`] of the range of the drive. It has at least three samples and no gap in it. A
/// slow ramp counts too, as long as it moves by less than that. None in static data, nor if
/// `longer_than_s` is NaN.
///
/// # Examples
///
/// ```
/// use recording::{Recording, RecordingParts, holds};
///
/// let recording = Recording::new(RecordingParts {
///     time_s: Some((0..400).map(|k| 0.5 * f64::from(k)).collect()),
///     drive: (0..400).map(|k| if (100..300).contains(&k) { 1.8 } else { 0.0 }).collect(),
///     output: vec![0.0; 400],
///     ..RecordingParts::default()
/// })?;
/// let hot = holds(&recording, 60.0);
/// assert_eq!((hot.len(), &hot[0].samples), (1, &(100..300)));
/// assert!((hot[0].duration_s - 100.0).abs() < 1e-9);
/// # Ok::<(), recording::RecordingError>(())
/// ```
#[must_use]
pub fn holds(recording: &Recording, longer_than_s: f64) -> Vec<Hold> {
    let time_s = recording.time_s();
    let n = recording.len();
    let longest_step_s = match recording.sampling() {
        Sampling::Uniform { .. } => f64::INFINITY,
        Sampling::Jittered { median_dt_s, .. } => GAP_FACTOR * median_dt_s,
        Sampling::Untimed => return Vec::new(),
    };
    // An antagonist moves the output as well.
    let mut drives: Vec<Held<'_>> = recording.drives().map(Held::of).collect();
    let mut found = Vec::new();
    let mut start = 0;
    while start < n {
        drives.iter_mut().for_each(|held| held.begin(start));
        let mut end = start + 1;
        while end < n
            && time_s[end] - time_s[end - 1] <= longest_step_s
            && drives.iter().all(|held| held.stands(end))
        {
            drives.iter_mut().for_each(|held| held.take(end));
            end += 1;
        }
        let ends_in_gap = end < n && time_s[end] - time_s[end - 1] > longest_step_s;
        let last = if ends_in_gap || end == n {
            end - 1
        } else {
            end
        };
        let duration_s = time_s[last] - time_s[start];
        if duration_s > longer_than_s && end - start >= FEWEST_SAMPLES {
            found.push(Hold {
                samples: start..end,
                drive: drives[0].middle(),
                duration_s,
            });
        }
        start = end;
    }
    found
}

/// A drive, and its range in a hold.
struct Held<'a> {
    drive: &'a [f64],
    /// How far it may move, in its unit.
    tolerance: f64,
    low: f64,
    high: f64,
}

impl<'a> Held<'a> {
    fn of(drive: &'a [f64]) -> Self {
        let (low, high) = range(drive.iter().copied());
        Self {
            drive,
            tolerance: HOLD_TOLERANCE * (high - low).min(f64::MAX),
            low,
            high,
        }
    }

    fn begin(&mut self, at: usize) {
        (self.low, self.high) = (self.drive[at], self.drive[at]);
    }

    /// True if the drive is still held with one sample more.
    fn stands(&self, at: usize) -> bool {
        let drive = self.drive[at];
        self.high.max(drive) - self.low.min(drive) <= self.tolerance
    }

    fn take(&mut self, at: usize) {
        let drive = self.drive[at];
        (self.low, self.high) = (self.low.min(drive), self.high.max(drive));
    }

    fn middle(&self) -> f64 {
        0.5 * self.low + 0.5 * self.high
    }
}

/// Lowest and highest of finite values; (∞, −∞) of none.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (value.min(low), value.max(high))
    })
}
