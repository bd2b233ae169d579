//! Single values of a series, or short runs, far from what is around them.

use std::ops::Range;

use crate::ordered::{Ordered, usual_size};

/// Distance from the line between the neighbors, over what is usual, from which a sample is wild: noise comes no farther than six
/// times.
pub(super) const FAR: f64 = 30.0;

/// Distance from the line between the neighbors, over what is usual around a sample, from which it is wild: an output may be
/// quiet for most of the time, and busy here.
const FAR_HERE: f64 = 10.0;

/// Distance from the line between the neighbors, over the usual step of a series around a sample, from which it is wild: at a
/// corner, sharp or round, a sample is no farther away than a step.
const STEPS_HERE: f64 = 2.0;

/// How near the neighbors are to one another then, over that distance, but for as many steps of a slope as lie between them:
/// beside a step they are not. There, steps on either side are as small beside that of the neighbors.
const ALIKE: f64 = 0.2;

/// Samples on either side whose median says where a series is.
const AROUND: usize = 5;

/// Wild runs of at most `longest` samples, in order; no distance below `least` is usual.
pub(super) fn wild_in(values: &[f64], least: f64, longest: usize) -> Vec<Range<usize>> {
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
            let middle = Ordered::new(&steps).middle().unwrap_or(0.0);
            steps.into_iter().map(move |step| step - middle)
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
    use crate::ordered::LEAST;

    fn found(values: &[f64]) -> Vec<Range<usize>> {
        wild_in(values, LEAST * Ordered::new(values).range(), 4)
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
