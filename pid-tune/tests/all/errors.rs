//! The text of every error.

use crate::common;

use std::error::Error;

use common::{P_ONLY, PARAMS, pid, rod, sample, undisturbed};
use pid_tune::{
    AntiWindup, ClosedLoop, ClosedLoopParams, CostWeights, Disturbances, DriveLimits, Pid,
    PidGains, PidParams, Reference, ResponseTerms, Sample, TuneError, feed_forward_a,
};
use wiener::thermal::{HeatBalance, Reach};

const NOT_FINITE: [(f64, &str); 3] = [
    (f64::NAN, "NaN"),
    (f64::INFINITY, "inf"),
    (f64::NEG_INFINITY, "-inf"),
];
const NEGATIVE: [(f64, &str); 4] = [(-1.5, "-1.5"), NOT_FINITE[0], NOT_FINITE[1], NOT_FINITE[2]];
const NOT_POSITIVE: [(f64, &str); 5] = [
    (0.0, "0"),
    NEGATIVE[0],
    NOT_FINITE[0],
    NOT_FINITE[1],
    NOT_FINITE[2],
];

const STEP: Reference<'_> = Reference::Step {
    from: 0.0,
    to: 0.5,
    at_s: 0.0,
};

fn text<T: std::fmt::Debug>(result: Result<T, TuneError>) -> String {
    result.unwrap_err().to_string()
}

fn refused(params: PidParams) -> String {
    text(Pid::new(params, &[P_ONLY]))
}

#[test]
fn gains_of_each_lane_must_not_be_negative() {
    type Set = fn(&mut PidGains, f64);
    let fields: [(&str, Set); 3] = [
        ("kp", |gains, value| gains.kp = value),
        ("ki", |gains, value| gains.ki = value),
        ("kd", |gains, value| gains.kd = value),
    ];
    for (name, set) in fields {
        for (value, shown) in NEGATIVE {
            for lane in 0..3 {
                let mut gains = [P_ONLY; 3];
                set(&mut gains[lane], value);
                assert_eq!(
                    text(Pid::new(PARAMS, &gains)),
                    format!("{name} = {shown}: must be finite and >= 0")
                );
            }
        }
    }
}

#[test]
fn the_sample_time_must_be_positive() {
    for (dt_s, shown) in NOT_POSITIVE {
        let expected = format!("dt_s = {shown}: must be finite and > 0");
        assert_eq!(refused(PidParams { dt_s, ..PARAMS }), expected);
        assert_eq!(text(ResponseTerms::<1>::new(&STEP, dt_s)), expected);
    }
}

#[test]
fn the_filter_must_not_be_negative() {
    for (value, shown) in NEGATIVE {
        let params = PidParams {
            derivative_filter_s: value,
            setpoint_weight: 1.0,
            ..PARAMS
        };
        assert_eq!(
            refused(params),
            format!("derivative_filter_s = {shown}: must be finite and >= 0")
        );
    }
}

#[test]
fn the_limits_must_leave_something_between_them() {
    for (lower, upper, shown) in [
        (0.0, 0.0, "0 .. 0"),
        (3.0, 0.0, "3 .. 0"),
        (f64::NAN, 3.0, "NaN .. 3"),
        (0.0, f64::NAN, "0 .. NaN"),
        (0.0, f64::INFINITY, "0 .. inf"),
        (f64::NEG_INFINITY, 3.0, "-inf .. 3"),
    ] {
        let limits = DriveLimits { lower, upper };
        assert_eq!(
            refused(PidParams { limits, ..PARAMS }),
            format!(
                "the drive is limited to {shown}: both must be finite, the lower below the upper"
            )
        );
    }
}

#[test]
fn back_calculation_must_not_overcorrect() {
    let with = |tracking_s| PidParams {
        dt_s: 0.25,
        anti_windup: AntiWindup::BackCalculation { tracking_s },
        ..PARAMS
    };
    assert!(Pid::new(with(0.25), &[P_ONLY]).is_ok());
    for (tracking_s, shown) in [(0.24, "0.24"), (f64::NAN, "NaN"), (f64::INFINITY, "inf")] {
        assert_eq!(
            refused(with(tracking_s)),
            format!("tracking_s = {shown}: must be finite and at least the sample time of 0.25 s")
        );
    }
}

#[test]
fn a_controller_starts_from_numbers() {
    let pid = pid(PARAMS, P_ONLY);
    let sound = sample(1.0, 0.5);
    for (value, shown) in NOT_FINITE {
        let measured = format!("measured[0] = {shown}: must be finite");
        assert_eq!(text(pid.rest([value])), measured);
        assert_eq!(text(pid.start(&sample(1.0, value), [0.0])), measured);
        assert_eq!(
            text(pid.start(&sound, [value])),
            format!("drive[0] = {shown}: must be finite")
        );
        assert_eq!(
            text(pid.start(&sample(value, 0.5), [0.0])),
            format!("setpoint = {shown}: must be finite")
        );
        let feed_forward = Sample {
            feed_forward: value,
            ..sound
        };
        assert_eq!(
            text(pid.start(&feed_forward, [0.0])),
            format!("feed_forward = {shown}: must be finite")
        );
    }
    assert_eq!(
        text(pid.start(&sample(f64::MAX, -f64::MAX), [0.0])),
        "integral[0] = -inf: must be finite"
    );
}

#[test]
fn values_of_a_reference_must_be_finite() {
    type Make = fn(f64) -> Reference<'static>;
    let references: [(&str, Make); 8] = [
        ("from", |from| Reference::Step {
            from,
            to: 1.0,
            at_s: 0.0,
        }),
        ("to", |to| Reference::Step {
            from: 1.0,
            to,
            at_s: 0.0,
        }),
        ("bias", |bias| Reference::Sine {
            bias,
            amplitude: 1.0,
            frequency_hz: 1.0,
        }),
        ("amplitude", |amplitude| Reference::Sine {
            bias: 1.0,
            amplitude,
            frequency_hz: 1.0,
        }),
        ("low", |low| Reference::Trapezoid {
            low,
            high: 1.0,
            ramp_s: 1.0,
            hold_s: 1.0,
        }),
        ("high", |high| Reference::Trapezoid {
            low: 1.0,
            high,
            ramp_s: 1.0,
            hold_s: 1.0,
        }),
        ("low", |low| Reference::Square {
            low,
            high: 1.0,
            hold_s: 1.0,
        }),
        ("high", |high| Reference::Square {
            low: 1.0,
            high,
            hold_s: 1.0,
        }),
    ];
    for (name, make) in references {
        assert!(make(1.0).checked().is_ok());
        for (value, shown) in NOT_FINITE {
            assert_eq!(
                text(make(value).checked()),
                format!("{name} = {shown}: must be finite")
            );
        }
    }
}

#[test]
fn durations_of_a_reference_have_their_ranges() {
    type Make = fn(f64) -> Reference<'static>;
    let not_negative: [(&str, Make); 2] = [
        ("at_s", |at_s| Reference::Step {
            from: 0.0,
            to: 1.0,
            at_s,
        }),
        ("hold_s", |hold_s| Reference::Trapezoid {
            low: 0.0,
            high: 1.0,
            ramp_s: 1.0,
            hold_s,
        }),
    ];
    for (name, make) in not_negative {
        for (value, shown) in NEGATIVE {
            assert_eq!(
                text(make(value).checked()),
                format!("{name} = {shown}: must be finite and >= 0")
            );
        }
    }
    let positive: [(&str, Make); 4] = [
        ("hold_s", |hold_s| Reference::Staircase {
            levels: &[1.0],
            hold_s,
        }),
        ("frequency_hz", |frequency_hz| Reference::Sine {
            bias: 0.0,
            amplitude: 1.0,
            frequency_hz,
        }),
        ("ramp_s", |ramp_s| Reference::Trapezoid {
            low: 0.0,
            high: 1.0,
            ramp_s,
            hold_s: 1.0,
        }),
        ("hold_s", |hold_s| Reference::Square {
            low: 0.0,
            high: 1.0,
            hold_s,
        }),
    ];
    for (name, make) in positive {
        for (value, shown) in NOT_POSITIVE {
            assert_eq!(
                text(make(value).checked()),
                format!("{name} = {shown}: must be finite and > 0")
            );
        }
    }
}

fn staircase(levels: &[f64]) -> Reference<'_> {
    Reference::Staircase {
        levels,
        hold_s: 1.0,
    }
}

#[test]
fn a_series_that_a_reference_borrows_must_hold_something() {
    assert_eq!(
        text(Reference::Samples(&[]).checked()),
        "samples has no values; at least 1 is needed"
    );
    assert_eq!(
        text(staircase(&[]).checked()),
        "levels has no values; at least 1 is needed"
    );
    for (value, shown) in NOT_FINITE {
        let series = [0.0, value];
        assert_eq!(
            text(Reference::Samples(&series).checked()),
            format!("samples[1] = {shown}: must be finite")
        );
        assert_eq!(
            text(staircase(&series).checked()),
            format!("levels[1] = {shown}: must be finite")
        );
    }
}

#[test]
fn a_loop_refuses_a_reference_that_is_not_sound() {
    let reference = Reference::Samples(&[]);
    let expected = "samples has no values; at least 1 is needed";
    assert_eq!(text(ClosedLoop::new(undisturbed(reference, 5))), expected);
    assert_eq!(text(ResponseTerms::<1>::new(&reference, 1.0)), expected);
}

#[test]
fn a_loop_has_samples() {
    assert_eq!(
        text(ClosedLoop::new(undisturbed(STEP, 0))),
        "n_samples = 0: must be at least 1"
    );
}

#[test]
fn the_ambient_temperature_of_a_loop_must_be_finite() {
    for (value, shown) in NOT_FINITE {
        let params = ClosedLoopParams {
            ambient_degc: value,
            ..undisturbed(STEP, 5)
        };
        assert_eq!(
            text(ClosedLoop::new(params)),
            format!("ambient_degc = {shown}: must be finite")
        );
    }
}

#[test]
fn a_series_of_a_loop_is_as_long_as_it_and_finite() {
    type Set = for<'a> fn(&mut ClosedLoopParams<'a>, &'a [f64]);
    let fields: [(&str, Set); 3] = [
        ("feed_forward", |params, series| {
            params.feed_forward = Some(series);
        }),
        ("measurement_noise", |params, series| {
            params.disturbances.measurement_noise = Some(series);
        }),
        ("output_load", |params, series| {
            params.disturbances.output_load = Some(series);
        }),
    ];
    for (name, set) in fields {
        for found in [0, 4, 6] {
            let series = vec![0.0; found];
            let mut params = undisturbed(STEP, 5);
            set(&mut params, &series);
            assert_eq!(
                text(ClosedLoop::new(params)),
                format!("{name} has {found} values where the run has 5 samples: must be equal")
            );
        }
        for (value, shown) in NOT_FINITE {
            let series = [0.0, 0.0, 0.0, value, 0.0];
            let mut params = undisturbed(STEP, 5);
            set(&mut params, &series);
            assert_eq!(
                text(ClosedLoop::new(params)),
                format!("{name}[3] = {shown}: must be finite")
            );
        }
    }
}

#[test]
fn a_converter_has_no_negative_step() {
    for (value, shown) in NEGATIVE {
        let params = ClosedLoopParams {
            disturbances: Disturbances {
                quantization_step: value,
                ..Disturbances::default()
            },
            ..undisturbed(STEP, 5)
        };
        assert_eq!(
            text(ClosedLoop::new(params)),
            format!("quantization_step = {shown}: must be finite and >= 0")
        );
    }
}

#[test]
fn dead_time_is_limited() {
    let params = ClosedLoopParams {
        disturbances: Disturbances {
            dead_time_samples: 65,
            ..Disturbances::default()
        },
        ..undisturbed(STEP, 5)
    };
    assert_eq!(
        text(ClosedLoop::new(params)),
        "dead_time_samples = 65: must be at most 64"
    );
}

#[test]
fn weights_must_not_be_negative() {
    type Set = fn(&mut CostWeights, f64);
    let fields: [(&str, Set); 5] = [
        ("mse", |weights, value| weights.mse = value),
        ("energy", |weights, value| weights.energy = value),
        ("rise_time", |weights, value| weights.rise_time = value),
        ("settling_time", |weights, value| {
            weights.settling_time = value;
        }),
        ("overshoot", |weights, value| weights.overshoot = value),
    ];
    for (name, set) in fields {
        for (value, shown) in NEGATIVE {
            let mut weights = CostWeights {
                mse: 1.0,
                energy: 1.0,
                rise_time: 1.0,
                settling_time: 1.0,
                overshoot: 1.0,
            };
            set(&mut weights, value);
            assert_eq!(
                text(weights.checked()),
                format!("{name} = {shown}: must be finite and >= 0")
            );
        }
    }
}

#[test]
fn what_the_heat_balance_refuses_is_the_source() {
    let heat = HeatBalance::new([rod(6.0).heat]).unwrap();
    let reach = Reach {
        from_degc: f64::NAN,
        to_degc: 60.0,
        ambient_degc: 22.0,
        within_s: 1.0,
    };
    let error = feed_forward_a(&heat, &reach).unwrap_err();
    assert_eq!(error.to_string(), "heat balance");
    assert_eq!(
        error.source().unwrap().to_string(),
        "from_degc = NaN °C: must be finite"
    );
}
