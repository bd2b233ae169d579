//! Differences between two runs of the same drive.

use crate::order::falling;
use crate::recording::Recording;
use crate::repeated::pairs::Pair;

/// Rates are differences over this part of the samples to each side.
const RATES: usize = 200;

/// Square of a term after regression on those before it, as a share of its own square, below which it is a combination of
/// them.
const SAME_TERM: f64 = 1e-3;

/// A difference between two runs, and by which number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Difference {
    /// The second moves this share further.
    Gain(f64),
    /// The second is later by so many seconds while it is heated.
    HeatingLater(f64),
    /// The second is later by so many seconds while it cools.
    CoolingLater(f64),
    /// Everything takes this share longer in the second.
    Slower(f64),
}

/// How far apart the outputs of two runs of the same drive are.
#[derive(Debug, Clone, PartialEq)]
pub struct Apart {
    /// Second less first in the mean, in the unit of the output.
    pub offset: f64,
    /// Root mean square of what they differ by beside that offset.
    pub rms: f64,
    /// Kinds of difference that each take at least a twentieth of the square, the one that takes most first.
    pub differences: Vec<Difference>,
    /// Root mean square of what is left without all of them.
    pub left: f64,
    /// Standard deviation of the difference within a short stretch, gain, delays and pace taken out: of half of the stretches it is less.
    /// Noise with a memory has it, too. `None` where gain, delays and pace take more than they take of noise, or few samples are compared.
    pub within_stretches: Option<f64>,
    /// Time in the first recording, s, and the outputs of both there, the offset taken out of the second: at most a thousand
    /// of them, equally far apart.
    pub outputs: Vec<[f64; 3]>,
}

/// Most points of outputs that are to be drawn.
const SHOWN: usize = 1000;

/// Share of the square of a difference that a term takes, from which it is named.
const NAMED: f64 = 0.05;

/// Share of noise, times its independent samples, that four terms take in one of a thousand draws.
const BY_CHANCE: f64 = 18.5;

/// Samples of a stretch within which noise varies as it does at large: eight times the longest memory of a sensor's noise.
const STRETCH: usize = 200;

/// Fewest stretches, and fewest samples of one.
const FEWEST_STRETCHES: usize = 8;
const FEWEST_SAMPLES: usize = 25;

/// The outputs of a pair.
///
/// ```text
/// y₂(t + lag) - y₁(t) = offset + gain (y - ȳ) - δ_h ẏ (heated) - δ_c ẏ (cooling) - s (t - t₀) ẏ,   y the mean of both
/// ```
///
/// by least squares; y₂ between samples by straight lines.
pub(crate) fn apart(first: &Recording, second: &Recording, pair: &Pair) -> Apart {
    let time_s = &first.time_s()[pair.samples.clone()];
    let of_first = &first.output()[pair.samples.clone()];
    let of_second: Vec<f64> = time_s
        .iter()
        .map(|t| between(second, t + pair.lag_s))
        .collect();
    let n = time_s.len() as f64;
    let mean = |values: &[f64]| values.iter().map(|value| value / n).sum::<f64>();
    let means = [mean(of_first), mean(&of_second)];
    let offset = means[1] - means[0];
    let differences: Vec<f64> = of_first
        .iter()
        .zip(&of_second)
        .map(|(a, b)| b - a - offset)
        .collect();
    let both: Vec<f64> = of_first
        .iter()
        .zip(&of_second)
        .map(|(a, b)| 0.5 * (a + b - means[0] - means[1]))
        .collect();
    let drive = first.drive()[pair.samples.clone()].iter();
    let quantity = first.drive_quantity();
    let levels: Vec<f64> = drive.map(|drive| quantity.level(*drive)).collect();
    let columns = terms(time_s, &levels, &both);
    let square = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
    let whole = square(&differences);
    let (values, taken, left) = regressed(&columns, differences);
    let kinds = [
        Difference::Gain,
        Difference::HeatingLater,
        Difference::CoolingLater,
        Difference::Slower,
    ];
    let mut named: Vec<(f64, Difference)> = kinds
        .iter()
        .zip(values)
        .zip(taken)
        .filter(|&(_, taken)| taken > NAMED * whole)
        .map(|((kind, value), taken)| (taken, kind(value)))
        .collect();
    falling(&mut named, |one| one.0);
    let of_motion = 1.0 - square(&left) / whole;
    // Of what is left: a slow motion would itself look like noise with a long memory.
    let is_by_chance = of_motion * independent(&left) <= BY_CHANCE;
    Apart {
        offset,
        rms: (whole / n).sqrt(),
        differences: named.into_iter().map(|(_, one)| one).collect(),
        left: (square(&left) / n).sqrt(),
        within_stretches: within_stretches(&left).filter(|_| is_by_chance),
        outputs: time_s
            .iter()
            .zip(of_first)
            .zip(&of_second)
            .map(|((t, a), b)| [*t, *a, b - offset])
            .step_by(time_s.len().div_ceil(SHOWN))
            .collect(),
    }
}

/// Independent samples in noise that forgets at the rate at which its neighbors do.
fn independent(noise: &[f64]) -> f64 {
    let square: f64 = noise.iter().map(|value| value * value).sum();
    let of_neighbors: f64 = noise.windows(2).map(|pair| pair[0] * pair[1]).sum();
    let correlation = (of_neighbors / square).clamp(0.0, 1.0);
    noise.len() as f64 * (1.0 - correlation) / (1.0 + correlation)
}

/// Standard deviation within a short stretch: of half of the stretches it is less, so that an event in some of them does not move it.
fn within_stretches(differences: &[f64]) -> Option<f64> {
    let n_stretch = STRETCH.min(differences.len() / FEWEST_STRETCHES);
    if n_stretch < FEWEST_SAMPLES {
        return None;
    }
    let n = n_stretch as f64;
    let mut squares: Vec<f64> = differences
        .chunks_exact(n_stretch)
        .map(|stretch| {
            let mean = stretch.iter().sum::<f64>() / n;
            let squares = stretch.iter().map(|value| (value - mean).powi(2));
            squares.sum::<f64>() / (n - 1.0)
        })
        .collect();
    falling(&mut squares, |square| *square);
    Some(squares[squares.len() / 2].sqrt())
}

/// Regression columns: changes of an output about its mean by another gain, a delay of heating, a delay of cooling, and
/// another pace.
fn terms(time_s: &[f64], levels: &[f64], output: &[f64]) -> [Vec<f64>; 4] {
    let rates = rates(time_s, output);
    let mean_level = levels
        .iter()
        .map(|level| level / levels.len() as f64)
        .sum::<f64>();
    // The way in which a drive moves the output.
    let pairs = levels.iter().zip(output);
    let along: f64 = pairs.map(|(level, y)| (level - mean_level) * y).sum();
    let start = levels.iter().position(|level| *level > mean_level);
    let start_s = time_s[start.unwrap_or(0)];
    let later = |heated: bool| {
        let own = |rate: &f64| match (rate * along > 0.0) == heated {
            true => -rate,
            false => 0.0,
        };
        rates.iter().map(own).collect()
    };
    let pace = rates.iter().zip(time_s);
    [
        output.to_vec(),
        later(true),
        later(false),
        pace.map(|(rate, t)| -rate * (t - start_s)).collect(),
    ]
}

/// The output at a time, by a straight line between samples.
fn between(recording: &Recording, t: f64) -> f64 {
    let (time_s, output) = (recording.time_s(), recording.output());
    let after = time_s.partition_point(|at| *at <= t);
    if after == 0 || after == time_s.len() {
        return output[after.min(time_s.len() - 1)];
    }
    let part = (t - time_s[after - 1]) / (time_s[after] - time_s[after - 1]);
    output[after - 1] + part * (output[after] - output[after - 1])
}

/// Rates over some samples either way.
fn rates(time_s: &[f64], values: &[f64]) -> Vec<f64> {
    let n = values.len();
    let half = (n / RATES).max(1);
    (0..n)
        .map(|k| {
            let (from, to) = (k.saturating_sub(half), (k + half).min(n - 1));
            (values[to] - values[from]) / (time_s[to] - time_s[from])
        })
        .collect()
}

/// Least squares of columns about their means: their coefficients, the square that each takes in the order of what they take, and
/// what is left.
fn regressed(columns: &[Vec<f64>; 4], mut left: Vec<f64>) -> ([f64; 4], [f64; 4], Vec<f64>) {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut open: Vec<(usize, Vec<f64>, f64)> = columns
        .iter()
        .enumerate()
        .map(|(k, column)| {
            let mean = column.iter().sum::<f64>() / column.len() as f64;
            let column: Vec<f64> = column.iter().map(|value| value - mean).collect();
            let square = dot(&column, &column);
            (k, column, square)
        })
        .collect();
    // Of the columns that were taken, in order: place, orthogonal to those before, what it takes along.
    let mut used: Vec<(usize, Vec<f64>, f64)> = Vec::new();
    let mut taken = [0.0; 4];
    loop {
        open.retain(|(_, column, square)| dot(column, column) > SAME_TERM * square);
        let takes = |column: &[f64]| dot(column, &left).powi(2) / dot(column, column);
        let best = (0..open.len()).max_by(|&a, &b| takes(&open[a].1).total_cmp(&takes(&open[b].1)));
        let Some(best) = best else { break };
        let (place, column, _) = open.swap_remove(best);
        taken[place] = takes(&column);
        let square = dot(&column, &column);
        let along = dot(&column, &left) / square;
        let take = |from: &mut Vec<f64>, times: f64| {
            let pairs = from.iter_mut().zip(&column);
            pairs.for_each(|(value, column)| *value -= times * column);
        };
        take(&mut left, along);
        for (_, other, _) in &mut open {
            let times = dot(&column, other) / square;
            take(other, times);
        }
        used.push((place, column, along));
    }
    // From the last back: what a column is of those that were taken before it.
    let mut values = [0.0; 4];
    for (place, own, along) in used.iter().rev() {
        let square = dot(own, own);
        let of_later: f64 = used
            .iter()
            .map(|(later, ..)| values[*later] * dot(own, &columns[*later]) / square)
            .sum();
        values[*place] = along - of_later;
    }
    (values, taken, left)
}
