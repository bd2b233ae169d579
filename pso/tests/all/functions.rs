//! The published functions, and how low each swarm gets on them.

// Clippy allows `unwrap` in test functions; this is for their helpers.
#![allow(clippy::unwrap_used)]

use approx::assert_abs_diff_eq;
use pso::test_functions::{
    PUBLISHED, TestFunction, ackley, griewank, rastrigin, rosenbrock, sphere,
};
use pso::{Boundary, Inertia, Progress, Stop, SwarmConfig, Topology, Weights, minimize};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::ops::ControlFlow;

const SEEDS: std::ops::Range<u64> = 0..9;

fn median_cost(config: &SwarmConfig, function: &TestFunction, n_dimensions: usize) -> f64 {
    let stop = Stop {
        iterations: Some(500),
        ..Stop::default()
    };
    let mut costs: Vec<f64> = SEEDS
        .map(|seed| {
            let generator = ChaCha8Rng::seed_from_u64(seed);
            let bounds = function.bounds(n_dimensions);
            let observer = |_: &Progress<'_>| ControlFlow::Continue(());
            let report = minimize(
                config.clone(),
                &bounds,
                &stop,
                generator,
                function.cost,
                observer,
            );
            report.unwrap().best.unwrap().cost
        })
        .collect();
    costs.sort_by(f64::total_cmp);
    costs[costs.len() / 2]
}

#[test]
fn minima_are_zero_where_stated() {
    for function in PUBLISHED {
        for n_dimensions in [1, 2, 10, 30] {
            let point = vec![function.minimizer; n_dimensions];
            assert_abs_diff_eq!((function.cost)(&point), 0.0, epsilon = 1e-15);
            assert!(function.domain.lower < function.minimizer);
            assert!(function.domain.upper > function.minimizer);
        }
    }
}

#[test]
fn values_agree_with_hand_calculation() {
    assert_abs_diff_eq!(sphere(&[1.0, -2.0]), 5.0);
    // 100 (3 − 4)² + (1 − 2)²
    assert_abs_diff_eq!(rosenbrock(&[2.0, 3.0]), 101.0);
    // At half-integers each cosine is −1.
    assert_abs_diff_eq!(rastrigin(&[0.5, -1.5]), 0.25 + 2.25 + 40.0, epsilon = 1e-12);
    // At (1, 1) the mean square is 1 and the mean cosine is 1.
    let expected = 20.0 - 20.0 * (-0.2_f64).exp();
    assert_abs_diff_eq!(ackley(&[1.0, 1.0]), expected, epsilon = 1e-12);
    // cos(2π) = 1.
    let x = std::f64::consts::TAU;
    assert_abs_diff_eq!(griewank(&[x]), x * x / 4000.0, epsilon = 1e-12);
}

#[test]
fn reliable_and_patient_presets_succeed_in_10_dimensions() {
    for config in [SwarmConfig::reliable(), SwarmConfig::patient()] {
        for function in &PUBLISHED {
            let median = median_cost(&config, function, 10);
            // Griewank is hard in few dimensions: its ripples do not average out.
            let factor = if function.name == "Griewank" {
                2.0
            } else {
                1.0
            };
            assert!(
                median < factor * function.threshold,
                "{}: {median}",
                function.name
            );
        }
    }
}

#[test]
fn tuning_preset_succeeds_in_30_dimensions_on_the_sphere() {
    let median = median_cost(&SwarmConfig::sadeghi_tuning(), &PUBLISHED[0], 30);
    assert!(median < PUBLISHED[0].threshold, "{median}");
}

#[test]
fn reliable_preset_passes_everybody_informed_in_30_dimensions() {
    let informed = SwarmConfig {
        topology: Topology::Global,
        ..SwarmConfig::reliable()
    };
    for function in &PUBLISHED {
        let reliable = median_cost(&SwarmConfig::reliable(), function, 30);
        let informed = median_cost(&informed, function, 30);
        assert!(
            reliable < informed,
            "{}: {reliable} {informed}",
            function.name
        );
    }
}

#[test]
fn patient_preset_passes_the_reliable_one_among_many_minima() {
    let griewank = PUBLISHED
        .iter()
        .find(|function| function.name == "Griewank")
        .unwrap();
    let reliable = median_cost(&SwarmConfig::reliable(), griewank, 30);
    let patient = median_cost(&SwarmConfig::patient(), griewank, 30);
    assert!(patient < 1e-6 * reliable, "{patient} {reliable}");
}

#[test]
fn identification_preset_improves_but_does_not_settle() {
    // An unstable variance under a speed limit: it searches forever and refines nothing.
    let sphere = &PUBLISHED[0];
    let start = Stop {
        iterations: Some(0),
        ..Stop::default()
    };
    let generator = ChaCha8Rng::seed_from_u64(0);
    let config = SwarmConfig::sadeghi_identification();
    let observer = |_: &Progress<'_>| ControlFlow::Continue(());
    let report = minimize(
        config.clone(),
        &sphere.bounds(10),
        &start,
        generator,
        sphere.cost,
        observer,
    );
    let first = report.unwrap().best.unwrap().cost;
    let median = median_cost(&config, sphere, 10);
    assert!(median < 0.1 * first, "{median} {first}");
    assert!(median > sphere.threshold, "{median}");
}

#[test]
fn every_schedule_boundary_and_topology_minimizes_the_sphere() {
    let schedules = [
        Weights::spso_2011().inertia,
        Inertia::LinearlyDecreasing {
            first: 0.9,
            last: 0.4,
            iterations: 400,
        },
        Inertia::Damped {
            first: 0.9,
            factor: 0.999,
        },
    ];
    for inertia in schedules {
        for boundary in [
            Boundary::Absorb,
            Boundary::Reflect,
            Boundary::Random,
            Boundary::Periodic,
        ] {
            for topology in [Topology::Global, Topology::Ring { neighbors: 2 }] {
                let weights = Weights {
                    inertia,
                    ..Weights::spso_2011()
                };
                let config = SwarmConfig {
                    weights,
                    boundary,
                    topology,
                    ..SwarmConfig::default()
                };
                let median = median_cost(&config, &PUBLISHED[0], 3);
                assert!(median < 1e-6, "{config:?}: {median}");
            }
        }
    }
}
