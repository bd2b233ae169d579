//! Times of a clock that is regular otherwise.

use std::ops::Range;

use super::runs::{FAR, wild_in};
use crate::recording::Recording;
use crate::sampling::Sampling;

/// Single times that are replaced at most unless the output plainly says that they are its own.
const A_FEW: usize = 3;

/// Share of the usual time between two samples by which a time stamp that stands apart is off.
const OFF_THE_BEAT: f64 = 0.1;

/// Squares of what is left of an output at one time over those at another, from which it plainly belongs to the other: a quarter of the
/// distance.
const PLAINLY: f64 = 16.0;

/// Single times that stand apart from what a clock with a regular step would say. A sample that was taken late has its own time: its
/// output lies nearer to the line between its neighbors there than at the time in the middle. Of a few the output has to say so
/// plainly, because a line is a poor guess where it bends; of many it has to deny it.
pub(super) fn off_the_beat(recording: &Recording) -> Vec<Range<usize>> {
    let Sampling::Jittered { median_dt_s, .. } = recording.sampling() else {
        return Vec::new();
    };
    let (time_s, output) = (recording.time_s(), recording.output());
    let late_s: Vec<f64> = time_s
        .iter()
        .enumerate()
        .map(|(k, time_s)| time_s - k as f64 * median_dt_s)
        .collect();
    let found = wild_in(&late_s, OFF_THE_BEAT / FAR * median_dt_s, 1);
    let squares = |share_at: &dyn Fn(usize) -> f64| -> f64 {
        let off = found.iter().map(|run| {
            let k = run.start;
            let (before, after) = (output[k - 1], output[k + 1]);
            output[k] - before - share_at(k) * (after - before)
        });
        off.map(|off| off * off).sum()
    };
    let as_stamped = squares(&|k| (time_s[k] - time_s[k - 1]) / (time_s[k + 1] - time_s[k - 1]));
    let at_most = if found.len() <= A_FEW {
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
