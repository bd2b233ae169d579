//! Same seed, same bits: any number of threads, any partition into calls, any interruption.

// Clippy allows `unwrap` in test functions; this is for their helpers.
#![allow(clippy::unwrap_used)]

use pso::test_functions::{rastrigin, sphere};
use pso::{Bound, Boundary, Inertia, Start, Stop, Swarm, SwarmConfig, Topology, Weights};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::ops::ControlFlow;

const CUBE: [Bound; 3] = [Bound {
    lower: -5.12,
    upper: 5.12,
}; 3];

/// Settings that use all of the memory: damping, the third random number, a ring.
fn restless() -> SwarmConfig {
    SwarmConfig {
        particles: 11,
        weights: Weights {
            inertia: Inertia::Damped {
                first: 0.9,
                factor: 0.995,
            },
            ..Weights::spso_2011()
        },
        boundary: Boundary::Random,
        topology: Topology::Ring { neighbors: 2 },
        ..SwarmConfig::default()
    }
}

fn configs() -> [SwarmConfig; 3] {
    let line = Inertia::LinearlyDecreasing {
        first: 0.9,
        last: 0.4,
        iterations: 30,
    };
    let weights = Weights {
        inertia: line,
        ..Weights::spso_2011()
    };
    let periodic = SwarmConfig {
        weights,
        boundary: Boundary::Periodic,
        ..SwarmConfig::default()
    };
    [SwarmConfig::default(), restless(), periodic]
}

/// Rastrigin's function with a forbidden corner.
fn cost(point: &[f64]) -> f64 {
    if point[0] > 3.0 {
        f64::NAN
    } else {
        rastrigin(point)
    }
}

fn costs(points: &[Vec<f64>]) -> Vec<f64> {
    points.iter().map(|point| cost(point)).collect()
}

fn up_to(iterations: u64) -> Stop {
    Stop {
        iterations: Some(iterations),
        ..Stop::default()
    }
}

fn swarm(config: &SwarmConfig) -> Swarm<ChaCha8Rng> {
    Swarm::new(config.clone(), &CUBE, ChaCha8Rng::seed_from_u64(42)).unwrap()
}

fn run(swarm: &mut Swarm<ChaCha8Rng>, iterations: u64) {
    let _ = swarm
        .run(&up_to(iterations), costs, |_| ControlFlow::Continue(()))
        .unwrap();
}

#[test]
fn n_calls_of_one_are_one_call_of_n() {
    for config in configs() {
        let mut whole = swarm(&config);
        run(&mut whole, 40);
        let mut stepped = swarm(&config);
        for iterations in 0..=40 {
            run(&mut stepped, iterations);
            // A finished run is not touched by another call.
            run(&mut stepped, iterations);
        }
        let mut told = swarm(&config);
        for _ in 0..=40 {
            let costs = costs(told.ask());
            told.tell(&costs).unwrap();
        }
        assert_eq!(whole.checkpoint(), stepped.checkpoint());
        assert_eq!(whole.checkpoint(), told.checkpoint());
        assert!(whole.rejected_costs() > 0);
    }
}

#[test]
fn observer_break_and_another_call_lose_nothing() {
    let mut whole = swarm(&restless());
    run(&mut whole, 40);
    let mut broken = swarm(&restless());
    loop {
        let ended = broken
            .run(&up_to(40), costs, |_| ControlFlow::Break(()))
            .unwrap();
        if ended == pso::Termination::Iterations {
            break;
        }
        assert_eq!(ended, pso::Termination::Observer);
    }
    assert_eq!(whole.checkpoint(), broken.checkpoint());
}

#[test]
fn resumed_is_uninterrupted() {
    for config in configs() {
        let mut whole = swarm(&config);
        run(&mut whole, 40);
        for iterations in [0, 1, 17, 40] {
            let mut first = swarm(&config);
            run(&mut first, iterations);
            let mut second = Swarm::resume(config.clone(), &CUBE, first.checkpoint()).unwrap();
            run(&mut second, 40);
            assert_eq!(whole.checkpoint(), second.checkpoint());
        }
    }
}

#[cfg(feature = "serde")]
#[test]
fn resumed_from_a_file_is_uninterrupted() {
    for config in configs() {
        let mut whole = swarm(&config);
        run(&mut whole, 40);
        // Before the first costs all best costs are +∞, which JSON has no number for.
        let mut part = swarm(&config);
        for iterations in [0, 1, 17] {
            let json = serde_json::to_string(&part.checkpoint()).unwrap();
            let checkpoint = serde_json::from_str(&json).unwrap();
            assert_eq!(part.checkpoint(), checkpoint);
            part = Swarm::resume(config.clone(), &CUBE, checkpoint).unwrap();
            run(&mut part, iterations);
        }
        run(&mut part, 40);
        assert_eq!(whole.checkpoint(), part.checkpoint());
    }
}

#[cfg(feature = "rayon")]
#[test]
fn threads_do_not_move_a_bit() {
    for config in configs() {
        let generator = || ChaCha8Rng::seed_from_u64(42);
        let observer = |_: &pso::Progress<'_>| ControlFlow::Continue(());
        let one = pso::minimize(
            config.clone(),
            &CUBE,
            &up_to(40),
            generator(),
            cost,
            observer,
        )
        .unwrap();
        for n_threads in [1, 2, 7] {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(n_threads)
                .build()
                .unwrap();
            let many = pool.install(|| {
                let config = config.clone();
                pso::minimize_parallel(config, &CUBE, &up_to(40), generator(), cost, observer)
            });
            assert_eq!(many.unwrap(), one);
        }
    }
}

#[test]
fn given_starts_leave_the_other_particles_alone() {
    let free = swarm(&SwarmConfig::default());
    let start = Start::Given(vec![vec![1.0, 2.0, 3.0]]);
    let given = swarm(&SwarmConfig {
        start,
        ..SwarmConfig::default()
    });
    assert_eq!(given.ask()[0], [1.0, 2.0, 3.0]);
    assert_eq!(given.ask()[1..], free.ask()[1..]);
}

/// A change of these numbers moves the result of every user: it belongs under *Numerical* in the
/// changelog.
#[test]
fn first_numbers_are_stable() {
    let mut found = Vec::new();
    for start in [Start::Uniform, Start::LatinHypercube] {
        let config = SwarmConfig {
            particles: 3,
            start,
            ..SwarmConfig::default()
        };
        let bounds = [
            Bound {
                lower: 0.0,
                upper: 1.0,
            },
            Bound {
                lower: -2.0,
                upper: 2.0,
            },
        ];
        let mut swarm = Swarm::new(config, &bounds, ChaCha8Rng::seed_from_u64(1)).unwrap();
        found.extend(swarm.ask().concat());
        for _ in 0..2 {
            let costs: Vec<f64> = swarm.ask().iter().map(|point| sphere(point)).collect();
            swarm.tell(&costs).unwrap();
        }
        found.extend(swarm.ask().concat());
    }
    // Shortest decimal form: it reads back to the same bits.
    let expected: [f64; 24] = [
        0.40248566366484806,
        -1.6784651642808721,
        0.5965601809348549,
        -1.1227016780647996,
        0.28369059130373764,
        0.8424408947244348,
        0.41534345436299613,
        0.47834322618950664,
        0.35228604903037475,
        1.7207451347666731,
        0.531490352681245,
        0.1798698391299613,
        0.8655200603116183,
        -0.46312973812531655,
        0.07310819349460003,
        -0.8336252287521433,
        0.4278968637679125,
        1.608832096114082,
        0.0048463000893774755,
        0.39402342304401966,
        0.29246847400379067,
        -0.10416938447348667,
        0.3219548477522248,
        -1.51236921147126,
    ];
    assert_eq!(found, expected);
}
