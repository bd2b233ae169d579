use core::f64::consts::PI;

use crate::TuneError;
use crate::error::{finite, not_negative, positive, some_finite};

/// An edge this close behind a sample, in samples, counts as on it: times are products, and products round.
const EDGE_SAMPLES: f64 = 1e-6;

/// Reference signal that the output shall follow, in the output's unit, over time from sample 0 on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reference<'a> {
    /// One step.
    Step {
        /// Value before.
        from: f64,
        /// Value from `at_s` on.
        to: f64,
        /// Time of the step, s; ≥ 0.
        at_s: f64,
    },
    /// One level after another, the last one for good.
    Staircase {
        /// The levels; at least 1.
        levels: &'a [f64],
        /// How long each is held, s; > 0.
        hold_s: f64,
    },
    /// bias + amplitude sin(2π frequency t).
    Sine {
        /// Value at time 0.
        bias: f64,
        /// Half of the peak-to-peak swing.
        amplitude: f64,
        /// Frequency, Hz; > 0.
        frequency_hz: f64,
    },
    /// Up, high, down, low, and again; `low` at time 0.
    Trapezoid {
        /// Lower level.
        low: f64,
        /// Upper level.
        high: f64,
        /// Duration of each ramp, s; > 0.
        ramp_s: f64,
        /// How long each level is held, s; ≥ 0, and 0 gives a triangle.
        hold_s: f64,
    },
    /// High, low, and again; `high` at time 0.
    Square {
        /// Lower level.
        low: f64,
        /// Upper level.
        high: f64,
        /// How long each level is held, s; > 0.
        hold_s: f64,
    },
    /// A value for each sample, the last one for good.
    Samples(
        /// The values; at least 1.
        &'a [f64],
    ),
}

impl Reference<'_> {
    /// Checks the values.
    ///
    /// # Errors
    ///
    /// [`TuneError`] for a value that is not finite, a duration or frequency out of its range, no levels or
    /// samples.
    pub fn checked(self) -> Result<Self, TuneError> {
        match self {
            Reference::Step { from, to, at_s } => {
                finite("from", from)?;
                finite("to", to)?;
                not_negative("at_s", at_s)?;
            }
            Reference::Staircase { levels, hold_s } => {
                some_finite("levels", levels)?;
                positive("hold_s", hold_s)?;
            }
            Reference::Sine {
                bias,
                amplitude,
                frequency_hz,
            } => {
                finite("bias", bias)?;
                finite("amplitude", amplitude)?;
                positive("frequency_hz", frequency_hz)?;
            }
            Reference::Trapezoid {
                low,
                high,
                ramp_s,
                hold_s,
            } => {
                finite("low", low)?;
                finite("high", high)?;
                positive("ramp_s", ramp_s)?;
                not_negative("hold_s", hold_s)?;
            }
            Reference::Square { low, high, hold_s } => {
                finite("low", low)?;
                finite("high", high)?;
                positive("hold_s", hold_s)?;
            }
            Reference::Samples(samples) => some_finite("samples", samples)?,
        }
        Ok(self)
    }

    /// Value at sample `k` of samples of `dt_s` > 0 seconds, of a reference that [`Reference::checked`]
    /// accepts.
    ///
    /// An edge shows at the first sample at or after it.
    #[must_use]
    pub fn at(&self, k: usize, dt_s: f64) -> f64 {
        match *self {
            Reference::Step { from, to, at_s } => {
                if edges_passed(at_s, k, dt_s) > 0 {
                    to
                } else {
                    from
                }
            }
            Reference::Staircase { levels, hold_s } => held(levels, edges_passed(hold_s, k, dt_s)),
            Reference::Sine {
                bias,
                amplitude,
                frequency_hz,
            } => bias + amplitude * libm::sin(2.0 * PI * frequency_hz * (k as f64 * dt_s)),
            Reference::Trapezoid {
                low,
                high,
                ramp_s,
                hold_s,
            } => {
                let half_s = ramp_s + hold_s;
                let n_halves = edges_passed(half_s, k, dt_s);
                let since_s = k as f64 * dt_s - n_halves as f64 * half_s;
                let share = (since_s / ramp_s).clamp(0.0, 1.0);
                if n_halves.is_multiple_of(2) {
                    low + (high - low) * share
                } else {
                    high + (low - high) * share
                }
            }
            Reference::Square { low, high, hold_s } => {
                if edges_passed(hold_s, k, dt_s).is_multiple_of(2) {
                    high
                } else {
                    low
                }
            }
            Reference::Samples(samples) => held(samples, k),
        }
    }
}

/// How many of the edges at `every_s`, twice that and so on lie at or before a sample; for a single edge,
/// whether it does.
pub(crate) fn edges_passed(every_s: f64, k: usize, dt_s: f64) -> usize {
    // Rounds down, and ends at the largest number: all there are, for an edge at 0.
    ((k as f64 + EDGE_SAMPLES) * dt_s / every_s) as usize
}

/// The value of an index, the last one for good.
fn held(values: &[f64], index: usize) -> f64 {
    values[index.min(values.len() - 1)]
}
