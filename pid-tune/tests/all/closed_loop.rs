//! The loop: its sample convention, and what disturbs it.

use crate::common;

use common::{
    ALL_ANTI_WINDUP, AMBIENT_DEGC, Lag, P_ONLY, PARAMS, assert_near, assert_same, at, pid, rod,
    rods, snapshots, undisturbed,
};
use pid_tune::{
    ClosedLoop, ClosedLoopParams, DerivativeOf, Disturbances, DriveLimits, MAX_DEAD_TIME_SAMPLES,
    Pid, PidGains, PidParams, Reference, ResponseTerms, Snapshot,
};
use wiener::{Input, Lanes, Output, Plant};

const STEP: Reference<'_> = Reference::Step {
    from: 0.0,
    to: 0.5,
    at_s: 0.0,
};

/// A displacement that does not move.
struct Still(f64);

impl Plant for Still {
    type State = ();

    fn rest(&self, _: f64) {}

    fn output(&self, (): &()) -> Output {
        Output {
            displacement: [self.0],
            temperature_degc: [AMBIENT_DEGC],
        }
    }

    fn step(&self, (): &mut (), _: &Input, _: f64) {}
}

fn outputs(snapshots: &[Snapshot]) -> Vec<f64> {
    snapshots.iter().map(|shown| shown.output[0]).collect()
}

fn applied(snapshots: &[Snapshot]) -> Vec<f64> {
    snapshots.iter().map(|shown| shown.drive[0]).collect()
}

#[test]
fn a_lag_under_proportional_control_follows_the_closed_form() {
    const KP: f64 = 4.0;
    let plant = Lag { tau_s: 3.0 };
    let params = PidParams {
        dt_s: 0.2,
        ..PARAMS
    };
    let pid = pid(params, PidGains { kp: KP, ..P_ONLY });
    let found = snapshots(undisturbed(STEP, 100), &plant, &pid);
    let retained = (-0.2_f64 / 3.0).exp();
    let pole = retained - (1.0 - retained) * KP;
    let balance = 0.5 * KP / (1.0 + KP);
    for (k, shown) in found.iter().enumerate() {
        assert_eq!(shown.k, k);
        assert_near(shown.time_s, 0.2 * k as f64, 1e-12);
        assert_near(
            shown.output[0],
            balance * (1.0 - pole.powi(k as i32)),
            1e-12,
        );
        assert_near(shown.drive[0], KP * (0.5 - shown.output[0]), 1e-12);
    }
}

#[test]
fn a_drive_shows_in_the_next_output() {
    let found = snapshots(
        undisturbed(STEP, 2),
        &Lag { tau_s: 1.0 },
        &pid(PARAMS, P_ONLY),
    );
    assert_same(&found[0].output, &[0.0]);
    assert_same(&found[0].drive, &[0.5]);
    assert_near(found[1].output[0], 0.5 * (1.0 - (-1.0_f64).exp()), 1e-15);
}

#[test]
fn states_go_on_where_a_loop_ends() {
    let plant = Lag { tau_s: 3.0 };
    let gains = PidGains {
        kp: 2.0,
        ki: 0.3,
        kd: 1.0,
    };
    let pid = pid(PARAMS, gains);
    let whole = outputs(&snapshots(undisturbed(STEP, 40), &plant, &pid));
    let mut plants = at(&plant, plant.rest(AMBIENT_DEGC));
    let mut pid_state = pid.rest([plants.state]).unwrap();
    let mut parts = Vec::new();
    for n_samples in [15, 25] {
        let closed_loop = ClosedLoop::new(undisturbed(STEP, n_samples)).unwrap();
        closed_loop.run(&mut plants, &pid, &mut pid_state, |shown| {
            parts.push(shown.output[0]);
        });
    }
    assert_same(&parts, &whole);
}

#[test]
fn the_converter_rounds_to_the_nearest_multiple() {
    // 5 mm in 12 bits: 1.22 µm.
    let quantization_step = 5.0 / 4096.0;
    let pid = pid(PARAMS, P_ONLY);
    for steps in [-700.3, -0.6, -0.4, 0.0, 0.4, 0.6, 409.49, 409.51, 4096.0] {
        let params = ClosedLoopParams {
            disturbances: Disturbances {
                quantization_step,
                ..Disturbances::default()
            },
            ..undisturbed(STEP, 1)
        };
        let output = steps * quantization_step;
        let found = snapshots(params, &Still(output), &pid)[0];
        assert_same(&found.output, &[output]);
        assert_near(found.measured[0], steps.round() * quantization_step, 1e-15);
        // The controller sees what was measured.
        assert_same(&found.drive, &[0.5 - found.measured[0]]);
    }
    let exact = snapshots(undisturbed(STEP, 1), &Still(0.123_456_789), &pid)[0];
    assert_same(&exact.measured, &[0.123_456_789]);
}

#[test]
fn noise_is_measured_and_a_load_is_also_true() {
    let measurement_noise = [0.1, -0.2, 0.0];
    let load = [0.0, 1.0, 2.0];
    let params = ClosedLoopParams {
        disturbances: Disturbances {
            measurement_noise: Some(&measurement_noise),
            output_load: Some(&load),
            ..Disturbances::default()
        },
        ..undisturbed(STEP, 3)
    };
    let found = snapshots(params, &Still(4.0), &pid(PARAMS, P_ONLY));
    for k in 0..3 {
        assert_same(&found[k].output, &[4.0 + load[k]]);
        assert_same(&found[k].measured, &[4.0 + load[k] + measurement_noise[k]]);
        assert_same(&found[k].drive, &[0.5 - found[k].measured[0]]);
    }
}

#[test]
fn dead_time_holds_commands_back_by_whole_samples() {
    let ramp: Vec<f64> = (0..200).map(f64::from).collect();
    let pid = pid(PARAMS, P_ONLY);
    for dead_time_samples in [0, 1, 2, 7, MAX_DEAD_TIME_SAMPLES] {
        let params = ClosedLoopParams {
            disturbances: Disturbances {
                dead_time_samples,
                ..Disturbances::default()
            },
            ..undisturbed(Reference::Samples(&ramp), ramp.len())
        };
        let closed_loop = ClosedLoop::new(params).unwrap();
        // Before the first command, the drive from which the controller took over.
        let mut pid_state = pid.start(&common::sample(0.0, 0.0), [-1.0]).unwrap();
        let mut found = Vec::new();
        closed_loop.run(&mut at(Still(0.0), ()), &pid, &mut pid_state, |shown| {
            found.push(shown.drive[0]);
        });
        let before = std::iter::repeat_n(-1.0, dead_time_samples);
        let commands = ramp.iter().map(|setpoint| setpoint - 1.0);
        let expected: Vec<f64> = before.chain(commands).take(ramp.len()).collect();
        assert_same(&found, &expected);
    }
}

#[test]
fn dead_time_makes_a_loop_oscillate_that_did_not() {
    let pid = pid(PARAMS, PidGains { kp: 3.0, ..P_ONLY });
    let plant = Lag { tau_s: 10.0 };
    let swing = |dead_time_samples| {
        let params = ClosedLoopParams {
            disturbances: Disturbances {
                dead_time_samples,
                ..Disturbances::default()
            },
            ..undisturbed(STEP, 400)
        };
        let late = outputs(&snapshots(params, &plant, &pid)[300..]);
        late.iter().copied().fold(f64::MIN, f64::max)
            - late.iter().copied().fold(f64::MAX, f64::min)
    };
    assert!(swing(0) < 1e-12);
    assert!(swing(10) > 0.1);
}

#[test]
fn a_feed_forward_acts_without_an_error() {
    let feed_forward = [0.3, 0.1, 0.2];
    let no_gains = PidGains { kp: 0.0, ..P_ONLY };
    let params = ClosedLoopParams {
        feed_forward: Some(&feed_forward),
        ..undisturbed(STEP, 3)
    };
    let found = snapshots(params, &Lag { tau_s: 1.0 }, &pid(PARAMS, no_gains));
    assert_same(&applied(&found), &feed_forward);
}

/// Outputs, drives and costs of each lane, as bits.
fn lanes<const L: usize>(params: PidParams, loop_params: ClosedLoopParams<'_>) -> Vec<Vec<u64>> {
    let mut found = Vec::new();
    for first in (0..32).step_by(L) {
        let gains: [PidGains; L] = std::array::from_fn(|l| PidGains {
            kp: 0.5 * (first + l) as f64,
            ki: 0.05 * (first + l) as f64,
            kd: 0.3 * (first + l) as f64,
        });
        let plant = rods::<L>(&std::array::from_fn(
            |l| rod(3.0 + 0.5 * (first + l) as f64),
        ));
        let pid = Pid::<L>::new(params, &gains).unwrap();
        let mut plants = at(&plant, plant.rest(AMBIENT_DEGC));
        let mut pid_state = pid.rest(plants.output().displacement).unwrap();
        let mut terms = ResponseTerms::new(&STEP, params.dt_s).unwrap();
        let mut bits = vec![Vec::new(); L];
        let closed_loop = ClosedLoop::new(loop_params).unwrap();
        closed_loop.run(&mut plants, &pid, &mut pid_state, |shown| {
            terms.add(shown);
            for l in 0..L {
                bits[l].push(shown.output[l].to_bits());
                bits[l].push(shown.drive[l].to_bits());
            }
        });
        for (bits, terms) in bits.iter_mut().zip(terms.terms()) {
            let step = terms.step.unwrap();
            let values = [
                terms.mse,
                terms.energy,
                step.rise_time_s,
                step.settling_time_s,
                step.overshoot,
            ];
            bits.extend(values.map(f64::to_bits));
        }
        found.append(&mut bits);
    }
    found
}

#[test]
fn lanes_give_equal_bits() {
    let noise: Vec<f64> = (0..300)
        .map(|k| 1e-3 * (f64::from(k) * 1.7).sin())
        .collect();
    let loop_params = ClosedLoopParams {
        disturbances: Disturbances {
            measurement_noise: Some(&noise),
            quantization_step: 5.0 / 4096.0,
            dead_time_samples: 2,
            ..Disturbances::default()
        },
        ..undisturbed(STEP, noise.len())
    };
    for anti_windup in ALL_ANTI_WINDUP {
        for derivative_of in [DerivativeOf::Error, DerivativeOf::Measurement] {
            let params = PidParams {
                dt_s: 0.287,
                limits: DriveLimits {
                    lower: 0.0,
                    upper: 3.0,
                },
                anti_windup,
                derivative_of,
                derivative_filter_s: 0.6,
                setpoint_weight: 1.0,
                gain_schedule: None,
            };
            let alone = lanes::<1>(params, loop_params);
            assert_eq!(alone.len(), 32);
            assert_eq!(lanes::<8>(params, loop_params), alone);
            assert_eq!(lanes::<32>(params, loop_params), alone);
        }
    }
}

#[test]
fn a_supply_rounds_commands_and_sleeps_below_its_dead_zone() {
    // Proportional: the command is the error itself, from 0.6 down.
    let params = ClosedLoopParams {
        disturbances: Disturbances {
            drive_step: 0.25,
            drive_dead_zone: 0.25,
            ..Disturbances::default()
        },
        ..undisturbed(
            Reference::Step {
                from: 0.0,
                to: 0.6,
                at_s: 0.0,
            },
            40,
        )
    };
    let acted: Vec<f64> = snapshots(params, &Lag { tau_s: 4.0 }, &pid(PARAMS, P_ONLY))
        .iter()
        .map(|snapshot| snapshot.drive[0])
        .collect();
    // 0.25 is within the dead zone: what is left of the drive is 0.5 or nothing.
    assert_same(&acted[..1], &[0.5]);
    let [half, none] = [0.5_f64, 0.0].map(f64::to_bits);
    assert!(
        acted
            .iter()
            .all(|drive| [half, none].contains(&drive.to_bits()))
    );
    assert!(acted.iter().any(|drive| drive.to_bits() == none));
    let refused = ClosedLoop::new(ClosedLoopParams {
        disturbances: Disturbances {
            drive_dead_zone: -1.0,
            ..Disturbances::default()
        },
        ..params
    });
    assert_eq!(
        refused.unwrap_err().to_string(),
        "drive_dead_zone = -1: must be finite and >= 0"
    );
}
