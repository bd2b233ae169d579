//! Laws of the swarm, for any settings, bounds and costs.

// Clippy allows `unwrap` in test functions; this is for their helpers.
#![allow(clippy::unwrap_used)]
// Costs and positions are copied, never computed, on their way: they must be equal bit for bit.
#![allow(clippy::float_cmp)]

use proptest::prelude::*;
use pso::{
    Bound, Boundary, Inertia, Progress, Stall, Start, Stop, Swarm, SwarmConfig, Termination,
    Topology, Weights, minimize,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::ops::ControlFlow;
use std::time::Duration;

fn any_config() -> impl Strategy<Value = SwarmConfig> {
    let inertia = prop_oneof![
        (0.0..2.0).prop_map(Inertia::Constant),
        (0.0..2.0, 0.0..2.0, 1_u64..30).prop_map(|(first, last, iterations)| {
            Inertia::LinearlyDecreasing {
                first,
                last,
                iterations,
            }
        }),
        (0.0..2.0, 0.01..1.0).prop_map(|(first, factor)| Inertia::Damped { first, factor }),
    ];
    let boundary = prop_oneof![
        Just(Boundary::Absorb),
        Just(Boundary::Reflect),
        Just(Boundary::Random),
        Just(Boundary::Periodic),
    ];
    let topology = prop_oneof![
        Just(Topology::Global),
        (1_usize..6).prop_map(|neighbors| Topology::Ring { neighbors }),
    ];
    let start = prop_oneof![Just(Start::Uniform), Just(Start::LatinHypercube)];
    let limit = proptest::option::of(0.01..2.0);
    (
        1_usize..12,
        inertia,
        0.0..5.0,
        0.0..5.0,
        boundary,
        topology,
        start,
        limit,
    )
        .prop_map(
            |(particles, inertia, cognitive, social, boundary, topology, start, velocity_limit)| {
                let weights = Weights {
                    inertia,
                    cognitive,
                    social,
                };
                SwarmConfig {
                    particles,
                    weights,
                    velocity_limit,
                    boundary,
                    topology,
                    start,
                }
            },
        )
}

/// Ranges of any size, some of them empty.
fn any_bounds() -> impl Strategy<Value = Vec<Bound>> {
    let bound = prop_oneof![
        4 => (-1e3..1e3, 0.0..1e3).prop_map(|(lower, range)| Bound { lower, upper: lower + range }),
        1 => (-1e3..1e3).prop_map(|value| Bound { lower: value, upper: value }),
        1 => Just(Bound { lower: -1e300, upper: 1e300 }),
        1 => (0.9..1.0).prop_map(|lower| Bound { lower, upper: lower + 1e-16 }),
    ];
    proptest::collection::vec(bound, 1..5)
}

/// A cost without structure: finite, infinite or NaN.
fn erratic(point: &[f64]) -> f64 {
    let bits = point
        .iter()
        .fold(0_u64, |bits, x| bits.rotate_left(7) ^ x.to_bits());
    match bits % 11 {
        0 => f64::NAN,
        1 => f64::INFINITY,
        rest => rest as f64 + (bits % 1009) as f64,
    }
}

proptest! {
    #[test]
    fn bounds_are_never_left(config in any_config(), bounds in any_bounds(), seed: u64) {
        let mut swarm = Swarm::new(config, &bounds, ChaCha8Rng::seed_from_u64(seed)).unwrap();
        for _ in 0..60 {
            for point in swarm.ask() {
                prop_assert_eq!(point.len(), bounds.len());
                for (x, bound) in point.iter().zip(&bounds) {
                    prop_assert!(*x >= bound.lower && *x <= bound.upper, "{x} {bound:?}");
                }
            }
            let costs: Vec<f64> = swarm.ask().iter().map(|point| erratic(point)).collect();
            swarm.tell(&costs).unwrap();
        }
    }

    #[test]
    fn best_is_the_lowest_cost_told_and_belongs_to_its_point(
        config in any_config(),
        bounds in any_bounds(),
        seed: u64,
    ) {
        let mut swarm = Swarm::new(config, &bounds, ChaCha8Rng::seed_from_u64(seed)).unwrap();
        let (mut lowest, mut n_nan) = (f64::INFINITY, 0);
        for _ in 0..30 {
            let costs: Vec<f64> = swarm.ask().iter().map(|point| erratic(point)).collect();
            swarm.tell(&costs).unwrap();
            lowest = costs.iter().copied().fold(lowest, f64::min);
            n_nan += costs.iter().filter(|cost| cost.is_nan()).count() as u64;
            prop_assert_eq!(swarm.best_cost().unwrap_or(f64::INFINITY), lowest);
            prop_assert_eq!(swarm.rejected_costs(), n_nan);
            if let Some(point) = swarm.best_point() {
                prop_assert_eq!(erratic(point), lowest);
            }
        }
        prop_assert!(swarm.history().windows(2).all(|pair| pair[1] <= pair[0]));
    }

    #[test]
    fn fixed_coordinates_never_move_and_disturb_nobody(config in any_config(), seed: u64) {
        let free = [Bound { lower: -1.0, upper: 2.0 }; 3];
        let mut fixed = free;
        fixed[1] = Bound { lower: 0.3, upper: 0.3 };
        let swarm = |bounds: &[Bound]| {
            Swarm::new(config.clone(), bounds, ChaCha8Rng::seed_from_u64(seed)).unwrap()
        };
        let (mut free, mut fixed) = (swarm(&free), swarm(&fixed));
        for _ in 0..30 {
            // The cost does not see the middle coordinate.
            let cost = |point: &Vec<f64>| erratic(&[point[0], point[2]]);
            for (a, b) in free.ask().iter().zip(fixed.ask()) {
                prop_assert_eq!([a[0], a[2]], [b[0], b[2]]);
                prop_assert_eq!(b[1], 0.3);
            }
            let costs: Vec<f64> = fixed.ask().iter().map(cost).collect();
            free.tell(&costs).unwrap();
            fixed.tell(&costs).unwrap();
        }
    }
}

fn swarm(particles: usize) -> Swarm<ChaCha8Rng> {
    let bounds = [Bound {
        lower: -1.0,
        upper: 1.0,
    }];
    let config = SwarmConfig {
        particles,
        ..SwarmConfig::default()
    };
    Swarm::new(config, &bounds, ChaCha8Rng::seed_from_u64(5)).unwrap()
}

fn report(stop: Stop, cost: impl FnMut(&[f64]) -> f64) -> pso::Report {
    let bounds = [Bound {
        lower: -1.0,
        upper: 1.0,
    }];
    let generator = ChaCha8Rng::seed_from_u64(5);
    let observer = |_: &Progress<'_>| ControlFlow::Continue(());
    minimize(
        SwarmConfig::default(),
        &bounds,
        &stop,
        generator,
        cost,
        observer,
    )
    .unwrap()
}

#[test]
fn ask_repeats_itself_until_tell() {
    let mut swarm = swarm(4);
    let first = swarm.ask().to_vec();
    assert_eq!(swarm.ask(), first);
    swarm.tell(&[0.0; 4]).unwrap();
    assert_ne!(swarm.ask(), first);
}

#[test]
fn tie_goes_to_the_lower_index() {
    let mut swarm = swarm(4);
    let points = swarm.ask().to_vec();
    swarm.tell(&[2.0, 1.0, 1.0, 1.0]).unwrap();
    assert_eq!(swarm.best_point(), Some(points[1].as_slice()));
}

#[test]
fn nan_costs_do_not_poison_the_swarm() {
    let stop = Stop::default();
    let report = report(stop, |x| {
        if x[0] < 0.2 {
            f64::NAN
        } else {
            (x[0] - 0.5).powi(2)
        }
    });
    assert!(report.rejected_costs > 0);
    assert!((report.best.unwrap().point[0] - 0.5).abs() < 1e-6);
}

#[test]
fn without_a_finite_cost_there_is_no_best() {
    let nan = report(Stop::default(), |_| f64::NAN);
    assert_eq!((nan.best, nan.rejected_costs), (None, 7_550));
    let infinite = report(Stop::default(), |_| f64::INFINITY);
    assert_eq!((infinite.best, infinite.rejected_costs), (None, 0));
}

#[test]
fn evaluations_are_counted_as_in_the_paper() {
    let mut n_calls = 0;
    let report = report(Stop::default(), |x| {
        n_calls += 1;
        x[0] * x[0]
    });
    assert_eq!(report.termination, Termination::Iterations);
    assert_eq!(
        (report.iterations, report.evaluations, n_calls),
        (150, 7_550, 7_550)
    );
}

#[test]
fn zero_iterations_evaluate_the_starts() {
    let report = report(
        Stop {
            iterations: Some(0),
            ..Stop::default()
        },
        |x| x[0],
    );
    assert_eq!(report.termination, Termination::Iterations);
    assert_eq!((report.iterations, report.evaluations), (0, 50));
}

#[test]
fn evaluation_limit_is_not_exceeded() {
    for (limit, evaluations) in [(50, 50), (99, 50), (100, 100), (149, 100)] {
        let report = report(
            Stop {
                evaluations: Some(limit),
                ..Stop::default()
            },
            |x| x[0],
        );
        assert_eq!(report.termination, Termination::Evaluations);
        assert_eq!(report.evaluations, evaluations);
    }
}

#[test]
fn target_ends_the_run_and_goes_before_other_reasons() {
    let stop = Stop {
        iterations: Some(0),
        target: Some(2.0),
        ..Stop::default()
    };
    let report = report(stop, |x| x[0]);
    assert_eq!(
        (report.termination, report.iterations),
        (Termination::Target, 0)
    );
}

#[test]
fn stall_ends_the_run() {
    let stall = Some(Stall {
        iterations: 7,
        relative_improvement: 0.0,
    });
    let report = report(
        Stop {
            stall,
            ..Stop::default()
        },
        |_| 3.0,
    );
    assert_eq!(
        (report.termination, report.iterations),
        (Termination::Stall, 7)
    );
}

#[test]
fn time_ends_the_run() {
    let stop = Stop {
        iterations: None,
        time: Some(Duration::from_nanos(1)),
        ..Stop::default()
    };
    let report = report(stop, |x| x[0]);
    assert_eq!(
        (report.termination, report.iterations),
        (Termination::Time, 0)
    );
}

#[test]
fn observer_ends_the_run_and_sees_every_iteration() {
    let mut seen = Vec::new();
    let mut swarm = swarm(4);
    let costs = |points: &[Vec<f64>]| points.iter().map(|x| x[0] * x[0]).collect();
    let ended = swarm.run(&Stop::default(), costs, |progress| {
        seen.push((progress.iterations, progress.evaluations));
        assert_eq!(progress.best_cost, progress.best_point.map(|x| x[0] * x[0]));
        if progress.iterations == 2 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    assert_eq!(ended, Ok(Termination::Observer));
    assert_eq!(seen, [(0, 4), (1, 8), (2, 12)]);
}

#[test]
fn single_particle_searches() {
    let mut swarm = swarm(1);
    for _ in 0..50 {
        let cost = swarm.ask()[0][0].abs();
        swarm.tell(&[cost]).unwrap();
    }
    assert!(swarm.history()[49] < swarm.history()[0]);
}
