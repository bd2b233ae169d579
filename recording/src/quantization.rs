//! The step of a converter, from the values alone.

use crate::digits::Digits;

/// At least this share of the differences between neighboring levels must be whole steps; the rest
/// may be stray values, such as those that a logger has interpolated. Our choice.
const ON_COMB: f64 = 0.95;

/// At least this share of the differences must be one step: half a step, or a tenth, divides as well.
const SINGLE: f64 = 0.05;

/// A comb is accepted if values without one would show it with a probability below e^−25. Our choice.
const EVIDENCE: f64 = 25.0;

/// Candidates tried, from the shortest difference up.
const MOST_CANDIDATES: usize = 16;

/// Step of the converter that produced `values`, in their unit, or `None` if none can be seen.
///
/// A quantized signal takes few levels, all on one comb: y = y_0 + q·whole number. With the
/// differences d_i > 0 between neighboring levels in order of size, q is the shortest difference
/// that occurs often, refined over ever longer differences by
///
/// ```text
/// q = Σ d_i / Σ k_i        k_i = d_i / q to the nearest whole number
/// ```
///
/// and it is accepted if at least 95 % of the d_i lie within the rounding of the printed numbers of
/// k_i q, if at least 5 % are single steps, and if values that fall anywhere would do as well with
/// a probability below e^−25 (Chernoff's bound on the binomial tail). Where the values are decimal
/// numbers of equal resolution r, the greatest common divisor of all differences is tried first.
///
/// # What it cannot see
///
/// * A step far below the noise: hardly any value then occurs twice. `None` unless at least a tenth
///   of the samples repeat a level. Such a step does not matter either.
/// * The decimals that a file is written with. They count as the step only if at least half of the
///   levels have the next possible number beside them.
/// * Fewer than three levels.
/// * Codes that never occur: a converter that only ever gives even codes has twice the step.
/// * The difference between a converter and a generator: an exact triangle wave lies on a comb too.
///
/// `None` if a value is not finite.
///
/// # Examples
///
/// ```
/// use recording::quantization_step;
///
/// // A slide potentiometer of 20.6 µm, in mm, moving to and fro.
/// let position_mm: Vec<f64> =
///     (0..500).map(|k| ((f64::from(k) / 40.0).sin() / 0.0206).round() * 0.0206).collect();
/// let step_mm = quantization_step(&position_mm);
/// assert!(step_mm.is_some_and(|step_mm| (step_mm - 0.0206).abs() < 1e-9));
/// ```
#[must_use]
pub fn quantization_step(values: &[f64]) -> Option<f64> {
    if !values.iter().all(|value| value.is_finite()) {
        return None;
    }
    let digits = Digits::of(values);
    let mut levels = values.to_vec();
    levels.sort_unstable_by(f64::total_cmp);
    levels.dedup_by(|next, level| *next <= *level);
    if levels.len() < 3 || levels.len() > values.len() - values.len().div_ceil(10) {
        return None;
    }
    decimal_step(&levels, digits).or_else(|| comb_step(&levels, digits))
}

/// The step of levels that are whole multiples of one decimal resolution.
fn decimal_step(levels: &[f64], digits: Digits) -> Option<f64> {
    let Digits::Decimal { decimals, .. } = digits else {
        return None;
    };
    let largest = largest_magnitude(levels);
    let resolution = 10_f64.powi(-decimals);
    if digits.resolution(largest) > 1.5 * resolution {
        return None;
    }
    // At most 15 digits, or the digits were not decimal.
    let scale = 10_f64.powi(decimals);
    let whole = |pair: &[f64]| ((pair[1] * scale).round() - (pair[0] * scale).round()) as u64;
    let divisor = levels.windows(2).map(whole).fold(0, greatest_divisor);
    let n_gaps = levels.len() - 1;
    let n_single = levels
        .windows(2)
        .filter(|pair| whole(pair) == divisor)
        .count();
    let share = n_single as f64 / n_gaps as f64;
    let by_chance = (n_gaps - 1) as f64 * (divisor as f64).ln() < EVIDENCE;
    if divisor == 0 || share < if by_chance { 0.5 } else { SINGLE } {
        return None;
    }
    Some(divisor as f64 / scale)
}

fn greatest_divisor(a: u64, b: u64) -> u64 {
    let (mut a, mut b) = (a, b);
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// The step of levels that lie on a comb as well as their printed digits allow.
fn comb_step(levels: &[f64], digits: Digits) -> Option<f64> {
    let rounding = 8.0 * f64::EPSILON * largest_magnitude(levels);
    // Length and tolerance: two numbers, each wrong by half its resolution.
    let gaps = || {
        levels.windows(2).filter_map(|pair| {
            let resolution = |value: f64| digits.resolution(value.abs()).max(f64::MIN_POSITIVE);
            let tolerance = 0.5 * (resolution(pair[0]) + resolution(pair[1])) + rounding;
            let gap = pair[1] - pair[0];
            // Shorter ones are one level printed in two ways.
            (gap > 1.5 * tolerance && gap.is_finite()).then_some((gap, tolerance))
        })
    };
    let mut lengths: Vec<f64> = gaps().map(|(gap, _)| gap).collect();
    lengths.sort_unstable_by(f64::total_cmp);
    let tolerance = gaps().map(|(_, tolerance)| tolerance).fold(0.0, f64::max);
    let n_gaps = lengths.len();
    let mut n_tried = 0;
    let mut from = 0;
    while from < n_gaps && n_tried < MOST_CANDIDATES {
        let width = 2.0 * tolerance;
        let n_similar = lengths[from..].partition_point(|gap| *gap <= lengths[from] + width);
        let similar = &lengths[from..from + n_similar];
        from += n_similar;
        if (n_similar as f64) < SINGLE * n_gaps as f64 {
            continue;
        }
        n_tried += 1;
        let start = similar.iter().sum::<f64>() / n_similar as f64;
        let step = refined(start, gaps());
        if is_comb(step, gaps(), tolerance) {
            return Some(step);
        }
    }
    None
}

/// The step by the longest differences that still count their steps without doubt.
fn refined(start: f64, gaps: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let mut step = start;
    for most_steps in [1.5, 3.5, 9.5, 33.5, 129.5, 1025.5] {
        let (length, n_steps) = gaps
            .clone()
            .filter_map(|(gap, tolerance)| {
                let n_steps = (gap / step).round();
                let fits = (gap - n_steps * step).abs() <= 2.0 * tolerance;
                (n_steps > 0.5 && n_steps < most_steps && fits).then_some((gap, n_steps))
            })
            .fold((0.0, 0.0), |sum, gap| (sum.0 + gap.0, sum.1 + gap.1));
        if n_steps > 0.5 && f64::is_finite(length) {
            step = length / n_steps;
        }
    }
    step
}

fn is_comb(step: f64, gaps: impl Iterator<Item = (f64, f64)>, tolerance: f64) -> bool {
    let (mut n_gaps, mut n_hits, mut n_single) = (0.0, 0.0, 0.0);
    for (gap, tolerance) in gaps {
        let n_steps = (gap / step).round();
        n_gaps += 1.0;
        if n_steps > 0.5 && (gap - n_steps * step).abs() <= tolerance {
            n_hits += 1.0;
            n_single += if n_steps < 1.5 { 1.0 } else { 0.0 };
        }
    }
    // Differences of printed numbers are whole multiples of their resolution, hence 3 and not 2.
    let chance = 3.0 * tolerance / step;
    if !(chance < 0.8 && n_hits >= ON_COMB * n_gaps && n_single >= SINGLE * n_gaps) {
        return false;
    }
    let divergence = ON_COMB * (ON_COMB / chance).ln()
        + (1.0 - ON_COMB) * ((1.0 - ON_COMB) / (1.0 - chance)).ln();
    // One difference went into the step.
    (n_gaps - 1.0) * divergence >= EVIDENCE
}

fn largest_magnitude(levels: &[f64]) -> f64 {
    let ends = [levels.first(), levels.last()];
    ends.into_iter()
        .flatten()
        .fold(0.0, |largest, value| value.abs().max(largest))
}
