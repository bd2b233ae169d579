//! A controller, plants around which it has margins, and what is required of its gains.

use pid_tune::{AntiWindup, DerivativeOf, DriveLimits, PidParams, PlantResponse, Requirements};

pub(crate) const CONTROLLER: PidParams = PidParams {
    dt_s: 0.287,
    limits: DriveLimits {
        lower: 0.0,
        upper: 3.0,
    },
    anti_windup: AntiWindup::Clamping,
    derivative_of: DerivativeOf::Measurement,
    derivative_filter_s: 1.2,
    setpoint_weight: 1.0,
    gain_schedule: None,
};

/// Time constant of the plants, s.
pub(crate) const TAU_S: f64 = 6.0;

/// The sampled answer of a lag of first order to a step of its drive.
pub(crate) fn lag(gain: f64, dead_time_samples: usize) -> PlantResponse {
    let answers: Vec<f64> = (1..600)
        .map(|k| gain * (1.0 - (-CONTROLLER.dt_s * f64::from(k) / TAU_S).exp()))
        .collect();
    PlantResponse::new(CONTROLLER.dt_s, dead_time_samples, &answers).unwrap()
}

pub(crate) fn requirements() -> Requirements {
    Requirements {
        gain_margin: 2.0,
        phase_margin_rad: 45.0_f64.to_radians(),
        sensor_step: 0.01,
        largest_kick: 0.05,
    }
}
