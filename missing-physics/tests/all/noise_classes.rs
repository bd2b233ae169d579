//! Noise that looks like physics: what grows toward low frequencies, and what a coarse converter leaves.

#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking wherever it makes its data"
)]

use crate::common;

use common::{diagnosed, output_mm, setting};
use missing_physics::NoiseClass;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use sma_effects::EffectValues;

/// The baseline model's output, mm.
fn clean() -> Vec<f64> {
    output_mm(setting(), EffectValues::default())
}

/// Noise of equal power in every octave: first-order processes with time constants that double.
fn flicker(n: usize, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut sum = vec![0.0; n];
    for octave in 0..12 {
        let phi = (-1.0 / f64::from(1 << octave)).exp();
        let mut state: f64 = StandardNormal.sample(&mut rng);
        for value in &mut sum {
            *value += state;
            let next: f64 = StandardNormal.sample(&mut rng);
            state = phi * state + (1.0 - phi * phi).sqrt() * next;
        }
    }
    sum
}

#[test]
fn noise_without_a_level_gives_no_names() {
    let clean = clean();
    let mut named = Vec::new();
    for seed in 0..8 {
        let noise = flicker(clean.len(), seed);
        let output = clean
            .iter()
            .zip(noise)
            .map(|(y, e)| y + 0.004 * e)
            .collect();
        let found = diagnosed(output, &[]);
        // A drift of the sensor and noise that grows toward low frequencies are one thing in a single recording.
        let is_drift = |name: &&str| name.ends_with("-drift");
        if !common::found(&found).iter().all(is_drift) {
            named.push(format!("{seed}: {:?}", common::found(&found)));
        }
    }
    assert!(named.is_empty(), "{named:?}");
}

#[test]
fn rounding_gives_no_names() {
    let clean = clean();
    // Half a percent of the stroke, and noise of a seventh of that.
    let step = 0.025;
    let mut named = 0;
    for seed in 0..8 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let output = clean.iter().map(|y| {
            let e: f64 = StandardNormal.sample(&mut rng);
            ((y + 0.15 * step * e) / step).round() * step
        });
        let found = diagnosed(output.collect(), &[]);
        assert_eq!(found.noise_floor.class, NoiseClass::Quantized);
        named += usize::from(!found.findings.is_empty());
    }
    assert!(named == 0, "{named}");
}
