//! Limit cycles of single loops: predictions against their own equations by a second route, and against simulation.

use approx::assert_abs_diff_eq;
use core::error::Error;
use core::f64::consts::PI;
use pid_tune::{
    Agreement, AntiWindup, Approach, BiasedSine, ChatterOrbit, DerivativeOf, DriveLimits,
    LinearLoop, PidGains, PidParams, PredictedCycle, RELIABLE_HARMONIC_RATIO, RodLoop,
    RodLoopParams, Source, StartFrom, TemperatureSine, fraction_response,
};
use wiener::hysteresis::{LoopParams, Rule};
use wiener::thermal::{HeatBalanceParams, ThermalConstants};
use wiener::{Drive, Plant, Wiener, WienerParams};

const LAMBDA_K_PER_A2: f64 = 15.0;
const TAU_S: f64 = 3.0;

fn paper_like() -> RodLoopParams {
    RodLoopParams {
        rod: WienerParams {
            heat: HeatBalanceParams::from_constants(ThermalConstants {
                tau_s: TAU_S,
                lambda_k_per_a2: LAMBDA_K_PER_A2,
            }),
            limiting_loop: LoopParams {
                loop_center_degc: 55.0,
                loop_half_width_k: 8.0,
                loop_spread_k: 3.0,
                ..LoopParams::default()
            },
            zeta: 0.85,
            gain: 5.0,
            offset: -0.19,
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
            kp: 200.0,
            ki: 0.01,
            kd: 0.0,
        },
        setpoint: 2.5,
        ambient_degc: 22.0,
        dead_time_samples: 0,
        quantization_step: 0.0,
    }
}

/// A loop that saturates little: its cycle is nearly a sine.
fn mild(gains: PidGains) -> RodLoopParams {
    let paper = paper_like();
    RodLoopParams {
        gains,
        dead_time_samples: 12,
        controller: PidParams {
            derivative_filter_s: 1.0,
            setpoint_weight: 1.0,
            ..paper.controller
        },
        ..paper
    }
}

fn rod_loop(params: RodLoopParams) -> RodLoop {
    RodLoop::new(params).unwrap()
}

/// The cycle of lowest frequency.
fn slowest(params: RodLoopParams) -> PredictedCycle {
    let cycles = rod_loop(params).predicted_cycles();
    *cycles
        .iter()
        .min_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz))
        .unwrap()
}

#[test]
fn a_predicted_cycle_solves_the_equations_that_it_claims_to() {
    for gains in [
        PidGains {
            kp: 0.8,
            ki: 0.0,
            kd: 0.0,
        },
        PidGains {
            kp: 0.8,
            ki: 0.1,
            kd: 0.0,
        },
        PidGains {
            kp: 0.6,
            ki: 0.1,
            kd: 0.5,
        },
        PidGains {
            kp: 200.0,
            ki: 0.01,
            kd: 0.0,
        },
    ] {
        let params = RodLoopParams {
            controller: PidParams {
                anti_windup: AntiWindup::Off,
                ..mild(gains).controller
            },
            ..mild(gains)
        };
        let cycle = slowest(params);
        let plant = Wiener::new(params.drive, params.rule, &[params.rod]).unwrap();
        let sine = TemperatureSine {
            bias_degc: cycle.bias_degc,
            amplitude_k: cycle.temperature_amplitude_k,
        };
        let cold = plant.rest(params.ambient_degc);
        let fraction = fraction_response(plant.hysteresis(), cold.memory(), sine).unwrap();
        let output = params.rod.gain * fraction.mean + params.rod.offset;
        assert_abs_diff_eq!(output, cycle.mean_output, epsilon = 1e-5);
        assert_abs_diff_eq!(
            params.rod.gain * fraction.first.magnitude(),
            cycle.amplitude,
            epsilon = 1e-5
        );
        let linear = LinearLoop {
            controller: params.controller,
            gains,
            plant_gain: 1.0,
            tau_s: TAU_S,
            dead_time_samples: params.dead_time_samples,
        };
        let omega = 2.0 * PI * cycle.frequency_hz;
        let amplitude = linear.controller_response(omega).magnitude() * cycle.amplitude;
        // The mean heat gives the bias of the drive, by bisection.
        let limits = params.controller.limits;
        let squared = |bias| {
            limits
                .saturated_sine_squared(BiasedSine { bias, amplitude })
                .unwrap()
        };
        let [mut low, mut high] = [-amplitude, limits.upper + amplitude];
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            let rise_k = LAMBDA_K_PER_A2 * squared(middle).mean;
            if rise_k < cycle.bias_degc - params.ambient_degc {
                low = middle;
            } else {
                high = middle;
            }
        }
        if gains.ki > 0.0 {
            assert_abs_diff_eq!(cycle.mean_output, params.setpoint, epsilon = 1e-6);
        } else {
            let bias = gains.kp * (params.setpoint - cycle.mean_output);
            assert_abs_diff_eq!(low, bias, epsilon = 1e-5);
        }
        let of_heat = LAMBDA_K_PER_A2 * squared(low).first / amplitude;
        let of_rod = params.rod.gain / cycle.temperature_amplitude_k;
        let response = linear.response(omega);
        let (re, im) = (fraction.first.re, fraction.first.im);
        let whole = [
            of_heat * of_rod * (response.re * re - response.im * im),
            of_heat * of_rod * (response.re * im + response.im * re),
        ];
        assert_abs_diff_eq!(whole[0], -1.0, epsilon = 1e-4);
        assert_abs_diff_eq!(whole[1], 0.0, epsilon = 1e-4);
        assert_eq!(
            cycle.reliable,
            cycle.harmonic_ratio <= RELIABLE_HARMONIC_RATIO
        );
    }
}

#[test]
fn anti_windup_decides_the_mean() {
    let with = |anti_windup| {
        let paper = mild(PidGains {
            kp: 200.0,
            ki: 0.01,
            kd: 0.0,
        });
        slowest(RodLoopParams {
            controller: PidParams {
                anti_windup,
                ..paper.controller
            },
            ..paper
        })
        .mean_output
            - 2.5
    };
    // Without any the mean error is 0; clamped, the integral rests and the mean is where the switch puts it.
    assert_abs_diff_eq!(with(AntiWindup::Off), 0.0, epsilon = 1e-6);
    assert!(with(AntiWindup::Clamping) > 0.3);
    assert!(with(AntiWindup::BackCalculation { tracking_s: 1.0 }) > 0.3);
}

#[test]
fn a_cycle_of_few_harmonics_is_predicted_by_harmonic_balance_alone() {
    let paper = paper_like();
    let params = RodLoopParams {
        rod: WienerParams {
            heat: HeatBalanceParams::from_constants(ThermalConstants {
                tau_s: 25.0,
                lambda_k_per_a2: LAMBDA_K_PER_A2,
            }),
            ..paper.rod
        },
        gains: PidGains {
            kp: 5.0,
            ki: 2.5e-4,
            kd: 0.0,
        },
        controller: PidParams {
            limits: DriveLimits {
                lower: 0.0,
                upper: 2.0,
            },
            ..paper.controller
        },
        dead_time_samples: 10,
        ..paper
    };
    let cycle = slowest(params);
    assert!(
        cycle.stable && cycle.reliable && cycle.harmonic_ratio < 0.1,
        "{cycle:?}"
    );
    for start in StartFrom::ALL {
        let run = rod_loop(params).simulated(start).unwrap().unwrap();
        assert_abs_diff_eq!(
            cycle.frequency_hz,
            run.frequency_hz,
            epsilon = 0.05 * run.frequency_hz
        );
        assert_abs_diff_eq!(
            cycle.amplitude,
            run.sine_amplitude,
            epsilon = 0.1 * run.sine_amplitude
        );
    }
}

#[test]
fn a_stable_orbit_is_what_the_simulation_does() {
    // One sample on, three off; one on, four off at the lower set point.
    for (setpoint, period_samples) in [(2.5, 4), (0.5, 5)] {
        let rod_loop = rod_loop(RodLoopParams {
            setpoint,
            ..paper_like()
        });
        let orbits = rod_loop.chatter_orbits();
        let stable: Vec<&ChatterOrbit> = orbits.iter().filter(|orbit| orbit.stable).collect();
        let [orbit] = stable[..] else {
            panic!("{orbits:?}")
        };
        assert_eq!(
            (orbit.period_samples, orbit.on_samples),
            (period_samples, 1)
        );
        assert!(orbit.exact && orbit.partial_drive.is_none());
        for start in StartFrom::ALL {
            let run = rod_loop.simulated(start).unwrap().unwrap();
            assert_abs_diff_eq!(run.frequency_hz, orbit.frequency_hz, epsilon = 1e-3);
            assert_abs_diff_eq!(
                run.sine_amplitude,
                orbit.sine_amplitude,
                epsilon = 0.01 * orbit.sine_amplitude
            );
        }
    }
}

#[test]
fn a_sample_between_the_limits_is_stable_where_the_gain_is_low() {
    // Period two, half of it at a partial drive, in a slow rod.
    let orbits = |kp| {
        let paper = paper_like();
        let slow = RodLoopParams {
            rod: WienerParams {
                heat: HeatBalanceParams::from_constants(ThermalConstants {
                    tau_s: 30.0,
                    lambda_k_per_a2: LAMBDA_K_PER_A2,
                }),
                ..paper.rod
            },
            gains: PidGains {
                kp,
                ki: 0.0,
                kd: 0.0,
            },
            setpoint: 1.5,
            controller: PidParams {
                limits: DriveLimits {
                    lower: 0.0,
                    upper: 2.0,
                },
                ..paper.controller
            },
            ..paper
        };
        let orbits = rod_loop(slow).chatter_orbits();
        orbits
            .into_iter()
            .filter(|orbit| orbit.period_samples == 2 && orbit.partial_drive.is_some())
            .collect::<Vec<_>>()
    };
    assert!(
        orbits(200.0).iter().any(|orbit| orbit.stable),
        "{:?}",
        orbits(200.0)
    );
    assert!(orbits(2000.0).iter().all(|orbit| !orbit.stable));
}

#[test]
fn a_soft_loop_rests_in_prediction_orbits_and_simulation() {
    // The paper's numbers in meters.
    let found = rod_loop(RodLoopParams {
        gains: PidGains {
            kp: 0.2,
            ki: 1e-5,
            kd: 0.0,
        },
        ..paper_like()
    })
    .analyzed()
    .unwrap();
    assert!(!found.foresees_cycle() && !found.cycles_in_simulation());
    assert!(found.cycles.is_empty() && found.orbits.is_empty());
    let margins = found.margins.unwrap();
    assert!(margins.stable && margins.gain_margin > 3.0);
    for outcome in found.outcomes {
        assert_eq!(outcome.agreement, Agreement::Confirmed);
    }
}

#[test]
fn a_hard_loop_cycles_from_every_start() {
    let found = rod_loop(RodLoopParams {
        dead_time_samples: 3,
        rule: Rule::Nested,
        ..paper_like()
    })
    .analyzed()
    .unwrap();
    assert!(!found.margins.unwrap().stable);
    assert_eq!(found.outcomes.map(|outcome| outcome.start), StartFrom::ALL);
    for outcome in found.outcomes {
        assert_eq!(outcome.agreement, Agreement::Confirmed, "{outcome:?}");
        assert_eq!(outcome.forecast.unwrap().source, Source::Chatter);
    }
    for approach in [Approach::FromBelow, Approach::FromAbove] {
        assert!(found.cycles.iter().any(|cycle| cycle.approach == approach));
        assert!(found.orbits.iter().any(|orbit| orbit.approach == approach));
    }
}

#[test]
fn every_drive_and_an_unreachable_set_point_are_analyzed() {
    let paper = paper_like();
    // The same heat at full drive: 3 A.
    let watt = 9.0 * LAMBDA_K_PER_A2;
    for (drive, upper) in [
        (Drive::Power { length_m: 1.0 }, watt),
        (Drive::Voltage { length_m: 1.0 }, 3.0 * LAMBDA_K_PER_A2),
        (
            Drive::Duty {
                supply_v: 3.0 * LAMBDA_K_PER_A2,
                length_m: 1.0,
            },
            1.0,
        ),
    ] {
        let params = RodLoopParams {
            drive,
            gains: PidGains {
                kp: 200.0 * upper / 3.0,
                ..paper.gains
            },
            dead_time_samples: 3,
            controller: PidParams {
                limits: DriveLimits { lower: 0.0, upper },
                ..paper.controller
            },
            ..paper
        };
        let found = rod_loop(params).analyzed().unwrap();
        for outcome in found.outcomes {
            assert_eq!(
                outcome.agreement,
                Agreement::Confirmed,
                "{drive:?} {outcome:?}"
            );
        }
    }
    let beyond = rod_loop(RodLoopParams {
        setpoint: 5.5,
        ..paper
    })
    .analyzed()
    .unwrap();
    assert!(beyond.margins.is_none() && !beyond.foresees_cycle());
    assert!(!beyond.cycles_in_simulation());
}

#[test]
fn what_is_no_loop_is_refused() {
    let paper = paper_like();
    let refused = |params: RodLoopParams| RodLoop::new(params).unwrap_err();
    let no_gain = refused(RodLoopParams {
        rod: WienerParams {
            gain: f64::NAN,
            ..paper.rod
        },
        ..paper
    });
    assert_eq!(no_gain.to_string(), "rod");
    assert_eq!(
        no_gain.source().unwrap().to_string(),
        "gain = NaN: must be finite, in the unit of the displacement"
    );
    let text = |params| refused(params).to_string();
    assert_eq!(
        text(RodLoopParams {
            setpoint: f64::NAN,
            ..paper
        }),
        "setpoint = NaN: must be finite"
    );
    assert_eq!(
        text(RodLoopParams {
            ambient_degc: f64::NAN,
            ..paper
        }),
        "ambient_degc = NaN: must be finite"
    );
    assert_eq!(
        text(RodLoopParams {
            quantization_step: f64::NAN,
            ..paper
        }),
        "quantization_step = NaN: must be finite and >= 0"
    );
    assert_eq!(
        text(RodLoopParams {
            dead_time_samples: 65,
            ..paper
        }),
        "dead_time_samples = 65: must be at most 64"
    );
    assert_eq!(
        text(RodLoopParams {
            controller: PidParams {
                limits: DriveLimits {
                    lower: -1.0,
                    upper: 3.0,
                },
                ..paper.controller
            },
            ..paper
        }),
        "lower = -1: must be finite and >= 0"
    );
    assert_eq!(
        text(RodLoopParams {
            gains: PidGains {
                kp: f64::NAN,
                ..paper.gains
            },
            ..paper
        }),
        "kp = NaN: must be finite and >= 0"
    );
}
