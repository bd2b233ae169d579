use core::f64::consts::PI;

use crate::complex::Complex;
use crate::error::{finite, positive};
use crate::open_loop::{controller_response, frequencies};
use crate::{MAX_DEAD_TIME_SAMPLES, Margins, Pid, PidGains, PidParams, TuneError};

/// A sampled PID, without its limits, around a first-order lag with dead time.
///
/// ```text
/// L(z) = C(z) K (1 - a)/(z - a) z^(-n),   a = e^(-Δt/τ),   z = e^(jωΔt)
/// C(z) = kp + ki Δt/(z - 1) + kd (1 - a_f)/Δt (z - 1)/(z - a_f),   a_f = e^(-Δt/T_f)
/// ```
///
/// The hold and the lag together are exactly (1 - a)/(z - a) `[Astrom1997, chapter 2]`, and C is that of
/// [`Pid`]: nothing is approximated between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearLoop {
    /// The controller; its limits, anti-windup and gain schedule do not count.
    pub controller: PidParams,
    /// Its gains.
    pub gains: PidGains,
    /// Output per drive in the steady state, K; finite.
    pub plant_gain: f64,
    /// Time constant τ of the lag, s; > 0.
    pub tau_s: f64,
    /// Dead time n beyond the hold, samples; at most [`MAX_DEAD_TIME_SAMPLES`].
    pub dead_time_samples: usize,
}

impl LinearLoop {
    /// Checks everything.
    ///
    /// # Errors
    ///
    /// Those of [`Pid::new`], [`TuneError::NotFinite`], [`TuneError::NotPositive`], [`TuneError::DeadTime`].
    pub fn checked(self) -> Result<Self, TuneError> {
        let _pid = Pid::new(self.controller, &[self.gains])?;
        finite("plant_gain", self.plant_gain)?;
        positive("tau_s", self.tau_s)?;
        if self.dead_time_samples > MAX_DEAD_TIME_SAMPLES {
            return Err(TuneError::DeadTime {
                value: self.dead_time_samples,
                most: MAX_DEAD_TIME_SAMPLES,
            });
        }
        Ok(self)
    }

    /// Half of the sampling frequency, rad/s: where frequencies end.
    #[must_use]
    pub fn nyquist_rad_per_s(&self) -> f64 {
        PI / self.controller.dt_s
    }

    /// L at a frequency, rad/s, above 0 and up to [`LinearLoop::nyquist_rad_per_s`].
    #[must_use]
    pub fn response(&self, omega_rad_per_s: f64) -> Complex {
        self.controller_response(omega_rad_per_s) * self.plant_response(omega_rad_per_s)
    }

    /// C at a frequency, rad/s.
    #[must_use]
    pub fn controller_response(&self, omega_rad_per_s: f64) -> Complex {
        controller_response(&self.controller, &self.gains, omega_rad_per_s)
    }

    /// L/C at a frequency, rad/s.
    fn plant_response(&self, omega_rad_per_s: f64) -> Complex {
        let dt_s = self.controller.dt_s;
        let angle_rad = omega_rad_per_s * dt_s;
        let retained = libm::exp(-dt_s / self.tau_s);
        let lag =
            Complex::real(1.0 - retained) / (Complex::unit(angle_rad) + Complex::real(-retained));
        lag * Complex::unit(-angle_rad * self.dead_time_samples as f64) * self.plant_gain
    }

    /// Margins, by a sweep of frequencies and refinement between them.
    #[must_use]
    pub fn margins(&self) -> Margins {
        let sweep = self.sweep();
        let responses: Vec<Complex> = sweep.iter().map(|&omega| self.response(omega)).collect();
        Margins::of(&sweep, &responses, |omega| self.response(omega))
    }

    /// Frequencies dense enough to follow the angle of L, rad/s.
    pub(crate) fn sweep(&self) -> Vec<f64> {
        let PidGains { kp, ki, .. } = self.gains;
        let mut slowest = 1.0 / self.tau_s;
        if ki > 0.0 && kp > 0.0 {
            slowest = slowest.min(ki / kp);
        }
        frequencies(slowest, self.nyquist_rad_per_s())
    }
}
