use core::f64::consts::PI;

use crate::complex::Complex;
use crate::{DerivativeOf, Margins, PidGains, PidParams, PlantResponse};

/// A sampled PID, without its limits, around a plant as it answers small changes.
///
/// ```text
/// L(z) = C(z) P(z) z^(-n),   z = e^(jωΔt)
/// C(z) = kp + ki Δt/(z - 1) + kd (1 - a_f)/Δt (z - 1)/(z - a_f),   a_f = e^(-Δt/T_f)
/// ```
///
/// with the dead time n beyond the hold.
#[derive(Debug, Clone, Copy)]
pub struct OpenLoop<'a> {
    /// The controller; its limits, anti-windup and gain schedule do not count. Its sample time is that of the plant's response.
    pub controller: PidParams,
    /// Its gains.
    pub gains: PidGains,
    /// The plant.
    pub plant: &'a PlantResponse,
}

/// Noise gain and bandwidth of a closed loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passage {
    /// Standard deviation of the drive over that of white noise of the measurement, in a closed loop; ∞ where
    /// it is unstable.
    pub noise_gain: f64,
    /// Lowest frequency at which the output follows less than 1/√2 of the reference, Hz; half of the sampling
    /// frequency where it follows all.
    pub bandwidth_hz: f64,
}

impl OpenLoop<'_> {
    /// L at a frequency, rad/s, above 0 and up to half of the sampling frequency.
    #[must_use]
    pub fn response(&self, omega_rad_per_s: f64) -> Complex {
        controller_response(&self.controller, &self.gains, omega_rad_per_s)
            * self.plant.at(omega_rad_per_s)
    }

    /// Margins, by the plant's sweep of frequencies and refinement between them.
    #[must_use]
    pub fn margins(&self) -> Margins {
        let controller = |omega| controller_response(&self.controller, &self.gains, omega);
        let (frequencies, responses): (Vec<f64>, Vec<Complex>) = self
            .plant
            .swept()
            .map(|(omega, plant)| (omega, controller(omega) * plant))
            .unzip();
        Margins::of(&frequencies, &responses, |omega| self.response(omega))
    }

    /// Noise gain from measurement to drive, and bandwidth from reference to output.
    ///
    /// ```text
    /// noise gain² = Δt/π ∫ |C/(1 + L)|² dω from 0 to π/Δt,   |T| = |C_r P/(1 + L)|
    /// C_r = b kp + ki Δt/(z - 1), and the derivative where it looks at the error
    /// ```
    #[must_use]
    pub fn passage(&self) -> Passage {
        if !self.margins().stable {
            return Passage {
                noise_gain: f64::INFINITY,
                bandwidth_hz: 0.0,
            };
        }
        let nyquist = PI / self.controller.dt_s;
        // Of the reference the proportional term sees a share, and the derivative perhaps nothing.
        let of_reference = PidGains {
            kp: self.controller.setpoint_weight * self.gains.kp,
            kd: match self.controller.derivative_of {
                DerivativeOf::Error => self.gains.kd,
                DerivativeOf::Measurement => 0.0,
            },
            ..self.gains
        };
        let mut before: Option<(f64, f64)> = None;
        let mut noise = 0.0;
        let mut bandwidth = nyquist;
        for (omega, plant) in self.plant.swept() {
            let controller = controller_response(&self.controller, &self.gains, omega);
            let open = controller * plant;
            let returned = open + Complex::ONE;
            let follows = controller_response(&self.controller, &of_reference, omega) * plant;
            let square = (controller / returned).magnitude().powi(2);
            // Below the first frequency as at it.
            let (from, density) = before.unwrap_or((0.0, square));
            noise += 0.5 * (density + square) * (omega - from);
            if bandwidth >= nyquist
                && (follows / returned).magnitude() < core::f64::consts::FRAC_1_SQRT_2
            {
                bandwidth = omega;
            }
            before = Some((omega, square));
        }
        Passage {
            noise_gain: (noise / nyquist).sqrt(),
            bandwidth_hz: bandwidth / (2.0 * PI),
        }
    }
}

/// C at a frequency, rad/s.
pub(crate) fn controller_response(
    controller: &PidParams,
    gains: &PidGains,
    omega_rad_per_s: f64,
) -> Complex {
    let [integral, derivative] = controller_parts(controller, omega_rad_per_s);
    let mut response = Complex::real(gains.kp);
    if gains.ki > 0.0 {
        response = response + integral * gains.ki;
    }
    if gains.kd > 0.0 {
        response = response + derivative * gains.kd;
    }
    response
}

/// Responses of integral and derivative at a frequency, rad/s, at gains of 1.
pub(crate) fn controller_parts(controller: &PidParams, omega_rad_per_s: f64) -> [Complex; 2] {
    let dt_s = controller.dt_s;
    let z = Complex::unit(omega_rad_per_s * dt_s);
    let z_less_one = z + Complex::real(-1.0);
    let retained = libm::exp(-dt_s / controller.derivative_filter_s);
    [
        Complex::real(dt_s) / z_less_one,
        z_less_one / (z + Complex::real(-retained)) * ((1.0 - retained) / dt_s),
    ]
}

/// Frequencies dense enough to follow the angle of a loop, rad/s: in equal ratios from far below its slowest
/// corner, then in equal steps to half of the sampling frequency.
pub(crate) fn frequencies(slowest_rad_per_s: f64, nyquist_rad_per_s: f64) -> Vec<f64> {
    const DECADES_PER_STEP: f64 = 0.01;
    const EQUAL_STEPS: usize = 800;
    /// Of half of the sampling frequency: the sweep begins no lower, however slow the integral.
    const LOWEST_SHARE: f64 = 1e-9;
    let nyquist = nyquist_rad_per_s;
    let step = nyquist / EQUAL_STEPS as f64;
    // From here on equal steps are the shorter ones.
    let joint = step / (libm::exp10(DECADES_PER_STEP) - 1.0);
    let first = (0.01 * slowest_rad_per_s.min(nyquist))
        .min(0.5 * joint)
        .max(LOWEST_SHARE * nyquist);
    let n_ratios = (libm::log10(joint / first) / DECADES_PER_STEP) as usize;
    let mut frequencies: Vec<f64> = (0..n_ratios)
        .map(|k| first * libm::exp10(DECADES_PER_STEP * k as f64))
        .collect();
    let n_steps = ((nyquist - joint) / step) as usize;
    frequencies.extend((0..=n_steps).map(|k| nyquist - step * (n_steps - k) as f64));
    frequencies
}
