//! Unseen recordings that do not belong to the rig: nothing stays explained that they refute.

use crate::common;

use common::{diagnosed_against, found, noisy, params, played, recording, setting, triangles_a};
use missing_physics::{Diagnosis, Verdict};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use recording::Recording;
use sma_effects::{EffectId, EffectSet, EffectValues, Extended, Setting};
use std::f64::consts::TAU;

const DT_S: f64 = 0.5;

/// A wire whose output is late by 0.6 s.
fn late(name: &str, heights_a: &[f64], spoiled: impl Fn(Vec<f64>) -> Vec<f64>) -> Recording {
    late_by(0.6, name, heights_a, spoiled)
}

fn late_by(
    lag_s: f64,
    name: &str,
    heights_a: &[f64],
    spoiled: impl Fn(Vec<f64>) -> Vec<f64>,
) -> Recording {
    let setting = Setting {
        active: EffectSet::of(EffectId::OutputLag),
        ..setting()
    };
    let mut effects = EffectValues::default();
    effects.output_lag.output_lag_s = lag_s;
    let drive = triangles_a(heights_a);
    let output = played(&Extended { setting }, params(), effects, &drive, DT_S);
    recording(name, drive, spoiled(noisy(output)), DT_S)
}

/// Held to an unseen recording whose output was spoiled.
fn held_to(spoiled: impl Fn(Vec<f64>) -> Vec<f64>) -> Diagnosis {
    let training = [late("training.csv", &[2.3, 1.9, 2.1], |output| output)];
    diagnosed_against(&training, &[late("unseen.csv", &[2.0, 2.2], spoiled)])
}

#[test]
fn what_is_explained_is_explained_there() {
    let diagnosis = held_to(|output| output);
    assert_eq!(diagnosis.verdict, Verdict::Explained);
    assert_eq!(found(&diagnosis), ["output-lag"]);
}

#[test]
fn a_sine_on_them_refutes_it() {
    let sine = |k: usize| 1.5 * (TAU * k as f64 / 37.0).sin();
    let verdict = held_to(|output| {
        let samples = output.into_iter().enumerate();
        samples.map(|(k, mm)| mm + sine(k)).collect()
    })
    .verdict;
    assert!(
        !matches!(verdict, Verdict::Explained | Verdict::Ambiguous),
        "{verdict:?}"
    );
}

#[test]
fn their_samples_in_another_order_refute_it() {
    let verdict = held_to(|mut output| {
        output.shuffle(&mut ChaCha8Rng::seed_from_u64(1));
        output
    })
    .verdict;
    assert!(
        !matches!(verdict, Verdict::Explained | Verdict::Ambiguous),
        "{verdict:?}"
    );
}

#[test]
fn nothing_is_missing_only_where_they_say_so() {
    let of = |lag_s: f64| {
        let training = [late_by(0.0, "training.csv", &[2.3, 1.9, 2.1], |output| {
            output
        })];
        let unseen = [late_by(lag_s, "unseen.csv", &[2.0, 2.2], |output| output)];
        diagnosed_against(&training, &unseen).verdict
    };
    assert_eq!(of(0.0), Verdict::Adequate);
    assert_eq!(of(0.6), Verdict::Unexplained);
}
