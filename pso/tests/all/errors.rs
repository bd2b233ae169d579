//! The text of every error, and NaN at every range check.

// Clippy allows `unwrap` in test functions; this is for their helpers.
#![allow(clippy::unwrap_used)]

use pso::{
    Bound, Boundary, Checkpoint, ConstrictionParams, Inertia, Stall, Start, Stop, Swarm,
    SwarmConfig, SwarmError, Topology, Weights,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::time::Duration;

const SQUARE: [Bound; 2] = [Bound {
    lower: -1.0,
    upper: 1.0,
}; 2];

fn swarm_of(config: SwarmConfig, bounds: &[Bound]) -> Result<Swarm<ChaCha8Rng>, SwarmError> {
    Swarm::new(config, bounds, ChaCha8Rng::seed_from_u64(0))
}

#[track_caller]
fn assert_config_error(config: SwarmConfig, text: &str) {
    assert_eq!(swarm_of(config, &SQUARE).unwrap_err().to_string(), text);
}

#[track_caller]
fn assert_bounds_error(bounds: &[Bound], text: &str) {
    assert_eq!(
        swarm_of(SwarmConfig::default(), bounds)
            .unwrap_err()
            .to_string(),
        text
    );
}

#[track_caller]
fn assert_stop_error(stop: Stop, text: &str) {
    let swarm = swarm_of(SwarmConfig::default(), &SQUARE).unwrap();
    assert_eq!(swarm.finished(&stop).unwrap_err().to_string(), text);
}

fn with_weights(inertia: Inertia, cognitive: f64, social: f64) -> SwarmConfig {
    let weights = Weights {
        inertia,
        cognitive,
        social,
    };
    SwarmConfig {
        weights,
        ..SwarmConfig::default()
    }
}

#[test]
fn empty_swarm() {
    let config = SwarmConfig {
        particles: 0,
        ..SwarmConfig::default()
    };
    assert_config_error(config, "particles = 0: must be at least 1");
}

#[test]
fn ring_without_neighbors() {
    let topology = Topology::Ring { neighbors: 0 };
    let config = SwarmConfig {
        topology,
        ..SwarmConfig::default()
    };
    assert_config_error(config, "topology.neighbors = 0: must be at least 1");
}

#[test]
fn velocity_limit() {
    for (limit, shown) in [
        (f64::NAN, "NaN"),
        (f64::INFINITY, "inf"),
        (0.0, "0"),
        (-0.5, "-0.5"),
    ] {
        let config = SwarmConfig {
            velocity_limit: Some(limit),
            ..SwarmConfig::default()
        };
        let text = format!("velocity_limit = {shown}: must be finite and > 0");
        assert_config_error(config, &text);
    }
}

#[test]
fn weights() {
    let constant = Inertia::Constant(0.7);
    for (value, shown) in [(f64::NAN, "NaN"), (f64::INFINITY, "inf"), (-0.1, "-0.1")] {
        let line = |first, last| Inertia::LinearlyDecreasing {
            first,
            last,
            iterations: 10,
        };
        for (name, config) in [
            ("inertia", with_weights(Inertia::Constant(value), 1.0, 1.0)),
            ("inertia.first", with_weights(line(value, 0.4), 1.0, 1.0)),
            ("inertia.last", with_weights(line(0.9, value), 1.0, 1.0)),
            (
                "inertia.first",
                with_weights(
                    Inertia::Damped {
                        first: value,
                        factor: 0.9,
                    },
                    1.0,
                    1.0,
                ),
            ),
            ("cognitive", with_weights(constant, value, 1.0)),
            ("social", with_weights(constant, 1.0, value)),
        ] {
            assert_config_error(
                config,
                &format!("weights.{name} = {shown}: must be finite and >= 0"),
            );
        }
    }
}

#[test]
fn inertia_schedules() {
    for (factor, shown) in [(f64::NAN, "NaN"), (0.0, "0"), (-0.5, "-0.5"), (1.5, "1.5")] {
        let config = with_weights(Inertia::Damped { first: 0.9, factor }, 1.0, 1.0);
        let text = format!("weights.inertia.factor = {shown}: must be > 0 and <= 1");
        assert_config_error(config, &text);
    }
    let line = Inertia::LinearlyDecreasing {
        first: 0.9,
        last: 0.4,
        iterations: 0,
    };
    let text = "weights.inertia.iterations = 0: must be at least 1";
    assert_config_error(with_weights(line, 1.0, 1.0), text);
}

#[test]
fn constriction() {
    let text = |phi_cognitive, phi_social| {
        let params = ConstrictionParams {
            phi_cognitive,
            phi_social,
        };
        Weights::constriction(params).unwrap_err().to_string()
    };
    for (value, shown) in [
        (f64::NAN, "NaN"),
        (f64::INFINITY, "inf"),
        (0.0, "0"),
        (-3.0, "-3"),
    ] {
        let rest = format!(" = {shown}: must be finite and > 0");
        assert_eq!(text(value, 2.05), format!("phi_cognitive{rest}"));
        assert_eq!(text(2.05, value), format!("phi_social{rest}"));
    }
    assert_eq!(
        text(2.0, 2.0),
        "phi_cognitive + phi_social = 4: must be finite and > 4"
    );
    let overflow = text(f64::MAX, f64::MAX);
    assert_eq!(
        overflow,
        "phi_cognitive + phi_social = inf: must be finite and > 4"
    );
}

#[test]
fn bounds() {
    assert_bounds_error(&[], "bounds = []: must hold at least 1 coordinate");
    for (value, shown) in [(f64::NAN, "NaN"), (f64::NEG_INFINITY, "-inf")] {
        let rest = format!(" = {shown}: must be finite and within ±1e300");
        let lower = [
            SQUARE[0],
            Bound {
                lower: value,
                upper: 1.0,
            },
        ];
        assert_bounds_error(&lower, &format!("bounds[1].lower{rest}"));
        let upper = [
            Bound {
                lower: 0.0,
                upper: value,
            },
            SQUARE[0],
        ];
        assert_bounds_error(&upper, &format!("bounds[0].upper{rest}"));
    }
    assert!(
        swarm_of(
            SwarmConfig::default(),
            &[Bound {
                lower: 0.0,
                upper: f64::MAX
            }]
        )
        .is_err()
    );
    let inverted = [
        SQUARE[0],
        Bound {
            lower: 3.0,
            upper: 1.0,
        },
    ];
    let text = "bounds[1]: lower = 3, upper = 1: lower must be <= upper";
    assert_bounds_error(&inverted, text);
}

#[test]
fn given_starts() {
    let given = |points: Vec<Vec<f64>>| SwarmConfig {
        particles: 2,
        start: Start::Given(points),
        ..SwarmConfig::default()
    };
    let text = "start: 3 points: must be at most 2, the number of particles";
    assert_config_error(given(vec![vec![0.0; 2]; 3]), text);
    let text = "start[1]: 3 coordinates: must be 2, as the bounds have";
    assert_config_error(given(vec![vec![0.0; 2], vec![0.0; 3]]), text);
    for (value, shown) in [(f64::NAN, "NaN"), (f64::INFINITY, "inf"), (-1.5, "-1.5")] {
        let text = format!("start[0][1] = {shown}: must lie in -1..=1");
        assert_config_error(given(vec![vec![0.0, value]]), &text);
    }
}

#[test]
fn costs_of_another_length_leave_the_swarm_alone() {
    let mut swarm = swarm_of(SwarmConfig::default(), &SQUARE).unwrap();
    let before = swarm.checkpoint();
    for count in [0, 49, 51] {
        let error = swarm.tell(&vec![0.0; count]).unwrap_err();
        let text = format!("costs: {count} values: must be 50, one for each particle");
        assert_eq!(error.to_string(), text);
        assert_eq!(swarm.checkpoint(), before);
    }
}

#[test]
fn limits() {
    let stop = Stop {
        evaluations: Some(49),
        ..Stop::default()
    };
    let text = "stop.evaluations = 49: must be at least 50, the number of particles";
    assert_stop_error(stop, text);
    for (target, shown) in [
        (f64::NAN, "NaN"),
        (f64::INFINITY, "inf"),
        (f64::NEG_INFINITY, "-inf"),
    ] {
        let stop = Stop {
            target: Some(target),
            ..Stop::default()
        };
        assert_stop_error(stop, &format!("stop.target = {shown}: must be finite"));
    }
    for (relative_improvement, shown) in [(f64::NAN, "NaN"), (f64::INFINITY, "inf"), (-0.1, "-0.1")]
    {
        let stall = Some(Stall {
            iterations: 5,
            relative_improvement,
        });
        let text = format!("stop.stall.relative_improvement = {shown}: must be finite and >= 0");
        assert_stop_error(
            Stop {
                stall,
                ..Stop::default()
            },
            &text,
        );
    }
    let stall = Some(Stall {
        iterations: 0,
        relative_improvement: 0.1,
    });
    let text = "stop.stall.iterations = 0: must be at least 1";
    assert_stop_error(
        Stop {
            stall,
            ..Stop::default()
        },
        text,
    );
    let stop = Stop {
        time: Some(Duration::ZERO),
        ..Stop::default()
    };
    assert_stop_error(stop, "stop.time = 0 s: must be > 0 s");
}

fn checkpoint() -> Checkpoint<ChaCha8Rng> {
    let mut swarm = swarm_of(SwarmConfig::default(), &SQUARE).unwrap();
    swarm.tell(&[1.0; 50]).unwrap();
    swarm.checkpoint()
}

#[test]
fn checkpoint_of_another_size() {
    let config = SwarmConfig {
        particles: 49,
        ..SwarmConfig::default()
    };
    let error = Swarm::resume(config, &SQUARE, checkpoint()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "checkpoint.best_costs: length 50: must be 49"
    );
    let error = Swarm::resume(SwarmConfig::default(), &SQUARE[..1], checkpoint()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "checkpoint.positions: length 2: must be 1"
    );
}

#[test]
fn checkpoint_outside_the_bounds() {
    let config = SwarmConfig {
        boundary: Boundary::Absorb,
        start: Start::Given(vec![vec![0.25, 0.75]]),
        ..SwarmConfig::default()
    };
    let checkpoint = swarm_of(config, &SQUARE).unwrap().checkpoint();
    let bounds = [Bound {
        lower: 0.5,
        upper: 1.0,
    }; 2];
    let error = Swarm::resume(SwarmConfig::default(), &bounds, checkpoint).unwrap_err();
    let text = "checkpoint.positions: particle 0 has 0.25: must be inside the bounds";
    assert_eq!(error.to_string(), text);
}

#[cfg(feature = "serde")]
#[test]
fn checkpoint_with_nan() {
    // Only a file can hold one.
    let nan = f64::NAN.to_bits();
    for (name, path, accepted) in [
        ("positions", "/positions/0/0", "inside the bounds"),
        ("best_positions", "/best_positions/0/0", "inside the bounds"),
        ("velocities", "/velocities/0/0", "finite"),
        ("best_costs", "/best_costs/0", "a number or infinite"),
        ("history", "/history/0", "a number or infinite"),
        ("damping", "/damping", "in 0..=1"),
    ] {
        let mut document = serde_json::to_value(checkpoint()).unwrap();
        *document.pointer_mut(path).unwrap() = nan.into();
        let checkpoint: Checkpoint<ChaCha8Rng> = serde_json::from_value(document).unwrap();
        let error = Swarm::resume(SwarmConfig::default(), &SQUARE, checkpoint).unwrap_err();
        let text = format!("checkpoint.{name}: particle 0 has NaN: must be {accepted}");
        assert_eq!(error.to_string(), text);
    }
}
