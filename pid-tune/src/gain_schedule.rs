use crate::error::positive;
use crate::{PidGains, PidParams, TuneError};

/// Levels of the output at which a [`GainSchedule`] has factors, at equal distances.
pub const SCHEDULE_LEVELS: usize = 8;

/// Factors of a [`GainSchedule`], and where they hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GainScheduleParams {
    /// First and last level, as the controller sees the output, in its unit; the second larger.
    pub outputs: [f64; 2],
    /// Way of the output from one branch to the other, in its unit; > 0. More than the sensor jumps at rest.
    pub turn: f64,
    /// Factors on the heating branch, from level to level; each finite and ≥ 1.
    pub heating: [f64; SCHEDULE_LEVELS],
    /// Factors on the cooling branch, likewise; each finite and ≥ 1.
    pub cooling: [f64; SCHEDULE_LEVELS],
}

/// Factor on the gains of a [`Pid`](crate::Pid), by the level of the output and the branch of the hysteresis on which it is.
///
/// ```text
/// φ(y, β) = φ_c(y) + β (φ_h(y) - φ_c(y))             β = 1 heating, 0 cooling
/// m_k = min(max(m_(k-1), y_k - w/2), y_k + w/2)      a play of width w, on the measurement
/// β_k = (y_k - m_k)/w + ½
/// ```
///
/// with straight lines between the levels, and the factors of the first and the last level beyond them. After a turn the factor
/// goes from one branch to the other while the output goes by w: it is continuous in the measurement, never switches, and noise of
/// less than w never takes it all the way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GainSchedule {
    params: GainScheduleParams,
    /// One over the distance of two levels.
    per_level: f64,
    /// 1/w.
    per_turn: f64,
}

impl GainSchedule {
    /// Checks everything.
    ///
    /// # Errors
    ///
    /// [`TuneError::ScheduleOutputs`], [`TuneError::NotPositive`] for the turn, [`TuneError::ScheduleFactor`].
    pub fn new(params: GainScheduleParams) -> Result<Self, TuneError> {
        let [lower, upper] = params.outputs;
        let per_level = LAST as f64 / (upper - lower);
        if !(lower < upper && per_level > 0.0 && per_level.is_finite()) {
            return Err(TuneError::ScheduleOutputs { lower, upper });
        }
        positive("turn", params.turn)?;
        let per_turn = 1.0 / params.turn;
        positive("1 / turn", per_turn)?;
        for (branch, factors) in [("heating", &params.heating), ("cooling", &params.cooling)] {
            for (index, &value) in factors.iter().enumerate() {
                if !(value >= 1.0 && value.is_finite()) {
                    return Err(TuneError::ScheduleFactor {
                        branch,
                        index,
                        value,
                    });
                }
            }
        }
        Ok(Self {
            params,
            per_level,
            per_turn,
        })
    }

    /// Factors, and where they hold.
    #[must_use]
    pub fn params(&self) -> &GainScheduleParams {
        &self.params
    }

    /// Level of a number below [`SCHEDULE_LEVELS`], in the output's unit.
    #[must_use]
    pub fn level(&self, index: usize) -> f64 {
        let [lower, upper] = self.params.outputs;
        lower + index as f64 / LAST as f64 * (upper - lower)
    }

    /// The largest factor that gains may have at an output, whatever the branch.
    #[must_use]
    pub fn largest_at(&self, output: f64) -> f64 {
        let [heating, cooling] = self.both(output);
        heating.max(cooling)
    }

    /// The largest factor of all.
    #[must_use]
    pub fn largest(&self) -> f64 {
        let all = self.params.heating.iter().chain(&self.params.cooling);
        all.fold(1.0, |largest, &factor| largest.max(factor))
    }

    /// Middle m of the play after a measurement.
    #[inline(always)]
    pub(crate) fn middle(&self, before: f64, measured: f64) -> f64 {
        let half = 0.5 * self.params.turn;
        before.max(measured - half).min(measured + half)
    }

    /// Factor at a measurement, with the play's middle there.
    #[inline(always)]
    pub(crate) fn factor(&self, measured: f64, middle: f64) -> f64 {
        let branch = ((measured - middle) * self.per_turn + 0.5).clamp(0.0, 1.0);
        let [heating, cooling] = self.both(measured);
        cooling + branch * (heating - cooling)
    }

    /// Factors of both branches.
    #[inline(always)]
    fn both(&self, output: f64) -> [f64; 2] {
        let place = ((output - self.params.outputs[0]) * self.per_level).clamp(0.0, LAST as f64);
        let below = (place as usize).min(LAST - 1);
        let share = place - below as f64;
        [&self.params.heating, &self.params.cooling]
            .map(|factors| factors[below] + share * (factors[below + 1] - factors[below]))
    }
}

/// Number of the last level.
const LAST: usize = SCHEDULE_LEVELS - 1;

impl PidParams {
    /// The controller without a schedule, and its gains, that does at rest what this one does at a factor of its schedule; `factor` is
    /// finite and ≥ 1.
    ///
    /// Of the set point, a schedule multiplies no more than what stands in the error: P = kp (φ e - (1 - b) r).
    #[must_use]
    pub fn frozen(&self, gains: &PidGains, factor: f64) -> (Self, PidGains) {
        if self.gain_schedule.is_none() {
            return (*self, *gains);
        }
        let fixed = Self {
            gain_schedule: None,
            setpoint_weight: 1.0 - (1.0 - self.setpoint_weight) / factor,
            ..*self
        };
        let gains = PidGains {
            kp: factor * gains.kp,
            ki: factor * gains.ki,
            kd: factor * gains.kd,
        };
        (fixed, gains)
    }
}
