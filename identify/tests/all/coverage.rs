//! The 95 % intervals hold the truth in 95 % of noisy repeats, white and correlated.

#![allow(
    clippy::unwrap_used,
    reason = "tests fail by panicking, in their helpers too"
)]

#[allow(dead_code, reason = "the other tests use the rest")]
use crate::common;

use common::{ROD, TRUE_TAU_S, recording, rod, steps, triangles, with_output};
use identify::{FitConfig, WienerModel, fit};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use recording::Recording;
use std::ops::ControlFlow;
use wiener::hysteresis::Rule;

const REPEATS: u64 = 400;

/// Standard deviation of the noise, mm: 1 % of the stroke.
const NOISE_MM: f64 = 0.03;

const TRUTH: [(&str, f64); 7] = [
    ("tau_s", TRUE_TAU_S),
    ("loop_center_degc", 70.0),
    ("loop_half_width_k", 8.0),
    ("loop_spread_k", 6.0),
    ("zeta", 0.8),
    ("gain", -3.0),
    ("offset", 0.5),
];

/// Noise of lag-1 correlation `phi` on a recording.
fn noisy(clean: &Recording, phi: f64, seed: u64) -> Recording {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let mut state = NOISE_MM * normal();
    let output = clean.output().iter().map(|y| {
        let noisy = y + state;
        state = phi * state + (1.0 - phi * phi).sqrt() * NOISE_MM * normal();
        noisy
    });
    with_output(clean, "mm", output.collect())
}

/// Share of repeats in which the interval of each parameter holds the truth.
fn coverage(phi: f64) -> Vec<f64> {
    let clean = [
        recording("a.csv", triangles(1500, 4.2), 0.5),
        recording("b.csv", steps(1500), 0.5),
    ];
    let model = WienerModel::new(&rod(ROD), Rule::LastReversal, &clean).unwrap();
    let config = FitConfig {
        starts: 1,
        swarm_iterations: 15,
        ..FitConfig::default()
    };
    let covered: Vec<[bool; 7]> = (0..REPEATS)
        .into_par_iter()
        .map(|seed| {
            let training = [
                noisy(&clean[0], phi, 2 * seed),
                noisy(&clean[1], phi, 2 * seed + 1),
            ];
            let fit = fit(&model, &training, &config, &mut |_| {
                ControlFlow::Continue(())
            })
            .unwrap();
            TRUTH.map(|(name, truth)| {
                let interval = fit.parameter(name).unwrap().intervals[0];
                interval.is_some_and(|interval| (interval.lower..=interval.upper).contains(&truth))
            })
        })
        .collect();
    (0..TRUTH.len())
        .map(|k| covered.iter().filter(|covered| covered[k]).count() as f64 / REPEATS as f64)
        .collect()
}

fn check(phi: f64) {
    let shares = coverage(phi);
    let pooled = shares.iter().sum::<f64>() / shares.len() as f64;
    assert!((0.93..=0.97).contains(&pooled), "pooled {pooled}");
    for ((name, _), share) in TRUTH.iter().zip(&shares) {
        assert!((0.915..=0.98).contains(share), "{name}: {share}");
    }
}

#[test]
fn intervals_cover_under_white_noise() {
    check(0.0);
}

#[test]
fn intervals_cover_under_correlated_noise() {
    check(0.8);
}
