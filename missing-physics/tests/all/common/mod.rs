//! A made-up wire: its baseline model, a drive, and a diagnosis of what it does.

#![allow(dead_code, reason = "each test uses what it needs")]

use fixtures::wire::{AMBIENT_DEGC, ROD};
use identify::WienerModel;
use missing_physics::{DiagnoseConfig, Diagnosis, diagnose, setting_of_rod};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use recording::{Recording, RecordingParts};
use rig_files::rod_file;
use sma_effects::{EffectValues, Extended, Hypothesis, Member, Setting};
use std::ops::ControlFlow;
use wiener::hysteresis::{LoopParams, Rule};
use wiener::thermal::RodParams;
use wiener::{Profile, Start, WienerParams};

pub(crate) const DT_S: f64 = 0.2;

const NOISE_MM: f64 = 0.005;

/// Two cycles that differ, a hot hold and a rest: nothing is repeated.
pub(crate) fn current_a() -> Vec<f64> {
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

/// Triangles of these heights, A, of 45 s either way at 0.5 s a sample, with rest between them.
pub(crate) fn triangles_a(heights_a: &[f64]) -> Vec<f64> {
    let cycle = |height_a: &f64| {
        let height_a = *height_a;
        let up = (0..90).map(move |k| height_a * f64::from(k) / 90.0);
        let down = (0..90).map(move |k| height_a * (1.0 - f64::from(k) / 90.0));
        std::iter::repeat_n(0.0, 40).chain(up).chain(down)
    };
    heights_a.iter().flat_map(cycle).collect()
}

/// Known properties of the wire.
pub(crate) fn setting() -> Setting {
    setting_of_rod(&rod_file::parse("rod.toml", ROD).unwrap(), "mm")
}

/// The baseline model of the wire.
pub(crate) fn params() -> WienerParams {
    let rod = RodParams {
        diameter_m: 0.75e-3,
        density_kg_per_m3: 6450.0,
        specific_heat_j_per_kg_k: 480.0,
        resistance_ohm_per_m: 2.13,
        convective_coefficient_w_per_m2_k: 60.0,
    };
    WienerParams {
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
    }
}

/// Output of a plant that starts at rest, mm, without noise.
pub(crate) fn played(
    fleet: &Extended,
    params: WienerParams,
    effects: EffectValues,
    current_a: &[f64],
    dt_s: f64,
) -> Vec<f64> {
    let [output, _] = played_warm(fleet, params, effects, current_a, dt_s);
    output
}

/// Output of a plant that starts at rest, mm, and the temperature that is recorded of it, °C, both without noise.
pub(crate) fn played_warm(
    fleet: &Extended,
    params: WienerParams,
    effects: EffectValues,
    current_a: &[f64],
    dt_s: f64,
) -> [Vec<f64>; 2] {
    let member = Member {
        params,
        effects,
        start: Start::rest(AMBIENT_DEGC),
    };
    let profile = Profile::uniform(current_a, dt_s, AMBIENT_DEGC).unwrap();
    let (mut output, mut temperature_degc) = (Vec::new(), Vec::new());
    fleet
        .run(&[member], &profile, &mut |block| {
            output.extend(block.displacement.iter().step_by(block.stride));
            temperature_degc.extend(block.temperature_degc.iter().step_by(block.stride));
        })
        .unwrap();
    [output, temperature_degc]
}

/// Recording of the drive that was played and of the output that came of it.
pub(crate) fn recording(name: &str, current_a: Vec<f64>, output: Vec<f64>, dt_s: f64) -> Recording {
    Recording::new(parts(name, current_a, output, dt_s)).unwrap()
}

/// Parts of a recording of the drive that was played and of the output that came of it.
pub(crate) fn parts(
    name: &str,
    current_a: Vec<f64>,
    output: Vec<f64>,
    dt_s: f64,
) -> RecordingParts {
    RecordingParts {
        name: name.to_owned(),
        time_s: Some((0..output.len()).map(|k| dt_s * k as f64).collect()),
        drive: current_a,
        output,
        output_unit: "mm".to_owned(),
        ..RecordingParts::default()
    }
}

/// Output of the wire with effects under its drive, mm, without noise.
pub(crate) fn output_mm(setting: Setting, effects: EffectValues) -> Vec<f64> {
    played(&Extended { setting }, params(), effects, &current_a(), DT_S)
}

/// An output with white noise.
pub(crate) fn noisy(output: Vec<f64>) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let noise = |mm: f64| {
        let normal: f64 = StandardNormal.sample(&mut rng);
        mm + NOISE_MM * normal
    };
    output.into_iter().map(noise).collect()
}

/// Diagnosis of an output, with hypotheses beside the catalogue.
pub(crate) fn diagnosed(output: Vec<f64>, hypotheses: &'static [Hypothesis]) -> Diagnosis {
    diagnosed_under(current_a(), output, hypotheses)
}

/// Diagnosis of an output under another drive, with hypotheses beside the catalogue.
pub(crate) fn diagnosed_under(
    current_a: Vec<f64>,
    output: Vec<f64>,
    hypotheses: &'static [Hypothesis],
) -> Diagnosis {
    let training = [recording("made-up.csv", current_a, output, DT_S)];
    let config = DiagnoseConfig {
        setting: Setting {
            hypotheses,
            ..setting()
        },
        ..DiagnoseConfig::default()
    };
    diagnosed_as(&training, &[], &config)
}

/// Diagnosis of recordings, held to others.
pub(crate) fn diagnosed_against(training: &[Recording], unseen: &[Recording]) -> Diagnosis {
    let config = DiagnoseConfig {
        setting: setting(),
        ..DiagnoseConfig::default()
    };
    diagnosed_as(training, unseen, &config)
}

/// Diagnosis of recordings of the wire, held to others, as it is asked for.
pub(crate) fn diagnosed_as(
    training: &[Recording],
    unseen: &[Recording],
    config: &DiagnoseConfig,
) -> Diagnosis {
    let rod = rod_file::parse("rod.toml", ROD).unwrap();
    let base = WienerModel::new(&rod, Rule::LastReversal, training).unwrap();
    let go_on = &mut |_| ControlFlow::Continue(());
    diagnose(&base, training, unseen, config, go_on).unwrap()
}

/// Ids of what was found, in alphabetical order.
pub(crate) fn found(diagnosis: &Diagnosis) -> Vec<&str> {
    let ids = diagnosis.findings.iter().map(|one| one.effect.id());
    let mut found: Vec<&str> = ids.collect();
    found.sort_unstable();
    found
}
