//! Where an output slips.

use std::fmt;
use std::ops::RangeInclusive;

use crate::Recording;
use crate::holds::HOLD_TOLERANCE;
use crate::ordered::{Ordered, usual_size};
use crate::quantization::quantization_step;
use crate::sampling::Sampling;
use crate::stuck::stuck;
use crate::warning::{Short, WithUnit, copied, quantity};

/// Step of the output over what neighbors usually differ by, from which it may be a slip: the same as of a sample that stands apart.
const FAR: f64 = 30.0;

/// That over the largest other difference around it: a rod that moves fast does so for some samples.
const ALONE: f64 = 5.0;

/// Share of the range below which no slip is said.
const LEAST: f64 = 0.02;

/// Samples on either side that are looked at.
const AROUND: usize = 10;

/// How far the level behind may be from that before and the step, over the step: it stays there.
const STAYS: f64 = 0.3;

/// How far a step back may be from the step, over it: a mechanism that snaps to and fro does not slip.
const BACK: f64 = 0.3;

/// Most slips of a recording; where there are more, the output moves in jumps.
const MOST: usize = 3;

/// A step of the output that nothing drives and that stays: a clamp or a sensor that slips.
#[derive(Debug, Clone, PartialEq)]
pub struct Slip {
    /// Index of the last sample before it.
    pub index: usize,
    /// Its time, s.
    pub time_s: f64,
    /// Change of the output, in its unit.
    pub step: f64,
    /// Unit of the output.
    pub unit: String,
    /// Name of the recording's file.
    pub file: String,
    /// The longest span without a slip, s.
    pub longest_s: [f64; 2],
}

impl fmt::Display for Slip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the output slips by ")?;
        quantity(f, self.step, &self.unit)?;
        let [start_s, end_s] = copied(self.longest_s);
        let file = &self.file;
        write!(
            f,
            " at {} s, while the drive is held, and stays there: no model follows that; fits take it back unless as_recorded = true; \
             a part without it is --window {file}:{start_s}..{end_s}, or window_s = [{start_s}, {end_s}] under \
             [recordings.\"{file}\"] in the rod file",
            Short(self.time_s)
        )
    }
}

impl Slip {
    /// Its size and place alone.
    pub(crate) fn short(&self) -> String {
        format!(
            "a slip of the output by {} at {} s, while the drive is held",
            WithUnit(self.step, &self.unit),
            Short(self.time_s)
        )
    }

    /// Takes it back: what comes after the slip is moved onto what was before, as far as a straight line through either tells.
    pub(crate) fn take_back(&self, output: &mut [f64]) {
        let step = step_between_lines(output, self.index);
        for value in output.iter_mut().skip(self.index + 1) {
            *value -= step;
        }
    }
}

/// Step from a sample to the next, by the samples on either side: the noise of two samples alone would stay in all that follow.
fn step_between_lines(output: &[f64], k: usize) -> f64 {
    let (before, after) = (&output[k + 1 - AROUND..=k], &output[k + 1..=k + AROUND]);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let half = AROUND / 2;
    // Of halves that are as far apart as their number of samples.
    let slope = |values: &[f64]| (mean(&values[half..]) - mean(&values[..half])) / half as f64;
    let slope = 0.5 * (slope(before) + slope(after));
    mean(after) - mean(before) - slope * AROUND as f64
}

/// Where the output slips: it goes to another level from one sample to the next, alone among the samples around, while the drive
/// is held, and never comes back by such a step. None in static data.
#[must_use]
pub fn slips(recording: &Recording) -> Vec<Slip> {
    let (time_s, output) = (recording.time_s(), recording.output());
    if recording.sampling() == Sampling::Untimed || output.len() < 2 * AROUND {
        return Vec::new();
    }
    let steps: Vec<f64> = output.windows(2).map(|two| two[1] - two[0]).collect();
    let range = Ordered::new(output).range();
    let converter = quantization_step(output).unwrap_or(0.0);
    let least = (FAR * usual_size(steps.iter().copied()))
        .max(LEAST * range)
        .max(ALONE * converter);
    let drives: Vec<(&[f64], f64)> = recording
        .drives()
        .map(|drive| (drive, HOLD_TOLERANCE * Ordered::new(drive).range()))
        .collect();
    let are_held = |samples: RangeInclusive<usize>| {
        let mut drives = drives.iter();
        drives.all(|(drive, still)| is_held(&drive[samples.clone()], *still))
    };
    // The step behind a repeated value is the logger's.
    let stuck = stuck(recording).map_or_else(Vec::new, |stuck| stuck.runs);
    let ends_stuck = |k: usize| stuck.iter().any(|run| run.end == k + 1);
    let jumps: Vec<usize> = (AROUND..steps.len() - AROUND)
        .filter(|&k| steps[k].abs() > least && is_alone(&steps, k) && !ends_stuck(k))
        .collect();
    let comes_back = |k: usize| {
        let is_back = |other: &usize| (steps[*other] + steps[k]).abs() < BACK * steps[k].abs();
        jumps.iter().any(is_back)
    };
    let slips: Vec<usize> = jumps
        .iter()
        .copied()
        .filter(|&k| are_held(k - AROUND..=k) && stays(output, k, steps[k]))
        .filter(|&k| !comes_back(k))
        .collect();
    if slips.len() > MOST {
        return Vec::new();
    }
    let longest_s = longest_between(time_s, &slips);
    let slip = |k: usize| Slip {
        index: k,
        time_s: time_s[k],
        step: steps[k],
        unit: recording.output_unit().to_owned(),
        file: recording.file_name(),
        longest_s,
    };
    slips.into_iter().map(slip).collect()
}

/// The longest span, s, that no slip interrupts.
fn longest_between(time_s: &[f64], slips: &[usize]) -> [f64; 2] {
    let starts = std::iter::once(0).chain(slips.iter().map(|k| k + 1));
    let ends = slips.iter().copied().chain([time_s.len() - 1]);
    let spans = starts
        .zip(ends)
        .map(|(start, end)| [time_s[start], time_s[end]]);
    let length_s = |[start_s, end_s]: &[f64; 2]| end_s - start_s;
    spans
        .max_by(|one, other| length_s(one).total_cmp(&length_s(other)))
        .unwrap_or_default()
}

/// True if a step is far above the others around it.
fn is_alone(steps: &[f64], k: usize) -> bool {
    let around = (k - AROUND..=k + AROUND).filter(|&other| other != k);
    let largest = around.fold(0.0_f64, |largest, other| largest.max(steps[other].abs()));
    steps[k].abs() > ALONE * largest
}

fn is_held(drive: &[f64], still: f64) -> bool {
    let lowest = drive.iter().copied().fold(f64::INFINITY, f64::min);
    let highest = drive.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    highest - lowest <= still
}

/// True if the level behind a step is the level before it plus the step.
fn stays(output: &[f64], k: usize, step: f64) -> bool {
    let median = |values: &[f64]| {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    };
    let before = median(&output[k + 1 - AROUND..=k]);
    let after = median(&output[k + 1..=k + AROUND]);
    (after - before - step).abs() < STAYS * step.abs()
}
