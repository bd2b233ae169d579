//! Where a logger repeats one value of the output.

use std::fmt;
use std::ops::Range;

use crate::Recording;
use crate::ordered::usual_size;
use crate::sampling::Sampling;
use crate::warning::{Short, copied, quantity};

/// Fewest samples of one value that are looked at. Our choice: fewer are a dropout, which is found as such.
const FEWEST: usize = 8;

/// Number of such runs that noise may make in the recording. Our choice.
const BY_CHANCE: f64 = 1e-3;

/// Step out of a run over what neighbors usually differ by, at least: noise comes no farther than six times, and a repeated value that is
/// no farther off does no harm.
const FAR: f64 = 10.0;

/// Step out of a run over the next one, at least: a logger catches up at once, a rod that begins to move goes on as it began.
const AT_ONCE: f64 = 5.0;

/// Spans in which the output stands at one value, while it moves on unseen: a logger or a connection that hangs.
#[derive(Debug, Clone, PartialEq)]
pub struct Stuck {
    /// Samples of one value, each run but for its first: that one was measured.
    pub runs: Vec<Range<usize>>,
    /// First and last time of each, s.
    pub spans_s: Vec<[f64; 2]>,
    /// Largest step by which the output goes on, in its unit.
    pub step: f64,
    /// Unit of the output.
    pub unit: String,
    /// Name of the recording's file.
    pub file: String,
}

impl fmt::Display for Stuck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(&[start_s, end_s]) = self.spans_s.first() else {
            return Ok(());
        };
        write!(
            f,
            "the output stands at one value from {} to {} s",
            Short(start_s),
            Short(end_s)
        )?;
        match self.spans_s.len() {
            1 => {}
            2 => f.write_str(" and once more")?,
            n => write!(f, " and {} times more", n - 1)?,
        }
        f.write_str(", and goes on by a step of ")?;
        quantity(f, self.step, &self.unit)?;
        let spans = self.spans_s.iter().map(|span| {
            let [start_s, end_s] = copied(*span);
            format!("[{start_s}, {end_s}]")
        });
        let spans = spans.collect::<Vec<_>>().join(", ");
        write!(
            f,
            ": the logger repeats a value, and no model follows that; leave it out with exclude_s = [{spans}] under \
             [recordings.\"{}\"] in the rod file",
            self.file
        )
    }
}

/// Where the output stands at one value, sample for sample, and goes on with a single step, though its neighbors hardly ever agree elsewhere.
/// `None` if it nowhere does, for static data, and where the output stands still as often without a step behind it: then that is its rest. A
/// value that is repeated up to the end is not told from rest.
#[must_use]
pub fn stuck(recording: &Recording) -> Option<Stuck> {
    let (time_s, output) = (recording.time_s(), recording.output());
    if recording.sampling() == Sampling::Untimed || output.len() < 2 {
        return None;
    }
    let all = runs(output);
    let n_equal: usize = all.iter().map(|run| run.len() - 1).sum();
    let n_long: usize = all
        .iter()
        .filter(|run| run.len() >= FEWEST)
        .map(|run| run.len() - 1)
        .sum();
    // One more, so that no chance is none.
    let equal = (n_equal - n_long + 1) as f64 / output.len() as f64;
    let by_chance = |run: &Range<usize>| output.len() as f64 * equal.powf((run.len() - 1) as f64);
    let usual = usual_size(output.windows(2).map(|two| two[1] - two[0]));
    if usual <= 0.0 {
        // A converter of coarse steps repeats most values.
        return None;
    }
    let step = |run: &Range<usize>| {
        output
            .get(run.end)
            .map_or(0.0, |next| next - output[run.start])
    };
    let next = |run: &Range<usize>| {
        let two = output.get(run.end..run.end + 2);
        two.map_or(0.0, |two| two[1] - two[0])
    };
    let stands = |run: &Range<usize>| run.len() >= FEWEST && by_chance(run) < BY_CHANCE;
    let goes_on = |run: &Range<usize>| {
        let step = step(run).abs();
        step > FAR * usual && step > AT_ONCE * next(run).abs()
    };
    let standing = all.into_iter().filter(stands);
    let (found, at_rest): (Vec<Range<usize>>, Vec<Range<usize>>) = standing.partition(goes_on);
    if at_rest.len() >= found.len() {
        return None;
    }
    let steps = found.iter().map(step);
    let step = steps.reduce(|a, b| if b.abs() > a.abs() { b } else { a })?;
    let runs: Vec<Range<usize>> = found.iter().map(|run| run.start + 1..run.end).collect();
    Some(Stuck {
        spans_s: runs
            .iter()
            .map(|run| [time_s[run.start], time_s[run.end - 1]])
            .collect(),
        runs,
        step,
        unit: recording.output_unit().to_owned(),
        file: recording.file_name(),
    })
}

/// Runs of equal neighbors, each of two samples or more.
fn runs(values: &[f64]) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for k in 1..values.len() {
        if values[k].to_bits() != values[k - 1].to_bits() {
            continue;
        }
        match runs.last_mut() {
            Some(last) if last.end == k => last.end = k + 1,
            _ => runs.push(k - 1..k + 1),
        }
    }
    runs
}
