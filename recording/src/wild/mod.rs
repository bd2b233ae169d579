//! Samples that do not belong to a series.

mod clock;
mod runs;

use std::fmt;
use std::ops::Range;

use clock::off_the_beat;
use runs::{FAR, wild_in};

use crate::Recording;
use crate::ordered::{LEAST, Ordered};
use crate::quantization::quantization_step;
use crate::warning::quantity;

/// Steps of its converter that an output goes, at least: neighbors that noise of two steps has made equal look quiet.
const STEPS: f64 = 10.0;

/// Share of a drive's range below which a sample that stands apart changes nothing that a fit could see.
const LEAST_OF_A_DRIVE: f64 = 0.1;

/// Share of the samples that may be wild; where there are more, they are what the series is like.
const MOST: f64 = 0.05;

/// Share of a drive's range that is a step: what the output does then is its answer.
const A_STEP: f64 = 0.1;

/// Single samples of a drive that are wild at most though it has levels there, where it stays for longer than [`LONGEST`] otherwise:
/// more are how the rod was driven.
const ONCE_OR_TWICE: usize = 3;

/// Longest run of an output at one value that is a dropout: a contact bounces for some samples. A rod has inertia, and neither
/// goes to another value within a sample nor comes back from it to where it was.
const LONGEST: usize = 4;

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

    /// Advice where nothing is replaced.
    pub(crate) fn advice(&self) -> &'static str {
        if self.is_of_clock() {
            "if the sample was taken in step, correct it in the file"
        } else {
            "if the rig did not see it, take it out of the file, or every fit follows it"
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
        if alone.len() <= ONCE_OR_TWICE && shortest_stay(drive, ordered, &alone) > LONGEST {
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
    let clock = off_the_beat(recording);
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
