//! Signals that stay at their extreme.

/// Fewest distinct values of a signal of which anything is said, and how many of the levels beside
/// an extreme it is compared with. Our choice.
const FEWEST_LEVELS: usize = 8;

/// Fewest samples at an extreme. Our choice.
const FEWEST_SAMPLES: usize = 5;

/// Samples at an extreme over those of the busiest level beside it, at least. A sine through a
/// converter has at most 1/(√2 − 1) = 2.4 times as many in its last step as in the one before.
const CROWDING: usize = 3;

/// The longest stay at an extreme over the longest at any value between the extremes, at least. Our
/// choice.
const LONGER_STAY: usize = 2;

/// An end of the range of a signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Side {
    /// The lowest value.
    Lowest,
    /// The highest value.
    Highest,
}

/// A signal that is flat at its extreme.
///
/// It may be clipped, by a sensor or an amplifier at its limit; it may as well rest against a stop,
/// or be at rest below the step of its converter. The values cannot tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clipping {
    /// The extreme, in the unit of the signal.
    pub at: f64,
    /// Which extreme.
    pub side: Side,
    /// Index of the first sample at it.
    pub first: usize,
    /// Samples at it.
    pub samples: usize,
    /// Stretches in which they come.
    pub occasions: usize,
    /// Samples of the longest stretch.
    pub longest: usize,
}

/// Where a signal is flat at its extremes: nothing, one of them, or both, the lowest first.
///
/// An extreme is flat if at least 5 samples have exactly its value, more than three times as many as
/// have any of the 8 values next to it, and if the longest stretch at it is at least twice as long
/// as the longest at any value between the extremes. So neither the turning points of a smooth
/// signal nor the plateaus of a quantized one count, noisy or not.
///
/// Nothing is said of a signal of fewer than 8 distinct values, or of one that is not finite.
///
/// # Examples
///
/// ```
/// use recording::{Side, clipping};
///
/// // An infrared thermometer that ends at 150.8 °C.
/// let temperature_degc: Vec<f64> =
///     (0..200).map(|k| (90.0 + 80.0 * (f64::from(k) / 16.0).sin()).min(150.8)).collect();
/// let flat = clipping(&temperature_degc);
/// assert_eq!(flat.len(), 1);
/// assert_eq!((flat[0].side, flat[0].occasions), (Side::Highest, 2));
/// ```
#[must_use]
pub fn clipping(values: &[f64]) -> Vec<Clipping> {
    if !values.iter().all(|value| value.is_finite()) {
        return Vec::new();
    }
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let rising = crowds(sorted.iter());
    let falling = crowds(sorted.iter().rev());
    let (&[lowest, ..], &[.., highest]) = (sorted.as_slice(), sorted.as_slice()) else {
        return Vec::new();
    };
    drop(sorted);
    let stays = [Stays::at(lowest, values), Stays::at(highest, values)];
    let between = longest_between(lowest, highest, values);
    let sides = [
        (Side::Lowest, lowest, rising),
        (Side::Highest, highest, falling),
    ];
    let flat = sides
        .into_iter()
        .zip(stays)
        .filter_map(|((side, at, crowds), stays)| {
            let (samples, beside) = crowds?;
            let flat = samples >= FEWEST_SAMPLES
                && samples > CROWDING * beside
                && stays.longest >= LONGER_STAY * between;
            flat.then_some(Clipping {
                at,
                side,
                first: stays.first,
                samples,
                occasions: stays.occasions,
                longest: stays.longest,
            })
        });
    flat.collect()
}

/// Samples at the first value and at the busiest of those next to it, or `None` if there are too
/// few values.
fn crowds<'a>(sorted: impl Iterator<Item = &'a f64>) -> Option<(usize, usize)> {
    let mut counts: Vec<usize> = Vec::with_capacity(FEWEST_LEVELS + 2);
    let mut last = None;
    for &value in sorted {
        let again = last.is_some_and(|last| same(last, value));
        last = Some(value);
        if !again && counts.len() > FEWEST_LEVELS {
            break;
        }
        match counts.last_mut() {
            Some(count) if again => *count += 1,
            _ => counts.push(1),
        }
    }
    if counts.len() < FEWEST_LEVELS {
        return None;
    }
    let (&samples, beside) = counts.split_first()?;
    Some((samples, beside.iter().copied().max()?))
}

/// True if two finite numbers are equal.
fn same(a: f64, b: f64) -> bool {
    a <= b && b <= a
}

struct Stays {
    first: usize,
    occasions: usize,
    longest: usize,
}

impl Stays {
    fn at(extreme: f64, values: &[f64]) -> Self {
        let first = values.iter().position(|value| same(*value, extreme));
        let first = first.unwrap_or(values.len());
        let (mut occasions, mut longest, mut length) = (0, 0, 0);
        for &value in values {
            if same(value, extreme) {
                length += 1;
                occasions += usize::from(length == 1);
                longest = longest.max(length);
            } else {
                length = 0;
            }
        }
        Self {
            first,
            occasions,
            longest,
        }
    }
}

/// The longest run of one value between the extremes.
fn longest_between(lowest: f64, highest: f64, values: &[f64]) -> usize {
    let runs = values.chunk_by(|a, b| same(*a, *b));
    runs.filter(|run| run[0] > lowest && run[0] < highest)
        .map(<[f64]>::len)
        .max()
        .unwrap_or(0)
}
