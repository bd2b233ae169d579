//! Cycles of the drive.

use std::ops::Range;

use crate::error::RecordingError;
use crate::holds::range;
use crate::recording::Recording;
use crate::sampling::{GAP_FACTOR, Sampling};

/// A drive is near its minimum up to this share of its range. Our choice.
const NEAR_MINIMUM: f64 = 0.05;

/// It has risen once it is this share of its range higher still, so that ripple does not count.
const RISE: f64 = 0.05;

/// Levels at which the starts of repeated cycles are looked for, as shares of the range of the
/// drive: a sine about a bias does not come near the rest before it.
const START_LEVELS: [f64; 4] = [NEAR_MINIMUM, 0.25, 0.5, 0.75];

/// Most rises of the drive in one cycle that repeats.
const MOST_RISES: usize = 16;

/// Drives are the same within this share of the range of the drive. Our choice.
const SAME_DRIVE: f64 = 0.005;

/// Share of the samples of a cycle at which the drive may differ: those at its edges, where the
/// clocks of drive and logger differ. Our choice.
const MOST_DIFFERENT: f64 = 0.01;

/// A whole cycle of the drive.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cycle {
    /// Its samples, from one rise of the drive to the next.
    pub samples: Range<usize>,
}

/// Cycles in which the drive does the same again.
#[derive(Debug, Clone, PartialEq)]
pub struct Repeats {
    /// At least two cycles, one after the other, of equal duration.
    pub cycles: Vec<Cycle>,
    /// That duration, s.
    pub period_s: f64,
}

/// The whole cycles of a recording, in order and without gaps between them.
///
/// A cycle starts at the first sample above the lowest 5 % of the range of the drive, if from there
/// the drive rises beyond 10 %, and ends where the next one starts. The last one ends with the
/// recording, and is whole if the drive has come back to its lowest 5 %. Of a current or a voltage
/// the magnitude counts, since both heat by their square. Samples before the first rise belong to no
/// cycle. None if the drive never changes.
#[must_use]
pub fn cycles(recording: &Recording) -> Vec<Cycle> {
    let Rises { starts, returned } = Rises::from_level(recording, NEAR_MINIMUM);
    let ends = starts.iter().skip(1).copied();
    let ends = ends.chain(returned.then_some(recording.len()));
    let pairs = starts.iter().zip(ends);
    pairs
        .map(|(&start, end)| Cycle {
            samples: start..end,
        })
        .collect()
}

/// Splits a recording into `n_parts` ranges of whole cycles, of as equal length as the cycles allow:
/// for folds and for held-out parts.
///
/// The ranges follow each other and cover the whole recording: what comes before the first cycle
/// belongs to the first part, what comes after the last to the last. See
/// [`Recording::slice`] for the recording of a part.
///
/// # Errors
///
/// [`RecordingError::PartsOutOfRange`] if there are fewer whole cycles than parts, or no parts are
/// wanted. One part is always possible.
pub fn split_by_cycles(
    recording: &Recording,
    n_parts: usize,
) -> Result<Vec<Range<usize>>, RecordingError> {
    let cycles = cycles(recording);
    let most = cycles.len().max(1);
    if !(1..=most).contains(&n_parts) {
        return Err(RecordingError::PartsOutOfRange {
            file: recording.name().to_owned(),
            n_parts,
            most,
        });
    }
    let n_samples = recording.len();
    let mut parts = Vec::with_capacity(n_parts);
    let (mut start, mut first_cycle) = (0, 0);
    for part in 1..n_parts {
        // Each part takes a cycle at least, and leaves one for each of those to come.
        let candidates = first_cycle + 1..=cycles.len() - (n_parts - part);
        let wanted = start + (n_samples - start) / (n_parts - part + 1);
        let off = |cycle: &usize| cycles[*cycle].samples.start.abs_diff(wanted);
        let Some(next) = candidates.min_by_key(off) else {
            unreachable!("there are at least as many cycles as parts");
        };
        let end = cycles[next].samples.start;
        parts.push(start..end);
        (start, first_cycle) = (end, next);
    }
    parts.push(start..n_samples);
    Ok(parts)
}

/// Cycles that the drive repeats, or `None` if it does not.
///
/// The drive itself is compared, as a function of the time since the cycle began: two cycles are the
/// same if at 99 % of the samples the drives differ by no more than 0.5 % of the range of the drive.
/// A cycle may have several rises. Of several ways to cut a recording into repeated cycles the one
/// that covers most of it is taken, then the shortest period. `None` for static data; no cycle spans
/// a gap.
#[must_use]
pub fn repeats(recording: &Recording) -> Option<Repeats> {
    let comparison = Comparison::of(recording)?;
    let mut best: Option<Repeats> = None;
    for level in START_LEVELS {
        let starts = Rises::from_level(recording, level).starts;
        for n_rises in 1..=MOST_RISES.min(starts.len().saturating_sub(1)) {
            let mut from = 0;
            while from + n_rises < starts.len() {
                let found = comparison.repeats_from(&starts[from..], n_rises);
                let n_found = found.cycles.len();
                let covers = |repeats: &Repeats| repeats.period_s * repeats.cycles.len() as f64;
                // A thousandth: the same cycles started at another level are not more.
                let more = |best: &Repeats| covers(&found) > 1.001 * covers(best);
                if n_found >= 2 && best.as_ref().is_none_or(more) {
                    best = Some(found);
                }
                from += if n_found >= 2 {
                    (n_found - 1) * n_rises
                } else {
                    1
                };
            }
        }
    }
    best
}

/// Where the drive rises through a level.
struct Rises {
    starts: Vec<usize>,
    /// True if the drive is back below the level after the last rise.
    returned: bool,
}

impl Rises {
    fn from_level(recording: &Recording, level: f64) -> Self {
        let quantity = recording.drive_quantity();
        let levels = || recording.drive().iter().map(|drive| quantity.level(*drive));
        let (lowest, highest) = range(levels());
        let width = (highest - lowest).min(f64::MAX);
        let low = lowest + level * width;
        let high = lowest + (level + RISE) * width;
        let mut starts = Vec::new();
        let mut last_low = None;
        for (k, value) in levels().enumerate() {
            if value <= low {
                last_low = Some(k);
            } else if let Some(k) = last_low.filter(|_| value > high) {
                starts.push(k + 1);
                last_low = None;
            }
        }
        Self {
            returned: last_low.is_some(),
            starts,
        }
    }
}

/// Compares stretches of the drive.
struct Comparison<'a> {
    recording: &'a Recording,
    dt_s: f64,
    uniform: bool,
    tolerance: f64,
}

impl<'a> Comparison<'a> {
    fn of(recording: &'a Recording) -> Option<Self> {
        let (dt_s, uniform) = match recording.sampling() {
            Sampling::Uniform { dt_s } => (dt_s, true),
            Sampling::Jittered { median_dt_s, .. } => (median_dt_s, false),
            Sampling::Untimed => return None,
        };
        let (lowest, highest) = range(recording.drive().iter().copied());
        let tolerance = SAME_DRIVE * (highest - lowest).min(f64::MAX);
        Some(Self {
            recording,
            dt_s,
            uniform,
            tolerance,
        })
    }

    /// The cycles of `n_rises` rises from the first start on that are alike; at least one.
    fn repeats_from(&self, starts: &[usize], n_rises: usize) -> Repeats {
        let time_s = self.recording.time_s();
        let period_s = time_s[starts[n_rises]] - time_s[starts[0]];
        let mut cycles = vec![Cycle {
            samples: starts[0]..starts[n_rises],
        }];
        for next in (n_rises..starts.len()).step_by(n_rises) {
            let (before, start) = (starts[next - n_rises], starts[next]);
            let drifted = (time_s[start] - time_s[before] - period_s).abs() > 1.5 * self.dt_s;
            if drifted || !self.alike(before, start, period_s) {
                break;
            }
            if let Some(cycle) = cycles.last_mut() {
                cycle.samples.end = cycle.samples.end.min(start);
            }
            let end_s = time_s[start] + period_s - 0.5 * self.dt_s;
            let end = start + time_s[start..].partition_point(|t| *t < end_s);
            cycles.push(Cycle {
                samples: start..end,
            });
        }
        Repeats { cycles, period_s }
    }

    /// True if the drive in a period from `second` repeats that from `first`.
    fn alike(&self, first: usize, second: usize, period_s: f64) -> bool {
        let (time_s, drive) = (self.recording.time_s(), self.recording.drive());
        let lag_s = time_s[second] - time_s[first];
        let end_s = time_s[first] + period_s - 0.5 * self.dt_s;
        let n_samples = time_s[first..].partition_point(|t| *t < end_s);
        let most = (MOST_DIFFERENT * n_samples as f64) as usize;
        let is_gap = |k: usize| {
            !self.uniform
                && k + 1 < time_s.len()
                && time_s[k + 1] - time_s[k] > GAP_FACTOR * self.dt_s
        };
        let mut n_different = 0;
        let mut other = second;
        for k in first..first + n_samples {
            if self.uniform {
                other = second + (k - first);
            } else {
                let t = time_s[k] + lag_s + 1e-6 * self.dt_s;
                while other + 1 < time_s.len() && time_s[other + 1] <= t {
                    other += 1;
                }
                if other + 1 >= time_s.len() && t > time_s[other] + 1.5 * self.dt_s {
                    return false;
                }
            }
            if other >= drive.len() || is_gap(k) || is_gap(other) {
                return false;
            }
            let same = (drive[k] - drive[other]).abs() <= self.tolerance;
            n_different += usize::from(!same);
            if n_different > most {
                return false;
            }
        }
        true
    }
}
