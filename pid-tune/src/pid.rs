use crate::error::{all_finite, finite, not_negative, positive};
use crate::{Command, GainSchedule, Sample, TuneError};

/// Gains of one controller in parallel form; each finite and ≥ 0.
///
/// Their units decide what a number means. The error is in the output's own unit: with mm and A, a
/// proportional gain of 200 asks for 200 A at an error of 1 mm and so saturates until the error is below
/// `upper`/200, 0.015 mm for a supply of 3 A.
///
/// An output that falls as the drive rises needs its sign changed, and that of the reference with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PidGains {
    /// Proportional gain, drive per error.
    pub kp: f64,
    /// Integral gain, drive per error and second.
    pub ki: f64,
    /// Derivative gain, drive seconds per error.
    pub kd: f64,
}

/// Input of the derivative term.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DerivativeOf {
    /// The error: a step of the reference gives a kick.
    Error,
    /// The measurement, with its sign changed: no kick.
    Measurement,
}

/// Anti-windup: keeps the integral from growing while the drive is saturated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AntiWindup {
    /// Nothing: the integral winds up. For comparison, and for the paper's loop, of which nothing else
    /// is said.
    Off,
    /// Conditional integration: no summand that drives a saturated command further out.
    Clamping,
    /// The integral follows the saturated command.
    BackCalculation {
        /// Time constant T_t with which it does, s; at least the sample time, or it would overcorrect.
        tracking_s: f64,
    },
}

/// Limits of the drive, in its own unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveLimits {
    /// Lower limit; usually 0, because no drive cools a rod.
    pub lower: f64,
    /// Upper limit; > lower.
    pub upper: f64,
}

impl DriveLimits {
    #[inline(always)]
    fn saturate<const L: usize>(self, unsaturated: [f64; L]) -> [f64; L] {
        let mut drive = [0.0; L];
        for l in 0..L {
            drive[l] = unsaturated[l].max(self.lower).min(self.upper);
        }
        drive
    }
}

/// All of a controller but its gains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PidParams {
    /// Sample time Δt, s; > 0.
    pub dt_s: f64,
    /// Limits of the drive.
    pub limits: DriveLimits,
    /// Anti-windup of the integral.
    pub anti_windup: AntiWindup,
    /// Input of the derivative term.
    pub derivative_of: DerivativeOf,
    /// Time constant T_f of the derivative's first-order filter, s; ≥ 0, and 0 leaves it unfiltered.
    pub derivative_filter_s: f64,
    /// Share b of the reference that the proportional term sees, 0 to 1: below 1, a step of the reference kicks less and
    /// the response overshoots less, while disturbances are met as before.
    pub setpoint_weight: f64,
    /// Factor on all gains by the output's level and branch; `None` for gains that stay.
    pub gain_schedule: Option<GainSchedule>,
}

/// PID controller as it is deployed: sampled, saturated, `L` of them side by side, each with its gains.
///
/// ```text
/// e_k = r_k - y_k
/// D_k = a D_(k-1) + (1 - a) kd (x_k - x_(k-1))/Δt,   a = e^(-Δt/T_f),   x = e or -y
/// v_k = kp (b r_k - y_k) + I_k + D_k + f_k
/// u_k = min(max(v_k, lower), upper)
///
/// I_(k+1) = I_k + ki e_k Δt                            Off
/// I_(k+1) = I_k + ki e_k Δt, or I_k where v_k is       Clamping
///           beyond a limit and ki e_k points there
/// I_(k+1) = I_k + ki e_k Δt + (u_k - v_k) Δt/T_t       BackCalculation
/// ```
///
/// with reference r, measurement y, feed-forward f, unsaturated command v and drive u. The integral is
/// brought up to date after the output, as in `[Astrom2006, chapter 13]`: the command depends on the newest
/// measurement with the least delay, and what is integrated knows whether it saturated. The anti-windup
/// schemes are those of `[Astrom1989]`.
///
/// A sample whose command would not be finite (a measurement that is `NaN`, say) is *missed*: the last command
/// is held, nothing else is remembered but the count, and the next derivative is over the time since the last
/// sound sample. A sensor that is gone for good holds the heating on: watch [`PidState::missed`].
///
/// With a [`GainSchedule`] and its factor φ_k:
///
/// ```text
/// v_k = kp (φ_k e_k - (1 - b) r_k) + I_k + D_k + f_k,   φ_k ki and φ_k kd in the place of ki and kd
/// ```
///
/// I and D are drives that were summed with the factors of their time: where e is 0, a change of the factor moves nothing.
///
/// # Differs from the source
///
/// The derivative's filter is exact for a signal that is straight between samples, not a backward difference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pid<const L: usize = 1> {
    params: PidParams,
    kp: [f64; L],
    /// ki Δt.
    ki_dt: [f64; L],
    /// (1 - a) kd.
    kd_new: [f64; L],
    /// a.
    retained: f64,
    /// 1/Δt.
    per_dt_s: f64,
}

/// Middle of a play before the first sample, whose output then counts as one that has come from below: a rod is cold at first.
const FROM_BELOW: f64 = f64::NEG_INFINITY;

/// State of a [`Pid`] between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PidState<const L: usize = 1> {
    integral: [f64; L],
    derivative: [f64; L],
    /// x of the last sound sample.
    watched: [f64; L],
    /// One over the time from the last sound sample to the next, 1/s.
    per_elapsed_s: [f64; L],
    /// Last command.
    unsaturated: [f64; L],
    missed: [u64; L],
    /// Middle of the schedule's play.
    middle: [f64; L],
}

/// Gains of one sample but kp, and the input of kp.
struct Weights<const L: usize> {
    /// Input of kp: b r - y, or φ e - (1 - b) r.
    weighed: [f64; L],
    ki_dt: [f64; L],
    kd_new: [f64; L],
    /// Middle of the schedule's play after the sample.
    middle: [f64; L],
}

impl<const L: usize> PidState<L> {
    /// Integral I, in the drive's unit.
    #[must_use]
    pub fn integral(&self) -> [f64; L] {
        self.integral
    }

    /// Number of samples missed since the start.
    #[must_use]
    pub fn missed(&self) -> [u64; L] {
        self.missed
    }
}

impl<const L: usize> Pid<L> {
    /// Checks everything; gains differ from lane to lane, the rest is common.
    ///
    /// # Errors
    ///
    /// [`TuneError::Negative`] for a gain or the filter's time constant, [`TuneError::NotPositive`] for the
    /// sample time, [`TuneError::Limits`], [`TuneError::Tracking`], [`TuneError::SetpointWeight`].
    pub fn new(params: PidParams, gains: &[PidGains; L]) -> Result<Self, TuneError> {
        let dt_s = params.dt_s;
        let DriveLimits { lower, upper } = params.limits;
        positive("dt_s", dt_s)?;
        not_negative("derivative_filter_s", params.derivative_filter_s)?;
        if !(lower < upper && lower.is_finite() && upper.is_finite()) {
            return Err(TuneError::Limits { lower, upper });
        }
        if !(0.0..=1.0).contains(&params.setpoint_weight) {
            return Err(TuneError::SetpointWeight {
                value: params.setpoint_weight,
            });
        }
        if let AntiWindup::BackCalculation { tracking_s: value } = params.anti_windup
            && !(value >= dt_s && value.is_finite())
        {
            return Err(TuneError::Tracking { value, dt_s });
        }
        for lane in gains {
            not_negative("kp", lane.kp)?;
            not_negative("ki", lane.ki)?;
            not_negative("kd", lane.kd)?;
        }
        let retained = libm::exp(-dt_s / params.derivative_filter_s);
        Ok(Self {
            params,
            kp: gains.map(|lane| lane.kp),
            ki_dt: gains.map(|lane| lane.ki * dt_s),
            kd_new: gains.map(|lane| (1.0 - retained) * lane.kd),
            retained,
            per_dt_s: 1.0 / dt_s,
        })
    }

    /// All but its gains.
    #[must_use]
    pub fn params(&self) -> &PidParams {
        &self.params
    }

    /// A controller that was idle: no integral, no error so far. Whatever reference comes first is a step.
    ///
    /// # Errors
    ///
    /// [`TuneError::NotFiniteAt`] for a measurement, with its lane.
    pub fn rest(&self, measured: [f64; L]) -> Result<PidState<L>, TuneError> {
        all_finite("measured", &measured)?;
        let watched = self.watched(&[0.0; L], &measured);
        Ok(self.state([0.0; L], watched, [0.0; L]))
    }

    /// A controller that takes over from a drive set by hand, without a bump: if the first sample is
    /// `sample`, its drive is `drive`, brought within the limits, up to rounding.
    ///
    /// An error at that moment is charged to the integral, which makes up for it at the speed of `ki`: take
    /// over with the reference at the measurement where that matters.
    ///
    /// # Errors
    ///
    /// [`TuneError::NotFinite`] or [`TuneError::NotFiniteAt`] for what is in the sample, the drive, or the
    /// integral that follows from them.
    pub fn start(&self, sample: &Sample<L>, drive: [f64; L]) -> Result<PidState<L>, TuneError> {
        finite("setpoint", sample.setpoint)?;
        all_finite("measured", &sample.measured)?;
        finite("feed_forward", sample.feed_forward)?;
        all_finite("drive", &drive)?;
        let drive = self.params.limits.saturate(drive);
        let error = sample.error();
        let mut integral = [0.0; L];
        let Weights { weighed, .. } = self.weights(&[FROM_BELOW; L], sample, &error);
        for l in 0..L {
            integral[l] = drive[l] - self.kp[l] * weighed[l] - sample.feed_forward;
        }
        all_finite("integral", &integral)?;
        let watched = self.watched(&error, &sample.measured);
        Ok(self.state(integral, watched, drive))
    }

    fn state(&self, integral: [f64; L], watched: [f64; L], drive: [f64; L]) -> PidState<L> {
        PidState {
            integral,
            derivative: [0.0; L],
            watched,
            per_elapsed_s: [self.per_dt_s; L],
            unsaturated: drive,
            missed: [0; L],
            middle: [FROM_BELOW; L],
        }
    }

    /// The command for one sample, to be called once every `dt_s`.
    #[inline(always)]
    pub fn step(&self, state: &mut PidState<L>, sample: &Sample<L>) -> Command<L> {
        let error = sample.error();
        let watched = self.watched(&error, &sample.measured);
        let weights = self.weights(&state.middle, sample, &error);
        let mut derivative = [0.0; L];
        let mut unsaturated = [0.0; L];
        for l in 0..L {
            let rate = (watched[l] - state.watched[l]) * state.per_elapsed_s[l];
            derivative[l] = self.retained * state.derivative[l] + weights.kd_new[l] * rate;
            unsaturated[l] = self.kp[l] * weights.weighed[l]
                + state.integral[l]
                + derivative[l]
                + sample.feed_forward;
        }
        let integral = self.integrated(&state.integral, &weights.ki_dt, &error, &unsaturated);
        // Nothing infinite or NaN is in a finite sum. Looked at once for all lanes: few samples are missed.
        let mut all_sound = true;
        for l in 0..L {
            all_sound &= unsaturated[l].is_finite() & integral[l].is_finite();
        }
        if all_sound {
            state.integral = integral;
            state.derivative = derivative;
            state.watched = watched;
            state.per_elapsed_s = [self.per_dt_s; L];
            state.unsaturated = unsaturated;
            state.middle = weights.middle;
        } else {
            for l in 0..L {
                if unsaturated[l].is_finite() && integral[l].is_finite() {
                    state.integral[l] = integral[l];
                    state.derivative[l] = derivative[l];
                    state.watched[l] = watched[l];
                    state.per_elapsed_s[l] = self.per_dt_s;
                    state.unsaturated[l] = unsaturated[l];
                    state.middle[l] = weights.middle[l];
                } else {
                    state.per_elapsed_s[l] =
                        1.0 / (1.0 / state.per_elapsed_s[l] + self.params.dt_s);
                    state.missed[l] += 1;
                }
            }
        }
        Command {
            drive: self.last_drive(state),
            unsaturated: state.unsaturated,
        }
    }

    /// Drive of the last command; before the first, what the controller started from.
    #[inline(always)]
    pub(crate) fn last_drive(&self, state: &PidState<L>) -> [f64; L] {
        self.params.limits.saturate(state.unsaturated)
    }

    /// Weights of a sample, after a play whose middle was `before`.
    #[inline(always)]
    fn weights(&self, before: &[f64; L], sample: &Sample<L>, error: &[f64; L]) -> Weights<L> {
        let mut weights = Weights {
            weighed: [0.0; L],
            ki_dt: self.ki_dt,
            kd_new: self.kd_new,
            middle: *before,
        };
        for l in 0..L {
            // For b = 1 the same bits as the error.
            weights.weighed[l] = self.params.setpoint_weight * sample.setpoint - sample.measured[l];
        }
        if let Some(schedule) = &self.params.gain_schedule {
            for l in 0..L {
                weights.middle[l] = schedule.middle(before[l], sample.measured[l]);
                let factor = schedule.factor(sample.measured[l], weights.middle[l]);
                weights.weighed[l] += (factor - 1.0) * error[l];
                weights.ki_dt[l] *= factor;
                weights.kd_new[l] *= factor;
            }
        }
        weights
    }

    /// x: what the derivative looks at.
    #[inline(always)]
    fn watched(&self, error: &[f64; L], measured: &[f64; L]) -> [f64; L] {
        match self.params.derivative_of {
            DerivativeOf::Error => *error,
            DerivativeOf::Measurement => {
                let mut watched = [0.0; L];
                for l in 0..L {
                    watched[l] = -measured[l];
                }
                watched
            }
        }
    }

    /// I of the next sample.
    #[inline(always)]
    fn integrated(
        &self,
        integral: &[f64; L],
        ki_dt: &[f64; L],
        error: &[f64; L],
        unsaturated: &[f64; L],
    ) -> [f64; L] {
        let mut next = [0.0; L];
        for l in 0..L {
            next[l] = integral[l] + ki_dt[l] * error[l];
        }
        // The choice stands outside the lanes' loops.
        match self.params.anti_windup {
            AntiWindup::Off => {}
            AntiWindup::Clamping => {
                let drive = self.params.limits.saturate(*unsaturated);
                for l in 0..L {
                    let outward = (unsaturated[l] - drive[l]) * error[l] > 0.0;
                    next[l] = if outward { integral[l] } else { next[l] };
                }
            }
            AntiWindup::BackCalculation { tracking_s } => {
                let drive = self.params.limits.saturate(*unsaturated);
                let share = self.params.dt_s / tracking_s;
                for l in 0..L {
                    next[l] += (drive[l] - unsaturated[l]) * share;
                }
            }
        }
        next
    }
}
