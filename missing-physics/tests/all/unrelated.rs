//! Outputs that have nothing to do with the drive: the model describes none of them, or leaves what is no noise.

use crate::common;

use common::{diagnosed_against, noisy, params, played, recording, setting};
use missing_physics::{Diagnosis, Verdict};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use sma_effects::{EffectValues, Extended};
use std::f64::consts::TAU;

const DT_S: f64 = 1.0;
const N: usize = 320;

/// Three cycles of a triangle of these heights, and rest between them.
fn current_a(heights_a: [f64; 3]) -> Vec<f64> {
    let cycle = |height_a: f64| {
        let up = (0..35).map(move |k| height_a * f64::from(k) / 35.0);
        let down = (0..35).map(move |k| height_a * (1.0 - f64::from(k) / 35.0));
        std::iter::repeat_n(0.0, 30).chain(up).chain(down)
    };
    let cycles = heights_a.into_iter().flat_map(cycle);
    cycles.chain(std::iter::repeat(0.0)).take(N).collect()
}

fn wire_mm(current_a: &[f64]) -> Vec<f64> {
    let setting = setting();
    played(
        &Extended { setting },
        params(),
        EffectValues::default(),
        current_a,
        DT_S,
    )
}

/// Diagnosis of an output that is recorded beside the drive of a wire.
fn of_output(output: Vec<f64>) -> Diagnosis {
    let drive = current_a([2.3, 1.9, 2.1]);
    let training = [recording("unrelated.csv", drive, output, DT_S)];
    diagnosed_against(&training, &[])
}

fn normal(seed: u64) -> impl Iterator<Item = f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    std::iter::repeat_with(move || StandardNormal.sample(&mut rng))
}

fn is_not_explained(what: &str, output: Vec<f64>) -> Diagnosis {
    let diagnosis = of_output(output);
    let verdict = diagnosis.verdict;
    assert!(
        matches!(
            verdict,
            Verdict::Unexplained | Verdict::NotConverged | Verdict::ExplainedInPart
        ),
        "{what}: {verdict:?} {:?}",
        common::found(&diagnosis)
    );
    diagnosis
}

#[test]
fn sines_of_time() {
    for period_s in [13.0, 90.0, 260.0] {
        let sine = |k: usize| 2.5 + 2.5 * (TAU * k as f64 / period_s).sin();
        let diagnosis = is_not_explained("sine", noisy((0..N).map(sine).collect()));
        // Far from the drive's period: no loop comes near, and none of another family is tried.
        if period_s < 200.0 {
            assert_eq!(diagnosis.simulations.other_loops, 0, "{period_s}");
        }
    }
}

#[test]
fn random_walks() {
    for seed in 1..=2 {
        let walk = normal(seed).scan(2.5, |at, step| {
            *at += 0.2 * step;
            Some(*at)
        });
        is_not_explained("random walk", walk.take(N).collect());
    }
}

#[test]
fn white_noise() {
    for seed in 1..=2 {
        let noise = normal(seed).map(|normal| 2.5 + normal);
        is_not_explained("white noise", noise.take(N).collect());
    }
}

#[test]
fn a_wire_backward_in_time() {
    for heights_a in [[2.3, 1.9, 2.1], [1.7, 2.2, 2.3]] {
        let backward = wire_mm(&current_a(heights_a)).into_iter().rev();
        is_not_explained("backward", noisy(backward.collect()));
    }
}

#[test]
fn the_output_of_another_run() {
    // The same wire under a drive that begins 50 or 120 s later.
    for late in [50, 120] {
        let own = wire_mm(&current_a([2.1, 2.3, 1.9]));
        let later = std::iter::repeat_n(own[0], late).chain(own);
        is_not_explained("another run", noisy(later.take(N).collect()));
    }
}
