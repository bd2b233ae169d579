//! Gains by rule: SIMC, and a relay test.

use crate::common;

use approx::assert_relative_eq;
use common::AMBIENT_DEGC;
use common::lags::Lags;
use core::f64::consts::PI;
use pid_tune::{
    AntiWindup, DerivativeOf, DriveLimits, FirstOrder, PidParams, PlantResponse, RelayCycle,
    RelayTest, Requirements, Screen,
};

const CONTROLLER: PidParams = PidParams {
    dt_s: 0.05,
    limits: DriveLimits {
        lower: 0.0,
        upper: 10.0,
    },
    anti_windup: AntiWindup::Clamping,
    derivative_of: DerivativeOf::Measurement,
    derivative_filter_s: 0.0,
    setpoint_weight: 1.0,
    gain_schedule: None,
};

fn lag(gain: f64, tau_s: f64, dead_time_samples: usize) -> PlantResponse {
    let answers: Vec<f64> = (1..4000)
        .map(|k| gain * (1.0 - (-CONTROLLER.dt_s * f64::from(k) / tau_s).exp()))
        .collect();
    PlantResponse::new(CONTROLLER.dt_s, dead_time_samples, &answers).unwrap()
}

fn screen(gain_margin: f64, phase_margin_deg: f64, plant: PlantResponse) -> Screen {
    let required = Requirements {
        gain_margin,
        phase_margin_rad: phase_margin_deg.to_radians(),
        sensor_step: 0.0,
        largest_kick: 1.0,
    };
    Screen::new(required, CONTROLLER, vec![plant]).unwrap()
}

#[test]
fn a_lag_is_found_in_its_own_answer() {
    for (gain, tau_s, dead_time_samples) in [(2.0, 6.0, 0), (0.3, 3.0, 40)] {
        let found = lag(gain, tau_s, dead_time_samples).first_order().unwrap();
        assert_relative_eq!(found.gain, gain, max_relative = 1e-6);
        assert_relative_eq!(found.tau_s, tau_s, max_relative = 2e-3);
        let dead_time_s = CONTROLLER.dt_s * (dead_time_samples as f64 + 0.5);
        assert!((found.dead_time_s - dead_time_s).abs() < 0.02, "{found:?}");
    }
    assert_eq!(lag(-1.0, 6.0, 0).first_order(), None);
}

#[test]
fn simc_is_the_published_rule() {
    // Skogestad 2003, table 1: a lag-dominant process of gain 2, τ 20, θ 1 with τ_c = θ.
    let process = FirstOrder {
        gain: 2.0,
        tau_s: 20.0,
        dead_time_s: 1.0,
    };
    let gains = process.simc(1.0);
    assert_relative_eq!(gains.kp, 5.0);
    assert_relative_eq!(gains.kp / gains.ki, 8.0);
    assert_relative_eq!(gains.kd, 0.0);
    // Where 4 (τ_c + θ) exceeds τ, the integral takes the pole of the lag away.
    let gains = process.simc(9.0);
    assert_relative_eq!(gains.kp / gains.ki, 20.0);
}

#[test]
fn rules_are_slowed_down_until_they_meet_what_is_required_and_no_further() {
    let easy = screen(1.5, 20.0, lag(2.0, 6.0, 20));
    let model = easy.plants()[0].first_order().unwrap();
    let recommended = model.simc(model.dead_time_s);
    assert_eq!(easy.simc(), Some(recommended));
    let strict = screen(6.0, 60.0, lag(2.0, 6.0, 20));
    let slow = strict.simc().unwrap();
    assert!(slow.kp < recommended.kp);
    let margins = strict.margins(&slow).unwrap();
    let tight = (margins.gain_margin / 6.0).min(margins.phase_margin_rad.to_degrees() / 60.0);
    assert!((0.99..1.02).contains(&tight), "{margins:?}");
    let cycle = RelayCycle {
        ultimate_gain: 4.0,
        period_s: 4.0,
    };
    let gains = cycle.pi();
    let slowed = strict.relay(&cycle).unwrap();
    // kp by a factor, T_i by the same one.
    let factor = gains.kp / slowed.kp;
    assert!(factor > 1.0);
    assert_relative_eq!(
        slowed.kp / slowed.ki,
        factor * gains.kp / gains.ki,
        max_relative = 1e-9
    );
}

#[test]
fn a_relay_finds_the_cycle_of_a_lag_with_dead_time() {
    // Between 0 and 10 about 5. After each crossing the lag goes on for θ, to ±a, and comes back:
    // a = d (1 - e^(-θ/τ)), T/2 = θ + τ ln(1 + a/d).
    let (tau_s, dead_time_samples) = (6.0, 40);
    let test = RelayTest {
        limits: CONTROLLER.limits,
        ambient_degc: AMBIENT_DEGC,
        dt_s: CONTROLLER.dt_s,
        tau_s,
        setpoint: 5.0,
        dead_time_samples,
        hysteresis: 0.0,
    };
    let lags = Lags {
        breaks_above: f64::INFINITY,
    };
    let cycle = test.run(&lags, tau_s).unwrap().unwrap();
    // A crossing is seen half a sample late, on average.
    let theta_s = CONTROLLER.dt_s * (dead_time_samples as f64 + 0.5);
    let share = 1.0 - (-theta_s / tau_s).exp();
    let period_s = 2.0 * (theta_s + tau_s * share.ln_1p());
    assert_relative_eq!(cycle.period_s, period_s, max_relative = 0.02);
    // One harmonic over the other is the lag's own gain, held drive and all.
    let omega = 2.0 * PI / cycle.period_s;
    assert_relative_eq!(
        cycle.ultimate_gain,
        1.0_f64.hypot(omega * tau_s),
        max_relative = 0.01
    );
    // A set point beyond the drive's reach has no cycle.
    let beyond = RelayTest {
        setpoint: 11.0,
        ..test
    };
    assert_eq!(beyond.run(&lags, tau_s).unwrap(), None);
}
