//! Samples that do not belong to a series.

use std::fmt;
use std::ops::Range;

use crate::Recording;
use crate::quantization::quantization_step;
use crate::warning::quantity;

/// Distance from the line between the neighbors, over what is usual, from which a sample is wild: noise comes no farther than six
/// times.
const FAR: f64 = 30.0;

/// Distance from the line between the neighbors, over what is usual around a sample, from which it is wild: an output may be
/// quiet for most of the time, and busy here.
const FAR_HERE: f64 = 10.0;

/// Distance from the line between the neighbors, over the usual step of a series around a sample, from which it is wild: at a
/// corner, sharp or round, a sample is no farther away than a step.
const STEPS_HERE: f64 = 2.0;

/// Steps of its converter that an output goes, at least: neighbors that noise of two steps has made equal look quiet.
const STEPS: f64 = 10.0;

/// How near the neighbors are to one another then, over that distance, but for as many steps of a slope as lie between them:
/// beside a step they are not. There, steps on either side are as small beside that of the neighbors.
const ALIKE: f64 = 0.2;

/// Share of the range below which no distance is usual: a drive that is held has none.
const LEAST: f64 = 1e-3;

/// Share of a drive's range below which a sample that stands apart changes nothing that a fit could see.
const LEAST_OF_A_DRIVE: f64 = 0.1;

/// Share of the samples that may be wild; where there are more, they are what the series is like.
const MOST: f64 = 0.05;

/// Share of the samples from which a value is a level of the drive.
const A_LEVEL: f64 = 0.01;

/// Share of a drive's range that is a step: what the output does then is its answer.
const A_STEP: f64 = 0.1;

/// Single samples of a drive that are wild at most though it has levels there, where it stays for longer than [`LONGEST`] otherwise:
/// more are how the rod was driven. Single times of a clock that is regular otherwise.
const ONCE_OR_TWICE: usize = 3;

/// Longest run of an output at one value that is a dropout: a contact bounces for some samples. A rod has inertia, and neither
/// goes to another value within a sample nor comes back from it to where it was.
const LONGEST: usize = 4;

/// Share of the usual time between two samples by which a time stamp that stands apart is off.
const OFF_THE_BEAT: f64 = 0.1;

/// Squares of what is left of an output at one time over those at another, from which it plainly belongs to the other: a quarter of the
/// distance.
const PLAINLY: f64 = 16.0;

/// Samples on either side whose median says where a series is.
const AROUND: usize = 5;

/// Samples far from both of their neighbors, which agree: glitches of a logger or of its clock, dropouts of a sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct Wild {
    /// `time`, `drive`, `antagonist drive` or `output`.
    pub role: &'static str,
    /// Unit of the value.
    pub unit: String,
    /// The samples, counted from 0; at least one.
    pub samples: Vec<usize>,
    /// Value of the first.
    pub value: f64,
    /// Time of the first, s; `None` for static data, and where times are wild themselves.
    pub time_s: Option<f64>,
}

/// Kind and place of the samples, without a verb; the caller adds what becomes of them.
impl fmt::Display for Wild {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { role, value, .. } = self;
        match self.samples.len() {
            1 if self.is_of_clock() => f.write_str("a time between samples in step, ")?,
            n if self.is_of_clock() => {
                write!(f, "{n} times, each between samples in step, the first ")?;
            }
            1 => write!(
                f,
                "a sample of the {role} that stands far from both neighbors, "
            )?,
            n => write!(
                f,
                "{n} samples of the {role} that stand far from both neighbors, the first "
            )?,
        }
        quantity(f, *value, &self.unit)?;
        match self.time_s {
            Some(time_s) => write!(f, " at {time_s} s"),
            None => write!(f, " in sample {}", self.samples[0]),
        }
    }
}

impl Wild {
    fn is_of_clock(&self) -> bool {
        self.role == "time"
    }

    /// The runs of samples one after another.
    fn runs(&self) -> Vec<Range<usize>> {
        let mut runs: Vec<Range<usize>> = Vec::new();
        for &sample in &self.samples {
            match runs.last_mut() {
                Some(run) if run.end == sample => run.end += 1,
                _ => runs.push(sample..sample + 1),
            }
        }
        runs
    }

    /// Puts what lies between their neighbors in place of the samples.
    pub(crate) fn replace(&self, values: &mut [f64]) {
        for run in self.runs() {
            let (before, after) = (values[run.start - 1], values[run.end]);
            let steps = (run.len() + 1) as f64;
            for (k, value) in values[run].iter_mut().enumerate() {
                let share = (k + 1) as f64 / steps;
                *value = (1.0 - share) * before + share * after;
            }
        }
    }

    /// Description of the values that replace the samples, with its verb.
    pub(crate) fn replacement(&self) -> &'static str {
        let is = if self.samples.len() == 1 { "is" } else { "are" };
        match (is, self.runs().iter().all(|run| run.len() == 1)) {
            ("is", _) => "is replaced by the mean of its neighbors",
            (_, true) => "are replaced by the mean of their neighbors",
            (_, false) => "are replaced by the line between their neighbors",
        }
    }
}

/// The wild samples of time, drive and output: single ones, and runs of up to four at one value of an output, to which it jumps and
/// from which it comes back. A drive of one sample that comes again and again is none.
#[must_use]
pub fn wild(recording: &Recording) -> Vec<Wild> {
    let drives: Vec<(&[f64], Ordered)> = recording
        .drives()
        .map(|drive| (drive, Ordered::new(drive)))
        .collect();
    let output = Ordered::new(recording.output());
    let of_drives = drives.iter().map(|(drive, ordered)| {
        let alone = wild_in(drive, LEAST_OF_A_DRIVE / FAR * ordered.range(), 1);
        let at_a_level = alone
            .iter()
            .filter(|run| ordered.has_level(drive[run.start]));
        if at_a_level.count() <= ONCE_OR_TWICE && shortest_stay(drive, ordered, &alone) > LONGEST {
            return alone;
        }
        let is_at_no_level = |run: &Range<usize>| !ordered.has_level(drive[run.start]);
        alone.into_iter().filter(is_at_no_level).collect()
    });
    let follows = |run: &Range<usize>| {
        let mut drives = drives.iter();
        drives.any(|(drive, ordered)| follows_the_drive(drive, A_STEP * ordered.range(), run))
    };
    let converter = quantization_step(recording.output()).unwrap_or(0.0);
    let least = (LEAST * output.range()).max(STEPS / FAR * converter);
    let mut of_output = wild_in(recording.output(), least, LONGEST);
    of_output.retain(|run| !follows(run));
    let series = ["drive", "antagonist drive"]
        .into_iter()
        .zip(recording.drives().zip(of_drives))
        .map(|(role, (drive, runs))| (role, recording.drive_unit(), drive, runs));
    let output = (
        "output",
        recording.output_unit(),
        recording.output(),
        of_output,
    );
    let clock = off_the_beat(recording.time_s(), recording.output());
    let time = ("time", "s", recording.time_s(), clock);
    let series = [time].into_iter().chain(series).chain([output]);
    let found = series.filter_map(|(role, unit, values, runs)| {
        let samples: Vec<usize> = runs.into_iter().flatten().collect();
        let &first = samples.first()?;
        if samples.len() as f64 > MOST * values.len() as f64 {
            return None;
        }
        Some(Wild {
            role,
            unit: unit.to_owned(),
            value: values[first],
            time_s: recording
                .time_s()
                .get(first)
                .copied()
                .filter(|_| role != "time"),
            samples,
        })
    });
    found.collect()
}

/// The values of a series in ascending order.
pub(crate) struct Ordered(Vec<f64>);

impl Ordered {
    pub(crate) fn new(values: &[f64]) -> Self {
        Self::of(values.to_vec())
    }

    fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        Self(values)
    }

    /// The upper of the two in the middle, if there are two.
    fn middle(&self) -> Option<f64> {
        self.0.get(self.0.len() / 2).copied()
    }

    /// From the first to the last hundredth: wild ones would stretch the range itself.
    pub(crate) fn range(&self) -> f64 {
        let at = |share: f64| self.0[(share * (self.0.len() - 1) as f64) as usize];
        at(0.99) - at(0.01)
    }

    /// True if the series stands at a value again and again: a drive that switches may do so for a single sample.
    fn has_level(&self, value: f64) -> bool {
        let near = LEAST * self.range();
        let below = self.0.partition_point(|other| *other < value - near);
        let up_to = self.0.partition_point(|other| *other <= value + near);
        (up_to - below) as f64 > A_LEVEL * self.0.len() as f64
    }
}

/// Single times that stand apart from what a clock with a regular step would say. A sample that was taken late has its own time: its
/// output lies nearer to the line between its neighbors there than at the time in the middle. Of a few the output has to say so
/// plainly, because a line is a poor guess where it bends; of many it has to deny it.
fn off_the_beat(time_s: &[f64], output: &[f64]) -> Vec<Range<usize>> {
    let steps = time_s.windows(2).map(|two| two[1] - two[0]);
    let Some(step_s) = Ordered::of(steps.collect()).middle() else {
        return Vec::new();
    };
    let late_s: Vec<f64> = time_s
        .iter()
        .enumerate()
        .map(|(k, time_s)| time_s - k as f64 * step_s)
        .collect();
    let found = wild_in(&late_s, OFF_THE_BEAT / FAR * step_s, 1);
    let squares = |share_at: &dyn Fn(usize) -> f64| -> f64 {
        let off = found.iter().map(|run| {
            let k = run.start;
            let (before, after) = (output[k - 1], output[k + 1]);
            output[k] - before - share_at(k) * (after - before)
        });
        off.map(|off| off * off).sum()
    };
    let as_stamped = squares(&|k| (time_s[k] - time_s[k - 1]) / (time_s[k + 1] - time_s[k - 1]));
    let at_most = if found.len() <= ONCE_OR_TWICE {
        PLAINLY * as_stamped
    } else {
        as_stamped / PLAINLY.sqrt()
    };
    if squares(&|_| 0.5) <= at_most {
        found
    } else {
        Vec::new()
    }
}

/// Samples between two steps of a drive, where these are nearest to one another; single samples at `alone` are left out.
fn shortest_stay(drive: &[f64], ordered: &Ordered, alone: &[Range<usize>]) -> usize {
    let mut rest = drive.to_vec();
    for run in alone {
        rest[run.start] = rest[run.start - 1];
    }
    let large = A_STEP * ordered.range();
    let is_step = |k: &usize| (rest[*k] - rest[*k - 1]).abs() > large;
    let steps: Vec<usize> = (1..rest.len()).filter(is_step).collect();
    let stays = steps.windows(2).map(|two| two[1] - two[0]);
    stays.min().unwrap_or(usize::MAX)
}

/// True if the drive makes steps larger than `large` there and back, just before a run or within it: a fast rod follows it.
fn follows_the_drive(drive: &[f64], large: f64, run: &Range<usize>) -> bool {
    let before = &drive[run.start.saturating_sub(2)..run.end];
    let steps = || before.windows(2).map(|two| two[1] - two[0]);
    steps().any(|step| step > large) && steps().any(|step| step < -large)
}

/// Middle of absolute values, as the standard deviation of a normal distribution.
pub(crate) fn usual_size(values: impl Iterator<Item = f64>) -> f64 {
    let mut sizes: Vec<f64> = values.map(f64::abs).collect();
    if sizes.is_empty() {
        return 0.0;
    }
    let middle = sizes.len() / 2;
    let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
    1.4826 * *median
}

/// Wild runs of at most `longest` samples, in order; no distance below `least` is usual.
fn wild_in(values: &[f64], least: f64, longest: usize) -> Vec<Range<usize>> {
    let bends = values
        .windows(3)
        .map(|three| three[1] - 0.5 * (three[0] + three[2]));
    let usual = usual_size(bends).max(least);
    if usual <= 0.0 {
        return Vec::new();
    }
    let mut found = Vec::new();
    let mut k = 1;
    while k + 1 < values.len() {
        match (1..=longest).find(|length| is_wild(values, k..k + length, usual)) {
            Some(length) => {
                found.push(k..k + length);
                k += length + 1;
            }
            None => k += 1,
        }
    }
    found
}

/// True if a run stands at one value, far from the samples before and behind it.
fn is_wild(values: &[f64], run: Range<usize>, usual: f64) -> bool {
    if run.end >= values.len() {
        return false;
    }
    let (before, after) = (values[run.start - 1], values[run.end]);
    let first = values[run.start];
    let distance = (first - 0.5 * (before + after)).abs();
    if distance <= FAR * usual {
        return false;
    }
    let is_one_value = values[run.clone()]
        .iter()
        .all(|value| (value - first).abs() <= usual);
    let around = Around::of(values, &run, distance);
    let across = (run.len() + 1) as f64 * around.nearest;
    let gap = (after - before).abs();
    // Between two levels, farther from both than these are from one another.
    let outside = (first - before).abs().min((first - after).abs());
    let is_between_levels = around.nearest < ALIKE * gap && outside > gap;
    is_one_value
        && (gap < ALIKE * distance + across || is_between_levels)
        && (first - median_around(values, &run)).abs() > 0.5 * distance
        && distance > STEPS_HERE * around.step
        && distance > FAR_HERE * around.noise
}

/// Steps around a run; the run itself and the steps into it and out of it are left out.
struct Around {
    /// Size of the larger of the nearest two; larger ones than half the run's own are jumps, and no slope.
    nearest: f64,
    /// Size of the middle one.
    step: f64,
    /// Usual size of what a step differs by from the middle one on its side.
    noise: f64,
}

impl Around {
    fn of(values: &[f64], run: &Range<usize>, distance: f64) -> Self {
        let before = &values[run.start.saturating_sub(AROUND)..run.start];
        let after = &values[run.end..(run.end + AROUND).min(values.len())];
        let [before, after]: [Vec<f64>; 2] =
            [before, after].map(|part| part.windows(2).map(|two| two[1] - two[0]).collect());
        let nearest = [before.last(), after.first()].into_iter().flatten();
        let slopes = nearest
            .map(|step| step.abs())
            .filter(|size| *size < 0.5 * distance);
        let nearest = slopes.fold(0.0, f64::max);
        let sizes = before.iter().chain(&after).map(|step| step.abs());
        let step = Ordered::of(sizes.collect()).middle().unwrap_or(0.0);
        let differ = [before, after].into_iter().flat_map(|steps| {
            let steps = Ordered::of(steps);
            let middle = steps.middle().unwrap_or(0.0);
            steps.0.into_iter().map(move |step| step - middle)
        });
        Self {
            nearest,
            step,
            noise: usual_size(differ),
        }
    }
}

/// Where a series is around a run: a sample between two wild ones has neighbors that agree, too.
fn median_around(values: &[f64], run: &Range<usize>) -> f64 {
    let before = &values[run.start.saturating_sub(AROUND)..run.start];
    let after = &values[run.end..(run.end + AROUND).min(values.len())];
    let mut around: Vec<f64> = before.iter().chain(after).copied().collect();
    around.sort_by(f64::total_cmp);
    around[around.len() / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(values: &[f64]) -> Vec<Range<usize>> {
        wild_in(values, LEAST * Ordered::new(values).range(), LONGEST)
    }

    fn smooth() -> Vec<f64> {
        let noise = |k: usize| 0.001 * (((k * k) as f64) * 0.7).sin();
        (0..400)
            .map(|k| (0.05 * k as f64).sin() + noise(k))
            .collect()
    }

    #[test]
    fn glitches_are_found_and_steps_are_not() {
        assert_eq!(found(&smooth()), []);
        let mut values = smooth();
        (values[50], values[301]) = (7.0, 0.0);
        assert_eq!(found(&values), [50..51, 301..302]);
        let mut drive = vec![0.0; 400];
        drive[100..200].fill(1.0);
        assert_eq!(found(&drive), []);
        drive[150] = 22.0;
        drive[300] = 0.5;
        assert_eq!(found(&drive), [150..151, 300..301]);
        assert_eq!(found(&[1.0, 1.0]), []);
    }

    #[test]
    fn dropouts_of_some_samples_are_runs_and_what_lies_between_them_is_not() {
        let mut values = smooth();
        values[50..53].fill(-5.0);
        values[54] = -5.0;
        values[200..205].fill(-5.0);
        // Five are too many.
        assert_eq!(found(&values), [50..53, 54..55]);
        // A run of several values is a motion.
        values[52] = -5.5;
        values[310] = -5.0;
        assert_eq!(found(&values), [54..55, 310..311]);
    }
}
