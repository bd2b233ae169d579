//! Laws of the controller and of the terms, over random gains, measurements and responses.

use crate::common;

use common::{P_ONLY, PARAMS, pid, sample};
use pid_tune::{
    AntiWindup, DerivativeOf, DriveLimits, PidGains, PidParams, Reference, ResponseTerms, Sample,
    Snapshot, Terms,
};
use proptest::prelude::*;

/// Largest error of [`any_measured`] about a set point of 0.
const LARGEST_ERROR: f64 = 10.0;

fn any_gains() -> impl Strategy<Value = PidGains> {
    (0.0..300.0, 0.0..20.0, 0.0..50.0).prop_map(|(kp, ki, kd)| PidGains { kp, ki, kd })
}

fn any_anti_windup() -> impl Strategy<Value = AntiWindup> {
    prop_oneof![
        Just(AntiWindup::Off),
        Just(AntiWindup::Clamping),
        (1.0..20.0).prop_map(|tracking_s| AntiWindup::BackCalculation { tracking_s }),
    ]
}

fn any_params() -> impl Strategy<Value = PidParams> {
    let derivative_of = prop_oneof![Just(DerivativeOf::Error), Just(DerivativeOf::Measurement)];
    let derivative_filter_s = prop_oneof![Just(0.0), 0.01..10.0];
    let limits = (-2.0..0.5, 0.6..10.0);
    (
        0.01..1.0,
        limits,
        any_anti_windup(),
        derivative_of,
        derivative_filter_s,
    )
        .prop_map(
            |(dt_s, (lower, upper), anti_windup, derivative_of, derivative_filter_s)| PidParams {
                dt_s,
                limits: DriveLimits { lower, upper },
                anti_windup,
                derivative_of,
                derivative_filter_s,
                setpoint_weight: 1.0,
                gain_schedule: None,
            },
        )
}

fn any_measured() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-LARGEST_ERROR..LARGEST_ERROR, 1..100)
}

/// Measurements of which some are missing.
fn any_with_gaps() -> impl Strategy<Value = Vec<f64>> {
    let value = prop_oneof![
        8 => -LARGEST_ERROR..LARGEST_ERROR,
        1 => prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(f64::MAX), Just(-f64::MAX)],
    ];
    prop::collection::vec(value, 1..100)
}

proptest! {
    #[test]
    fn the_drive_is_always_within_its_limits(
        params in any_params(), gains in any_gains(), measured in any_with_gaps(),
        feed_forward in -5.0..5.0,
    ) {
        let pid = pid(params, gains);
        let mut state = pid.rest([0.0]).unwrap();
        let DriveLimits { lower, upper } = params.limits;
        for measured in measured {
            let sample = Sample { feed_forward, ..sample(0.5, measured) };
            let command = pid.step(&mut state, &sample);
            prop_assert!((lower..=upper).contains(&command.drive[0]), "{:?}", command);
            prop_assert!(command.unsaturated[0].is_finite());
            prop_assert!(state.integral()[0].is_finite());
        }
    }

    #[test]
    fn a_proportional_drive_rises_with_the_set_point_and_falls_with_the_output(
        params in any_params(), kp in 0.0..300.0, setpoint in -5.0..5.0, measured in -5.0..5.0,
        more in 0.0..5.0,
    ) {
        let pid = pid(params, PidGains { kp, ..P_ONLY });
        let drive = |setpoint, measured| {
            let mut state = pid.rest([0.0]).unwrap();
            pid.step(&mut state, &sample(setpoint, measured)).drive[0]
        };
        let here = drive(setpoint, measured);
        prop_assert!(drive(setpoint + more, measured) >= here);
        prop_assert!(drive(setpoint, measured + more) <= here);
    }

    #[test]
    fn with_anti_windup_the_integral_is_bounded_however_long_the_saturation(
        params in any_params(), gains in any_gains(), measured in any_measured(), repeats in 1..50_usize,
    ) {
        let gains = PidGains { kd: 0.0, ..gains };
        // Largest integral of a command within the limits, and what is added to it in one sample, or in
        // balance with what is drawn back.
        let beyond = match params.anti_windup {
            AntiWindup::Off => f64::INFINITY,
            AntiWindup::Clamping => gains.ki * params.dt_s,
            AntiWindup::BackCalculation { tracking_s } => gains.kp + gains.ki * tracking_s,
        } * LARGEST_ERROR * (1.0 + 1e-12);
        let pid = pid(params, gains);
        let mut state = pid.rest([0.0]).unwrap();
        for measured in measured {
            for _ in 0..repeats {
                pid.step(&mut state, &sample(0.0, measured));
                let [integral] = state.integral();
                prop_assert!(integral <= params.limits.upper + beyond, "{}", integral);
                prop_assert!(integral >= params.limits.lower.min(0.0) - beyond, "{}", integral);
            }
        }
    }

    #[test]
    fn anti_windup_does_nothing_while_there_is_no_saturation(
        params in any_params(), gains in any_gains(), measured in any_measured(),
    ) {
        let drives = |anti_windup| -> Vec<u64> {
            let params = PidParams { anti_windup, limits: PARAMS.limits, ..params };
            let pid = pid(params, gains);
            let (drives, _) = common::drives(&pid, 0.5, &measured);
            drives.iter().map(|drive| drive.to_bits()).collect()
        };
        let off = drives(AntiWindup::Off);
        prop_assert_eq!(&drives(AntiWindup::Clamping), &off);
        prop_assert_eq!(&drives(AntiWindup::BackCalculation { tracking_s: 5.0 }), &off);
    }

    #[test]
    fn taking_over_makes_no_bump(
        params in any_params(), gains in any_gains(), setpoint in -5.0..5.0, measured in -5.0..5.0,
        feed_forward in -2.0..2.0, drive in -5.0..15.0,
    ) {
        let pid = pid(params, gains);
        let sample = Sample { feed_forward, ..sample(setpoint, measured) };
        let mut state = pid.start(&sample, [drive]).unwrap();
        let [first] = pid.step(&mut state, &sample).drive;
        let expected = drive.clamp(params.limits.lower, params.limits.upper);
        // Rounding of kp e, up to 3000.
        prop_assert!((first - expected).abs() <= 1e-11, "{} {}", first, expected);
    }

    #[test]
    fn a_scaled_output_with_gains_scaled_back_gives_the_same_drive(
        params in any_params(), gains in any_gains(), measured in any_measured(),
        power in -10..10_i32,
    ) {
        // By a power of two, so that nothing rounds.
        let scale = f64::from(power).exp2();
        let (here, _) = common::drives(&pid(params, gains), 0.5, &measured);
        let scaled: Vec<f64> = measured.iter().map(|measured| measured * scale).collect();
        let back = PidGains {
            kp: gains.kp / scale,
            ki: gains.ki / scale,
            kd: gains.kd / scale,
        };
        let (there, _) = common::drives(&pid(params, back), 0.5 * scale, &scaled);
        prop_assert_eq!(here, there);
    }

    #[test]
    fn terms_of_a_step_are_finite_and_within_the_run(
        outputs in prop::collection::vec(-3.0..3.0, 2..60), to in -2.0..2.0, dt_s in 0.01..1.0,
    ) {
        let step = terms(to, dt_s, &outputs).step.unwrap();
        let left_s = (outputs.len() - 1) as f64 * dt_s;
        prop_assert!((0.0..=left_s).contains(&step.rise_time_s), "{:?}", step);
        prop_assert!((0.0..=left_s).contains(&step.settling_time_s), "{:?}", step);
        prop_assert!(step.overshoot >= 0.0 && step.overshoot.is_finite());
    }

    #[test]
    fn terms_of_a_step_do_not_depend_on_scale_and_sign(
        outputs in prop::collection::vec(-3.0..3.0, 2..60), to in -2.0..2.0, dt_s in 0.01..1.0,
        power in -10..10_i32, falls in any::<bool>(),
    ) {
        let scale = f64::from(power).exp2() * if falls { -1.0 } else { 1.0 };
        let scaled: Vec<f64> = outputs.iter().map(|output| output * scale).collect();
        prop_assert_eq!(
            terms(to * scale, dt_s, &scaled).step,
            terms(to, dt_s, &outputs).step
        );
    }

    #[test]
    fn what_settles_later_has_the_longer_settling_time(
        outputs in prop::collection::vec(-3.0..3.0, 2..60), dt_s in 0.01..1.0,
    ) {
        let mut earlier = outputs.clone();
        earlier.extend([1.0, 1.0, 1.0]);
        let mut later = outputs;
        later.extend([1.5, 1.0, 1.0]);
        let settling = |outputs: &[f64]| terms(1.0, dt_s, outputs).step.unwrap().settling_time_s;
        prop_assert!(settling(&later) > settling(&earlier));
    }
}

fn terms(to: f64, dt_s: f64, outputs: &[f64]) -> Terms {
    let reference = Reference::Step {
        from: 0.0,
        to,
        at_s: 0.0,
    };
    let mut response = ResponseTerms::new(&reference, dt_s).unwrap();
    for (k, &output) in outputs.iter().enumerate() {
        response.add(&Snapshot {
            k,
            time_s: k as f64 * dt_s,
            setpoint: to,
            output: [output],
            measured: [output],
            drive: [0.0],
            temperature_degc: [0.0],
        });
    }
    response.terms()[0]
}
