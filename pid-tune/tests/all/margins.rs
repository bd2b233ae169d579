//! Margins: against closed forms, a published table, and loops at the edge of stability.

use approx::assert_abs_diff_eq;
use core::f64::consts::PI;
use pid_tune::{
    AntiWindup, DerivativeOf, DriveLimits, LinearLoop, MAX_DEAD_TIME_SAMPLES, PidGains, PidParams,
};

const CONTROLLER: PidParams = PidParams {
    dt_s: 0.287,
    limits: DriveLimits {
        lower: 0.0,
        upper: 3.0,
    },
    anti_windup: AntiWindup::Clamping,
    derivative_of: DerivativeOf::Error,
    derivative_filter_s: 0.0,
    setpoint_weight: 1.0,
    gain_schedule: None,
};

const LOOP: LinearLoop = LinearLoop {
    controller: CONTROLLER,
    gains: PidGains {
        kp: 1.0,
        ki: 0.0,
        kd: 0.0,
    },
    plant_gain: 1.0,
    tau_s: 6.0,
    dead_time_samples: 0,
};

fn with_kp(kp: f64) -> LinearLoop {
    LinearLoop {
        gains: PidGains { kp, ..LOOP.gains },
        ..LOOP
    }
}

#[test]
fn proportional_control_of_a_lag_has_its_closed_forms() {
    // L = K (1 - a)/(z - a), closed-loop pole p = a - K (1 - a): the gain margin is where p = -1, the peak of
    // |z - a|/|z - p| is at z = -1 for p < a, and |L| = 1 where 1 + a² - 2a cos Ω = K² (1 - a)².
    let a = (-CONTROLLER.dt_s / LOOP.tau_s).exp();
    for kp in [0.5, 3.0, 12.0, 30.0] {
        let found = with_kp(kp).margins();
        let pole = a - kp * (1.0 - a);
        assert!(found.stable);
        assert_abs_diff_eq!(
            found.gain_margin,
            (1.0 + a) / (kp * (1.0 - a)),
            epsilon = 1e-9
        );
        assert_abs_diff_eq!(
            found.peak_sensitivity,
            (1.0 + a) / (1.0 + pole),
            epsilon = 1e-9
        );
        assert_abs_diff_eq!(found.peak_hz, 0.5 / CONTROLLER.dt_s, epsilon = 1e-9);
        if kp < 1.0 {
            assert!(found.phase_margin_rad.is_infinite() && found.delay_margin_s.is_infinite());
            continue;
        }
        let cos = (1.0 + a * a - (kp * (1.0 - a)).powi(2)) / (2.0 * a);
        let angle = cos.acos();
        let lag = PI - angle.sin().atan2(cos - a);
        assert_abs_diff_eq!(found.phase_margin_rad, lag, epsilon = 1e-9);
        assert_abs_diff_eq!(
            found.delay_margin_s,
            lag / angle * CONTROLLER.dt_s,
            epsilon = 1e-9
        );
    }
}

#[test]
fn tuning_for_a_delay_has_the_margins_of_its_published_table() {
    // Skogestad 2003, table 1, first-order process, τ_c = θ: gain margin 3.14, phase margin 61.4°, M_s 1.59, allowed
    // increase of the delay 2.14 θ. L = e^(-θs)/(2θs): the zero of the PI takes the pole of the lag away. Held and
    // sampled, half a sample belongs to the delay.
    let dt_s = 0.1;
    let dead_time_samples = 50;
    let delay_s = (dead_time_samples as f64 + 0.5) * dt_s;
    let tau_s = 20.0;
    let a: f64 = (-dt_s / tau_s).exp();
    // L = kp K (1 - a)/(z - 1) z^-n has the gain 1/(2θ) of an integrator.
    let kp = dt_s / (2.0 * delay_s * (1.0 - a));
    let found = LinearLoop {
        controller: PidParams { dt_s, ..CONTROLLER },
        gains: PidGains {
            kp,
            ki: kp * (1.0 - a) / dt_s,
            kd: 0.0,
        },
        plant_gain: 1.0,
        tau_s,
        dead_time_samples,
    }
    .margins();
    assert!(found.stable);
    #[allow(clippy::approx_constant, reason = "as printed; it is π indeed")]
    let printed_gain_margin = 3.14;
    assert_abs_diff_eq!(found.gain_margin, printed_gain_margin, epsilon = 0.005);
    assert_abs_diff_eq!(found.phase_margin_rad.to_degrees(), 61.4, epsilon = 0.05);
    assert_abs_diff_eq!(found.peak_sensitivity, 1.59, epsilon = 0.005);
    assert_abs_diff_eq!(found.delay_margin_s / delay_s, 2.14, epsilon = 0.005);
}

#[test]
fn stability_ends_where_the_gain_margin_says() {
    let gains = [
        PidGains {
            kp: 2.0,
            ki: 0.0,
            kd: 0.0,
        },
        PidGains {
            kp: 2.0,
            ki: 0.4,
            kd: 0.0,
        },
        PidGains {
            kp: 1.0,
            ki: 0.1,
            kd: 0.8,
        },
        PidGains {
            kp: 0.0,
            ki: 0.3,
            kd: 0.0,
        },
    ];
    for gains in gains {
        for dead_time_samples in [0, 1, 7, MAX_DEAD_TIME_SAMPLES] {
            let scaled = |factor: f64| {
                LinearLoop {
                    controller: PidParams {
                        derivative_filter_s: 0.6,
                        setpoint_weight: 1.0,
                        ..CONTROLLER
                    },
                    gains,
                    plant_gain: factor,
                    dead_time_samples,
                    ..LOOP
                }
                .checked()
                .unwrap()
                .margins()
            };
            let small = scaled(1e-3);
            assert!(small.stable && small.gain_margin > 1.0, "{small:?}");
            let limit = 1e-3 * small.gain_margin;
            assert!(scaled(limit * (1.0 - 1e-6)).stable, "{gains:?}");
            let beyond = scaled(limit * (1.0 + 1e-6));
            assert!(!beyond.stable && beyond.gain_margin < 1.0, "{gains:?}");
            assert!(beyond.delay_margin_s.to_bits() == 0 && beyond.phase_margin_rad.to_bits() == 0);
        }
    }
}

#[test]
fn whole_samples_of_the_delay_margin_are_borne_and_one_more_is_not() {
    for kp in [2.0, 4.0, 9.0] {
        let delayed = |dead_time_samples| {
            LinearLoop {
                dead_time_samples,
                ..with_kp(kp)
            }
            .margins()
        };
        let borne = (delayed(0).delay_margin_s / CONTROLLER.dt_s) as usize;
        assert!(borne > 0);
        assert!(delayed(borne).stable);
        assert!(!delayed(borne + 1).stable);
    }
}

#[test]
fn what_is_no_loop_is_refused() {
    let refused = |linear: LinearLoop| linear.checked().unwrap_err().to_string();
    assert_eq!(
        refused(with_kp(f64::NAN)),
        "kp = NaN: must be finite and >= 0"
    );
    assert_eq!(
        refused(LinearLoop {
            plant_gain: f64::NAN,
            ..LOOP
        }),
        "plant_gain = NaN: must be finite"
    );
    assert_eq!(
        refused(LinearLoop {
            tau_s: f64::NAN,
            ..LOOP
        }),
        "tau_s = NaN: must be finite and > 0"
    );
    assert_eq!(
        refused(LinearLoop {
            dead_time_samples: MAX_DEAD_TIME_SAMPLES + 1,
            ..LOOP
        }),
        "dead_time_samples = 65: must be at most 64"
    );
}
