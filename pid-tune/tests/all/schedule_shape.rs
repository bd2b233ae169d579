//! Schedules by a plant's slopes, and margins with them.

use approx::assert_relative_eq;
use pid_tune::{
    Answer, Answers, DriveLimits, PidGains, PidParams, SCHEDULE_LEVELS, ScheduleShape, Screen,
    SmallChanges,
};
use wiener::hysteresis::Rule;
use wiener::{Drive, Ensemble, Member, Start};

use crate::common::screened::{CONTROLLER, TAU_S, lag, requirements};
use crate::common::{AMBIENT_DEGC, assert_same, rod};

const GAINS: PidGains = PidGains {
    kp: 2.0,
    ki: 0.5,
    kd: 0.1,
};
const SHAPE: ScheduleShape = ScheduleShape {
    exponent: 1.0,
    by_branch: true,
    largest_factor: 3.0,
    turn: 0.2,
};

/// Lags that are steepest at half of the way, and there steeper by half on heating.
fn answers() -> Answers {
    let on = |steepest: f64| {
        (0..15)
            .map(|k| {
                let output = 0.5 * f64::from(k);
                let slope = steepest / (1.0 + (output - 3.5).powi(2));
                Answer {
                    output,
                    slope,
                    plant: lag(slope, 1),
                }
            })
            .collect()
    };
    Answers {
        outputs: [0.0, 7.0],
        heating: on(1.5),
        cooling: on(1.0),
    }
}

fn with(shape: ScheduleShape) -> PidParams {
    PidParams {
        gain_schedule: Some(shape.schedule(&answers()).unwrap()),
        ..CONTROLLER
    }
}

#[test]
fn factors_are_the_inverse_of_the_slopes_within_their_limit() {
    let schedule = SHAPE.schedule(&answers()).unwrap();
    let params = schedule.params();
    for index in 0..SCHEDULE_LEVELS {
        let level = schedule.level(index);
        assert_relative_eq!(level, index as f64);
        // The steepest levels are half a step away from the steepest place.
        let away = (1.0 + (level - 3.5).powi(2)) / 1.25;
        assert_relative_eq!(params.heating[index], away.min(3.0), max_relative = 1e-12);
        assert_relative_eq!(
            params.cooling[index],
            (1.5 * away).min(3.0),
            max_relative = 1e-12
        );
    }
    // By level alone it is the factor of the steeper branch; an exponent takes its power.
    let by_level = ScheduleShape {
        by_branch: false,
        exponent: 0.5,
        ..SHAPE
    };
    let halved = by_level.schedule(&answers()).unwrap();
    assert_same(&halved.params().heating, &halved.params().cooling);
    assert_relative_eq!(
        halved.params().heating[5],
        2.6_f64.sqrt(),
        max_relative = 1e-12
    );
    let none = ScheduleShape {
        exponent: 0.0,
        ..SHAPE
    };
    assert!(none.schedule(&answers()).unwrap().largest() <= 1.0);
}

#[test]
fn where_a_plant_does_not_answer_the_factor_is_the_largest() {
    let mut flat = answers();
    for answer in &mut flat.heating[..5] {
        answer.slope = 0.0;
    }
    let schedule = SHAPE.schedule(&flat).unwrap();
    assert_same(&schedule.params().heating[..2], &[3.0, 3.0]);
    for answer in flat.heating.iter_mut().chain(&mut flat.cooling) {
        answer.slope = 0.0;
    }
    let schedule = SHAPE.schedule(&flat).unwrap();
    assert_same(&schedule.params().heating, &[3.0; SCHEDULE_LEVELS]);
}

#[test]
fn a_screen_looks_at_each_level_with_its_larger_factor() {
    let controller = with(SHAPE);
    let schedule = controller.gain_schedule.unwrap();
    let screen = Screen::everywhere(requirements(), controller, &answers()).unwrap();
    let fixed = Screen::everywhere(requirements(), CONTROLLER, &answers()).unwrap();
    assert_eq!(screen.plants().len(), 30);
    let mut gain_margin = f64::INFINITY;
    let mut phase_margin_rad = f64::INFINITY;
    let mut noise_gain = 0.0_f64;
    let all = answers();
    for answer in all.heating.iter().chain(&all.cooling) {
        let factor = schedule.largest_at(answer.output);
        let gains = PidGains {
            kp: factor * GAINS.kp,
            ki: factor * GAINS.ki,
            kd: factor * GAINS.kd,
        };
        let alone = Screen::new(requirements(), CONTROLLER, vec![answer.plant.clone()]).unwrap();
        let margins = alone.margins(&gains).unwrap();
        gain_margin = gain_margin.min(margins.gain_margin);
        phase_margin_rad = phase_margin_rad.min(margins.phase_margin_rad);
        noise_gain = noise_gain.max(alone.passage(&gains).unwrap().noise_gain);
    }
    let found = screen.margins(&GAINS).unwrap();
    assert_relative_eq!(found.gain_margin, gain_margin);
    assert_relative_eq!(found.phase_margin_rad, phase_margin_rad);
    assert_relative_eq!(screen.passage(&GAINS).unwrap().noise_gain, noise_gain);
    // The heating branch with the cooling branch's factor is worse than with its own.
    assert!(found.gain_margin < 0.7 * fixed.margins(&GAINS).unwrap().gain_margin);
    // A jump of the sensor counts where the factor is largest.
    assert_relative_eq!(
        screen.kick(&GAINS),
        3.0 * fixed.kick(&GAINS),
        max_relative = 1e-12
    );
    assert_relative_eq!(
        screen.largest_gains().kp,
        fixed.largest_gains().kp / 3.0,
        max_relative = 1e-12
    );
    // Without knowing where plants are, the largest factor counts everywhere.
    let unknown = Screen::new(requirements(), controller, vec![lag(1.5, 1)]).unwrap();
    let tripled = PidGains {
        kp: 3.0 * GAINS.kp,
        ki: 3.0 * GAINS.ki,
        kd: 3.0 * GAINS.kd,
    };
    let plain = Screen::new(requirements(), CONTROLLER, vec![lag(1.5, 1)]).unwrap();
    assert_relative_eq!(
        unknown.margins(&GAINS).unwrap().phase_margin_rad,
        plain.margins(&tripled).unwrap().phase_margin_rad
    );
}

#[test]
fn a_frozen_controller_follows_the_weighted_set_point_as_a_scheduled_one_does() {
    let controller = PidParams {
        setpoint_weight: 0.4,
        ..with(SHAPE)
    };
    let (fixed, gains) = controller.frozen(&GAINS, 2.0);
    assert_eq!(fixed.gain_schedule, None);
    // kp (φ e - (1 - b) r) = φ kp (b' r - y).
    let (reference, output) = (3.0, 2.0);
    let expected = GAINS.kp * (2.0 * (reference - output) - 0.6 * reference);
    assert_relative_eq!(
        gains.kp * (fixed.setpoint_weight * reference - output),
        expected,
        max_relative = 1e-12
    );
    let (same, as_given) = CONTROLLER.frozen(&GAINS, 2.0);
    assert_eq!((same, as_given), (CONTROLLER, GAINS));
}

#[test]
fn slopes_of_a_rod_are_those_of_its_loop() {
    let rods = Ensemble {
        drive: Drive::Power { length_m: 1.0 },
        rule: Rule::LastReversal,
    };
    let params = rod(TAU_S);
    let member = Member {
        params,
        start: Start::rest(AMBIENT_DEGC),
    };
    let changes = SmallChanges {
        limits: DriveLimits {
            lower: 0.0,
            upper: 20.0,
        },
        ambient_degc: AMBIENT_DEGC,
        dt_s: 0.1,
        tau_s: TAU_S,
        outputs: [params.offset, params.offset + params.gain],
        dead_time_samples: 0,
    };
    let answers = changes.everywhere(&rods, member).unwrap();
    let swing = params.limiting_loop.fraction_swing;
    for (answers, name) in [(&answers.heating, "heating"), (&answers.cooling, "cooling")] {
        assert!(answers.len() > 10, "{name}");
        // dξ/dT is proportional to cos² of the way through the loop, and power heats in proportion.
        let cosine = |output: f64| {
            let fraction = (output - params.offset) / params.gain;
            let center = params.limiting_loop.fraction_center;
            let angle = core::f64::consts::PI * (fraction - center) / (2.0 * swing);
            (2.0 * angle).cos().mul_add(0.5, 0.5)
        };
        let steepest = answers
            .iter()
            .max_by(|a, b| a.slope.total_cmp(&b.slope))
            .unwrap();
        for answer in answers.iter().filter(|one| cosine(one.output) > 0.2) {
            let expected = cosine(answer.output) / cosine(steepest.output);
            assert_relative_eq!(answer.slope / steepest.slope, expected, max_relative = 0.05);
        }
    }
}

#[test]
fn what_is_no_shape_is_refused() {
    let text = |shape: ScheduleShape| shape.schedule(&answers()).unwrap_err().to_string();
    for exponent in [-0.1, 1.1, f64::NAN] {
        assert_eq!(
            text(ScheduleShape { exponent, ..SHAPE }),
            format!("exponent of a gain schedule = {exponent}: must lie in 0 .. 1")
        );
    }
    for largest_factor in [1.0, -3.0, f64::NAN, f64::INFINITY] {
        assert_eq!(
            text(ScheduleShape {
                largest_factor,
                ..SHAPE
            }),
            format!("largest factor of a gain schedule = {largest_factor}: must be finite and > 1")
        );
    }
    for turn in [0.0, f64::NAN] {
        assert_eq!(
            text(ScheduleShape { turn, ..SHAPE }),
            format!("turn = {turn}: must be finite and > 0")
        );
    }
    let mut one_sided = answers();
    one_sided.cooling.clear();
    assert_eq!(
        SHAPE.schedule(&one_sided).unwrap_err().to_string(),
        "cooling has no values; at least 1 is needed"
    );
}
