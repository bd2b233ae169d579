//! Gains by the output's level and branch.

use crate::common;

use common::{P_ONLY, PARAMS, assert_near, assert_same, pid, sample};
use pid_tune::{
    AntiWindup, DerivativeOf, GainSchedule, GainScheduleParams, Pid, PidGains, PidParams, Sample,
    TuneError,
};

const FACTORS: GainScheduleParams = GainScheduleParams {
    outputs: [1.0, 8.0],
    turn: 0.5,
    heating: [4.0, 3.0, 2.0, 1.0, 1.0, 1.5, 2.5, 4.0],
    cooling: [4.0, 3.5, 3.0, 2.0, 1.5, 2.0, 3.5, 4.0],
};

fn scheduled(params: PidParams) -> PidParams {
    PidParams {
        gain_schedule: Some(GainSchedule::new(FACTORS).unwrap()),
        ..params
    }
}

/// Factors on the gains at outputs one after another: drives at an error of 1 and a proportional gain of 1.
fn factors(outputs: &[f64]) -> Vec<f64> {
    let pid = pid(scheduled(PARAMS), P_ONLY);
    let mut state = pid.rest([outputs[0]]).unwrap();
    outputs
        .iter()
        .map(|&output| pid.step(&mut state, &sample(output + 1.0, output)).drive[0] / P_ONLY.kp)
        .collect()
}

#[test]
fn factors_lie_on_straight_lines_between_levels_and_stay_beyond_them() {
    // Rising: the heating branch.
    let rising = factors(&[-3.0, 1.0, 1.5, 2.0, 3.25, 4.0, 5.5, 8.0, 90.0]);
    let expected = [4.0, 4.0, 3.5, 3.0, 1.75, 1.0, 1.25, 4.0, 4.0];
    rising
        .iter()
        .zip(expected)
        .for_each(|(&found, expected)| assert_near(found, expected, 1e-12));
    // Falling: the cooling branch.
    let falling = factors(&[90.0, 7.5, 6.0, 4.5, 2.0, -3.0]);
    let expected = [4.0, 3.75, 2.0, 1.75, 3.5, 4.0];
    falling
        .iter()
        .zip(expected)
        .for_each(|(&found, expected)| assert_near(found, expected, 1e-12));
}

#[test]
fn a_turn_takes_the_factor_from_one_branch_to_the_other_by_the_way_of_the_output() {
    // At 4 heating has 1 and cooling 2, with slopes of 0 and of -1 and -0.5 a level.
    let turning = factors(&[4.0, 4.0, 3.9, 3.8, 3.7, 3.6, 3.5, 3.4]);
    for (k, &found) in turning.iter().enumerate().skip(1) {
        let fallen = 0.1 * (k as f64 - 1.0);
        let share = (1.0 - fallen / FACTORS.turn).max(0.0);
        let [heating, cooling] = [1.0 + fallen, 2.0 + fallen];
        assert_near(found, cooling + share * (heating - cooling), 1e-12);
    }
}

#[test]
fn noise_at_rest_does_not_go_from_branch_to_branch() {
    // Ten jumps of a sensor make a turn: to and fro by half of it, the factor keeps nearer to its own branch.
    let mut outputs = vec![4.0];
    outputs.extend((0..1_000).map(|k| 4.0 - 0.125 * f64::from(k * 7 % 3)));
    let of_noise = factors(&outputs);
    let (lowest, highest) = of_noise.iter().fold((f64::MAX, 0.0_f64), |range, &factor| {
        (range.0.min(factor), range.1.max(factor))
    });
    assert_near(lowest, 1.0, 1e-12);
    // Half of the way from 1.25 to 2.25, the factors at 3.75.
    assert_near(highest, 1.75, 1e-12);
    // And back at the same output it is the same: nothing wanders.
    assert_near(of_noise[1_000], of_noise[1], 1e-12);
}

#[test]
fn a_change_of_the_factor_does_not_move_the_drive_without_an_error() {
    let gains = PidGains {
        kp: 3.0,
        ki: 0.7,
        kd: 0.0,
    };
    for setpoint_weight in [1.0, 0.3] {
        for anti_windup in common::ALL_ANTI_WINDUP {
            let params = scheduled(PidParams {
                setpoint_weight,
                anti_windup,
                ..PARAMS
            });
            let pid = pid(params, gains);
            let held = 1.25;
            let mut state = pid.start(&sample(4.0, 4.0), [held]).unwrap();
            // Up and down over all levels and both branches, the reference always at the output.
            let way = (0..400).map(|k| 4.0 + 4.5 * (0.05 * f64::from(k)).sin());
            for output in way {
                let before = state.integral()[0];
                let [drive] = pid.step(&mut state, &sample(output, output)).drive;
                assert_same(&state.integral(), &[before]);
                // What the weight takes from the set point is not scheduled.
                let weighed = gains.kp * (1.0 - setpoint_weight) * (4.0 - output);
                assert_near(drive, held + weighed, 1e-12);
            }
        }
    }
}

#[test]
fn a_turn_moves_the_drive_no_more_than_the_output_does() {
    // With an error that stays, over a turn in steps: nothing jumps, whatever the branches' factors.
    let gains = PidGains { ki: 0.0, ..P_ONLY };
    let pid = pid(scheduled(PARAMS), gains);
    let mut state = pid.rest([4.0]).unwrap();
    let mut before = None;
    let step = 1e-3;
    for k in 0..2_000 {
        let output = if k < 200 {
            4.0 + step * f64::from(k)
        } else {
            4.2 - step * f64::from(k - 200)
        };
        let [drive] = pid.step(&mut state, &sample(output + 0.5, output)).drive;
        if let Some(before) = before {
            // At most 1 a level and 1 a turn of 0.5, times kp and the error of 0.5.
            let most = (1.0 + 1.0 / FACTORS.turn) * step * gains.kp * 0.5;
            let moved: f64 = drive - before;
            assert!(moved.abs() <= 1.01 * most, "{k}: {moved}");
        }
        before = Some(drive);
    }
}

#[test]
fn all_three_gains_are_multiplied() {
    let gains = PidGains {
        kp: 1.5,
        ki: 0.4,
        kd: 0.6,
    };
    for derivative_of in [DerivativeOf::Error, DerivativeOf::Measurement] {
        let params = PidParams {
            derivative_of,
            derivative_filter_s: 1.7,
            anti_windup: AntiWindup::Off,
            ..PARAMS
        };
        // Beyond the last level the factor is 4 on both branches.
        let four = pid(scheduled(params), gains);
        let larger = pid(
            params,
            PidGains {
                kp: 4.0 * gains.kp,
                ki: 4.0 * gains.ki,
                kd: 4.0 * gains.kd,
            },
        );
        let mut states = [&four, &larger].map(|pid| pid.rest([20.0]).unwrap());
        for k in 0..50 {
            let output = 20.0 + f64::from(k % 7);
            let one = sample(21.0, output);
            let [a, b] = [
                four.step(&mut states[0], &one),
                larger.step(&mut states[1], &one),
            ];
            assert_near(a.unsaturated[0], b.unsaturated[0], 1e-12);
        }
    }
}

#[test]
fn a_controller_takes_over_without_a_bump() {
    let gains = PidGains {
        kp: 1.5,
        ki: 0.4,
        kd: 0.6,
    };
    let pid = pid(scheduled(PARAMS), gains);
    for output in [0.0, 1.7, 4.0, 7.9, 12.0] {
        let first = sample(output + 0.4, output);
        let mut state = pid.start(&first, [2.0]).unwrap();
        assert_near(pid.step(&mut state, &first).drive[0], 2.0, 1e-12);
    }
}

#[test]
fn a_missed_sample_turns_nothing() {
    let pid = pid(scheduled(PARAMS), P_ONLY);
    let mut states = [pid.rest([4.0]).unwrap(), pid.rest([4.0]).unwrap()];
    pid.step(&mut states[0], &sample(5.0, 4.0));
    pid.step(&mut states[1], &sample(5.0, 4.0));
    for missed in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let command = pid.step(&mut states[1], &sample(5.0, missed));
        assert!(command.drive[0].is_finite());
    }
    assert_eq!(states[1].missed(), [3]);
    let after = |state| pid.step(state, &sample(5.0, 3.9)).drive;
    let [one, other] = &mut states;
    assert_same(&after(one), &after(other));
}

#[test]
fn lanes_are_what_each_is_alone() {
    let gains = [0.5, 1.0, 4.0].map(|kp| PidGains {
        kp,
        ki: 0.3,
        kd: 0.2,
    });
    let params = scheduled(PARAMS);
    let all = Pid::new(params, &gains).unwrap();
    let alone = gains.map(|gains| pid(params, gains));
    let mut state = all.rest([2.0; 3]).unwrap();
    let mut states = alone.map(|pid| pid.rest([2.0]).unwrap());
    for k in 0..300 {
        let measured: [f64; 3] =
            core::array::from_fn(|l| 4.0 + 4.0 * (0.1 * f64::from(k) + l as f64).sin());
        let drives = all.step(
            &mut state,
            &Sample {
                setpoint: 4.0,
                measured,
                feed_forward: 0.0,
            },
        );
        for l in 0..3 {
            let one = alone[l].step(&mut states[l], &sample(4.0, measured[l]));
            assert_same(&one.drive, &[drives.drive[l]]);
        }
    }
}

#[test]
fn ones_leave_the_controller_as_it_is() {
    let ones = GainScheduleParams {
        heating: [1.0; 8],
        cooling: [1.0; 8],
        ..FACTORS
    };
    let gains = PidGains {
        kp: 1.5,
        ki: 0.4,
        kd: 0.6,
    };
    let with = PidParams {
        gain_schedule: Some(GainSchedule::new(ones).unwrap()),
        ..PARAMS
    };
    let outputs: Vec<f64> = (0..100).map(|k| 4.0 * (0.3 * f64::from(k)).sin()).collect();
    let [a, b] = [with, PARAMS].map(|params| common::drives(&pid(params, gains), 3.0, &outputs).0);
    assert_same(&a, &b);
}

#[test]
fn what_is_no_schedule_is_refused() {
    let text = |params| GainSchedule::new(params).unwrap_err().to_string();
    for outputs in [
        [1.0, 1.0],
        [2.0, 1.0],
        [f64::NAN, 1.0],
        [0.0, f64::INFINITY],
    ] {
        let [lower, upper] = outputs;
        assert_eq!(
            text(GainScheduleParams { outputs, ..FACTORS }),
            format!(
                "a gain schedule from an output of {lower} to {upper}: both must be finite, the first below the second"
            )
        );
    }
    for turn in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(
            text(GainScheduleParams { turn, ..FACTORS }),
            format!("turn = {turn}: must be finite and > 0")
        );
    }
    let turn = 1e-310;
    assert_eq!(
        text(GainScheduleParams { turn, ..FACTORS }),
        "1 / turn = inf: must be finite and > 0"
    );
    for value in [0.99, -2.0, f64::NAN, f64::INFINITY] {
        let mut params = FACTORS;
        params.cooling[2] = value;
        assert_eq!(
            text(params),
            format!("cooling[2] = {value}: a factor of a gain schedule must be finite and >= 1")
        );
    }
    let refused: TuneError = GainSchedule::new(GainScheduleParams {
        heating: [0.0; 8],
        ..FACTORS
    })
    .unwrap_err();
    assert!(matches!(
        refused,
        TuneError::ScheduleFactor {
            branch: "heating",
            index: 0,
            ..
        }
    ));
}
