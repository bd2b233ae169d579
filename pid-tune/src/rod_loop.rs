use wiener::hysteresis::{Branch, Memory, Rule};
use wiener::{Drive, Plant, State, Wiener, WienerParams};

use crate::error::{finite, not_negative};
use crate::{
    DriveLimits, LinearLoop, MAX_DEAD_TIME_SAMPLES, Pid, PidGains, PidParams, SineResponse,
    TuneError, describing::BiasedSine,
};

/// Most samples of an approach to the set point; only rods that are slower than any sampling needs take more.
const MAX_APPROACH_SAMPLES: usize = 1_000_000;

/// One rod under one controller at one set point: what limit-cycle analysis looks at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RodLoopParams {
    /// The rod.
    pub rod: WienerParams,
    /// How the drive heats it.
    pub drive: Drive,
    /// Memory rule of its hysteresis.
    pub rule: Rule,
    /// The controller; its lower limit is ≥ 0, because a drive below 0 heats like one above, or would have to cool. With a
    /// gain schedule its gains are those at the set point, on the branch where they are larger.
    pub controller: PidParams,
    /// Its gains.
    pub gains: PidGains,
    /// Set point r, in the output's unit; constant.
    pub setpoint: f64,
    /// Temperature of the surroundings T_a, °C.
    pub ambient_degc: f64,
    /// Dead time beyond the hold, samples; at most [`MAX_DEAD_TIME_SAMPLES`].
    pub dead_time_samples: usize,
    /// Step of the converter that measures, in the output's unit; ≥ 0. It rounds in simulations, predictions are
    /// without it.
    pub quantization_step: f64,
}

/// A [`RodLoopParams`] that was checked.
///
/// ```text
/// e → PID, held over Δt → limits → power ∝ u² or u → lag τ → hysteresis → y = gain ξ + offset
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct RodLoop {
    params: RodLoopParams,
    plant: Wiener,
    pid: Pid,
    /// Steady rise of the temperature at a drive of 1, K.
    rise_k: f64,
    /// True if the power is proportional to the square of the drive.
    squares: bool,
}

/// How a rod came to its cycle, which a nested memory does not forget.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Approach {
    /// Heated from rest at the upper limit, past the set point by what the dead time lets pass.
    FromBelow,
    /// Cooled from the hottest state at the lower limit, past the set point likewise.
    FromAbove,
}

impl RodLoop {
    /// Checks everything.
    ///
    /// # Errors
    ///
    /// [`TuneError::Rod`] for the rod and its drive, those of [`Pid::new`], [`TuneError::Negative`] for the lower
    /// limit or the converter's step, [`TuneError::NotFinite`], [`TuneError::DeadTime`].
    pub fn new(params: RodLoopParams) -> Result<Self, TuneError> {
        let schedule = params.controller.gain_schedule;
        let factor = schedule.map_or(1.0, |schedule| schedule.largest_at(params.setpoint));
        let (controller, gains) = params.controller.frozen(&params.gains, factor);
        let params = RodLoopParams {
            controller,
            gains,
            ..params
        };
        let plant = Wiener::new(params.drive, params.rule, &[params.rod])?;
        let pid = Pid::new(params.controller, &[params.gains])?;
        not_negative("lower", params.controller.limits.lower)?;
        finite("setpoint", params.setpoint)?;
        finite("ambient_degc", params.ambient_degc)?;
        not_negative("quantization_step", params.quantization_step)?;
        if params.dead_time_samples > MAX_DEAD_TIME_SAMPLES {
            return Err(TuneError::DeadTime {
                value: params.dead_time_samples,
                most: MAX_DEAD_TIME_SAMPLES,
            });
        }
        let resistance = plant.heat().resistance_ohm_per_m();
        let [lambda_k_per_a2] = plant.heat().lambda_k_per_a2();
        let [power_w_per_m] = params.drive.power_w_per_m([1.0], resistance);
        Ok(Self {
            params,
            plant,
            pid,
            rise_k: power_w_per_m * lambda_k_per_a2 / resistance[0],
            squares: matches!(params.drive, Drive::Current | Drive::Voltage { .. }),
        })
    }

    /// Parameters of the loop; its controller has no gain schedule.
    #[must_use]
    pub fn params(&self) -> &RodLoopParams {
        &self.params
    }

    pub(crate) fn plant(&self) -> &Wiener {
        &self.plant
    }

    pub(crate) fn pid(&self) -> &Pid {
        &self.pid
    }

    pub(crate) fn limits(&self) -> DriveLimits {
        self.params.controller.limits
    }

    pub(crate) fn dt_s(&self) -> f64 {
        self.params.controller.dt_s
    }

    pub(crate) fn tau_s(&self) -> f64 {
        self.plant.heat().tau_s()[0]
    }

    /// Output at a fraction.
    pub(crate) fn output_at(&self, fraction: f64) -> f64 {
        self.params.rod.gain * fraction + self.params.rod.offset
    }

    /// Steady temperature at a drive, °C.
    pub(crate) fn balance_degc(&self, drive: f64) -> f64 {
        let load = if self.squares { drive * drive } else { drive };
        self.params.ambient_degc + self.rise_k * load
    }

    /// Derivative of the steady temperature by the drive, K per its unit.
    pub(crate) fn rise_per_drive_k(&self, drive: f64) -> f64 {
        if self.squares {
            2.0 * self.rise_k * drive
        } else {
            self.rise_k
        }
    }

    /// Drive that holds a temperature, brought within the limits.
    pub(crate) fn holding_drive(&self, temperature_degc: f64) -> f64 {
        let load = ((temperature_degc - self.params.ambient_degc) / self.rise_k).max(0.0);
        let drive = if self.squares { load.sqrt() } else { load };
        let DriveLimits { lower, upper } = self.limits();
        drive.max(lower).min(upper)
    }

    /// Steady rise of the temperature, K, in mean and first harmonic, under a saturated sine.
    pub(crate) fn rise(&self, sine: BiasedSine) -> SineResponse {
        let response = if self.squares {
            self.limits().squared_sine_response(sine)
        } else {
            self.limits().sine_response(sine)
        };
        SineResponse {
            mean: self.rise_k * response.mean,
            first: self.rise_k * response.first,
        }
    }

    /// Temperature on a limiting curve at which the rod has an output, °C; `None` if at none.
    pub(crate) fn limiting_degc(&self, branch: Branch, output: f64) -> Option<f64> {
        let fraction = (output - self.params.rod.offset) / self.params.rod.gain;
        let limits = self.plant.hysteresis().limits();
        let [temperature_degc] = limits.temperature_degc(branch, [fraction]).ok()?;
        Some(temperature_degc)
    }

    /// The loop with a gain from drive to output in the place of all that is not linear.
    pub(crate) fn linear(&self, plant_gain: f64) -> LinearLoop {
        LinearLoop {
            controller: self.params.controller,
            gains: self.params.gains,
            plant_gain,
            tau_s: self.tau_s(),
            dead_time_samples: self.params.dead_time_samples,
        }
    }

    /// The loop at its worst: the steepest slope of the limiting loop, and the drive that holds the set point on
    /// the heating curve, where power answers the drive most.
    ///
    /// ```text
    /// K = gain dξ/dT dT/du,   max |dξ/dT| = 2|ξ_s|/(π h_0),   dT/du = 2u ΔT(1) or ΔT(1)
    /// ```
    ///
    /// with the steady rise ΔT(1) at a drive of 1. On a minor branch the slope right after a reversal is only 1 - ζ
    /// of the limiting curve's: a loop that this one calls unstable may still rest. `None` where no temperature
    /// brings the output to the set point.
    #[must_use]
    pub fn worst_linear(&self) -> Option<LinearLoop> {
        let temperature_degc = self.limiting_degc(Branch::Heating, self.params.setpoint)?;
        let limiting_loop = self.params.rod.limiting_loop;
        let slope_per_k = core::f64::consts::FRAC_2_PI * limiting_loop.fraction_swing
            / limiting_loop.loop_spread_k;
        let rise_per_drive_k = self.rise_per_drive_k(self.holding_drive(temperature_degc));
        Some(self.linear(self.params.rod.gain * slope_per_k * rise_per_drive_k))
    }

    /// The hottest state: at the upper limit for long.
    pub(crate) fn hot(&self) -> State {
        let hottest_degc = self.balance_degc(self.limits().upper);
        self.plant
            .on_limiting_curve(Branch::Cooling, [hottest_degc])
    }

    /// Memory of the hysteresis when the first cycle begins: the way to the set point at a limit, until the
    /// controller would leave that limit, and the dead time after it.
    pub(crate) fn history(&self, approach: Approach) -> Memory<1> {
        let DriveLimits { lower, upper } = self.limits();
        let (mut state, drive, sign) = match approach {
            Approach::FromBelow => (self.plant.rest(self.params.ambient_degc), upper, 1.0),
            Approach::FromAbove => (self.hot(), lower, -1.0),
        };
        let input = wiener::Input {
            drive: [drive],
            ambient_degc: self.params.ambient_degc,
        };
        let dt_s = self.dt_s();
        let saturated = |state: &State| {
            let error = self.params.setpoint - self.plant.output(state).displacement[0];
            sign * (self.params.gains.kp * error - drive) >= 0.0
        };
        // Later the temperature has come as near to its balance as it ever will.
        let most = ((20.0 * self.tau_s() / dt_s) as usize).min(MAX_APPROACH_SAMPLES);
        let mut passed = 0;
        while saturated(&state) && passed < most {
            self.plant.step(&mut state, &input, dt_s);
            passed += 1;
        }
        for _ in 0..self.params.dead_time_samples {
            self.plant.step(&mut state, &input, dt_s);
        }
        state.memory().clone()
    }
}
