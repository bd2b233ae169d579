//! Where a logger repeats one value of the output.

use std::fmt;
use std::ops::Range;
use std::path::Path;

use crate::Recording;
use crate::ordered::usual_size;
use crate::sampling::Sampling;
use crate::warning::{Short, quantity};

/// Fewest samples of one value that are looked at.
const FEWEST: usize = 8;

/// Number of such runs that noise may make in the recording.
const BY_CHANCE: f64 = 1e-3;

/// Step out of a run over what neighbors usually differ by: noise comes no farther than six times, and what stood still all the same does
/// no harm.
const FAR: f64 = 10.0;

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
        let [start_s, end_s] = self.spans_s[0];
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
            let [start_s, end_s] = span.map(|time_s| (time_s * 1e6).round() / 1e6);
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

/// Where the output stands at one value, sample for sample, and goes on with a step, though its neighbors hardly ever agree elsewhere.
/// `None` if it nowhere does, and for static data.
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
    let is_stuck = |run: &Range<usize>| {
        run.len() >= FEWEST && by_chance(run) < BY_CHANCE && step(run).abs() > FAR * usual
    };
    let found: Vec<Range<usize>> = all.into_iter().filter(is_stuck).collect();
    let steps = found.iter().map(step);
    let step = steps.reduce(|a, b| if b.abs() > a.abs() { b } else { a })?;
    let file = Path::new(recording.name()).file_name();
    let runs: Vec<Range<usize>> = found.iter().map(|run| run.start + 1..run.end).collect();
    Some(Stuck {
        spans_s: runs
            .iter()
            .map(|run| [time_s[run.start], time_s[run.end - 1]])
            .collect(),
        runs,
        step,
        unit: recording.output_unit().to_owned(),
        file: file.map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
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
