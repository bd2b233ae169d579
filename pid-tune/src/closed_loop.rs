use wiener::{Input, Lanes};

use crate::error::{all_finite, finite, not_negative};
use crate::{Pid, PidState, Reference, Sample, TuneError};

/// Largest dead time of a [`ClosedLoop`], samples.
pub const MAX_DEAD_TIME_SAMPLES: usize = 64;

/// 1.5·2^52: added to a double of less than 2^51 and taken away again, it leaves the nearest integer.
const ROUNDING: f64 = 6_755_399_441_055_744.0;

/// Disturbances of a loop; none by default.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Disturbances<'a> {
    /// Added to what the controller sees, not to the output, in the output's unit: a value for each sample.
    pub measurement_noise: Option<&'a [f64]>,
    /// Added to the plant's output, in its unit: a load that the plant does not feel but the sensor and the
    /// error do. A value for each sample.
    pub output_load: Option<&'a [f64]>,
    /// Step of the converter that measures, in the output's unit, which rounds to the nearest multiple; ≥ 0,
    /// and 0 for none. 5 mm in 12 bits are 1.22 µm. The converter's range is left out.
    pub quantization_step: f64,
    /// Samples from a command to its effect on the plant; at most [`MAX_DEAD_TIME_SAMPLES`].
    pub dead_time_samples: usize,
    /// Step of the drive, in its unit: the supply rounds a command to the nearest multiple; ≥ 0, and 0 for none.
    pub drive_step: f64,
    /// Drive up to which nothing acts, in its unit: a supply that wakes up above it; ≥ 0, and 0 for none.
    pub drive_dead_zone: f64,
}

/// Conditions of a closed-loop run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosedLoopParams<'a> {
    /// Reference that the output shall follow.
    pub reference: Reference<'a>,
    /// Number of samples; ≥ 1.
    pub n_samples: usize,
    /// Temperature of the surroundings, °C.
    pub ambient_degc: f64,
    /// Drive added to the controller's, in the drive's unit, a value for each sample; see
    /// [`feed_forward_a`](crate::feed_forward_a).
    pub feed_forward: Option<&'a [f64]>,
    /// Output that the controller aims at in the place of the reference, a value for each sample: with a feed-forward the
    /// output that it leads to, so that the controller corrects what differs from it and nothing else.
    pub aim: Option<&'a [f64]>,
    /// Disturbances of the loop.
    pub disturbances: Disturbances<'a>,
}

/// Plants under control, from a reference to their outputs, sample by sample.
///
/// At t_k the output is measured; from it and the reference the controller computes the drive that acts from
/// t_k to t_(k+1), or `dead_time_samples` later:
///
/// ```text
/// y_k = plant + load_k
/// m_k = q round((y_k + noise_k)/q)     with a converter of step q
/// u_k = controller(r_k, or the aim, m_k, f_k)
/// plant driven by supply(u_(k-n)), n the dead time; before k = n by the controller's last drive before the loop
/// ```
///
/// All lanes have the same reference and disturbances, each its own plant and gains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosedLoop<'a> {
    params: ClosedLoopParams<'a>,
}

/// A loop at one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Snapshot<const L: usize = 1> {
    /// Number of the sample.
    pub k: usize,
    /// Time t_k, s.
    pub time_s: f64,
    /// Reference.
    pub setpoint: f64,
    /// True output, with the load.
    pub output: [f64; L],
    /// Output as the controller sees it.
    pub measured: [f64; L],
    /// Drive that acts on the plant until the next sample.
    pub drive: [f64; L],
    /// Temperature of the rod, °C.
    pub temperature_degc: [f64; L],
}

impl<'a> ClosedLoop<'a> {
    /// Checks reference, series and dead time.
    ///
    /// # Errors
    ///
    /// Those of [`Reference::checked`]; [`TuneError::NoSamples`], [`TuneError::UnequalLength`],
    /// [`TuneError::DeadTime`], and what else is not finite or out of its range.
    pub fn new(params: ClosedLoopParams<'a>) -> Result<Self, TuneError> {
        let ClosedLoopParams {
            reference,
            n_samples,
            ambient_degc,
            feed_forward,
            aim,
            disturbances,
        } = params;
        reference.checked()?;
        if n_samples == 0 {
            return Err(TuneError::NoSamples);
        }
        finite("ambient_degc", ambient_degc)?;
        for (name, series) in [
            ("feed_forward", feed_forward),
            ("aim", aim),
            ("measurement_noise", disturbances.measurement_noise),
            ("output_load", disturbances.output_load),
        ] {
            let Some(series) = series else { continue };
            if series.len() != n_samples {
                return Err(TuneError::UnequalLength {
                    name,
                    found: series.len(),
                    expected: n_samples,
                });
            }
            all_finite(name, series)?;
        }
        for (name, value) in [
            ("quantization_step", disturbances.quantization_step),
            ("drive_step", disturbances.drive_step),
            ("drive_dead_zone", disturbances.drive_dead_zone),
        ] {
            not_negative(name, value)?;
        }
        if disturbances.dead_time_samples > MAX_DEAD_TIME_SAMPLES {
            return Err(TuneError::DeadTime {
                value: disturbances.dead_time_samples,
                most: MAX_DEAD_TIME_SAMPLES,
            });
        }
        Ok(Self { params })
    }

    /// Conditions of its run.
    #[must_use]
    pub fn params(&self) -> &ClosedLoopParams<'a> {
        &self.params
    }

    /// Runs plants under their controllers, both from their states, and shows every sample to `visit`.
    ///
    /// The states are left at the end of the last sample, but commands that dead time still holds back are
    /// lost. Plants are any [`Lanes`]: a [`Started`](wiener::Started) plant, or a trait object whose equations are
    /// compiled elsewhere. The loop itself is on the widest vectors with `wiener::widest_vectors`, if `visit` is
    /// `#[inline(always)]`.
    #[inline(always)]
    pub fn run<const L: usize, P: Lanes<L> + ?Sized>(
        &self,
        plants: &mut P,
        pid: &Pid<L>,
        pid_state: &mut PidState<L>,
        mut visit: impl FnMut(&Snapshot<L>),
    ) {
        let dt_s = pid.params().dt_s;
        let disturbances = &self.params.disturbances;
        let dead_time = disturbances.dead_time_samples;
        // Commands on their way, around in a ring: the place after the newest holds the oldest.
        let mut commands = [pid.last_drive(pid_state); MAX_DEAD_TIME_SAMPLES + 1];
        let mut place = 0;
        for k in 0..self.params.n_samples {
            let mut shown = plants.output();
            offset(&mut shown.displacement, disturbances.output_load, k);
            let mut measured = shown.displacement;
            offset(&mut measured, disturbances.measurement_noise, k);
            quantize(&mut measured, disturbances.quantization_step);
            let setpoint = self.params.reference.at(k, dt_s);
            let sample = Sample {
                setpoint: self.params.aim.map_or(setpoint, |series| series[k]),
                measured,
                feed_forward: self.params.feed_forward.map_or(0.0, |series| series[k]),
            };
            let mut command = pid.step(pid_state, &sample).drive;
            quantize(&mut command, disturbances.drive_step);
            silence(&mut command, disturbances.drive_dead_zone);
            commands[place] = command;
            place = if place == dead_time { 0 } else { place + 1 };
            let drive = commands[place];
            visit(&Snapshot {
                k,
                time_s: k as f64 * dt_s,
                setpoint,
                output: shown.displacement,
                measured,
                drive,
                temperature_degc: shown.temperature_degc,
            });
            let input = Input {
                drive,
                ambient_degc: self.params.ambient_degc,
            };
            plants.step(&input, dt_s);
        }
    }
}

/// Adds a series' value, if there is a series.
#[inline(always)]
fn offset<const L: usize>(values: &mut [f64; L], series: Option<&[f64]>, k: usize) {
    if let Some(series) = series {
        for l in 0..L {
            values[l] += series[k];
        }
    }
}

/// Rounds to the nearest multiple of a step, half-way to the even one; 0 for none.
#[inline(always)]
fn quantize<const L: usize>(values: &mut [f64; L], step: f64) {
    if step > 0.0 {
        for l in 0..L {
            values[l] = ((values[l] / step + ROUNDING) - ROUNDING) * step;
        }
    }
}

/// Leaves nothing of values up to an edge.
#[inline(always)]
fn silence<const L: usize>(values: &mut [f64; L], edge: f64) {
    if edge > 0.0 {
        for l in 0..L {
            values[l] = if values[l].abs() > edge {
                values[l]
            } else {
                0.0
            };
        }
    }
}
