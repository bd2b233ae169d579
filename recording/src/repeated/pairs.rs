//! Stretches in which the drive does the same, after the same.

use std::ops::Range;

use crate::cycles::{Cycle, cycles, repeats};
use crate::holds::range;
use crate::recording::Recording;
use crate::sampling::GAP_FACTOR;

/// Drives are the same within this share of their range. Our choice.
const SAME_DRIVE: f64 = 0.005;

/// Samples in a row at which drives may differ: those at their edges, where the clocks of drive and logger differ.
const EDGE: usize = 2;

/// Part of a sample by which clocks stamp one early or late.
const JITTER: f64 = 0.1;

/// Share of the samples at which they may: with more than that it is another drive.
const MOST_DIFFERENT: f64 = 0.02;

/// Share of the shorter of two cycles in which they are the same, where both are one cycle.
const WHOLE: f64 = 0.95;

/// A drive rests up to this share of its range, and is on again from twice that.
const NEAR_REST: f64 = 0.05;

/// Share of its range within which an output is at rest.
const AT_REST: f64 = 0.02;

/// Most beginnings of a recording that are compared.
const MOST_BEGINNINGS: usize = 12;

/// Share of its range by which the output moves in a stretch that tells anything.
const MOVES: f64 = 0.2;

/// Share of what the output moves by in a cycle, by which the next one lies higher or lower, from which the rod is still on its way: cycles that
/// are short beside its time constant take many to come to theirs.
const ON_ITS_WAY: f64 = 0.05;

/// Fewest samples of a stretch.
const FEWEST: usize = 30;

/// Samples of one recording, and when the drive of another does the same.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Pair {
    /// Places of the recordings among all.
    pub(crate) recordings: [usize; 2],
    /// Samples of the first.
    pub(crate) samples: Range<usize>,
    /// Time in the second over that in the first, s.
    pub(crate) lag_s: f64,
    /// True if the two begin, or may begin, in different states: a first cycle and the next, cycles that are on their way, a
    /// recording that begins driven, a rod that has not come to rest.
    pub(crate) begins_elsewhere: bool,
    /// By how much the lag may be off, s: a step of the clocks, unless all drives are equal as they stand.
    pub(crate) lag_within_s: f64,
}

/// All pairs of stretches with the same drive: from the beginning of recordings, after rests that last as long as the stretch, and
/// cycles, each with the one after it. Static data have none.
pub(crate) fn pairs(recordings: &[Recording]) -> Vec<Pair> {
    let followed: Vec<Option<Followed<'_>>> = recordings.iter().map(Followed::of).collect();
    let mut found = Vec::new();
    for (a, first) in followed.iter().enumerate() {
        let Some(first) = first else { continue };
        let cycles = first.cycles(a);
        let from = if cycles.is_empty() { a } else { a + 1 };
        found.extend(cycles);
        for (b, second) in followed.iter().enumerate().skip(from) {
            if let Some(second) = second {
                found.extend(first.common([a, b], second));
            }
        }
    }
    found
}

/// Where something begins in a recording, and for how long its drive rested before, s.
#[derive(Debug, Clone, Copy)]
struct Beginning {
    sample: usize,
    rested_s: f64,
    /// True if the rod has come to rest here, as far as the recording tells.
    is_at_rest: bool,
}

/// A recording with what its drive does.
struct Followed<'a> {
    recording: &'a Recording,
    dt_s: f64,
    drive_range: f64,
    output_range: f64,
    beginnings: Vec<Beginning>,
}

impl<'a> Followed<'a> {
    fn of(recording: &'a Recording) -> Option<Self> {
        let dt_s = recording.sampling().usual_dt_s()?;
        Some(Self {
            drive_range: width(recording.drive()),
            output_range: width(recording.output()),
            beginnings: beginnings(recording),
            recording,
            dt_s,
        })
    }

    /// Each two cycles that follow one another and are the same.
    fn cycles(&self, place: usize) -> Vec<Pair> {
        let single = self.alike(place, &cycles(self.recording));
        if !single.is_empty() {
            return single;
        }
        let several = repeats(self.recording);
        several.map_or_else(Vec::new, |repeats| self.alike(place, &repeats.cycles))
    }

    /// Each two of some cycles that follow one another and are the same.
    fn alike(&self, place: usize, cycles: &[Cycle]) -> Vec<Pair> {
        let time_s = self.recording.time_s();
        let mut found = Vec::new();
        // Whether the cycle before the first of two was as they are.
        let mut goes_on = false;
        for two in cycles.windows(2) {
            let [first, second] = [&two[0].samples, &two[1].samples];
            let lag_s = time_s[second.start] - time_s[first.start];
            let shortest = first.len().min(second.len());
            let within = first.start..first.start + shortest;
            let (lag_s, lag_within_s, samples) = self.shared(self, &within, lag_s);
            let is_whole = samples.len() as f64 >= WHOLE * shortest as f64;
            let is_same = is_whole && self.tells(&samples);
            if is_same {
                found.push(Pair {
                    recordings: [place, place],
                    samples,
                    lag_s,
                    begins_elsewhere: !goes_on || self.is_on_its_way([first, second]),
                    lag_within_s,
                });
            }
            goes_on = is_same;
        }
        found
    }

    /// True if the output of a cycle lies elsewhere than that of the one before.
    fn is_on_its_way(&self, [first, second]: [&Range<usize>; 2]) -> bool {
        let output = self.recording.output();
        let mean = |samples: &Range<usize>| {
            output[samples.clone()].iter().sum::<f64>() / samples.len() as f64
        };
        (mean(second) - mean(first)).abs() > ON_ITS_WAY * width(&output[first.clone()])
    }

    /// The longest stretches that two recordings, or one, have in common, of each two beginnings.
    fn common(&self, recordings: [usize; 2], other: &Self) -> Vec<Pair> {
        let is_same = self.recording.drive_unit() == other.recording.drive_unit()
            && self.recording.output_unit() == other.recording.output_unit()
            && self.recording.antagonist_drive().is_some()
                == other.recording.antagonist_drive().is_some();
        let is_one = recordings[0] == recordings[1];
        let mut found: Vec<Pair> = Vec::new();
        for (k, begun) in self.beginnings.iter().enumerate() {
            let skip = if is_one { k + 1 } else { 0 };
            for later in other.beginnings.iter().skip(skip).filter(|_| is_same) {
                let lag_s =
                    other.recording.time_s()[later.sample] - self.recording.time_s()[begun.sample];
                let is_known = found.iter().any(|pair| {
                    pair.samples.contains(&begun.sample)
                        && (pair.lag_s - lag_s).abs() <= 2.0 * self.dt_s.max(other.dt_s)
                });
                if is_known {
                    continue;
                }
                // The rest before tells of as long a stretch.
                let until_s =
                    self.recording.time_s()[begun.sample] + begun.rested_s.min(later.rested_s);
                let until = self.recording.time_s().partition_point(|t| *t <= until_s);
                let (lag_s, lag_within_s, samples) =
                    self.shared(other, &(begun.sample..until), lag_s);
                if self.tells(&samples) {
                    found.push(Pair {
                        recordings,
                        samples,
                        lag_s,
                        begins_elsewhere: !(begun.is_at_rest && later.is_at_rest),
                        lag_within_s,
                    });
                }
            }
        }
        // Of those that begin elsewhere the longest is enough.
        let longest = found.iter().filter(|pair| pair.begins_elsewhere);
        let longest = longest.map(|pair| pair.samples.len()).max();
        found.retain(|pair| !pair.begins_elsewhere || Some(pair.samples.len()) == longest);
        found
    }

    /// True if a stretch is informative: it is driven and moves the output.
    fn tells(&self, samples: &Range<usize>) -> bool {
        samples.len() >= FEWEST
            && width(&self.recording.drive()[samples.clone()]) > NEAR_REST * self.drive_range
            && width(&self.recording.output()[samples.clone()]) > MOVES * self.output_range
    }

    /// The lag near the one that is given with which both drives are the same for longest, by how much it may be off, and the samples
    /// from the first of a range on over which they are.
    fn shared(&self, other: &Self, within: &Range<usize>, lag_s: f64) -> (f64, f64, Range<usize>) {
        let given = self.shared_at(other, within, lag_s);
        if given.1 == 0 {
            return (lag_s, 0.0, given.0);
        }
        // A clock may have begun within a sample of another.
        let step_s = self.dt_s.max(other.dt_s);
        let mut best = (lag_s, given);
        for lag_s in
            [-0.25, 0.25, -0.5, 0.5, -0.75, 0.75, -1.0, 1.0].map(|part| lag_s + part * step_s)
        {
            let next = self.shared_at(other, within, lag_s);
            if next.0.len() > best.1.0.len() {
                best = (lag_s, next);
            }
        }
        (best.0, step_s, best.1.0)
    }

    /// Samples from the first of a range on over which both drives are equal at a given lag, and the number of samples among
    /// them at which the drives differ.
    fn shared_at(&self, other: &Self, within: &Range<usize>, lag_s: f64) -> (Range<usize>, usize) {
        let time_s = self.recording.time_s();
        let later_s = other.recording.time_s();
        let tolerance = SAME_DRIVE * self.drive_range.max(other.drive_range);
        // Whether the drives are the same at a sample; nothing where one of the two says nothing.
        let is_same = |k: usize| {
            let t = time_s[k] + lag_s;
            let at = |t: f64| later_s.partition_point(|later| *later <= t).checked_sub(1);
            let (early, late) = (at(t - JITTER * other.dt_s), at(t + JITTER * other.dt_s)?);
            let is_within = t - later_s[late] <= GAP_FACTOR * other.dt_s;
            let is_same_at = |j: usize| {
                let mut pairs = self.recording.drives().zip(other.recording.drives());
                pairs.all(|(a, b)| (a[k] - b[j]).abs() <= tolerance)
            };
            is_within.then(|| is_same_at(late) || early.is_some_and(is_same_at))
        };
        let is_gap = |k: usize| time_s[k] - time_s[k - 1] > GAP_FACTOR * self.dt_s;
        let start = within.start;
        let (mut end, mut in_a_row, mut n_different) = (start, 0, 0);
        for k in within.clone() {
            let Some(is_same) = is_same(k).filter(|_| k == start || !is_gap(k)) else {
                break;
            };
            if is_same {
                in_a_row = 0;
                end = k + 1;
                continue;
            }
            in_a_row += 1;
            n_different += 1;
            let most = MOST_DIFFERENT * (k - start) as f64 + EDGE as f64;
            if in_a_row > EDGE || n_different as f64 > most {
                break;
            }
        }
        // Those after the last that is the same end the stretch.
        (start..end, n_different - in_a_row)
    }
}

fn width(values: &[f64]) -> f64 {
    let (lowest, highest) = range(values.iter().copied());
    (highest - lowest).min(f64::MAX)
}

/// The first sample, and each at which the drive is on again.
fn beginnings(recording: &Recording) -> Vec<Beginning> {
    let quantity = recording.drive_quantity();
    let levels = || recording.drive().iter().map(|drive| quantity.level(*drive));
    let (lowest, highest) = range(levels());
    let span = (highest - lowest).min(f64::MAX);
    let [low, on] = [1.0, 2.0].map(|times| lowest + times * NEAR_REST * span);
    let time_s = recording.time_s();
    let mut found = vec![Beginning {
        sample: 0,
        rested_s: f64::INFINITY,
        is_at_rest: levels().next().is_some_and(|level| level <= low),
    }];
    // The sample at which the drive was last higher than at rest, and whether it has rested since.
    let (mut driven, mut has_rested) = (None, false);
    for (k, level) in levels().enumerate() {
        if level <= low {
            has_rested = true;
            continue;
        }
        if has_rested && level > on {
            has_rested = false;
            // Nothing is known of before the first sample.
            let rested_s = driven.map_or(f64::INFINITY, |driven: usize| time_s[k] - time_s[driven]);
            found.push(Beginning {
                sample: k,
                rested_s,
                is_at_rest: driven.is_none_or(|driven| has_come_to_rest(recording, driven..k)),
            });
        }
        driven = Some(k);
    }
    found.truncate(MOST_BEGINNINGS);
    found
}

/// True if an output has come to rest during a rest of the drive, and the rest lasts at least twice as long as the output
/// moved in it: heat goes on to leave the rod when nothing moves any more.
fn has_come_to_rest(recording: &Recording, rest: Range<usize>) -> bool {
    let (time_s, output) = (recording.time_s(), recording.output());
    let end = output[rest.end];
    let near = AT_REST * width(output);
    let last_moving = output[rest.clone()]
        .iter()
        .rposition(|y| (y - end).abs() > near);
    let moved_s = last_moving.map_or(0.0, |k| time_s[rest.start + k] - time_s[rest.start]);
    time_s[rest.end] - time_s[rest.start] >= 2.0 * moved_s
}
