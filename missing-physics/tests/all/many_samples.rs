//! A run of many samples is judged on fewer; what is said of it holds for all.

use crate::common;

use common::{DT_S, current_a, diagnosed_as, found, params, played, recording, setting};
use missing_physics::{DiagnoseConfig, NoiseClass, Verdict};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use recording::Recording;
use sma_effects::{EffectId, EffectSet, EffectValues, Extended, Setting};
use std::f64::consts::TAU;

/// Samples for each of the wire's drive: together five times as many as are judged.
const OFTEN: usize = 25;
const NOISE_MM: f64 = 0.005;

/// The wire with latent heat, under a share of its drive, recorded `OFTEN` times as often.
fn recorded(name: &str, share: f64, seed: u64) -> Recording {
    let effects = EffectValues::typical(EffectId::LatentHeat, 1.0);
    let active = EffectSet::of(EffectId::LatentHeat);
    recorded_of(name, share, (active, effects), seed, |_| 0.0)
}

fn recorded_of(
    name: &str,
    share: f64,
    (active, effects): (EffectSet, EffectValues),
    seed: u64,
    beside_mm: impl Fn(f64) -> f64,
) -> Recording {
    recorded_at(name, share, (active, effects), seed, beside_mm, 0.0)
}

/// [`recorded_of`] in surroundings that are so much cooler, K: what the rod does there is what one does whose loop lies as much higher.
fn recorded_at(
    name: &str,
    share: f64,
    (active, effects): (EffectSet, EffectValues),
    seed: u64,
    beside_mm: impl Fn(f64) -> f64,
    cooler_k: f64,
) -> Recording {
    let mut params = params();
    params.limiting_loop.loop_center_degc += cooler_k;
    let often = |current_a: f64| std::iter::repeat_n(share * current_a, OFTEN);
    let drive: Vec<f64> = current_a().into_iter().flat_map(often).collect();
    let setting = Setting {
        active,
        ..setting()
    };
    let dt_s = DT_S / OFTEN as f64;
    let mut output = played(&Extended { setting }, params, effects, &drive, dt_s);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for (k, value) in output.iter_mut().enumerate() {
        let normal: f64 = StandardNormal.sample(&mut rng);
        *value += NOISE_MM * normal + beside_mm(dt_s * k as f64);
    }
    recording(name, drive, output, dt_s)
}

/// Four effects, which are soon searched.
fn config() -> DiagnoseConfig {
    DiagnoseConfig {
        setting: setting(),
        catalogue: [
            EffectId::LatentHeat,
            EffectId::DeadTime,
            EffectId::OutputLag,
            EffectId::ThermalExpansion,
        ]
        .into_iter()
        .collect(),
        ..DiagnoseConfig::default()
    }
}

#[test]
fn a_hum_between_the_judged_samples_is_heard() {
    let plain = (EffectSet::EMPTY, EffectValues::default());
    // Five samples of it cancel, and so many become one.
    let verdict = |hum_mm: f64| {
        let hum = |time_s: f64| hum_mm * (TAU * 25.0 * time_s).sin();
        let training = [recorded_of("often.csv", 1.0, plain, 3, hum)];
        diagnosed_as(&training, &[], &config()).verdict
    };
    assert_eq!(verdict(0.0), Verdict::Adequate);
    assert_eq!(verdict(4.0 * NOISE_MM), Verdict::Unexplained);
}

#[test]
fn steps_of_a_converter_stay_rounding_in_means() {
    let plain = (EffectSet::EMPTY, EffectValues::default());
    // Half a percent of the stroke, and noise of a seventh of that.
    let step_mm = 0.025;
    let exact = recorded_of("often.csv", 1.0, plain, 4, |_| 0.0);
    let output = exact.output().iter();
    let rounded = output.map(|output_mm| (output_mm / step_mm).round() * step_mm);
    let training = [exact.with_output(rounded.collect()).unwrap()];
    let diagnosis = diagnosed_as(&training, &[], &config());
    assert_eq!(diagnosis.verdict, Verdict::Adequate);
    assert_eq!(diagnosis.noise_floor.class, NoiseClass::Quantized);
}

#[test]
fn a_name_its_interval_and_the_errors_are_those_of_all_samples() {
    let training = [recorded("often.csv", 1.0, 1)];
    let unseen = [recorded("unseen.csv", 0.95, 2)];
    assert!(training[0].len() > 40_000);
    let found_in = diagnosed_as(&training, &unseen, &config());
    assert_eq!(found_in.verdict, Verdict::Explained);
    assert_eq!(found(&found_in), ["latent-heat"]);
    let [low, high] = found_in.findings[0].parameters[0].ci95.unwrap();
    let truth = EffectId::LatentHeat.info().parameters[0].typical;
    // Noise of 0.1 % of the stroke on 41,250 samples leaves little open.
    assert!(
        low < truth && truth < high && high - low < 0.01 * truth,
        "{low} {high}"
    );
    let is_noise = |rmse_mm: f64| (rmse_mm / NOISE_MM - 1.0).abs() < 0.02;
    let stage = found_in.extended.unwrap().stage;
    for rmse_mm in [
        stage.fit.train_rmse,
        stage.validated[0].rmse,
        stage.predicted_rmse.unwrap(),
    ] {
        assert!(is_noise(rmse_mm), "{rmse_mm}");
    }
    let plain = &found_in.baseline;
    let [first, last] = [&found_in.ladder[0], &found_in.ladder[1]];
    assert_eq!(first.train_rmse.to_bits(), plain.fit.train_rmse.to_bits());
    assert!(is_noise(last.train_rmse) && is_noise(last.unseen_rmse.unwrap()));
}

#[test]
fn the_baseline_model_is_at_the_minimum_of_all_samples() {
    let plain = (EffectSet::EMPTY, EffectValues::default());
    let run = |name: &str, seed: u64, cooler_k: f64| {
        recorded_at(name, 1.0, plain, seed, |_| 0.0, cooler_k)
    };
    let training = [run("monday.csv", 5, 0.0), run("tuesday.csv", 6, 0.3)];
    let diagnosis = diagnosed_as(&training, &[], &config());
    assert_eq!(diagnosis.verdict, Verdict::Adequate);
    let fit = &diagnosis.baseline.fit;
    assert!(fit.converged() && fit.starts > 1);
    let level_k = fit.parameter("ambient_level_k").unwrap();
    let interval = level_k.intervals[1].unwrap();
    assert!((level_k.values[1] + 0.3).abs() < 0.01, "{level_k:?}");
    // As of 80,000 samples, not of the 16,000 on which it was searched.
    assert!(interval.upper - interval.lower < 0.01, "{interval:?}");
    assert!((fit.train_rmse / NOISE_MM - 1.0).abs() < 0.01);
}
