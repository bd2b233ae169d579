//! First estimates of the noise floor of an output, without a model.

use std::ops::Range;

use crate::cycles::{Repeats, repeats};
use crate::holds::{Hold, holds};
use crate::inspect::{LONG_HOLD_S, SETTLE_S};
use crate::quantization::quantization_step;
use crate::recording::Recording;
use crate::sampling::{GAP_FACTOR, Sampling};

/// Fewest samples of a settled hold.
const FEWEST_HELD: usize = 10;

/// A settled hold is still moving if one of the shapes of a transient takes away more than this share
/// of what varies about its line. White noise leaves little to them, a transient nearly everything.
const STILL_MOVING: f64 = 0.5;

/// Orders of the differences of neighboring samples: the higher, the less they keep of a smooth motion.
const ORDERS: Range<usize> = 2..8;

/// Distance of the least of these estimates above the noise, in one of twenty draws of white noise, times the root of the samples.
const ABOVE: f64 = 1.25;

/// Decays of these shapes over the length of a hold, 1/e each, beside a parabola.
const DECAYS: [f64; 3] = [4.0, 12.0, 40.0];

/// Standard deviation of a normal distribution over its median absolute deviation.
const NORMAL_OVER_MAD: f64 = 1.4826;

/// Which holds tell of the noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseConfig {
    /// A hold must last longer than this, s.
    pub hold_s: f64,
    /// Time from the start of a hold until the output has settled, s: five time constants.
    pub settle_s: f64,
}

impl Default for NoiseConfig {
    /// Holds of more than [`LONG_HOLD_S`], settled after [`SETTLE_S`]: where the time constant is not known, and with
    /// the holds that are seen to move still left out.
    fn default() -> Self {
        Self {
            hold_s: LONG_HOLD_S,
            settle_s: SETTLE_S,
        }
    }
}

/// Noise of the output by what a smooth signal leaves of the differences of neighboring samples: of six orders the least.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DifferenceNoise {
    /// Standard deviation by the mean square, in the unit of the output; too high by what the signal
    /// itself bends within a few steps.
    pub standard_deviation: f64,
    /// Standard deviation by the median absolute deviation, which fast motion in less than half of the recording hardly
    /// moves; too low where the converter's step exceeds the noise.
    pub robust_standard_deviation: f64,
    /// Threes of samples that went into the differences of the lowest order.
    pub samples: usize,
}

/// Noise of the output while the drive is held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HoldNoise {
    /// Pooled standard deviation about the line of each hold, in the unit of the output.
    pub standard_deviation: f64,
    /// Samples that went into it.
    pub samples: usize,
    /// Holds that went into it.
    pub holds: usize,
    /// Holds left out, because the output was still moving.
    pub still_moving: usize,
    /// Correlation of neighboring samples, −1..1: near 0 for white noise, near 1 for a drift. 0 where
    /// nothing varies.
    pub lag1_autocorrelation: f64,
}

/// Noise of the output by cycles in which the drive does the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RepeatNoise {
    /// Standard deviation by the mean square of the differences of neighboring cycles, in the unit
    /// of the output.
    pub standard_deviation: f64,
    /// Standard deviation by the median absolute deviation, which a few disturbances and a shift between the cycles do not
    /// move.
    pub robust_standard_deviation: f64,
    /// Differences that went into it.
    pub samples: usize,
    /// Cycles that went into it: all repeated ones but the first.
    pub cycles: usize,
}

/// First estimates of the noise floor of the output: standard deviations, in its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseFloor {
    /// By differences of neighboring samples: the white part only.
    pub differences: DifferenceNoise,
    /// By holds; `None` where there is no settled one.
    pub holds: Option<HoldNoise>,
    /// By repeated cycles; `None` where there are fewer than three.
    pub repeats: Option<RepeatNoise>,
    /// Standard deviation q/√12 of rounding to the step q of the converter; `None` where no step is
    /// seen.
    pub rounding: Option<f64>,
}

impl NoiseFloor {
    /// The noise is at least this much, but in one of twenty recordings with n samples.
    ///
    /// ```text
    /// max(min((1 − 1.25/√n) differences, max(holds, repeats)), q/√12)
    /// ```
    ///
    /// Differences count a fast motion as noise: the least of all estimates is the bound.
    /// Rounding counts even where a sensor that sticks shows no noise: as soon as the output moves
    /// over several steps, q/√12 of its error is rounding.
    #[must_use]
    pub fn lower(&self) -> f64 {
        let n = self.differences.samples as f64;
        self.at_least((1.0 - ABOVE / n.sqrt()).max(0.0))
    }

    /// The white part of the noise, about: as [`NoiseFloor::lower`], without the doubt of a finite number of samples.
    #[must_use]
    pub fn white(&self) -> f64 {
        self.at_least(1.0)
    }

    fn at_least(&self, share: f64) -> f64 {
        let differences = self
            .differences
            .standard_deviation
            .min(self.differences.robust_standard_deviation);
        let differences = share * differences;
        let white = self
            .measured()
            .map_or(differences, |highest| highest.min(differences));
        white.max(self.rounding.unwrap_or(0.0))
    }

    /// The noise is at most about this much, max(holds, repeats, q/√12), as far as those see it; or
    /// `None`: without settled holds and repeated cycles there is a lower bound only.
    #[must_use]
    pub fn upper(&self) -> Option<f64> {
        self.measured()
            .map(|highest| highest.max(self.rounding.unwrap_or(0.0)))
    }

    /// True if there is a lower bound only.
    #[must_use]
    pub fn is_lower_bound_only(&self) -> bool {
        self.measured().is_none()
    }

    fn measured(&self) -> Option<f64> {
        let holds = self.holds.map(|holds| holds.standard_deviation);
        let repeats = self.repeats.map(|repeats| repeats.standard_deviation);
        holds.into_iter().chain(repeats).reduce(f64::max)
    }
}

/// First estimates of the noise floor of the output, by up to three ways.
///
/// **Differences** of orders p = 2 to 7, for unequal steps too, of which the least counts; order 2 is that of Gasser et al.:
///
/// ```text
/// σ² = mean of (Σ w_i y_(k+i))² / Σ w_i²,  i = 0..p
/// w_i = Π 1 / (t_(k+i) − t_(k+j)),  j ≠ i
/// ```
///
/// T. Gasser, L. Sroka and C. Jennen-Steinmetz, Residual variance and residual pattern in nonlinear
/// regression, Biometrika 73 (1986) 625–633, doi:10.1093/biomet/73.3.625. It sees white noise only:
/// a lower bound where noise has memory. Motion y(t) counts as noise by its p-th derivative times Δt^p, hence the higher orders, and the
/// second version by 1.4826 × the median of the magnitudes instead of the mean of the squares.
///
/// **Holds** longer than [`NoiseConfig::hold_s`], from [`NoiseConfig::settle_s`] after their start:
/// the sum of squares about a straight line for each of them, over all samples less two a hold.
/// Holds of fewer than 10 settled samples are left out, and those that still move: where a parabola, or
/// an exponential that decays with 1/4, 1/12 or 1/40 of the hold, takes away more than half of that
/// sum. What is left of a slow transient raises the estimate by up to √2. A drift that stays linear over a hold does not count as noise; what
/// happens only while the actuator moves is not seen.
///
/// **Repeats**: the first of [`repeats`] is discarded, then
///
/// ```text
/// σ² = 1/2 mean of (y_(m+1, k) − y_(m, k))²        neighboring cycles m, m + 1; sample k of a cycle
/// ```
///
/// and the same by 1.4826 × the median absolute deviation. Between unequal steps the later cycle is
/// interpolated linearly, and 1/2 is 1/(1 + a² + b²) with its weights. Needs three repeated cycles.
///
/// `None` for static data, whose neighbors are not neighbors in time, and where no three neighboring
/// samples are without a gap between them.
///
/// # Examples
///
/// ```
/// use recording::{NoiseConfig, Recording, RecordingParts, noise_floor};
///
/// let recording = Recording::new(RecordingParts {
///     time_s: Some((0..100).map(f64::from).collect()),
///     drive: vec![0.0; 100],
///     // ±0.01 in turn, about a drift.
///     output: (0..100).map(|k| 0.01 * f64::from(1 - 2 * (k % 2)) + 1e-4 * f64::from(k)).collect(),
///     ..RecordingParts::default()
/// })?;
/// let floor = noise_floor(&recording, NoiseConfig { settle_s: 0.0, ..NoiseConfig::default() });
/// let held = floor.and_then(|floor| floor.holds);
/// assert!(held.is_some_and(|held| (held.standard_deviation / 0.01 - 1.0).abs() < 0.02));
/// assert!(held.is_some_and(|held| held.lag1_autocorrelation < -0.9));
/// # Ok::<(), recording::RecordingError>(())
/// ```
#[must_use]
pub fn noise_floor(recording: &Recording, config: NoiseConfig) -> Option<NoiseFloor> {
    let holds = holds(recording, config.hold_s);
    let step = quantization_step(recording.output());
    let repeats = repeats(recording);
    noise_floor_of(recording, &holds, config.settle_s, repeats.as_ref(), step)
}

/// As [`noise_floor`], of what has been found already.
pub(crate) fn noise_floor_of(
    recording: &Recording,
    holds: &[Hold],
    settle_s: f64,
    repeats: Option<&Repeats>,
    step: Option<f64>,
) -> Option<NoiseFloor> {
    let output = Scaled::of(recording);
    Some(NoiseFloor {
        differences: difference_noise(recording, output)?,
        holds: hold_noise(recording, output, holds, settle_s),
        repeats: repeats.and_then(|repeats| repeat_noise(recording, output, repeats)),
        rounding: step.map(|step| step / 12_f64.sqrt()),
    })
}

/// The output in units of its largest value, so that no square overflows.
#[derive(Clone, Copy)]
struct Scaled<'a> {
    output: &'a [f64],
    scale: f64,
}

impl<'a> Scaled<'a> {
    fn of(recording: &'a Recording) -> Self {
        let output = recording.output();
        let largest = output.iter().fold(0.0, |largest, y| y.abs().max(largest));
        // Nothing but zeros: any scale does.
        let scale = if largest > 0.0 { largest } else { 1.0 };
        Self { output, scale }
    }

    fn at(self, k: usize) -> f64 {
        self.output[k] / self.scale
    }

    /// A standard deviation of scaled values, in the unit of the output.
    fn unscaled(self, variance: f64) -> f64 {
        (variance.max(0.0).sqrt() * self.scale).min(f64::MAX)
    }
}

fn difference_noise(recording: &Recording, output: Scaled<'_>) -> Option<DifferenceNoise> {
    let time_s = recording.time_s();
    let (longest_step_s, is_uniform) = match recording.sampling() {
        Sampling::Uniform { .. } => (f64::INFINITY, true),
        Sampling::Jittered { median_dt_s, .. } => (GAP_FACTOR * median_dt_s, false),
        Sampling::Untimed => return None,
    };
    let of_order = |order: usize| {
        let equal: Vec<f64> = (0..=order).map(|k| k as f64).collect();
        let equal = weights(&equal);
        let mut found = Vec::with_capacity(time_s.len());
        for (k, t) in time_s.windows(order + 1).enumerate() {
            let own;
            let weights = if is_uniform {
                &equal
            } else {
                if t.windows(2).any(|two| two[1] - two[0] > longest_step_s) {
                    continue;
                }
                own = weights(t);
                &own
            };
            let Some(weights) = weights else { continue };
            let sum = weights
                .iter()
                .enumerate()
                .map(|(i, w)| w * output.at(k + i));
            found.push(sum.sum::<f64>().abs());
        }
        let samples = found.len();
        let squares: f64 = found.iter().map(|r| r * r).sum();
        let deviation = NORMAL_OVER_MAD * median(&mut found)?;
        Some((squares / samples as f64, deviation * deviation, samples))
    };
    let all: Vec<(f64, f64, usize)> = ORDERS.filter_map(of_order).collect();
    let &(.., samples) = all.first()?;
    let least =
        |of: fn(&(f64, f64, usize)) -> f64| all.iter().map(of).fold(f64::INFINITY, f64::min);
    Some(DifferenceNoise {
        standard_deviation: output.unscaled(least(|one| one.0)),
        robust_standard_deviation: output.unscaled(least(|one| one.1)),
        samples,
    })
}

/// Weights of samples at some times in their divided difference, with squares that sum to 1: of white noise it has the deviation, of a
/// polynomial of lower order nothing. `None` where steps are too unequal for numbers.
fn weights(time_s: &[f64]) -> Option<Vec<f64>> {
    let span_s = time_s[time_s.len() - 1] - time_s[0];
    let of = |i: usize| -> f64 {
        let others = (0..time_s.len()).filter(|j| *j != i);
        let product: f64 = others.map(|j| (time_s[i] - time_s[j]) / span_s).product();
        product.recip()
    };
    let weights: Vec<f64> = (0..time_s.len()).map(of).collect();
    let norm = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
    (norm.is_finite() && norm > 0.0).then(|| weights.iter().map(|w| w / norm).collect())
}

fn hold_noise(
    recording: &Recording,
    output: Scaled<'_>,
    holds: &[Hold],
    settle_s: f64,
) -> Option<HoldNoise> {
    let time_s = recording.time_s();
    let mut pooled = About::default();
    let (mut samples, mut n_holds, mut still_moving) = (0, 0, 0);
    for hold in holds {
        let held = &time_s[hold.samples.clone()];
        let settled_s = held[0] + settle_s;
        let n_unsettled = held.partition_point(|t| *t < settled_s);
        let first = hold.samples.start + n_unsettled;
        let n_settled = hold.samples.end - first;
        // A settling time that is not a number settles nothing.
        if settled_s.is_nan() || n_settled < FEWEST_HELD {
            continue;
        }
        let Some(about) = About::line(&time_s[first..hold.samples.end], |k| output.at(first + k))
        else {
            continue;
        };
        if about.transient > STILL_MOVING * about.squares {
            still_moving += 1;
            continue;
        }
        pooled.squares += about.squares;
        pooled.products += about.products;
        samples += n_settled;
        n_holds += 1;
    }
    (n_holds > 0).then(|| HoldNoise {
        standard_deviation: output.unscaled(pooled.squares / (samples - 2 * n_holds) as f64),
        samples,
        holds: n_holds,
        still_moving,
        lag1_autocorrelation: if pooled.squares > 0.0 {
            pooled.products / pooled.squares
        } else {
            0.0
        },
    })
}

/// Deviations from the line of least squares through a stretch.
#[derive(Debug, Clone, Copy, Default)]
struct About {
    /// Sum of squares.
    squares: f64,
    /// Sum of products of neighbors.
    products: f64,
    /// How much of the squares the best of the shapes of a transient takes away.
    transient: f64,
}

impl About {
    /// About the line through y(k) at these times, or `None` if time spans more than a number can.
    fn line(time_s: &[f64], y: impl Fn(usize) -> f64) -> Option<Self> {
        let n = time_s.len() as f64;
        let (first, last) = (time_s.first()?, time_s.last()?);
        let half = 0.5 * (last - first);
        if !(half > 0.0 && half.is_finite()) {
            return None;
        }
        // Time on −1..1, less its mean.
        let place = |k: usize| (time_s[k] - first) / half - 1.0;
        let each = || 0..time_s.len();
        let middle = each().map(place).sum::<f64>() / n;
        let u = |k: usize| place(k) - middle;
        let square = each().map(|k| u(k) * u(k)).sum::<f64>();
        let mean = each().map(&y).sum::<f64>() / n;
        let slope = each().map(|k| u(k) * (y(k) - mean)).sum::<f64>() / square;
        let residual = |k: usize| y(k) - mean - slope * u(k);
        // The residual is orthogonal to 1 and u; of the shape only what is so too counts.
        let taken_by = |shape: &dyn Fn(usize) -> f64| {
            let (mut sum, mut along, mut squares, mut overlap) = (0.0, 0.0, 0.0, 0.0);
            for k in each() {
                let value = shape(k);
                sum += value;
                along += value * u(k);
                squares += value * value;
                overlap += value * residual(k);
            }
            let rest = squares - sum * sum / n - along * along / square;
            if rest > 1e-9 * squares {
                overlap * overlap / rest
            } else {
                0.0
            }
        };
        let mut transient = taken_by(&|k| u(k) * u(k));
        for decays in DECAYS {
            transient = transient.max(taken_by(&|k| (-0.5 * decays * (place(k) + 1.0)).exp()));
        }
        let mut about = Self {
            transient,
            ..Self::default()
        };
        let mut before = None;
        for k in each() {
            let rest = residual(k);
            about.squares += rest * rest;
            about.products += before.map_or(0.0, |before| before * rest);
            before = Some(rest);
        }
        Some(about)
    }
}

fn repeat_noise(
    recording: &Recording,
    output: Scaled<'_>,
    repeats: &Repeats,
) -> Option<RepeatNoise> {
    let time_s = recording.time_s();
    let uniform = matches!(recording.sampling(), Sampling::Uniform { .. });
    let cycles = repeats.cycles.get(1..).unwrap_or(&[]);
    let mut differences = Vec::new();
    for pair in cycles.windows(2) {
        let (cycle, next) = (&pair[0].samples, &pair[1].samples);
        if uniform {
            let both = cycle.clone().zip(next.clone());
            differences
                .extend(both.map(|(k, other)| (output.at(other) - output.at(k)) / 2_f64.sqrt()));
            continue;
        }
        let mut other = next.start;
        for k in cycle.clone() {
            let t = time_s[next.start] + (time_s[k] - time_s[cycle.start]);
            while other + 2 < next.end && time_s[other + 1] <= t {
                other += 1;
            }
            if other + 1 >= next.end {
                break;
            }
            let b = (t - time_s[other]) / (time_s[other + 1] - time_s[other]);
            if !(0.0..=1.0).contains(&b) {
                continue;
            }
            let a = 1.0 - b;
            let there = a * output.at(other) + b * output.at(other + 1);
            differences.push((there - output.at(k)) / (1.0 + a * a + b * b).sqrt());
        }
    }
    let samples = differences.len();
    let squares: f64 = differences.iter().map(|d| d * d).sum();
    let middle = median(&mut differences)?;
    differences
        .iter_mut()
        .for_each(|d| *d = (*d - middle).abs());
    let deviation = NORMAL_OVER_MAD * median(&mut differences)?;
    Some(RepeatNoise {
        standard_deviation: output.unscaled(squares / samples as f64),
        robust_standard_deviation: output.unscaled(deviation * deviation),
        samples,
        cycles: cycles.len(),
    })
}

/// The median, the lower of the middle two of an even number; orders the values anew.
fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len().checked_sub(1)? / 2;
    let (_, &mut median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    Some(median)
}
