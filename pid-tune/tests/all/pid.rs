//! The difference equation of the controller, worked by hand.

use crate::common;

use common::{ALL_ANTI_WINDUP, Lag, P_ONLY, PARAMS, assert_near, assert_same, drives, pid, sample};
use pid_tune::{
    AntiWindup, DerivativeOf, DriveLimits, Pid, PidGains, PidParams, Reference, Sample,
};

const PI: PidGains = PidGains {
    kp: 2.0,
    ki: 0.5,
    kd: 0.0,
};

const D_ONLY: PidGains = PidGains {
    kp: 0.0,
    ki: 0.0,
    kd: 1.0,
};

const LIMITED: PidParams = PidParams {
    limits: DriveLimits {
        lower: 0.0,
        upper: 3.0,
    },
    ..PARAMS
};

/// Drives and integrals for errors one after another.
fn worked(anti_windup: AntiWindup, errors: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let pid = pid(
        PidParams {
            anti_windup,
            ..LIMITED
        },
        PI,
    );
    let mut state = pid.rest([0.0]).unwrap();
    errors
        .iter()
        .map(|&error| {
            let [drive] = pid.step(&mut state, &sample(error, 0.0)).drive;
            (drive, state.integral()[0])
        })
        .unzip()
}

/// The fourth and fifth are saturated.
const ERRORS: [f64; 6] = [1.0, 1.0, 1.0, 1.0, 1.0, -0.5];

#[test]
fn without_anti_windup_the_integral_goes_on() {
    let (drives, integrals) = worked(AntiWindup::Off, &ERRORS);
    assert_same(&drives, &[2.0, 2.5, 3.0, 3.0, 3.0, 1.5]);
    assert_same(&integrals, &[0.5, 1.0, 1.5, 2.0, 2.5, 2.25]);
}

#[test]
fn clamping_holds_the_integral_while_saturated_outward() {
    let (drives, integrals) = worked(AntiWindup::Clamping, &ERRORS);
    assert_same(&drives, &[2.0, 2.5, 3.0, 3.0, 3.0, 0.5]);
    assert_same(&integrals, &[0.5, 1.0, 1.5, 1.5, 1.5, 1.25]);
}

#[test]
fn back_calculation_draws_the_integral_to_the_limit() {
    let (drives, integrals) = worked(AntiWindup::BackCalculation { tracking_s: 2.0 }, &ERRORS);
    assert_same(&drives, &[2.0, 2.5, 3.0, 3.0, 3.0, 0.875]);
    assert_same(&integrals, &[0.5, 1.0, 1.5, 1.75, 1.875, 1.625]);
}

#[test]
fn the_lower_limit_is_one_too() {
    let errors = [-1.0, -1.0, 0.25];
    let (drives, integrals) = worked(AntiWindup::Off, &errors);
    assert_same(&drives, &[0.0, 0.0, 0.0]);
    assert_same(&integrals, &[-0.5, -1.0, -0.875]);
    let (drives, integrals) = worked(AntiWindup::Clamping, &errors);
    assert_same(&drives, &[0.0, 0.0, 0.5]);
    assert_same(&integrals, &[0.0, 0.0, 0.125]);
    let back_calculation = AntiWindup::BackCalculation { tracking_s: 2.0 };
    let (drives, integrals) = worked(back_calculation, &errors);
    assert_same(&drives, &[0.0, 0.0, 1.25]);
    assert_same(&integrals, &[0.5, 0.75, 0.875]);
}

#[test]
fn clamping_integrates_what_leads_out_of_saturation() {
    let pid = pid(LIMITED, PI);
    // Held at the upper limit by the feed-forward, with an output that is too high.
    let high = Sample {
        feed_forward: 10.0,
        ..sample(0.0, 1.0)
    };
    let mut state = pid.start(&high, [3.0]).unwrap();
    let [before] = state.integral();
    let lifted = Sample {
        feed_forward: 20.0,
        ..high
    };
    let command = pid.step(&mut state, &lifted);
    assert_same(&command.drive, &[3.0]);
    assert_same(&command.unsaturated, &[13.0]);
    assert_same(&state.integral(), &[before - 0.5]);
}

#[test]
fn anti_windup_shortens_the_overshoot_that_saturation_makes() {
    let reference = Reference::Step {
        from: 0.0,
        to: 1.0,
        at_s: 0.0,
    };
    let overshoot = |anti_windup| {
        let params = PidParams {
            dt_s: 0.1,
            limits: DriveLimits {
                lower: 0.0,
                upper: 1.2,
            },
            anti_windup,
            ..PARAMS
        };
        let gains = PidGains {
            kp: 3.0,
            ki: 3.0,
            kd: 0.0,
        };
        let loop_params = common::undisturbed(reference, 600);
        let snapshots = common::snapshots(loop_params, &Lag { tau_s: 5.0 }, &pid(params, gains));
        let highest = snapshots.iter().map(|shown| shown.output[0]);
        highest.fold(0.0, f64::max) - 1.0
    };
    let [off, clamping, back_calculation] = ALL_ANTI_WINDUP.map(overshoot);
    assert!(off > 0.15, "{off}");
    assert!(clamping < 0.2 * off, "{clamping} {off}");
    assert!(back_calculation < 0.5 * off, "{back_calculation} {off}");
}

#[test]
fn an_unfiltered_derivative_is_the_difference() {
    let pid = pid(PARAMS, D_ONLY);
    let (drives, _) = drives(&pid, 0.0, &[0.0, 1.0, 3.0, 3.0, 2.5]);
    assert_same(&drives, &[0.0, -1.0, -2.0, 0.0, 0.5]);
}

#[test]
fn a_filtered_derivative_of_a_ramp_is_the_exact_exponential() {
    const FILTER_S: f64 = 0.7;
    const SLOPE: f64 = 4.0;
    for dt_s in [0.01, 0.3, 2.0] {
        let params = PidParams {
            dt_s,
            derivative_filter_s: FILTER_S,
            setpoint_weight: 1.0,
            ..PARAMS
        };
        let ramp: Vec<f64> = (0..40).map(|k| SLOPE * dt_s * f64::from(k)).collect();
        let (drives, _) = drives(&pid(params, D_ONLY), 0.0, &ramp);
        for (k, drive) in drives.iter().enumerate() {
            let time_s = dt_s * k as f64;
            assert_near(*drive, -SLOPE * (1.0 - (-time_s / FILTER_S).exp()), 1e-12);
        }
    }
}

#[test]
fn only_the_derivative_of_the_error_kicks_at_a_step_of_the_reference() {
    for (derivative_of, kick) in [(DerivativeOf::Error, 2.0), (DerivativeOf::Measurement, 0.0)] {
        let params = PidParams {
            derivative_of,
            dt_s: 0.5,
            ..PARAMS
        };
        let pid = pid(params, D_ONLY);
        let mut state = pid.start(&sample(4.0, 4.0), [0.0]).unwrap();
        assert_same(&pid.step(&mut state, &sample(4.0, 4.0)).drive, &[0.0]);
        assert_same(&pid.step(&mut state, &sample(5.0, 4.0)).drive, &[kick]);
        // The output counts the same for both.
        assert_same(&pid.step(&mut state, &sample(5.0, 4.5)).drive, &[-1.0]);
    }
}

#[test]
fn from_rest_the_first_reference_is_a_step() {
    let gains = PidGains {
        kp: 3.0,
        ki: 1.0,
        kd: 1.0,
    };
    for (derivative_of, first) in [(DerivativeOf::Error, 8.0), (DerivativeOf::Measurement, 6.0)] {
        let pid = pid(
            PidParams {
                derivative_of,
                ..PARAMS
            },
            gains,
        );
        let mut state = pid.rest([0.5]).unwrap();
        assert_same(&pid.step(&mut state, &sample(2.5, 0.5)).drive, &[first]);
    }
}

#[test]
fn the_feed_forward_is_added() {
    let pid = pid(PARAMS, P_ONLY);
    let mut state = pid.rest([0.0]).unwrap();
    let sample = Sample {
        feed_forward: 0.25,
        ..sample(1.0, 0.0)
    };
    assert_same(&pid.step(&mut state, &sample).drive, &[1.25]);
}

#[test]
fn taking_over_from_a_drive_makes_no_bump() {
    let gains = PidGains {
        kp: 2.0,
        ki: 0.5,
        kd: 3.0,
    };
    for (by_hand, taken) in [(1.7, 1.7), (5.0, 3.0), (-1.0, 0.0)] {
        for derivative_of in [DerivativeOf::Error, DerivativeOf::Measurement] {
            let params = PidParams {
                derivative_of,
                ..LIMITED
            };
            let pid = pid(params, gains);
            let sample = Sample {
                feed_forward: 0.3,
                ..sample(1.0, 0.8)
            };
            let mut state = pid.start(&sample, [by_hand]).unwrap();
            assert_near(pid.step(&mut state, &sample).drive[0], taken, 1e-15);
        }
    }
}

#[test]
fn a_missed_measurement_holds_the_command_and_nothing_else_happens() {
    for no_number in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for anti_windup in ALL_ANTI_WINDUP {
            let params = PidParams {
                anti_windup,
                ..LIMITED
            };
            let pid = pid(params, PI);
            let (_, before) = drives(&pid, 1.0, &[0.2, 0.4]);
            let mut state = before;
            let mut last = [0.0];
            for _ in 0..1000 {
                last = pid.step(&mut state, &sample(1.0, no_number)).drive;
            }
            assert_eq!(state.missed(), [1000]);
            assert_same(&state.integral(), &before.integral());
            let (expected, _) = drives(&pid, 1.0, &[0.2, 0.4]);
            assert_same(&last, &expected[1..]);
            // Sound again, it goes on as if nothing had been.
            let sound = pid.step(&mut state, &sample(1.0, 0.6));
            let (expected, _) = drives(&pid, 1.0, &[0.2, 0.4, 0.6]);
            assert_same(&sound.drive, &expected[2..]);
            assert_eq!(state.missed(), [1000]);
        }
    }
}

#[test]
fn a_set_point_or_feed_forward_that_is_no_number_is_missed_too() {
    let pid = pid(PARAMS, PI);
    let mut state = pid.rest([0.0]).unwrap();
    pid.step(&mut state, &sample(1.0, 0.0));
    pid.step(&mut state, &sample(f64::NAN, 0.0));
    let no_number = Sample {
        feed_forward: f64::NAN,
        ..sample(1.0, 0.0)
    };
    let command = pid.step(&mut state, &no_number);
    assert_eq!(state.missed(), [2]);
    assert_same(&command.drive, &[2.0]);
}

#[test]
fn before_the_first_sound_measurement_the_drive_is_that_of_the_start() {
    let pid = pid(LIMITED, PI);
    let mut state = pid.start(&sample(1.0, 0.0), [0.7]).unwrap();
    let command = pid.step(&mut state, &sample(1.0, f64::NAN));
    assert_same(&command.drive, &[0.7]);
    let mut state = pid.rest([0.0]).unwrap();
    let command = pid.step(&mut state, &sample(1.0, f64::NAN));
    assert_same(&command.drive, &[0.0]);
}

#[test]
fn a_derivative_behind_missed_samples_is_over_all_of_their_time() {
    let pid = pid(PARAMS, D_ONLY);
    let missing = [0.0, 1.0, f64::NAN, f64::NAN, 4.0, 5.0];
    let (drives, state) = drives(&pid, 0.0, &missing);
    for (drive, expected) in drives.iter().zip([0.0, -1.0, -1.0, -1.0, -1.0, -1.0]) {
        assert_near(*drive, expected, 1e-15);
    }
    assert_eq!(state.missed(), [2]);
}

#[test]
fn a_missed_measurement_of_one_lane_is_not_felt_by_the_others() {
    let pid = Pid::new(LIMITED, &[PI; 3]).unwrap();
    let alone = common::pid(LIMITED, PI);
    let mut state = pid.rest([0.0; 3]).unwrap();
    let measured = [[0.2; 3], [0.3, f64::NAN, 0.3], [0.4; 3]];
    let mut last = [0.0; 3];
    for measured in measured {
        last = pid
            .step(
                &mut state,
                &Sample {
                    setpoint: 1.0,
                    measured,
                    feed_forward: 0.0,
                },
            )
            .drive;
    }
    assert_eq!(state.missed(), [0, 1, 0]);
    let (sound, _) = drives(&alone, 1.0, &[0.2, 0.3, 0.4]);
    let (missing, _) = drives(&alone, 1.0, &[0.2, f64::NAN, 0.4]);
    assert_same(&last, &[sound[2], missing[2], sound[2]]);
}

#[test]
fn a_weighed_reference_kicks_less_and_meets_disturbances_as_before() {
    let gains = PidGains {
        kp: 2.0,
        ki: 0.3,
        kd: 0.0,
    };
    let weighed = PidParams {
        setpoint_weight: 0.25,
        ..PARAMS
    };
    let [plain, weighed] = [PARAMS, weighed].map(|params| pid(params, gains));
    // A step of the reference, nothing measured: a quarter of the kick, the same integral.
    let [before, after] = [&plain, &weighed].map(|pid| drives(pid, 1.0, &[0.0, 0.0]).0);
    assert_same(&before, &[2.0, 2.0 + 0.3]);
    assert_same(&after, &[0.5, 0.5 + 0.3]);
    // From rest at the reference a disturbance of the measurement moves both alike.
    let at_rest = |pid: &Pid| {
        let start = sample(1.0, 1.0);
        let mut state = pid.start(&start, [5.0]).unwrap();
        let still = pid.step(&mut state, &start).drive[0];
        pid.step(&mut state, &sample(1.0, 0.9)).drive[0] - still
    };
    assert!((at_rest(&plain) - at_rest(&weighed)).abs() < 1e-12);
    let refused = Pid::new(
        PidParams {
            setpoint_weight: 1.5,
            ..PARAMS
        },
        &[gains],
    );
    assert_eq!(
        refused.unwrap_err().to_string(),
        "setpoint_weight = 1.5: must lie in 0 .. 1"
    );
}
