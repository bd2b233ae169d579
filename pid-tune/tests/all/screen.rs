//! Requirements of gains: margins, the sensor's jumps, rest.

use crate::common;

use approx::assert_relative_eq;
use common::screened::{CONTROLLER, TAU_S, lag, requirements};
use common::{AMBIENT_DEGC, rod, undisturbed};
use core::f64::consts::PI;
use pid_tune::{
    ClosedLoop, ClosedLoopParams, CostWeights, Disturbances, Goal, LinearLoop, OpenLoop, Pid,
    PidGains, PidParams, PlantResponse, Plants, Reference, Requirements, RestTest, RodLoop,
    RodLoopParams, Sample, Screen, SmallChanges, Task, TaskError, TuneError, TunerConfig, tune,
};
use std::ops::ControlFlow;
use wiener::hysteresis::Rule;
use wiener::{Drive, Ensemble, Member, Start};

const RODS: Ensemble = Ensemble {
    drive: Drive::Current,
    rule: Rule::LastReversal,
};
const SETPOINT_MM: f64 = 2.5;

fn gains(kp: f64, ki: f64, kd: f64) -> PidGains {
    PidGains { kp, ki, kd }
}

fn member() -> Member {
    Member {
        params: rod(TAU_S),
        start: Start::rest(AMBIENT_DEGC),
    }
}

fn changes() -> SmallChanges {
    SmallChanges {
        limits: CONTROLLER.limits,
        ambient_degc: AMBIENT_DEGC,
        dt_s: CONTROLLER.dt_s,
        tau_s: TAU_S,
        outputs: [0.0, SETPOINT_MM],
        dead_time_samples: 1,
    }
}

#[test]
fn a_loop_of_answers_has_the_margins_of_the_lag_that_they_are_of() {
    for (dead_time_samples, gains) in [
        (0, gains(3.0, 0.4, 0.0)),
        (1, gains(2.0, 0.1, 0.5)),
        (5, gains(1.0, 0.2, 0.0)),
    ] {
        let plant = lag(1.7, dead_time_samples);
        let found = OpenLoop {
            controller: CONTROLLER,
            gains,
            plant: &plant,
        }
        .margins();
        let exact = LinearLoop {
            controller: CONTROLLER,
            gains,
            plant_gain: 1.7,
            tau_s: TAU_S,
            dead_time_samples,
        }
        .margins();
        assert!(found.stable && exact.stable);
        for (found, exact) in [
            (found.gain_margin, exact.gain_margin),
            (found.phase_margin_rad, exact.phase_margin_rad),
            (found.delay_margin_s, exact.delay_margin_s),
            (found.peak_sensitivity, exact.peak_sensitivity),
        ] {
            assert_relative_eq!(found, exact, max_relative = 1e-6);
        }
    }
}

#[test]
fn noise_passes_as_it_does_in_a_long_run() {
    // A proportional loop around the lag, in closed form: u_k = -kp (y_k + e_k), y_(k+1) = a y_k + (1 - a) u_k.
    // var u = kp² (σ² + var y), var y = ((1 - a) kp)² σ²/(1 - p²), p = a - (1 - a) kp.
    let plant = lag(1.0, 0);
    let a = (-CONTROLLER.dt_s / TAU_S).exp();
    for kp in [0.5, 4.0, 15.0] {
        let pole = a - (1.0 - a) * kp;
        let output = ((1.0 - a) * kp).powi(2) / (1.0 - pole * pole);
        let expected = kp * (1.0 + output).sqrt();
        let passage = OpenLoop {
            controller: CONTROLLER,
            gains: gains(kp, 0.0, 0.0),
            plant: &plant,
        }
        .passage();
        assert_relative_eq!(passage.noise_gain, expected, max_relative = 1e-3);
    }
}

#[test]
fn the_steepest_answer_of_a_rod_is_that_of_its_limiting_loop() {
    let steepest = changes().steepest(&RODS, member()).unwrap();
    // Most in the end and early, heating and cooling; some are the same.
    assert!((1..=4).contains(&steepest.len()));
    let rod_loop = RodLoop::new(RodLoopParams {
        rod: member().params,
        drive: RODS.drive,
        rule: RODS.rule,
        controller: CONTROLLER,
        gains: gains(1.0, 0.0, 0.0),
        setpoint: SETPOINT_MM,
        ambient_degc: AMBIENT_DEGC,
        dead_time_samples: 1,
        quantization_step: 0.0,
    })
    .unwrap();
    let foreseen = rod_loop.worst_linear().unwrap().plant_gain;
    let found = steepest.iter().map(PlantResponse::gain).fold(0.0, f64::max);
    // At one of sixteen outputs, and over a small way: not quite the steepest point.
    assert!(
        (0.9..1.01).contains(&(found / foreseen)),
        "{found} {foreseen}"
    );
    let first_order = steepest[0].first_order().unwrap();
    assert_relative_eq!(first_order.tau_s, TAU_S, max_relative = 0.02);
    let delay_s = 1.5 * CONTROLLER.dt_s;
    assert_relative_eq!(first_order.dead_time_s, delay_s, max_relative = 0.1);
}

#[test]
fn gains_pass_if_and_only_if_margins_and_jumps_are_as_required() {
    let required = requirements();
    let screen = Screen::new(required, CONTROLLER, vec![lag(1.7, 1), lag(0.4, 3)]).unwrap();
    let (mut passed, mut missed) = (0, 0);
    for kp in [0.3, 1.0, 3.0, 6.0, 9.0, 14.0, 20.0] {
        for ki in [0.0, 0.1, 1.0, 5.0] {
            for kd in [0.0, 1.0, 6.0] {
                let gains = gains(kp, ki, kd);
                let margins = screen.margins(&gains).unwrap();
                // By straight lines between frequencies: within 1 %.
                let near = |value: f64, wanted: f64| (value / wanted - 1.0).abs() < 0.01;
                let [gain, phase] = [margins.gain_margin, margins.phase_margin_rad];
                let kick = screen.kick(&gains);
                if near(gain, required.gain_margin)
                    || near(phase, required.phase_margin_rad)
                    || near(kick, required.largest_kick)
                {
                    continue;
                }
                let meets = margins.stable
                    && gain >= required.gain_margin
                    && phase >= required.phase_margin_rad
                    && kick <= required.largest_kick;
                let shortfall = screen.shortfall(&gains);
                assert_eq!(shortfall <= 0.0, meets, "{gains:?} {margins:?} {shortfall}");
                if meets {
                    passed += 1;
                } else {
                    missed += 1;
                }
            }
        }
    }
    assert!(passed > 10 && missed > 10, "{passed} {missed}");
}

#[test]
fn a_kick_is_what_one_step_of_the_sensor_does_to_the_drive() {
    let screen = Screen::new(requirements(), CONTROLLER, vec![lag(1.0, 0)]).unwrap();
    for gains in [
        gains(2.0, 0.0, 0.0),
        gains(1.0, 0.5, 0.0),
        gains(0.5, 0.1, 3.0),
    ] {
        let pid = Pid::new(CONTROLLER, &[gains]).unwrap();
        let seen = |measured: f64| Sample {
            setpoint: 1.0,
            measured: [measured],
            feed_forward: 0.0,
        };
        let mut still = pid.start(&seen(1.0), [1.5]).unwrap();
        let before = pid.step(&mut still, &seen(1.0)).drive[0];
        let step = requirements().sensor_step;
        let after = pid.step(&mut still, &seen(1.0 - step)).drive[0];
        let range = CONTROLLER.limits.upper - CONTROLLER.limits.lower;
        // What a sample integrates comes with the next one.
        let integrated = gains.ki * CONTROLLER.dt_s * step;
        let expected = (after - before + integrated) / range;
        assert_relative_eq!(screen.kick(&gains), expected, max_relative = 1e-9);
    }
    let most = screen.largest_gains();
    let alone = [
        gains(most.kp, 0.0, 0.0),
        gains(0.0, most.ki, 0.0),
        gains(0.0, 0.0, most.kd),
    ];
    for gains in alone {
        assert_relative_eq!(screen.kick(&gains), 0.05, max_relative = 1e-9);
    }
}

fn step_task(closed_loop: ClosedLoop<'_>) -> Task<'_, Ensemble> {
    Task::new(RODS, closed_loop, CONTROLLER).unwrap()
}

fn step_loop() -> ClosedLoop<'static> {
    ClosedLoop::new(ClosedLoopParams {
        disturbances: Disturbances {
            quantization_step: requirements().sensor_step,
            dead_time_samples: 1,
            ..Disturbances::default()
        },
        ..undisturbed(
            Reference::Step {
                from: 0.0,
                to: SETPOINT_MM,
                at_s: 0.0,
            },
            400,
        )
    })
    .unwrap()
}

const WEIGHTS: CostWeights = CostWeights {
    mse: 1.0,
    energy: 0.0,
    rise_time: 0.0,
    settling_time: 0.1,
    overshoot: 0.0,
};

#[test]
fn what_is_tuned_meets_what_is_required_and_rests() {
    let task = step_task(step_loop());
    let steepest = changes().steepest(&RODS, member()).unwrap();
    let screen = Screen::new(requirements(), CONTROLLER, steepest).unwrap();
    let config = TunerConfig {
        starts: 2,
        moves: 30,
        ..TunerConfig::for_task(&task, 5.0).unwrap()
    };
    let free = Goal::of(WEIGHTS);
    let found = |goal: &Goal<'_>| {
        tune(&task, &Plants::judged(&[member()]), goal, &config, |_| {
            ControlFlow::Continue(())
        })
    };
    let fast = found(&free).unwrap();
    // Nothing was required, and it shows.
    assert!(screen.shortfall(&fast.gains) > 0.0 && fast.refused == 0);
    let loops = [step_loop()];
    let rest = RestTest {
        loops: &loops,
        height: SETPOINT_MM,
        drive_swing: 0.2 * 3.0,
    };
    let goal = Goal {
        screen: Some(&screen),
        rest: Some(rest),
        ..free
    };
    let sound = found(&goal).unwrap();
    assert!(sound.refused > 0);
    let margins = screen.margins(&sound.gains).unwrap();
    assert!(margins.gain_margin > 1.98 && margins.phase_margin_rad > 0.99 * PI / 4.0);
    assert!(screen.kick(&sound.gains) <= 0.05);
    assert!(sound.ending.drive_swing <= 0.6 && !sound.ending.oscillates(SETPOINT_MM));
    assert!(sound.cost >= fast.cost);
    // SIMC that meets the same is one of those that were looked for.
    let simc = screen.simc().unwrap();
    let [of_simc] = task.responses(&[(member(), simc)]).unwrap()[..] else {
        panic!("one case")
    };
    assert!(sound.cost <= 1.01 * goal.cost(&of_simc), "{sound:?}");
}

#[test]
fn requirements_that_nothing_meets_are_an_error() {
    let task = step_task(step_loop());
    let screen = |largest_kick| {
        let required = Requirements {
            sensor_step: 1.0,
            largest_kick,
            ..requirements()
        };
        Screen::new(required, CONTROLLER, vec![lag(2.0, 1)]).unwrap()
    };
    let bounds = |kp| {
        let mut config = TunerConfig::for_task(&task, 5.0).unwrap();
        config.bounds.lower.kp = kp;
        config.starts = 1;
        config.moves = 5;
        config
    };
    let found = |goal: &Goal<'_>, config: &TunerConfig| {
        tune(&task, &Plants::judged(&[member()]), goal, config, |_| {
            ControlFlow::Continue(())
        })
    };
    let strict = screen(0.01);
    let goal = Goal {
        screen: Some(&strict),
        ..Goal::of(WEIGHTS)
    };
    let unmet = found(&goal, &bounds(1.0));
    assert_eq!(unmet, Err(TaskError::Tune(TuneError::Unmet)));
    // A switch never rests: its drive goes from end to end.
    let loops = [step_loop()];
    let goal = Goal {
        rest: Some(RestTest {
            loops: &loops,
            height: SETPOINT_MM,
            drive_swing: 0.6,
        }),
        ..Goal::of(WEIGHTS)
    };
    let restless = found(&goal, &bounds(400.0));
    assert_eq!(restless, Err(TaskError::Tune(TuneError::NoRest)));
    for (required, name) in [
        (
            Requirements {
                gain_margin: 0.0,
                ..requirements()
            },
            "gain_margin",
        ),
        (
            Requirements {
                largest_kick: f64::NAN,
                ..requirements()
            },
            "largest_kick",
        ),
    ] {
        let refused = Screen::new(required, CONTROLLER, Vec::new()).unwrap_err();
        assert!(refused.to_string().starts_with(name), "{refused}");
    }
}

#[test]
fn an_answer_that_was_cut_has_the_margins_of_the_whole_one() {
    // Two time constants of a slow lag: what was not recorded dies out as the end of it does.
    let slow_s = 12.0 * TAU_S;
    let samples = (2.0 * slow_s / CONTROLLER.dt_s) as usize;
    let answers: Vec<f64> = (1..samples)
        .map(|k| 3.0 * (1.0 - (-CONTROLLER.dt_s * k as f64 / slow_s).exp()))
        .collect();
    let cut = PlantResponse::new(CONTROLLER.dt_s, 1, &answers).unwrap();
    assert_relative_eq!(cut.gain(), 3.0, max_relative = 1e-6);
    assert_relative_eq!(
        cut.first_order().unwrap().tau_s,
        slow_s,
        max_relative = 1e-3
    );
    for gains in [gains(1.0, 0.4, 0.0), gains(0.0, 0.25, 0.0)] {
        let found = OpenLoop {
            controller: CONTROLLER,
            gains,
            plant: &cut,
        }
        .margins();
        let exact = LinearLoop {
            controller: CONTROLLER,
            gains,
            plant_gain: 3.0,
            tau_s: slow_s,
            dead_time_samples: 1,
        }
        .margins();
        assert_relative_eq!(
            found.phase_margin_rad,
            exact.phase_margin_rad,
            max_relative = 1e-6
        );
    }
}

#[test]
fn an_unstable_loop_amplifies_noise_without_end_and_a_weighed_one_follows_later() {
    let plant = lag(1.0, 1);
    let passage = |controller, gains| {
        OpenLoop {
            controller,
            gains,
            plant: &plant,
        }
        .passage()
    };
    let unstable = passage(CONTROLLER, gains(200.0, 0.0, 0.0));
    assert!(unstable.noise_gain.is_infinite() && unstable.bandwidth_hz.abs() < 1e-12);
    let pi = gains(3.0, 0.5, 0.0);
    let whole = passage(CONTROLLER, pi);
    let weighed = PidParams {
        setpoint_weight: 0.3,
        ..CONTROLLER
    };
    let weighed = passage(weighed, pi);
    assert_relative_eq!(whole.noise_gain, weighed.noise_gain);
    assert!(
        weighed.bandwidth_hz < 0.6 * whole.bandwidth_hz,
        "{weighed:?} {whole:?}"
    );
}

#[test]
fn longer_samples_than_a_rod_lasts_are_no_fault() {
    let slow = SmallChanges {
        dt_s: 10.0 * TAU_S,
        ..changes()
    };
    let steepest = slow.steepest(&RODS, member()).unwrap();
    assert!(steepest.iter().all(|plant| plant.gain().is_finite()));
}
