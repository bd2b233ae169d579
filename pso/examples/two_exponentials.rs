//! Which settings find both time constants of a sum of two exponentials, and how is the search
//! interrupted and resumed?
//!
//! The curve is `a e^(−t/τ₁) + b e^(−t/τ₂) + c` with some noise. In its cost a long flat valley (τ₁ = τ₂: one
//! exponential) waits for swarms that settle too early, and half of the bounds are far from the minimum.
//! The example tries each setting with many seeds, shows how many end at the noise floor, and then
//! runs the best of them in two halves.
//!
//! `cargo run --release -p pso --example two_exponentials`

use pso::{Bound, Boundary, Stop, Swarm, SwarmConfig, SwarmError, Topology, minimize};
use rand::{RngCore, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::io::Write;
use std::ops::ControlFlow;

const N_SEEDS: u64 = 40;

/// a, b, c, τ₁, τ₂.
const TRUTH: [f64; 5] = [2.0, 1.0, 0.3, 3.0, 25.0];

const BOUNDS: [Bound; 5] = [
    Bound {
        lower: 0.0,
        upper: 10.0,
    },
    Bound {
        lower: 0.0,
        upper: 10.0,
    },
    Bound {
        lower: -2.0,
        upper: 2.0,
    },
    Bound {
        lower: 0.1,
        upper: 100.0,
    },
    Bound {
        lower: 0.1,
        upper: 100.0,
    },
];

fn curve(parameters: &[f64], t: f64) -> f64 {
    let [a, b, c, tau_1, tau_2] = parameters else {
        unreachable!("BOUNDS has five coordinates");
    };
    a * (-t / tau_1).exp() + b * (-t / tau_2).exp() + c
}

/// Samples (t, y) with uniform noise of ±0.02.
fn recording() -> Vec<(f64, f64)> {
    let mut generator = ChaCha8Rng::seed_from_u64(2024);
    (0..120)
        .map(|k| {
            let t = f64::from(k);
            let noise = f64::from(generator.next_u32()) / f64::from(u32::MAX) - 0.5;
            (t, curve(&TRUTH, t) + 0.04 * noise)
        })
        .collect()
}

/// Mean squared error.
fn cost(parameters: &[f64], samples: &[(f64, f64)]) -> f64 {
    let sum: f64 = samples
        .iter()
        .map(|&(t, y)| (curve(parameters, t) - y).powi(2))
        .sum();
    sum / samples.len() as f64
}

/// Share of the seeds that end within 1 % of the cost that the best run reached.
fn share_at_floor(
    config: &SwarmConfig,
    samples: &[(f64, f64)],
    floor: f64,
) -> Result<f64, SwarmError> {
    let mut n_at_floor = 0;
    for seed in 0..N_SEEDS {
        let report = minimize(
            config.clone(),
            &BOUNDS,
            &Stop::default(),
            ChaCha8Rng::seed_from_u64(seed),
            |parameters| cost(parameters, samples),
            |_| ControlFlow::Continue(()),
        )?;
        n_at_floor += usize::from(report.best.is_some_and(|best| best.cost < 1.01 * floor));
    }
    Ok(n_at_floor as f64 / N_SEEDS as f64)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut out = std::io::stdout().lock();
    let samples = recording();
    let evaluate = |points: &[Vec<f64>]| points.iter().map(|point| cost(point, &samples)).collect();

    // The floor: a long run.
    let long = Stop {
        iterations: Some(2000),
        ..Stop::default()
    };
    let mut swarm = Swarm::new(
        SwarmConfig::patient(),
        &BOUNDS,
        ChaCha8Rng::seed_from_u64(0),
    )?;
    let ended = swarm.run(&long, evaluate, |_| ControlFlow::Continue(()))?;
    let floor = swarm.best_cost().ok_or("no finite cost")?;
    writeln!(out, "floor: mean squared error {floor:.3e} ({ended})")?;
    writeln!(
        out,
        "parameters: {:.3?}, true {TRUTH:.3?}\n",
        swarm.best_point()
    )?;

    writeln!(
        out,
        "share of {N_SEEDS} seeds at the floor after 150 iterations:"
    )?;
    let reliable = SwarmConfig::reliable();
    for (name, config) in [
        ("reliable", reliable.clone()),
        (
            "  without speed limit",
            SwarmConfig {
                velocity_limit: None,
                ..reliable.clone()
            },
        ),
        (
            "  boundary: reflect",
            SwarmConfig {
                boundary: Boundary::Reflect,
                ..reliable.clone()
            },
        ),
        (
            "  boundary: random",
            SwarmConfig {
                boundary: Boundary::Random,
                ..reliable.clone()
            },
        ),
        (
            "  boundary: periodic",
            SwarmConfig {
                boundary: Boundary::Periodic,
                ..reliable.clone()
            },
        ),
        (
            "  everybody informed",
            SwarmConfig {
                topology: Topology::Global,
                ..reliable.clone()
            },
        ),
        (
            "  ring of one neighbor",
            SwarmConfig {
                topology: Topology::Ring { neighbors: 1 },
                ..reliable.clone()
            },
        ),
        ("patient", SwarmConfig::patient()),
        ("sadeghi_tuning", SwarmConfig::sadeghi_tuning()),
        (
            "sadeghi_identification",
            SwarmConfig::sadeghi_identification(),
        ),
    ] {
        let share = share_at_floor(&config, &samples, floor)?;
        writeln!(out, "{name:<24}{:5.0} %", 100.0 * share)?;
    }

    // Interrupted after 60 iterations, resumed elsewhere: the same bits as in one go.
    let generator = || ChaCha8Rng::seed_from_u64(7);
    let up_to = |iterations| Stop {
        iterations: Some(iterations),
        ..Stop::default()
    };
    let onward = |_: &pso::Progress<'_>| ControlFlow::Continue(());
    let mut whole = Swarm::new(reliable.clone(), &BOUNDS, generator())?;
    let _ = whole.run(&up_to(150), evaluate, onward)?;
    let mut first = Swarm::new(reliable.clone(), &BOUNDS, generator())?;
    let _ = first.run(&up_to(60), evaluate, onward)?;
    let mut second = Swarm::resume(reliable, &BOUNDS, first.checkpoint())?;
    let _ = second.run(&up_to(150), evaluate, onward)?;
    let same = whole.checkpoint() == second.checkpoint();
    writeln!(out, "\nresumed run equals the uninterrupted one: {same}")?;
    Ok(())
}
