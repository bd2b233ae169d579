//! The documented move and order of random numbers, written a second time.

// Clippy allows `unwrap` in test functions; this is for their helpers.
#![allow(clippy::unwrap_used)]

use pso::test_functions::rosenbrock;
use pso::{Bound, Boundary, Inertia, Start, Swarm, SwarmConfig, Topology, Weights};
use rand::{RngCore, SeedableRng};
use rand_chacha::ChaCha8Rng;

const LOWER: f64 = -2.0;
const RANGE: f64 = 5.0;
const PARTICLES: usize = 7;
const COORDINATES: usize = 3;

fn draw(generator: &mut ChaCha8Rng) -> f64 {
    (generator.next_u64() / 2_u64.pow(11)) as f64 / 2.0_f64.powi(53)
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// First index of the lowest cost among those who inform a particle.
fn leader(topology: Topology, particle: usize, costs: &[f64]) -> usize {
    let informs = |other: &usize| {
        let apart = other.abs_diff(particle);
        match topology {
            Topology::Global => true,
            Topology::Ring { neighbors } => apart.min(costs.len() - apart) <= neighbors,
        }
    };
    // Of equal elements `min_by` takes the first.
    (0..costs.len())
        .filter(informs)
        .min_by(|&a, &b| costs[a].total_cmp(&costs[b]))
        .unwrap()
}

#[test]
fn constant_inertia_moves_as_documented() {
    assert_moves(Inertia::Constant(0.8), Topology::Global, |_| 0.8);
}

#[test]
fn linearly_decreasing_inertia_moves_as_documented() {
    let (first, last) = (0.9, 0.4);
    let inertia = Inertia::LinearlyDecreasing {
        first,
        last,
        iterations: 20,
    };
    assert_moves(inertia, Topology::Global, |k| {
        if k < 20 {
            first + (last - first) * (f64::from(k) / 20.0)
        } else {
            last
        }
    });
}

#[test]
fn damped_inertia_moves_as_documented() {
    let (first, factor) = (0.95, 0.98);
    let product = |k| (0..k).fold(1.0, |product, _| product * factor);
    let inertia = Inertia::Damped { first, factor };
    assert_moves(inertia, Topology::Global, |k| first * product(k));
}

#[test]
fn ring_moves_as_documented() {
    let ring = Topology::Ring { neighbors: 2 };
    assert_moves(Inertia::Constant(0.8), ring, |_| 0.8);
}

/// Compares 50 moves with the equations, given the inertia of move k.
#[track_caller]
fn assert_moves(inertia: Inertia, topology: Topology, weight: impl Fn(u32) -> f64) {
    let (c1, c2, limit) = (1.7, 0.9, 0.3);
    let weights = Weights {
        inertia,
        cognitive: c1,
        social: c2,
    };
    let config = SwarmConfig {
        particles: PARTICLES,
        weights,
        velocity_limit: Some(limit),
        boundary: Boundary::Absorb,
        topology,
        start: Start::Uniform,
    };
    let bounds = [Bound {
        lower: LOWER,
        upper: LOWER + RANGE,
    }; COORDINATES];
    let mut swarm = Swarm::new(config, &bounds, ChaCha8Rng::seed_from_u64(1)).unwrap();

    let mut generator = ChaCha8Rng::seed_from_u64(1);
    let uniform = |generator: &mut ChaCha8Rng| LOWER + draw(generator) * RANGE;
    let cut = |v: f64| v.clamp(-limit * RANGE, limit * RANGE);
    let mut x = vec![vec![0.0; COORDINATES]; PARTICLES];
    x.iter_mut()
        .flatten()
        .for_each(|x| *x = uniform(&mut generator));
    let mut v = x.clone();
    v.iter_mut()
        .flatten()
        .for_each(|v| *v = cut(uniform(&mut generator) - *v));
    let (mut best, mut best_costs) = (x.clone(), vec![f64::INFINITY; PARTICLES]);

    let mut n_absorbed = 0;
    for k in 0..50 {
        let w = weight(k);
        assert_eq!(swarm.ask(), x);
        let costs: Vec<f64> = x.iter().map(|point| rosenbrock(point)).collect();
        swarm.tell(&costs).unwrap();
        for particle in 0..PARTICLES {
            if costs[particle] < best_costs[particle] {
                best_costs[particle] = costs[particle];
                best[particle] = x[particle].clone();
            }
        }
        assert_eq!(bits(swarm.best_costs()), bits(&best_costs));
        for particle in 0..PARTICLES {
            let leader = &best[leader(topology, particle, &best_costs)];
            for j in 0..COORDINATES {
                let (r1, r2) = (draw(&mut generator), draw(&mut generator));
                let here = x[particle][j];
                // The sum in the order of the equation: (w v + own) + social.
                let own = c1 * r1 * (best[particle][j] - here);
                let velocity = cut(w * v[particle][j] + own + c2 * r2 * (leader[j] - here));
                let target = here + velocity;
                let inside = target.clamp(LOWER, LOWER + RANGE);
                let absorbed = target.to_bits() != inside.to_bits();
                n_absorbed += usize::from(absorbed);
                x[particle][j] = inside;
                v[particle][j] = if absorbed { 0.0 } else { velocity };
            }
        }
    }
    assert!(n_absorbed > 0);
}
