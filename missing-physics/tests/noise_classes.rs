//! Noise that looks like physics: what grows toward low frequencies, and what a coarse converter leaves.

#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking wherever it makes its data"
)]

use identify::{Rod, WienerModel};
use missing_physics::{DiagnoseConfig, Diagnosis, NoiseClass, diagnose, setting_of_rod};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use recording::{Recording, RecordingParts};
use wiener::hysteresis::{LoopParams, Rule};
use wiener::thermal::RodParams;
use wiener::{Drive, Ensemble, Member, Profile, Start, WienerParams};

const ROD: &str = r#"
[rod]
diameter_mm = 0.75
length_mm = 125.0
density_kg_per_m3 = 6450.0
specific_heat_j_per_kg_k = 480.0
resistance_ohm_per_m = 2.13
[surroundings]
ambient_degc = 22.0
[load]
lever = 1.0
[columns]
output = { name = "displacement_mm", unit = "mm" }
"#;

const DT_S: f64 = 0.2;

/// Two cycles that differ, a hot hold and a rest: nothing is repeated.
fn current_a() -> Vec<f64> {
    let mut current_a = vec![0.0; 100];
    for (from, to, seconds) in [
        (0.0, 2.3, 50.0),
        (2.3, 0.0, 60.0),
        (0.0, 2.1, 30.0),
        (2.1, 2.1, 70.0),
        (2.1, 0.0, 20.0),
        (0.0, 0.0, 80.0),
    ] {
        let n = (seconds / DT_S) as usize;
        current_a.extend((0..n).map(|k| from + (to - from) * k as f64 / n as f64));
    }
    current_a
}

/// The plain model's output, mm.
fn clean() -> (Vec<f64>, Vec<f64>) {
    let rod = RodParams {
        diameter_m: 0.75e-3,
        density_kg_per_m3: 6450.0,
        specific_heat_j_per_kg_k: 480.0,
        resistance_ohm_per_m: 2.13,
        convective_coefficient_w_per_m2_k: 60.0,
    };
    let params = WienerParams {
        heat: rod.heat_balance().unwrap(),
        limiting_loop: LoopParams {
            loop_center_degc: 55.0,
            loop_half_width_k: 8.0,
            loop_spread_k: 3.0,
            ..LoopParams::default()
        },
        zeta: 0.85,
        gain: 5.0,
        offset: 0.0,
    };
    let current_a = current_a();
    let profile = Profile::uniform(&current_a, DT_S, 22.0).unwrap();
    let member = Member {
        params,
        start: Start::rest(22.0),
    };
    let ensemble = Ensemble {
        drive: Drive::Current,
        rule: Rule::LastReversal,
    };
    let mut output = Vec::new();
    ensemble
        .run(&[member], &profile, &mut |block| {
            output.extend(block.displacement.iter().step_by(block.stride));
        })
        .unwrap();
    (current_a, output)
}

fn diagnosed(output: Vec<f64>, current_a: Vec<f64>) -> Diagnosis {
    let rod = Rod::parse("rod.toml", ROD).unwrap();
    let recording = Recording::new(RecordingParts {
        time_s: Some((0..output.len()).map(|k| DT_S * k as f64).collect()),
        drive: current_a,
        output,
        output_unit: "mm".to_owned(),
        ..RecordingParts::default()
    });
    let training = [recording.unwrap()];
    let base = WienerModel::new(&rod, Rule::LastReversal, &training).unwrap();
    let config = DiagnoseConfig {
        setting: setting_of_rod(&rod, "mm"),
        ..DiagnoseConfig::default()
    };
    diagnose(&base, &training, &[], &config, &mut |_| ()).unwrap()
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
    let (current_a, clean) = clean();
    let mut named = 0;
    for seed in 0..12 {
        let noise = flicker(clean.len(), seed);
        let output = clean
            .iter()
            .zip(noise)
            .map(|(y, e)| y + 0.004 * e)
            .collect();
        let found = diagnosed(output, current_a.clone());
        if found.noise_floor.class == NoiseClass::OneOverF {
            assert!(found.findings.is_empty(), "{seed} {:?}", found.findings);
        }
        named += usize::from(!found.findings.is_empty());
    }
    assert!(named <= 1, "{named}");
}

#[test]
fn rounding_gives_no_names() {
    let (current_a, clean) = clean();
    // Half a percent of the stroke, and noise of a seventh of that.
    let step = 0.025;
    let mut named = 0;
    for seed in 0..8 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let output = clean.iter().map(|y| {
            let e: f64 = StandardNormal.sample(&mut rng);
            ((y + 0.15 * step * e) / step).round() * step
        });
        let found = diagnosed(output.collect(), current_a.clone());
        assert_eq!(found.noise_floor.class, NoiseClass::Quantized);
        named += usize::from(!found.findings.is_empty());
    }
    assert!(named == 0, "{named}");
}
