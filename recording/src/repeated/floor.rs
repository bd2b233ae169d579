//! Lower bound on the error of any model of a rig: how far the rig itself repeats.

use crate::holds::range;
use crate::noise::{NoiseConfig, noise_floor};
use crate::order::falling;
use crate::recording::Recording;
use crate::repeated::apart::{Apart, apart};
use crate::repeated::pairs::{Pair, pairs};

/// Least noise there is, as a share of the output's range: numbers in a file are rounded.
const ROUNDING: f64 = 1e-6;

/// Difference of two runs over that of independent noise, up to which they repeat.
const REPEATS: f64 = 1.5;

/// Noise over its white part, at most, as for what is slower than a sensor's noise: with a memory of 25 samples it is five times as large as
/// between neighbors.
const MOST_MEMORY: f64 = 5.0;

/// A stretch of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Name of the recording.
    pub recording: String,
    /// Its time from, s.
    pub start_s: f64,
    /// And to, s.
    pub end_s: f64,
}

/// Two stretches in which the drive does the same, and what their outputs differ by.
#[derive(Debug, Clone, PartialEq)]
pub struct RepeatedDrive {
    /// The earlier of them.
    pub first: Part,
    /// The other.
    pub second: Part,
    /// How far apart the outputs are.
    pub apart: Apart,
    /// Samples that were compared.
    pub samples: usize,
    /// Root mean square of the difference that noise alone would cause, in the unit of the output. Noise is that of settled
    /// holds where there are any, else the white part, and what the difference itself has of noise with a memory.
    pub by_noise: f64,
    pair: Pair,
}

impl RepeatedDrive {
    /// Places of the recordings of both stretches among those that were compared.
    #[must_use]
    pub fn recordings(&self) -> [usize; 2] {
        self.pair.recordings
    }

    /// This pair in recordings with equal times and drives, but other outputs; `None` if there are fewer recordings, or
    /// fewer samples in them.
    #[must_use]
    pub fn of_outputs(&self, recordings: &[Recording]) -> Option<Self> {
        let [first, second] = self.pair.recordings;
        let (first, second) = (recordings.get(first)?, recordings.get(second)?);
        (first.len() >= self.pair.samples.end).then(|| Self {
            apart: at_best_lag(first, second, &self.pair),
            ..self.clone()
        })
    }
}

/// How far a rig repeats.
#[derive(Debug, Clone, PartialEq)]
pub struct RepeatFloor {
    /// Stretches with the same drive, the longest first.
    pub pairs: Vec<RepeatedDrive>,
    /// Stretches with the same drive that begin, or may begin, in different states: first cycles and the next, cycles that are still on
    /// their way to the one that repeats, recordings that begin driven, rods that have not come to rest. Their difference need not be the
    /// rig's.
    pub first_cycles: Vec<RepeatedDrive>,
    /// Unit of the output.
    pub unit: String,
}

impl RepeatFloor {
    /// Root mean square of what outputs differ by under the same drive after the same, offsets taken out, over all pairs, in the unit
    /// of the output; `None` where only a first cycle is repeated.
    #[must_use]
    pub fn rms(&self) -> Option<f64> {
        self.of_all(|pair| pair.apart.rms)
    }

    /// Value of [`Self::rms`] that noise alone would cause, in the unit of the output.
    #[must_use]
    pub fn by_noise(&self) -> Option<f64> {
        self.of_all(|pair| pair.by_noise)
    }

    /// Repeat floor of the pairs of different recordings among the first `n`; `None` if there are none.
    #[must_use]
    pub fn between_first(&self, n: usize) -> Option<Self> {
        let is_between = |pair: &&RepeatedDrive| {
            let [first, second] = pair.pair.recordings;
            first != second && first.max(second) < n
        };
        let pairs: Vec<RepeatedDrive> = self.pairs.iter().filter(is_between).cloned().collect();
        (!pairs.is_empty()).then(|| Self {
            pairs,
            ..self.clone()
        })
    }

    /// No model with the same parameters in both of two runs can be nearer than this to both, in the unit of the output: half of what
    /// they differ by, the error of their mean.
    #[must_use]
    pub fn nearest(&self) -> Option<f64> {
        self.rms().map(|rms| 0.5 * rms)
    }

    /// True if runs differ by no more than their noise, up to a factor of 1.5.
    #[must_use]
    pub fn is_noise(&self) -> bool {
        let pair = self.rms().zip(self.by_noise());
        pair.is_some_and(|(rms, by_noise)| rms <= REPEATS * by_noise)
    }

    fn of_all(&self, of: fn(&RepeatedDrive) -> f64) -> Option<f64> {
        let samples: usize = self.pairs.iter().map(|pair| pair.samples).sum();
        let squares = self.pairs.iter();
        let squares = squares.map(|pair| pair.samples as f64 * of(pair).powi(2));
        (samples > 0).then(|| (squares.sum::<f64>() / samples as f64).sqrt())
    }
}

/// The outputs of a pair with the lag, of those that the clocks leave open, by which they differ least.
fn at_best_lag(first: &Recording, second: &Recording, pair: &Pair) -> Apart {
    let as_given = apart(first, second, pair);
    if pair.lag_within_s <= 0.0 {
        return as_given;
    }
    let parts = [-1.0, -0.75, -0.5, -0.25, 0.25, 0.5, 0.75, 1.0];
    let others = parts.map(|part| {
        let lag_s = pair.lag_s + part * pair.lag_within_s;
        apart(
            first,
            second,
            &Pair {
                lag_s,
                ..pair.clone()
            },
        )
    });
    others.into_iter().fold(
        as_given,
        |least, next| if next.rms < least.rms { next } else { least },
    )
}

/// How far recordings of one rig repeat, without a model: what their outputs differ by where the drive does the same after the same.
///
/// Compared are the longest stretches that two recordings have in common from their beginnings on, or after rests that last as long
/// as the stretch, and cycles with the ones after them, where those lie no more than a twentieth of their range higher or lower.
/// Drives are the same within half a percent of their range but for edges that
/// clocks put a sample or two apart. Of recordings in several units those of the longest pair are compared. `None` if no drive is repeated.
///
/// # Examples
///
/// ```
/// use recording::{Recording, RecordingParts, repeat_floor};
///
/// let run = |name: &str, gain: f64| {
///     Recording::new(RecordingParts {
///         name: name.to_owned(),
///         time_s: Some((0..400).map(|k| 0.1 * f64::from(k)).collect()),
///         drive: (0..400).map(|k| if (50..250).contains(&k) { 1.0 } else { 0.0 }).collect(),
///         output_unit: "mm".to_owned(),
///         output: (0..400)
///             .map(|k| if (50..250).contains(&k) { gain * (1.0 - (-0.02 * f64::from(k - 50)).exp()) } else { 0.0 })
///             .collect(),
///         ..RecordingParts::default()
///     })
/// };
/// let floor = repeat_floor(&[run("a", 2.0)?, run("b", 2.1)?]).unwrap();
/// // A twentieth of what the output varies by.
/// assert!((floor.rms().unwrap() - 0.045).abs() < 0.005);
/// # Ok::<(), recording::RecordingError>(())
/// ```
#[must_use]
pub fn repeat_floor(recordings: &[Recording]) -> Option<RepeatFloor> {
    // The white part, and with what holds show.
    let noises: Vec<[f64; 2]> = recordings
        .iter()
        .map(|recording| {
            let (lowest, highest) = range(recording.output().iter().copied());
            let floor = noise_floor(recording, NoiseConfig::default());
            let known = floor.map_or([0.0; 2], |floor| {
                let held = floor.holds.map_or(0.0, |holds| holds.standard_deviation);
                [floor.white(), floor.white().max(held)]
            });
            known.map(|deviation| deviation.max(ROUNDING * (highest - lowest)))
        })
        .collect();
    let mut all = pairs(recordings);
    falling(&mut all, |pair| pair.samples.len() as f64);
    // Of recordings in several units those of the longest pair.
    let unit_of = |pair: &Pair| recordings[pair.recordings[0]].output_unit();
    let unit = unit_of(all.first()?).to_owned();
    all.retain(|pair| unit_of(pair) == unit);
    let (first_cycles, pairs): (Vec<Pair>, Vec<Pair>) =
        all.into_iter().partition(|pair| pair.begins_elsewhere);
    let described = |pair: &Pair| {
        let [first, second] = pair.recordings.map(|place| &recordings[place]);
        let time_s = &first.time_s()[pair.samples.clone()];
        let [start_s, end_s] = [time_s[0], time_s[time_s.len() - 1]];
        let part = |recording: &Recording, lag_s: f64| Part {
            recording: recording.name().to_owned(),
            start_s: start_s + lag_s,
            end_s: end_s + lag_s,
        };
        let [of_first, of_second] = pair.recordings.map(|place| noises[place]);
        let apart = at_best_lag(first, second, pair);
        let [white, known] = [0, 1].map(|k: usize| of_first[k].hypot(of_second[k]));
        let with_memory = apart.within_stretches;
        let with_memory = with_memory.filter(|own| *own <= MOST_MEMORY * white);
        RepeatedDrive {
            first: part(first, 0.0),
            second: part(second, pair.lag_s),
            apart,
            samples: time_s.len(),
            by_noise: with_memory.map_or(known, |own| own.max(known)),
            pair: pair.clone(),
        }
    };
    Some(RepeatFloor {
        pairs: pairs.iter().map(described).collect(),
        first_cycles: first_cycles.iter().map(described).collect(),
        unit,
    })
}
