//! Agreement of predicted and simulated limit cycles, over many loops; the whole map is in
//! `examples/limit_cycle_map.rs`. The rods here are others than those, and the forecast's rule was not made on them.

use pid_tune::{
    AntiWindup, DerivativeOf, DriveLimits, LoopAnalysis, PidGains, PidParams, RodLoop,
    RodLoopParams,
};
use wiener::hysteresis::{LoopParams, Rule};
use wiener::thermal::{HeatBalanceParams, ThermalConstants};
use wiener::{Drive, WienerParams};

fn analyzed(kp: f64, tau_s: f64, setpoint: f64, dead_time_samples: usize) -> LoopAnalysis {
    RodLoop::new(RodLoopParams {
        rod: WienerParams {
            heat: HeatBalanceParams::from_constants(ThermalConstants {
                tau_s,
                lambda_k_per_a2: 12.0,
            }),
            limiting_loop: LoopParams {
                loop_center_degc: 72.0,
                loop_half_width_k: 8.0,
                loop_spread_k: 5.5,
                ..LoopParams::default()
            },
            zeta: 0.9,
            gain: 5.0,
            offset: -0.2,
        },
        drive: Drive::Current,
        rule: Rule::LastReversal,
        controller: PidParams {
            dt_s: 0.287,
            limits: DriveLimits {
                lower: 0.0,
                upper: 3.0,
            },
            anti_windup: AntiWindup::Clamping,
            derivative_of: DerivativeOf::Measurement,
            derivative_filter_s: 0.0,
            setpoint_weight: 1.0,
            gain_schedule: None,
        },
        gains: PidGains {
            kp,
            ki: kp * 5e-5,
            kd: 0.0,
        },
        setpoint,
        ambient_degc: 22.0,
        dead_time_samples,
        quantization_step: 5.0 / 4096.0,
    })
    .unwrap()
    .analyzed()
    .unwrap()
}

#[test]
fn rest_and_cycle_are_foreseen_in_nine_of_ten_loops() {
    let (mut n_agree, mut n_cycle, mut n_loops) = (0, 0, 0);
    for kp in [200.0, 0.2] {
        for tau_s in [4.0, 9.0, 20.0, 50.0] {
            for setpoint in [0.4, 1.2, 2.4, 3.6] {
                let found = analyzed(kp, tau_s, setpoint, 0);
                n_agree += usize::from(found.foresees_cycle() == found.cycles_in_simulation());
                n_cycle += usize::from(found.cycles_in_simulation());
                n_loops += 1;
            }
        }
    }
    assert_eq!(n_loops, 32);
    assert!(n_cycle >= 8, "{n_cycle} cycle: the map would show nothing");
    assert!(10 * n_agree >= 9 * n_loops, "{n_agree} of {n_loops}");
}

#[test]
fn amplitude_and_frequency_are_foreseen_to_fifteen_percent_in_the_median() {
    let [mut amplitude, mut frequency] = [Vec::new(), Vec::new()];
    let mut n_cycle = 0;
    for dead_time_samples in [2, 5] {
        for tau_s in [3.0, 7.0] {
            for setpoint in [0.6, 1.6, 2.8, 3.8] {
                let found = analyzed(200.0, tau_s, setpoint, dead_time_samples);
                n_cycle += usize::from(found.cycles_in_simulation());
                for outcome in found.outcomes {
                    if let (Some(forecast), Some(run)) = (outcome.forecast, outcome.oscillation) {
                        amplitude.push((forecast.amplitude / run.sine_amplitude - 1.0).abs());
                        frequency.push((forecast.frequency_hz / run.frequency_hz - 1.0).abs());
                    }
                }
            }
        }
    }
    assert_eq!(n_cycle, 16);
    assert!(amplitude.len() >= 40);
    for mut errors in [amplitude, frequency] {
        errors.sort_by(f64::total_cmp);
        assert!(errors[errors.len() / 2] < 0.15, "{errors:?}");
    }
}
