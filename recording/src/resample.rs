//! Resampling to a uniform step.

use std::f64::consts::PI;

use crate::error::RecordingError;
use crate::quantity::Quantity;
use crate::recording::{Recording, RecordingParts};
use crate::sampling::Sampling;

/// Middle of the transition band, 1/dt: between a passband to 0.3/dt and a stopband from 0.5/dt.
const CUTOFF: f64 = 0.4;

/// Half length of the kernel, new steps. Kaiser's formula asks for 9.1 at 60 dB over a transition of
/// 0.2/dt.
const HALF_LENGTH: f64 = 10.0;

/// Kaiser's shape parameter for 60 dB: 0.1102 (60 − 8.7).
const SHAPE: f64 = 5.65;

/// Entries of the kernel's table a new step; interpolated linearly, to 5e-6.
const PER_STEP: f64 = 512.0;

/// Steps that differ by less than this share are the same: a step printed and read again.
const SAME_STEP: f64 = 1e-9;

/// The recording at equal steps of `dt_s` seconds, from its first time stamp on.
///
/// # Drive
///
/// Row k's drive holds over [t_k, t_(k+1)), so the drive of a new sample is the average of that
/// piecewise constant function over the new step, exactly, in what it heats by:
///
/// ```text
/// current, voltage:            i' = ± √(1/dt ∫ i² dt)     with the sign of ∫ i dt, + for 0
/// duty, power, temperature:    d' =    1/dt ∫ d dt        (power of a PWM bridge: V² D / R)
/// ```
///
/// The heat in a fixed resistance is kept. What changes faster than the new step is not: averaging
/// the drive has no effect on the output that a thermal mass much slower than `dt_s` could show. The
/// last recorded drive goes on to the end of the last new step.
///
/// # Output and other measurements
///
/// They are low-pass filtered before they are sampled anew, or noise above the new Nyquist
/// frequency 0.5/dt would be folded below it. A symmetric kernel shifts nothing in time:
///
/// ```text
/// y'(t) = Σ w((t_k − t)/dt) y_k / Σ w((t_k − t)/dt)
/// w(u) = sin(0.8 π u)/(π u) · I_0(5.65 √(1 − (u/10)²))/I_0(5.65),  |u| ≤ 10      [Kaiser1974]
/// ```
///
/// J. F. Kaiser, Nonrecursive digital filter design using the I_0-sinh window function, Proc. IEEE
/// Int. Symp. Circuits and Systems (1974) 20–23. A sine up to 0.3/dt is kept within 0.2 %, one from
/// 0.5/dt up is reduced to 0.2 % or less. Beyond its ends the signal is continued by its point
/// reflection, so that a straight line stays one; within 10 new steps of an end the output is as
/// good as that guess, and the first new sample is the first recorded one.
///
/// Unequal steps are first interpolated linearly at about the median step Δ. That reduces a sine of
/// frequency f by (π f Δ)²/3 on top: 3 % at 0.1/Δ.
///
/// A step equal to that of a uniform recording (to 1e-9) leaves it as it is.
///
/// # Errors
///
/// [`RecordingError::NoTime`] for static data; [`RecordingError::GapInside`] for a recording with a
/// gap, where nothing says what the drive did; [`RecordingError::StepOutOfRange`] for a step below
/// the recording's own (the median one, where they differ), as resampling adds no information, for
/// one beyond its duration, or NaN. Faults as of [`Recording::new`] where numbers near the largest
/// that there are overflow.
///
/// # Examples
///
/// ```
/// use recording::{Recording, RecordingParts, resample};
///
/// let fast = Recording::new(RecordingParts {
///     time_s: Some((0..1000).map(|k| 0.01 * f64::from(k)).collect()),
///     drive: (0..1000).map(|k| if k % 10 < 5 { 2.0 } else { 0.0 }).collect(),
///     output: (0..1000).map(|k| 0.02 * f64::from(k)).collect(),
///     ..RecordingParts::default()
/// })?;
/// let slow = resample(&fast, 0.1)?;
/// assert_eq!(slow.len(), 100);
/// // A current of 2 A for half of the time heats as √2 A do, not as 1 A.
/// assert!((slow.drive()[3] - 2_f64.sqrt()).abs() < 1e-9);
/// assert!((slow.output()[3] - 0.6).abs() < 1e-9);
/// # Ok::<(), recording::RecordingError>(())
/// ```
pub fn resample(recording: &Recording, dt_s: f64) -> Result<Recording, RecordingError> {
    let file = || recording.name().to_owned();
    let n = recording.len();
    let own_dt_s = match recording.sampling() {
        Sampling::Uniform { dt_s } => dt_s,
        Sampling::Jittered { median_dt_s, .. } => median_dt_s,
        Sampling::Untimed => return Err(RecordingError::NoTime { file: file() }),
    };
    if let Some(gap) = recording.gaps().first() {
        return Err(RecordingError::GapInside {
            file: file(),
            start_s: gap.start_s,
            dt_s: gap.dt_s,
            end: gap.index + 1,
            n_samples: n,
        });
    }
    let time_s = recording.time_s();
    let duration_s = time_s[n - 1] - time_s[0];
    let accepted = own_dt_s * (1.0 - SAME_STEP)..=duration_s * (1.0 + SAME_STEP);
    if !(accepted.contains(&dt_s) && duration_s.is_finite()) {
        return Err(RecordingError::StepOutOfRange {
            file: file(),
            dt_s,
            min_dt_s: own_dt_s,
            max_dt_s: duration_s,
        });
    }
    let uniform = matches!(recording.sampling(), Sampling::Uniform { .. });
    if uniform && (dt_s / own_dt_s - 1.0).abs() <= SAME_STEP {
        return Ok(recording.clone());
    }
    // Without gaps no more than GAP_FACTOR times as many as were recorded.
    let n_new = (duration_s / dt_s * (1.0 + SAME_STEP)) as usize + 1;
    let filter = Filter::new(recording, own_dt_s, dt_s, n_new);
    Recording::new(RecordingParts {
        name: file(),
        time_s: Some((0..n_new).map(|j| time_s[0] + j as f64 * dt_s).collect()),
        drive_quantity: recording.drive_quantity(),
        drive: averaged_drive(recording, recording.drive(), dt_s, n_new),
        antagonist_drive: recording
            .antagonist_drive()
            .map(|drive| averaged_drive(recording, drive, dt_s, n_new)),
        smoothed_noise: recording.smoothed_noise() * (own_dt_s / dt_s).sqrt(),
        drive_unit: recording.own_drive_unit(),
        output_unit: recording.output_unit().to_owned(),
        output: filter.apply(recording.output()),
        temperature_degc: recording.temperature_degc().map(|t| filter.apply(t)),
        ambient_degc: recording.ambient_degc().map(|t| filter.apply(t)),
        stress_pa: recording.stress_pa().map(|stress| filter.apply(stress)),
        resistance: recording
            .resistance()
            .map(|whole| whole.map(|values| filter.apply(values))),
    })
}

/// One of the drives at each new step, averaged in what it heats by.
fn averaged_drive(recording: &Recording, drive: &[f64], dt_s: f64, n_new: usize) -> Vec<f64> {
    let time_s = recording.time_s();
    let squared = matches!(
        recording.drive_quantity(),
        Quantity::Current | Quantity::Voltage
    );
    let n = drive.len();
    // Of a uniform recording the grid, not the stamps: those are rounded.
    let start_s = |k: usize| match recording.sampling() {
        Sampling::Uniform { dt_s } => k as f64 * dt_s,
        _ => time_s[k] - time_s[0],
    };
    let largest = drive
        .iter()
        .fold(0.0, |largest: f64, d| largest.max(d.abs()));
    let scale = if largest > 0.0 { largest } else { 1.0 };
    let mut k = 0;
    let step = |j: usize| {
        let (from_s, to_s) = (j as f64 * dt_s, (j + 1) as f64 * dt_s);
        let (mut sum, mut squares, mut at_s) = (0.0, 0.0, from_s);
        loop {
            // The last drive lasts for ever.
            let end_s = if k + 1 < n {
                start_s(k + 1).min(to_s)
            } else {
                to_s
            };
            let share = ((end_s - at_s) / (to_s - from_s)).max(0.0);
            let value = drive[k] / scale;
            sum += share * value;
            squares += share * value * value;
            at_s = at_s.max(end_s);
            if k + 1 >= n || start_s(k + 1) > to_s {
                break;
            }
            k += 1;
        }
        let average = if squared {
            squares.sqrt() * if sum < 0.0 { -1.0 } else { 1.0 }
        } else {
            sum
        };
        // Rounding must not lift an average above what it averages.
        average.clamp(-1.0, 1.0) * scale
    };
    (0..n_new).map(step).collect()
}

/// The low-pass filter and the grids that it works between.
struct Filter<'a> {
    /// Time stamps of a recording with unequal steps.
    time_s: Option<&'a [f64]>,
    /// Step of the grid that is filtered, s.
    from_dt_s: f64,
    n_from: usize,
    to_dt_s: f64,
    n_to: usize,
    /// The kernel at whole multiples of 1/[`PER_STEP`].
    kernel: Vec<f64>,
}

impl<'a> Filter<'a> {
    fn new(recording: &'a Recording, own_dt_s: f64, to_dt_s: f64, n_to: usize) -> Self {
        let n_entries = (HALF_LENGTH * PER_STEP) as usize + 2;
        let kernel = (0..n_entries).map(|entry| weight(entry as f64 / PER_STEP));
        let time_s = recording.time_s();
        let n = recording.len();
        let duration_s = time_s[n - 1] - time_s[0];
        let (time_s, from_dt_s, n_from) = match recording.sampling() {
            Sampling::Uniform { dt_s } => (None, dt_s, n),
            _ => {
                let n_steps = (duration_s / own_dt_s).ceil().max(1.0);
                (Some(time_s), duration_s / n_steps, n_steps as usize + 1)
            }
        };
        Self {
            time_s,
            from_dt_s,
            n_from,
            to_dt_s,
            n_to,
            kernel: kernel.collect(),
        }
    }

    /// The values, filtered and at the new steps.
    fn apply(&self, values: &[f64]) -> Vec<f64> {
        match self.time_s {
            Some(time_s) => {
                self.filtered(&interpolated(time_s, values, self.from_dt_s, self.n_from))
            }
            None => self.filtered(values),
        }
    }

    fn filtered(&self, values: &[f64]) -> Vec<f64> {
        let ratio = self.to_dt_s / self.from_dt_s;
        let last = self.n_from as i64 - 1;
        let each = (0..self.n_to).map(|j| {
            let center = j as f64 * ratio;
            let reach = HALF_LENGTH * ratio;
            let (first, end) = (
                (center - reach).ceil() as i64,
                (center + reach).floor() as i64,
            );
            let (mut sum, mut weights) = (0.0, 0.0);
            for k in first..=end {
                let weight = self.weight_at((k as f64 - center).abs() / ratio);
                weights += weight;
                sum += weight * continued(values, k, last);
            }
            sum / weights
        });
        each.collect()
    }

    fn weight_at(&self, steps: f64) -> f64 {
        let entry = steps * PER_STEP;
        let index = (entry as usize).min(self.kernel.len() - 2);
        let part = entry - index as f64;
        (1.0 - part) * self.kernel[index] + part * self.kernel[index + 1]
    }
}

/// Value k of a signal continued beyond its ends by point reflection, and then level.
fn continued(values: &[f64], k: i64, last: i64) -> f64 {
    let at = |k: i64| values[k.clamp(0, last) as usize];
    if k < 0 {
        2.0 * at(0) - at(-k)
    } else if k > last {
        2.0 * at(last) - at(2 * last - k)
    } else {
        at(k)
    }
}

/// Values at `n` equal steps from the first stamp, on straight lines between the stamps.
fn interpolated(time_s: &[f64], values: &[f64], dt_s: f64, n: usize) -> Vec<f64> {
    let mut k = 0;
    let at = |j: usize| {
        let t = time_s[0] + j as f64 * dt_s;
        while k + 2 < time_s.len() && time_s[k + 1] <= t {
            k += 1;
        }
        let part = ((t - time_s[k]) / (time_s[k + 1] - time_s[k])).clamp(0.0, 1.0);
        (1.0 - part) * values[k] + part * values[k + 1]
    };
    (0..n).map(at).collect()
}

/// The kernel, `u` new steps from its center.
fn weight(u: f64) -> f64 {
    let angle = 2.0 * PI * CUTOFF * u;
    let sinc = if angle > 0.0 {
        angle.sin() / angle
    } else {
        1.0
    };
    let inside = 1.0 - (u / HALF_LENGTH).powi(2);
    if inside >= 0.0 {
        2.0 * CUTOFF * sinc * bessel_i0(SHAPE * inside.sqrt()) / bessel_i0(SHAPE)
    } else {
        0.0
    }
}

/// Modified Bessel function of order 0, by its series Σ ((x/2)^m / m!)²; for x up to about 10.
fn bessel_i0(x: f64) -> f64 {
    let (mut term, mut sum) = (1.0, 1.0);
    for m in 1..40 {
        term *= (0.5 * x / f64::from(m)).powi(2);
        sum += term;
    }
    sum
}
